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
WITH_ROS = ("ros", "_node")


def test_all_modules_are_seen():
    assert {"mesh_navigation.planner", "mesh_navigation.planners.dijkstra"} <= set(MODULES)


@pytest.mark.parametrize("module", [name for name in MODULES if not name.endswith(WITH_ROS)])
def test_library_imports_no_rospy(module):
    program = f"import sys, {module}; print('rospy' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    assert done.stdout.strip() == "False"
