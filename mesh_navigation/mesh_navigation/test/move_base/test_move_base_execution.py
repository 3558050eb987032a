"""Each way through planning, driving and recovery, with each outcome."""

import pytest
from actionlib_msgs.msg import GoalStatus
from mbf_msgs.msg import ExePathResult, GetPathResult
from move_base_world import Scripted, World, drive, plan, recover

from mesh_navigation.base.outcomes import ExePathOutcome, GetPathOutcome, RecoveryOutcome
from mesh_navigation.move_base.move_base_execution import FINAL
from mesh_navigation.move_base.sub_goals import GoalEnd, PlanAnswer

PLAN_FAILURES = [int(o) for o in GetPathOutcome if o not in (0, GetPathOutcome.CANCELED)]
DRIVE_FAILURES = [int(o) for o in ExePathOutcome if o not in (0, ExePathOutcome.CANCELED)]
RECOVERY_FAILURES = [int(o) for o in RecoveryOutcome if o not in (0, RecoveryOutcome.CANCELED)]
OWN = {"plan": (71, 99), "drive": (121, 149), "recover": (171, 199)}
OSCILLATION = 105


def as_answered(outcome):
    return 13 if outcome == OSCILLATION else outcome


@pytest.mark.parametrize("success", [0, 1, 9])
def test_success(success):
    world = World(plan=[plan(success)], drive=[drive(success, 3.0)])
    end = world.run("a")
    assert world.begun == ["plan 0", "drive 0"]
    assert (end.outcome, end.message) == (success, f"drive 0 ends with {success}")
    assert end.drive == "value of drive 0" and not world.log


@pytest.mark.parametrize("outcome", PLAN_FAILURES + list(OWN["plan"]))
def test_failures_of_planning_pass_through(outcome):
    world = World(plan=[plan(outcome)])
    end = world.run()
    assert (end.outcome, end.message) == (outcome, f"plan 0 ends with {outcome}")
    assert end.drive is None and world.begun == ["plan 0"]


@pytest.mark.parametrize("outcome", DRIVE_FAILURES + list(OWN["drive"]))
def test_failures_of_driving_pass_through(outcome):
    world = World(drive=[drive(outcome)])
    end = world.run()
    assert (end.outcome, end.message) == (as_answered(outcome), f"drive 0 ends with {outcome}")
    assert end.drive == "value of drive 0" and world.begun == ["plan 0", "drive 0"]


def test_what_is_final():
    names = {"plan": set(), "drive": set()}
    for outcome in FINAL:
        names["plan" if outcome < 100 else "drive"].add(outcome.name)
    common = {"TF_ERROR", "NOT_INITIALIZED", "INVALID_PLUGIN", "INTERNAL_ERROR", "STOPPED"}
    assert names["plan"] == common | {"OUT_OF_MAP", "MAP_ERROR"}
    assert names["drive"] == common | {"INVALID_PATH"}


@pytest.mark.parametrize("outcome", PLAN_FAILURES + list(OWN["plan"]))
def test_recovery_of_planning(outcome):
    world = World(plan=[plan(outcome), plan()])
    end = world.run("a", "b")
    if outcome in FINAL:
        assert end.outcome == outcome and world.begun == ["plan 0"]
    else:
        assert end.outcome == 0 and world.begun == ["plan 0", "a", "plan 1", "drive 0"]
        assert f"plan 0 ends with {outcome}" in world.log[0] and "trying a" in world.log[0]
        assert world.log[1] == "the robot has a plan again, after a"


@pytest.mark.parametrize("outcome", [53, 54])
def test_a_goal_that_is_blocked_for_good_moves_no_robot(outcome):
    world = World(plan=[plan(outcome, lasting=True), plan()])
    end = world.run("a", "b")
    assert (end.outcome, end.message) == (outcome, f"plan 0 ends with {outcome}")
    assert world.begun == ["plan 0"] and world.counts["recover"] == 0
    # Also when the robot has moved already, and the next plan finds that out.
    world = World(plan=[plan(), plan(outcome, lasting=True)], drive=[drive(106)])
    assert world.run("a", "b").outcome == outcome
    assert world.begun == ["plan 0", "drive 0", "a", "plan 1"]


def test_what_an_answer_has_no_field_for():
    lasting = PlanAnswer(outcome=54, message="no path")
    lasting.lasting = True
    assert GoalEnd.of(GoalStatus.ABORTED, lasting).lasting
    for result in (PlanAnswer(outcome=54), GetPathResult(outcome=54), ExePathResult(outcome=106)):
        assert not GoalEnd.of(GoalStatus.ABORTED, result).lasting


@pytest.mark.parametrize("outcome", DRIVE_FAILURES + list(OWN["drive"]))
def test_recovery_of_driving(outcome):
    world = World(drive=[drive(outcome), drive()])
    end = world.run("a", "b")
    if outcome in FINAL:
        assert end.outcome == outcome and world.begun == ["plan 0", "drive 0"]
    else:
        assert end.outcome == 0
        assert world.begun == ["plan 0", "drive 0", "a", "plan 1", "drive 1"]


