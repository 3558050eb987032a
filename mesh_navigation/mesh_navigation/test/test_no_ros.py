"""Libraries stay free of rospy."""

import pkgutil
import subprocess
import sys

import pytest

import mesh_navigation

MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(mesh_navigation.__path__, "mesh_navigation.")
    if not module.ispkg
)

# Imports each module in a process of its own; what takes longest is imported once, before.
IMPORTS = """
import os, sys
import mesh_map.map.mesh_map
for module in sys.argv[1:]:
    if os.fork() == 0:
        __import__(module)
        print(module, "rospy" in sys.modules, flush=True)
        os._exit(0)
    os.wait()
"""


def speaks_ros(name):
    return name.endswith(("ros", "_node")) or ".ros." in name


LIBRARIES = [name for name in MODULES if not speaks_ros(name)]


@pytest.fixture(scope="module")
def with_rospy():
    """What each library says of rospy once it is imported; nothing of those that fail."""
    words = [sys.executable, "-c", IMPORTS, *LIBRARIES]
    done = subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True)
    return dict(line.split() for line in done.stdout.splitlines())


def test_all_modules_are_seen():
    assert {"mesh_navigation.plugins.planner", "mesh_navigation.planners.dijkstra"} <= set(MODULES)


@pytest.mark.parametrize("module", LIBRARIES)
def test_library_imports_no_rospy(module, with_rospy):
    assert with_rospy.get(module) == "False"
