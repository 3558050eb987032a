"""A robot that is not localized for a while: what it was driving along is no plan any more."""

import pytest
from move_base_world import World, drive, plan, recover

TF_ERROR = 111


def losing(world, begin, end, times):
    """Nobody knows where the robot is, from begin to end (s)."""

    def lose():
        world.lost, world.times = True, None

    def find():
        world.lost, world.times = False, times

    world.at(begin, lose)
    world.at(end, find)


def test_it_gets_another_plan_once_it_is_localized():
    world = World(drive=[drive(0, 100.0, 0.5), drive(0, 5.0)])
    losing(world, 3.0, 40.0, 2)
    assert world.run("a").outcome == 0
    assert world.begun == ["plan 0", "drive 0", "plan 1", "drive 1"]
    assert dict(world.starts)["plan 1"] == pytest.approx(40.05, abs=0.04)
    assert world.log == ["the robot was not localized meanwhile, and gets another plan"]


def test_nothing_is_planned_meanwhile():
    world = World(drive=[drive(0, 100.0, 0.5), drive(0, 5.0)])
    world.values.update(planner_frequency=2.0)
    losing(world, 3.2, 40.0, 2)
    assert world.run().outcome == 0
    times = [when for name, when in world.starts if name.startswith("plan")]
    assert not [when for when in times if 3.3 < when < 40.0] and len(times) > 5


def test_a_moment_between_two_looks_counts():
    world = World(drive=[drive(0, 100.0, 0.5), drive(0, 5.0)])
    world.at(3.0, lambda: setattr(world, "times", 2))
    assert world.run().outcome == 0
    assert world.begun == ["plan 0", "drive 0", "plan 1", "drive 1"]


def test_a_drive_that_fails_where_the_robot_is_found_is_planned_anew():
    """Too far from its path, that is, which no recovery behavior can help."""
    world = World(drive=[drive(108, 10.0), drive(0, 5.0)])
    losing(world, 3.0, 9.995, 2)
    assert world.run("a").outcome == 0
    assert world.begun == ["plan 0", "drive 0", "plan 1", "drive 1"]


def test_it_ends_where_the_drive_loses_patience():
    world = World(drive=[drive(TF_ERROR, 10.0)])
    losing(world, 3.0, 50.0, 2)
    end = world.run("a")
    assert (end.outcome, end.message) == (TF_ERROR, f"drive 0 ends with {TF_ERROR}")
    assert world.begun == ["plan 0", "drive 0"] and world.time < 11.0


def test_it_has_arrived_before_it_is_stopped():
    world = World(drive=[drive(0, 4.0, after_cancel=2.0)])
    world.at(3.0, lambda: setattr(world, "times", 2))
    assert world.run().outcome == 0
    assert world.begun == ["plan 0", "drive 0"]


def test_a_drive_that_does_not_end_is_not_followed_by_another_one():
    world = World(drive=[drive(0, 900.0, after_cancel=100.0)])
    world.at(3.0, lambda: setattr(world, "times", 2))
    end = world.run("a")
    assert end.outcome == 17 and "may be elsewhere" in end.message
    assert "exe_path does not end" in end.message and world.counts["plan"] == 1


def test_the_last_recovery_that_fails_for_it_does_not_end_the_goal():
    world = World(drive=[drive(106), drive(0, 5.0)], recover=[recover(152, 15.0)])
    losing(world, 3.0, 12.0, 2)
    assert world.run("a").outcome == 0
    assert world.begun == ["plan 0", "drive 0", "a", "plan 1", "drive 1"]
    world = World(drive=[drive(106), drive(0, 5.0)], recover=[recover(152, 15.0)])
    assert world.run("a").outcome == 106


def test_a_plan_that_fails_is_none():
    world = World(plan=[plan(), plan(63)], drive=[drive(0, 100.0)])
    losing(world, 3.0, 5.0, 2)
    assert world.run().outcome == 63
