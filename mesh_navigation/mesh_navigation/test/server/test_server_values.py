"""Changes of the server's own parameters."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.execution.server_parameters import DYNAMIC_PARAMETERS, PARAMETERS
from mesh_navigation.plugins.plugin_list import BEHAVIORS, CONTROLLERS, PLANNERS, PluginList
from mesh_navigation.server.ros.server_values_ros import changed_values, misspelled_names

DEFAULTS = {parameter.name: parameter.default for parameter in PARAMETERS}


def test_what_is_not_given_stays():
    present = {**DEFAULTS, "planner_patience": 2.0, "robot_frame": "base"}
    values, complaints = changed_values(present, {"planner_frequency": 1})
    assert values == {**present, "planner_frequency": 1.0} and complaints == []
    assert present["planner_frequency"] == 0.0  # a value of a goal in progress never changes


@pytest.mark.parametrize(
    "given, value, words",
    [
        ({"planner_patience": -1.0}, 0.0, "outside of [0.0, 100.0]: 0.0 is used"),
        ({"planner_patience": "long"}, 2.0, "has to be a number: it stays 2.0"),
        ({"planner_patience": float("nan")}, 2.0, "it stays 2.0"),
    ],
)
def test_what_cannot_be_used(given, value, words):
    values, complaints = changed_values({**DEFAULTS, "planner_patience": 2.0}, given)
    assert values["planner_patience"] == value
    assert len(complaints) == 1 and words in complaints[0]


def test_static_parameters_stay():
    assert changed_values(DEFAULTS, {"robot_frame": "wheel", "nobody": 3}) == (DEFAULTS, [])


def test_restore_defaults():
    present = {**DEFAULTS, "robot_frame": "base", "restore_defaults": False}
    present.update((parameter.name, 1) for parameter in DYNAMIC_PARAMETERS)
    given = {"restore_defaults": True, "planner_patience": 7.0}
    values, complaints = changed_values(present, given)
    assert values == {**DEFAULTS, "robot_frame": "base"} and complaints == []
    assert values["restore_defaults"] is False
    values, _ = changed_values(present, {"restore_defaults": False})
    assert values == {**present, "restore_defaults": False}


def listed():
    lists = (
        (PLANNERS, {"name": "wave_front", "type": "wave_front_planner/WaveFrontPlanner"}),
        (CONTROLLERS, {"name": "mesh_controller", "type": "mesh_controller/MeshController"}),
        (BEHAVIORS, {"name": "wait", "type": "mesh_recovery/Wait"}),
    )
    return [PluginList(kind, [entry]) for kind, entry in lists]


@pytest.mark.parametrize(
    "given, meant",
    [
        ({"robot_radus": 0.4}, "robot_radius"),
        ({"foot_print": [[0, 0], [1, 0], [0, 1]]}, "footprint"),
        ({"planner": [], "contollers": []}, "controllers"),
        ({"mesh_controler": {"max_lin_velocity": 0.3}}, "mesh_controller"),
        ({"wave_fornt": {}}, "wave_front"),
        ({"gaurd": {"max_lin_velocity": 0.4}}, "guard"),
        ({"mesh_mab": {}}, "mesh_map"),
        ({"guard": {"max_lin_velocty": 0.4}}, "max_lin_velocity"),
    ],
)
def test_a_name_that_is_nearly_one_that_is_read_is_said(given, meant):
    """The default of what was meant counts: that of a smaller or faster robot."""
    found = misspelled_names(given, listed())
    assert any(f"is {meant} meant?" in complaint for complaint in found)
    assert len(found) <= len(given)


def test_names_of_others_and_right_ones_are_no_complaint():
    """Also all that the released Move Base Flex reads, and has no counterpart here."""
    right = {name: DEFAULTS[name] for name in DEFAULTS}
    right.update(robot_radius=0.2, footprint=[], planners=[], controllers=[], recovery_behaviors=[])
    right.update(mesh_map={}, wave_front={}, mesh_controller={}, wait={}, cost_limit=1.0, guard={})
    others = dict.fromkeys(("force_stop_at_goal", "force_stop_on_cancel", "map_frame"), True)
    others.update(dict.fromkeys(("global_frame", "shutdown_costmaps", "publish_goal"), True))
    others.update(clear_layers={}, back_up={}, rosdistro="noetic", guard_dog={"name": 1})
    assert misspelled_names({**right, **others}, listed()) == []
    assert misspelled_names({"guard": 5}, listed()) == []


def test_shipped_configurations_have_no_misspelt_name():
    folder = Path(__file__).resolve().parents[2] / "config"
    given = {}
    for name in ("planners", "controllers", "recovery"):
        given.update(yaml.safe_load((folder / f"{name}.yaml").read_text(encoding="utf-8")))
    kinds = [PluginList(k, given[k.parameter[1:]]) for k in (PLANNERS, CONTROLLERS, BEHAVIORS)]
    assert misspelled_names(given, kinds) == []
    for plugins in kinds:
        prepared = plugins.prepared(MeshMap(np.eye(3), [[0, 1, 2]]), given)
        assert not prepared.complaints


def test_parameters_of_a_plugin_that_are_misspelt_are_said():
    (plugins, *_) = listed()
    given = {"wave_front": {"cost_limt": 0.5, "somebody": 1, "cost_factor": 1.0}}
    prepared = plugins.prepared(MeshMap(np.eye(3), [[0, 1, 2]]), given)
    said = "wave_front/the parameter cost_limt is not known; is cost_limit meant?"
    assert prepared.complaints == [said]
