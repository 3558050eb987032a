"""Names of modules in README and plugin descriptions, and those that plugins of others use."""

import importlib
import subprocess
import sys

import pytest

NAMES = {
    "mesh_navigation": ["MeshNavigator"],
    "mesh_navigation.cancellation": ["Cancellation"],
    "mesh_navigation.clock": ["Clock"],
    "mesh_navigation.controller": ["Command", "ControlFailure", "ControllerPlan", "MeshController"],
    "mesh_navigation.controllers.mesh_controller": ["MeshController"],
    "mesh_navigation.outcomes": ["ExePathOutcome", "GetPathOutcome", "RecoveryOutcome"],
    "mesh_navigation.planner": ["MeshPlanner", "PlanFailure", "PlanResult", "stop_if_canceled"],
    "mesh_navigation.planners.dijkstra": ["DijkstraMeshPlanner"],
    "mesh_navigation.planners.mmp": ["MMPPlanner"],
    "mesh_navigation.planners.wave_front": ["CVPMeshPlanner", "WaveFrontPlanner"],
    "mesh_navigation.planning": ["SHORT_NAMES", "load_map", "make_planner", "plan"],
    "mesh_navigation.pose": ["Pose", "rotate"],
    "mesh_navigation.recoveries.back_up": ["BackUp"],
    "mesh_navigation.recoveries.clear_layers": ["ClearLayers"],
    "mesh_navigation.recoveries.wait": ["Wait"],
    "mesh_navigation.recovery": ["MeshRecovery", "RecoveryResult"],
    "mesh_navigation.robot": ["STOP", "Robot", "RobotLost", "RobotState", "Velocity"],
    "mesh_navigation.simulation.driving": ["drive", "make_controller"],
}
MOVED = {
    "mesh_navigation.cancellation": "mesh_navigation.base.cancellation",
    "mesh_navigation.clock": "mesh_navigation.base.clock",
    "mesh_navigation.controller": "mesh_navigation.plugins.controller",
    "mesh_navigation.outcomes": "mesh_navigation.base.outcomes",
    "mesh_navigation.planner": "mesh_navigation.plugins.planner",
    "mesh_navigation.planning": "mesh_navigation.execution.planning",
    "mesh_navigation.pose": "mesh_navigation.base.pose",
    "mesh_navigation.recovery": "mesh_navigation.plugins.recovery",
    "mesh_navigation.robot": "mesh_navigation.base.robot",
}


@pytest.mark.parametrize("module", NAMES)
def test_documented_names(module):
    found = importlib.import_module(module)
    assert [name for name in NAMES[module] if not hasattr(found, name)] == []


@pytest.mark.parametrize("old", MOVED)
def test_old_and_new_names_are_one_module(old):
    assert importlib.import_module(old) is importlib.import_module(MOVED[old])


@pytest.mark.parametrize("old", MOVED)
def test_old_names_alone(old):
    program = f"import sys, {old} as old; print(old.__name__, 'rospy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.PIPE)
    assert done.stdout.decode().split() == [MOVED[old], "False"]
