"""Replanning and oscillation while the robot drives."""

import math

import pytest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import ExePathFeedback
from move_base_world import Scripted, World, drive, plan
from nav_msgs.msg import Path

from mesh_navigation.move_base.sub_goals import SubActions


def plans(world):
    return [time for name, time in world.starts if name.startswith("plan")]


def test_plans_come_at_the_frequency_and_are_injected():
    world = World(drive=[drive(0, 9.0, 1.0)])
    world.values["planner_frequency"] = 0.5
    end = world.run()
    assert end.outcome == 0 and end.drive == "value of drive 4"
    assert plans(world) == pytest.approx([0, 2.1, 4.1, 6.1, 8.1], abs=0.1)
    each = [name for number in range(5) for name in (f"plan {number}", f"drive {number}")]
    assert world.begun == each
    # The robot never stood between an old plan and a new one.
    assert world.calls.count("end of drive 3") == 1
    assert world.x == pytest.approx(world.time - 0.1, abs=0.03)


def test_no_plans_at_frequency_zero():
    world = World(drive=[drive(0, 20.0, 1.0)])
    assert world.run().outcome == 0
    assert plans(world) == [0]


def test_frequency_may_change_while_driving():
    world = World(drive=[drive(0, 4.0, 1.0)])
    world.at(2.0, lambda: world.values.update(planner_frequency=1.0))
    world.at(2.5, lambda: world.values.update(planner_frequency=0.0))
    assert world.run().outcome == 0
    assert plans(world) == pytest.approx([0, 2.0], abs=0.05)


def test_no_plans_near_the_goal():
    world = World(goal_x=3.1, plan=[plan(0, 0.02)], drive=[drive(0, 3.09, 1.0)])
    world.values["planner_frequency"] = 100.0
    assert world.run().outcome == 0
    assert len(plans(world)) > 10 and 2.9 < max(plans(world)) < 3.05 < world.time - 0.05


def test_a_plan_that_comes_near_the_goal_is_not_used():
    world = World(goal_x=2.0, plan=[plan(), plan(0, 0.91)], drive=[drive(0, 1.99, 1.0)])
    world.values["planner_frequency"] = 1.0
    assert world.run().outcome == 0
    assert world.begun == ["plan 0", "drive 0", "plan 1"]
    assert world.calls[-2:] == ["end of plan 1", "end of drive 0"]


def test_one_plan_at_a_time():
    world = World(plan=[plan(), plan(0, 3.0)], drive=[drive(0, 8.0, 1.0)])
    world.values["planner_frequency"] = 10.0
    assert world.run().outcome == 0
    # As soon as one has ended the next begins; the world asserts that it is one at a time.
    assert plans(world)[:4] == pytest.approx([0, 0.2, 3.2, 6.2], abs=0.1)


def test_a_failed_plan_keeps_the_old_one_and_is_told_once():
    failing = [plan(54)] * 3 + [plan(52)] * 2 + [plan()] * 2 + [plan(54)]
    world = World(plan=[plan(), *failing], drive=[drive(0, 7.5, 1.0)])
    world.values["planner_frequency"] = 1.0
    assert world.run("a").outcome == 0
    assert "a" not in world.begun
    assert [message.split(":")[0] for message in world.log] == [
        "no new plan, the robot follows the old one",
        "no new plan, the robot follows the old one",
        "planning succeeds again",
    ]
    assert "(54)" in world.log[0] and "(52)" in world.log[1]


def test_plans_that_fail_now_and_then_are_not_told():
    """A start that is blocked for a moment is part of driving."""
    world = World(plan=[plan(), plan(54), plan(54), plan(), plan(54)] * 3, drive=[drive(0, 14, 1)])
    world.values["planner_frequency"] = 1.0
    assert world.run("a").outcome == 0
    assert world.counts["plan"] > 10 and world.log == []


@pytest.mark.parametrize("state, outcome", [("REJECTED", 59), ("PREEMPTED", 51)])
def test_new_plans_that_are_rejected_or_canceled_by_others(state, outcome):
    world = World(
        plan=[plan(), Scripted(outcome, state=getattr(GoalStatus, state))],
        drive=[drive(0, 3.0, 1.0)],
    )
    world.values["planner_frequency"] = 1.0
    assert world.run().outcome == 0
    assert world.counts == {"plan": 3, "drive": 1, "recover": 0}


def test_a_plan_is_canceled_when_the_drive_ends():
    world = World(plan=[plan(), plan(0, 1000.0)], drive=[drive(106, 2.0, 1.0)])
    world.values["planner_frequency"] = 1.0
    assert world.run().outcome == 106
    assert world.calls[-1] == "end of plan 1" and world.time < 3.0


