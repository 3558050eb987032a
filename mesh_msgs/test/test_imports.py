"""ROS stays at the rim: the libraries of this package can be used without rospy."""

import subprocess
import sys

import pytest

LIBRARIES = [
    "arrays",
    "array_services",
    "identity",
    "module_aliases",
    "outdoor_world",
    "testing",
    "transform",
    "validation",
    "zoo",
]


@pytest.mark.parametrize("name", LIBRARIES)
def test_library_does_not_import_rospy(name):
    code = "import sys, mesh_msgs.%s; sys.exit('rospy' in sys.modules)" % name
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_ros_module_does():
    code = "import sys, mesh_msgs.ros; sys.exit('rospy' not in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
