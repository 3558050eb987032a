"""The sources whose messages users meet."""

from pathlib import Path
from typing import Dict, Iterator, Tuple

PACKAGES = (
    "mesh_msgs",
    "mesh_msgs_hdf5",
    "mesh_map",
    "mesh_navigation",
    "mesh_localization",
    "rviz_mesh_plugin",
)
HARNESS = "test/osmesa_harness"
ROOMS = ("include", "nodes", "scripts", "src")
# Worlds for tests and demos, what tests share, and programs of those who build the packages.
LEFT_OUT = ("/test/", "/world/", "/outdoor_world.py", "/zoo.py", "/testing", "plugin/scripts/")


def repository() -> Path:
    """The top of the repository that this file lies in."""
    return Path(__file__).resolve().parents[5]


def sources(root: Path) -> Tuple[Dict[str, str], Dict[str, str]]:
    """The sources in Python and in C++, each path (relative to root) -> text."""
    python, cpp = {}, {}
    for path in _files(root):
        name = path.relative_to(root).as_posix()
        inside = name[len(HARNESS) :] if name.startswith(HARNESS) else name
        if any(part in inside for part in LEFT_OUT):
            continue
        if path.suffix in (".cpp", ".h") and not name.startswith(HARNESS):
            cpp[name] = path.read_text(encoding="utf-8")
        elif path.suffix == ".py":
            python[name] = path.read_text(encoding="utf-8")
        elif not path.suffix:
            text = path.read_text(encoding="utf-8", errors="replace")
            if text.startswith("#!/usr/bin/python3"):
                python[name] = text
    return python, cpp


def _files(root: Path) -> Iterator[Path]:
    for package in PACKAGES + (HARNESS,):
        for manifest in sorted((root / package).rglob("package.xml")):
            for room in ROOMS:
                yield from (p for p in sorted((manifest.parent / room).rglob("*")) if p.is_file())