def test_time_that_jumps_back():
    world = World(drive=[drive(0, 12.0, 1.0)])
    world.values.update(planner_frequency=0.25, oscillation_timeout=3.0)
    world.at(2.0, lambda: setattr(world, "jump", -100.0))
    assert world.run().outcome == 0
    assert plans(world) == pytest.approx([0, 2.0, 6.1, 10.1], abs=0.2)


# Oscillation


@pytest.mark.parametrize(
    "speed, turn, outcome",
    [(0.0, 0.0, 13), (0.09, 0.0, 13), (0.0, 0.5, 13), (0.11, 0.0, 0), (0.0, 0.7, 0)],
)
def test_oscillation_is_no_way_and_no_turn(speed, turn, outcome):
    world = World(drive=[drive(0, 30.0, speed, turn)])
    world.values.update(oscillation_timeout=5.0, oscillation_angle=3.0)
    end = world.run()
    assert end.outcome == outcome
    if outcome:
        assert world.time == pytest.approx(5.2, abs=0.1)
        assert "5.0 s" in end.message and "0.50 m" in end.message
        assert end.drive == "value of drive 0"


def test_oscillation_is_not_looked_for_by_default():
    assert World(drive=[drive(0, 300.0)]).run().outcome == 0


def test_a_robot_that_waits_for_its_pose_does_not_oscillate():
    world = World(drive=[drive(0, 12.0, 1.0)])
    world.values.update(oscillation_timeout=2.0, planner_frequency=1.0)
    world.at(3.0, lambda: setattr(world, "lost", True))
    world.at(9.0, lambda: setattr(world, "lost", False))
    assert world.run().outcome == 0
    assert not [when for when in plans(world) if 3.2 < when < 9.0]


def test_progress_is_told_with_and_without_a_pose():
    class Server:
        def send(self, goal, on_feedback, owner):
            self.tell = on_feedback

    server, told, heard = Server(), [], []
    actions = SubActions(None, server, None, PoseStamped(), "", "", heard.append)
    actions.drive(Path(), told.append)
    feedback = ExePathFeedback(outcome=3, dist_to_goal=2.0)
    feedback.current_pose.pose.orientation.w = 1.0
    for frame in ("map", ""):
        feedback.current_pose.header.frame_id = frame
        server.tell(feedback)
    assert told[0][1:] == (2.0, 3) and told[1] is None
    assert heard == [feedback] * 2


def test_oscillation_ends_the_drive_before_the_recovery():
    world = World(drive=[drive(0, math.inf), drive(0, 3.0, 1.0)])
    world.values["oscillation_timeout"] = 2.0
    assert world.run("a", "b").outcome == 0
    expected = ["plan 0", "end of plan 0", "drive 0", "end of drive 0", "a", "end of a", "plan 1"]
    assert world.calls[:7] == expected


def test_every_behavior_gets_its_time_and_the_end_is_oscillation():
    world = World(drive=[drive(0, math.inf)], recover=[Scripted(0, 10.0)])
    world.values["oscillation_timeout"] = 2.0
    end = world.run("a", "b")
    assert end.outcome == 13 and end.message.endswith("recovery did not help: a, b")
    assert world.counts == {"plan": 3, "drive": 3, "recover": 2}
    assert world.time == pytest.approx(3 * 2.2 + 2 * 10, abs=0.5)


def test_oscillation_goes_on_over_new_plans():
    world = World(drive=[drive(0, math.inf)])
    world.values.update(oscillation_timeout=5.0, planner_frequency=1.0)
    assert world.run().outcome == 13
    assert world.time == pytest.approx(5.2, abs=0.2) and world.counts["drive"] == 5


def test_a_drive_that_arrives_while_it_is_canceled_has_arrived():
    world = World(drive=[drive(0, 5.05, after_cancel=1.0)])
    world.values["oscillation_timeout"] = 5.0
    world.values["oscillation_distance"] = 1.0
    assert world.run("a").outcome == 0


def test_a_drive_that_does_not_end_is_not_joined_by_a_behavior():
    world = World(drive=[drive(0, math.inf, after_cancel=math.inf)])
    world.values["oscillation_timeout"] = 1.0
    end = world.run("a")
    assert end.outcome == 17 and "does not end" in end.message
    assert world.counts["recover"] == 0 and world.time < 10.0


def test_what_nobody_expects_ends_the_drive_too():
    world = World(drive=[drive(0, 9.0, 1.0)])
    world.at(2.0, world.values.clear)
    with pytest.raises(KeyError):
        world.run()
    assert world.calls[-1] == "end of drive 0" and not world.active
