"""The library is ROS-free: only ros.py, *_ros.py and *_node.py import rospy; names of before."""
import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "src"
MODULES = sorted(
    ".".join(path.relative_to(SOURCE).with_suffix("").parts)
    for path in SOURCE.rglob("*.py")
    if path.name != "__init__.py" and not re.fullmatch(r"ros|\w+_(node|ros)", path.stem)
)


def test_there_are_modules():
    assert len(MODULES) > 15


@pytest.mark.parametrize("unwanted", ["rospy", "rosgraph", "meshio", "scipy"])
def test_the_library_imports_no_ros(unwanted):
    program = "import sys, %s; sys.exit(%r in sys.modules)" % (", ".join(MODULES), unwanted)
    result = subprocess.run([sys.executable, "-c", program], timeout=60, check=False)
    assert result.returncode == 0


@pytest.mark.parametrize(
    "module, name",
    [
        ("confine", "confined_path"),
        ("convert", "convert"),
        ("convert", "repack"),
        ("edit", "Edit"),
        ("exporter", "write_mesh"),
        ("importer", "read_mesh"),
        ("isolation", "IsolatedMapFile"),
        ("labels.label_store", "LabelStore"),
        ("map_file", "MapFile"),
        ("mesh", "Label"),
        ("mesh", "Mesh"),
    ],
)
def test_documented_names_stay(module, name):
    """Under the name that the README has had since before the modules moved into rooms."""
    found = getattr(importlib.import_module("mesh_msgs_hdf5." + module), name)
    assert getattr(importlib.import_module(found.__module__), name) is found
