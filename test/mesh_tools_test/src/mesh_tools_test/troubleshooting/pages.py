"""The pages of troubleshooting: messages in code font, then their cause and the way out.

An entry is a list of messages in code font, a paragraph that begins with **Cause.** and one that
begins with **Way out.**; it may stand for several messages that say the same of different things.
"""

import re
from pathlib import Path
from typing import Iterator, List, NamedTuple, Tuple

FOLDER = "docs/troubleshooting"
INDEX = "index.md"
CAUSE, WAY_OUT = "**Cause.**", "**Way out.**"
_MESSAGE = re.compile(r"- (`+) ?(.+?) ?\1$")

# Where the sources of a folder are explained; the first that fits counts.
PAGES = (
    ("mesh_map/src/mesh_map/commands/reconstruct", "reconstruction.md"),
    ("mesh_map/src/mesh_map/commands/", "mesh_tool.md"),
    ("mesh_map/src/mesh_map/spatial/", "spatial.md"),
    ("mesh_map/src/mesh_map/reconstruction/", "reconstruction.md"),
    ("mesh_map/src/mesh_map/scans/", "reconstruction.md"),
    ("mesh_map/src/reconstruction/", "reconstruction.md"),
    ("mesh_map/src/bindings/reconstruction", "reconstruction.md"),
    ("mesh_map/src/mesh_map/", "layers.md"),
    ("mesh_map/nodes/", "layers.md"),
    ("mesh_map/", "spatial.md"),
    ("mesh_msgs/src/mesh_msgs/package_exports.py", "packages.md"),
    ("mesh_msgs/src/mesh_msgs/module_aliases.py", "packages.md"),
    ("mesh_msgs/src/mesh_msgs/init_node.py", "packages.md"),
    ("mesh_msgs/src/mesh_msgs/master_watch.py", "packages.md"),
    ("mesh_msgs/", "messages.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/commands/", "mesh_tool.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/comparison/", "mesh_tool.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/rendering/", "mesh_tool.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/validation/", "mesh_tool.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/formats/", "import.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/label", "labels.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/ros/", "labels.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/server/", "servers.md"),
    ("mesh_msgs_hdf5/src/mesh_msgs_hdf5/verbs/", "packages.md"),
    ("mesh_msgs_hdf5/src/", "map_files.md"),
    ("mesh_navigation/mesh_navigation/src/mesh_navigation/planners/", "planning.md"),
    ("mesh_navigation/mesh_navigation/src/mesh_navigation/client/", "clients.md"),
    ("mesh_navigation/mesh_navigation/src/mesh_navigation/commands/", "clients.md"),
    ("mesh_navigation/mesh_navigation/src/mesh_navigation/plugins/", "packages.md"),
    ("mesh_navigation/mesh_navigation/src/mesh_navigation/simulation/", "simulation.md"),
    ("mesh_navigation/mesh_localization/", "localization.md"),
    ("mesh_navigation/", "driving.md"),
    ("rviz_mesh_plugin/src/label_editing/", "rviz_labels.md"),
    ("rviz_mesh_plugin/src/navigation/", "rviz_navigation.md"),
    ("rviz_mesh_plugin/src/panel/mesh_navigation", "rviz_navigation.md"),
    ("rviz_mesh_plugin/src/panel/", "rviz_labels.md"),
    ("rviz_mesh_plugin/src/measurement/", "rviz_tools.md"),
    ("rviz_mesh_plugin/src/picking/", "rviz_tools.md"),
    ("rviz_mesh_plugin/src/tools/", "rviz_tools.md"),
    ("rviz_mesh_plugin/", "rviz_displays.md"),
    ("test/osmesa_harness/", "packages.md"),
)


class Entry(NamedTuple):
    """page: its path; line: of its first message; messages: (line, text)."""

    page: str
    line: int
    messages: List[Tuple[int, str]]
    cause: str
    way_out: str


def page_for(source: str) -> str:
    """The page that explains the messages of a source, as a path from the repository's top."""
    name = next(page for prefix, page in PAGES if source.startswith(prefix))
    return FOLDER + "/" + name


def entries_of(page: str, text: str) -> List[Entry]:
    """The entries of a page in their order."""
    found: List[Entry] = []
    for line, paragraph in _paragraphs(text):
        first = paragraph.split("\n", 1)[0]
        told = " ".join(paragraph.split())
        if first.startswith("- `"):
            rows = enumerate(paragraph.split("\n"), line)
            matches = [(at, _MESSAGE.match(row)) for at, row in rows]
            messages = [(at, match.group(2) if match else "") for at, match in matches]
            found.append(Entry(page, line, messages, "", ""))
        elif first.startswith(CAUSE) and found:
            found[-1] = found[-1]._replace(cause=told[len(CAUSE) :].strip())
        elif first.startswith(WAY_OUT) and found:
            found[-1] = found[-1]._replace(way_out=told[len(WAY_OUT) :].strip())
    return found


def read_entries(root: Path) -> List[Entry]:
    """The entries of all pages; root: the repository's top."""
    found = []
    for path in sorted((root / FOLDER).glob("*.md")):
        if path.name != INDEX:
            page = path.relative_to(root).as_posix()
            found += entries_of(page, path.read_text(encoding="utf-8"))
    return found


def code(text: str) -> str:
    """A message in code font."""
    return "`` %s ``" % text if "`" in text else "`%s`" % text


def _paragraphs(text: str) -> Iterator[Tuple[int, str]]:
    rows: List[str] = []
    for number, row in enumerate(text.split("\n") + [""], 1):
        if row.strip():
            rows.append(row)
        elif rows:
            yield number - len(rows), "\n".join(rows)
            rows = []
