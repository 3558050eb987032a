"""Changes of the server's own parameters."""

import pytest

from mesh_navigation.execution.server_parameters import DYNAMIC_PARAMETERS, PARAMETERS
from mesh_navigation.server.ros.server_values_ros import changed_values

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
