"""Outcomes by name, and what the command go_to makes of results."""

import json
import math
import subprocess
import sys

import pytest
from fake_mbf_server import path_along
from mbf_msgs.msg import (
    ExePathResult,
    GetPathResult,
    MoveBaseFeedback,
    MoveBaseResult,
    RecoveryResult,
)

from mesh_navigation.client.navigation_result import (
    NavigationResult,
    canceled_outcome,
    outcome_name,
)
from mesh_navigation.commands.go_to_node import Remaining, arrival_text, plan_text

ALL = {
    getattr(kind, name): name
    for kind in (MoveBaseResult, GetPathResult, ExePathResult, RecoveryResult)
    for name in vars(kind)
    if name.isupper()
}
ALL[50] = ALL[100] = "FAILURE"  # move_base has other names for those of its parts


def test_every_outcome_has_its_name():
    assert len(ALL) == 50
    assert {outcome: outcome_name(outcome) for outcome in ALL} == ALL


@pytest.mark.parametrize(
    "outcome, name",
    [
        (3, "SUCCESS"),
        (49, "MOVE_BASE_ERROR"),
        (75, "PLANNER_ERROR"),
        (149, "CONTROLLER_ERROR"),
        (199, "RECOVERY_ERROR"),
        (200, "UNKNOWN"),
    ],
)
def test_outcomes_of_plugins(outcome, name):
    assert outcome_name(outcome) == name


@pytest.mark.parametrize(
    "action, outcome", [("get_path", 51), ("exe_path", 101), ("recovery", 151), ("move_base", 11)]
)
def test_canceled(action, outcome):
    assert canceled_outcome(action) == outcome


def test_the_navigator_is_loaded_when_it_is_asked_for():
    program = (
        "import sys, mesh_navigation\n"
        "before = 'rospy' in sys.modules\n"
        "from mesh_navigation import MeshNavigator\n"
        "print(before, MeshNavigator.__name__)\n"
        "try:\n    mesh_navigation.MashNavigator\n"
        "except AttributeError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    first, second = done.stdout.splitlines()
    assert first == "False MeshNavigator"
    assert second == "module 'mesh_navigation' has no attribute 'MashNavigator'"


def result_of(details, succeeded=True):
    return NavigationResult(details.outcome, details.message, succeeded, details)


def arrival(**fields):
    details = MoveBaseResult(message="there", dist_to_goal=0.25, angle_to_goal=0.1, **fields)
    details.final_pose.header.frame_id = "map"
    details.final_pose.pose.position.x = 2.0
    return result_of(details)


def test_the_report_of_an_arrival():
    first, second = arrival_text(arrival(), 12.34, False).splitlines()
    assert first == "SUCCESS (0): there"
    assert second == (
        "12.3 s; now at (2.00, 0.00, 0.00) in 'map', 0.25 m from the goal, 5.7 degrees from its "
        "heading"
    )
    values = json.loads(arrival_text(arrival(), 12.34, True))
    assert values == {
        "outcome": 0,
        "outcome_name": "SUCCESS",
        "message": "there",
        "dist_to_goal": 0.25,
        "angle_to_goal": pytest.approx(0.1),
        "seconds": 12.34,
    }


def test_the_report_of_what_never_began():
    details = MoveBaseResult(outcome=59, message="no planner\n'x'", dist_to_goal=math.nan)
    text = arrival_text(result_of(details, False), 0.5, False)
    assert text == "INVALID_PLUGIN (59): no planner 'x'\n0.5 s\n"
    assert json.loads(arrival_text(result_of(details), 0.5, True))["dist_to_goal"] is None


def test_the_report_of_a_plan():
    details = GetPathResult(message="path", path=path_along((0, 0), (3, 0), (3, 4)), cost=8.0)
    assert plan_text(result_of(details), 0.25, False).splitlines() == [
        "SUCCESS (0): path",
        "length 7.000 m, 250 ms",
    ]
    values = json.loads(plan_text(result_of(details), 0.25, True))
    assert (values["length"], values["cost"], values["frame_id"]) == (7.0, 8.0, "map")
    assert values["positions"] == [[0, 0, 0], [3, 0, 0], [3, 4, 0]]
    failed = result_of(GetPathResult(outcome=54, message="no way"), False)
    assert plan_text(failed, 0.25, False) == "NO_PATH_FOUND (54): no way\n"


def test_what_remains():
    remaining = Remaining()
    feedback = MoveBaseFeedback(dist_to_goal=8.0, angle_to_goal=-math.pi / 2)
    feedback.last_cmd_vel.twist.linear.x = 0.5
    text, share = remaining.update(feedback)
    assert (text, share) == ("8.00 m to the goal, 90 degrees to turn, 0.50 m/s", 0.0)
    assert remaining.update(MoveBaseFeedback(dist_to_goal=2.0))[1] == 0.75
    assert remaining.update(MoveBaseFeedback(dist_to_goal=9.0))[1] == 0.0
    assert remaining.update(MoveBaseFeedback(dist_to_goal=math.nan)) == ("driving", None)
    assert Remaining().update(MoveBaseFeedback(dist_to_goal=0.0))[1] is None