@pytest.mark.parametrize("kind, outcome", [("plan", 54), ("drive", 106)])
def test_recovery_can_be_switched_off(kind, outcome):
    world = World(**{kind: [Scripted(outcome)]})
    world.values["recovery_enabled"] = False
    assert world.run("a").outcome == outcome
    assert "a" not in world.begun


@pytest.mark.parametrize("failure", RECOVERY_FAILURES + list(OWN["recover"]))
def test_a_failed_behavior_is_a_failure(failure):
    """After it, planning is tried; the last one that fails ends all with the original error."""
    world = World(plan=[plan(54)], recover=[recover(failure)])
    end = world.run("a", "b")
    assert world.begun == ["plan 0", "a", "plan 1", "b"]
    assert end.outcome == 54
    assert end.message == "plan 1 ends with 54; recovery did not help: a, b"
    assert any(f"recovery a failed: a ends with {failure} ({failure})" == m for m in world.log)


def test_a_failed_behavior_may_be_followed_by_a_plan():
    world = World(plan=[plan(54), plan()], recover=[recover(152)])
    assert world.run("a", "b").outcome == 0
    assert world.begun == ["plan 0", "a", "plan 1", "drive 0"]


def test_behaviors_that_do_not_help_come_to_an_end():
    world = World(plan=[plan(54)])
    end = world.run("a", "b", "c")
    assert world.begun == ["plan 0", "a", "plan 1", "b", "plan 2", "c", "plan 3"]
    assert (end.outcome, end.message) == (
        54,
        "plan 3 ends with 54; recovery did not help: a, b, c",
    )


def test_original_error_of_driving():
    world = World(drive=[drive(106, value) for value in (0.1, 0.2)], recover=[recover(158)])
    end = world.run("a")
    assert world.begun == ["plan 0", "drive 0", "a"]
    assert (end.outcome, end.drive) == (106, "value of drive 0")


def test_the_chain_begins_anew_after_a_plan():
    world = World(plan=[plan(54), plan(), plan(54), plan(54), plan()], drive=[drive(106), drive()])
    assert world.run("a", "b", "c").outcome == 0
    # The plan was recovered by a, so that the drive begins with a; its trouble remains (b, c).
    expected = ["plan 0", "a", "plan 1", "drive 0", "a", "plan 2", "b", "plan 3", "c", "plan 4"]
    assert world.begun == [*expected, "drive 1"]


@pytest.mark.parametrize(
    "speed, reported, restarts",
    [(0.2, 0, True), (-0.2, 0, True), (0.01, 0, False), (0.2, 106, False), (0.0, 0, False)],
)
def test_the_chain_begins_anew_when_the_robot_gets_on(speed, reported, restarts):
    again = drive(106, 5.0, speed, reported=reported)
    world = World(drive=[drive(106), again, drive(106), drive(106), drive(106)])
    assert world.run("a", "b").outcome == 106
    used = [name for name in world.begun if name in "ab"]
    assert used == (["a", "a", "b"] if restarts else ["a", "b"])
    assert any("the robot gets on again, after a" in m for m in world.log) == restarts


def test_getting_on_by_nothing_does_not_count():
    world = World(drive=[drive(106, 5.0, 0.005)])
    world.values["oscillation_distance"] = 0.0
    assert world.run("a", "b").outcome == 106
    assert world.counts["recover"] == 2


def test_planning_and_driving_that_fail_in_turn_come_to_an_end():
    world = World(plan=[plan(), plan(54)] * 50, drive=[drive(106)])
    assert world.run("a", "b", "c").outcome in (54, 106)
    assert world.counts["recover"] <= 2 * 3


REJECTED = [("plan", 59), ("drive", 113), ("recover", 155)]


@pytest.mark.parametrize("kind, outcome", REJECTED)
def test_a_rejected_sub_goal_is_an_error(kind, outcome):
    scripts = {"plan": [plan(54)]} if kind == "recover" else {}
    scripts[kind] = [Scripted(outcome, state=GoalStatus.REJECTED)]
    world = World(**scripts)
    end = world.run("a", "b")
    assert end.outcome == outcome
    assert end.message.endswith(f"ends with {outcome}")
    assert world.counts["recover"] == (kind == "recover")


@pytest.mark.parametrize("kind, outcome", [("plan", 51), ("drive", 101), ("recover", 151)])
def test_a_sub_goal_that_others_cancel_ends_it(kind, outcome):
    scripts = {"plan": [plan(54)]} if kind == "recover" else {}
    scripts[kind] = [Scripted(outcome, state=GoalStatus.PREEMPTED)]
    world = World(**scripts)
    end = world.run("a", "b")
    assert end.outcome == 11
    assert "was canceled, not by move_base" in end.message
    assert f"ends with {outcome}" in end.message
    assert not world.active


def test_every_recovery_gets_the_original_message():
    world = World(plan=[plan(54), plan(53)])
    world.run("a")
    assert "planning failed: plan 0 ends with 54 (54); trying a" in world.log
