"""The library is ROS-free: only ros.py, *_ros.py and *_node.py import rospy."""
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
