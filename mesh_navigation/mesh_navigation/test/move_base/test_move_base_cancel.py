"""Cancels at every moment, sub-goals that do not obey, and hundreds of random courses."""

import math
import random

import pytest
from move_base_world import Scripted, World, drive, plan, recover


def course():
    """Plans that fail and succeed, behaviors, a drive with new plans, the arrival."""
    world = World(
        plan=[plan(54, 0.3), plan(0, 0.3), plan(0, 0.2)],
        drive=[drive(106, 0.45, 1.0), drive(0, 1.5, 1.0)],
        recover=[recover(150, 0.4), recover(0, 0.4)],
    )
    world.values["planner_frequency"] = 2.0
    return world


def test_the_course_without_a_cancel():
    world = course()
    assert world.run("a", "b", "c").outcome == 0
    assert [name for name in world.begun if name in "abc"] == ["a", "a"]
    assert {"plan 3", "drive 2"} <= set(world.begun)
    assert world.time > 3.0


def test_a_cancel_at_every_moment():
    whole = course()
    whole.run("a", "b", "c")
    during = set()
    for number in range(int(whole.time / 0.01)):
        world, begun = course(), []

        def cancel():
            begun.extend(world.begun)
            world.cancellation.cancel("for a test")

        world.at(number * 0.01, cancel)
        end = world.run("a", "b", "c")
        assert end.outcome == 11, f"canceled after {number * 0.01} s"
        assert "for a test" in end.message
        assert not world.active and world.begun == begun
        assert world.time <= number * 0.01 + 0.13
        during.add(end.message.split(":")[0])
    stages = ("get_path", "exe_path", "recovery a")
    assert during >= {f"canceled during {stage}" for stage in stages}


def test_a_cancel_before_the_start():
    world = course()
    world.cancellation.cancel("before")
    assert world.run().outcome == 11
    assert world.counts["drive"] == 0 and not world.active


@pytest.mark.parametrize("kind", ["plan", "drive", "recover"])
def test_the_answer_does_not_wait_for_the_deaf(kind):
    scripts = {"plan": [plan(54)]} if kind == "recover" else {}
    scripts[kind] = [Scripted(0, math.inf, after_cancel=math.inf)]
    world = World(**scripts)
    world.at(1.0, lambda: world.cancellation.cancel("for a test"))
    end = world.run("a")
    assert end.outcome == 11 and "has not ended within 5 s" in end.message
    assert world.time < 1.0 + 5.1


def test_others_cancel_the_drive_at_every_moment():
    """Also while a new plan takes over: the robot stops."""
    for number in range(120):
        world = World(drive=[drive(0, 1000.0, 1.0)])
        world.values["planner_frequency"] = 20.0

        def cancel():
            for goal in world.active:
                if goal.kind == "drive":
                    goal.cancel("of somebody else")

        moment = 0.5 + number * 0.01
        world.at(moment, cancel)
        end = world.run("a")
        assert end.outcome == 11 and "of somebody else" in end.message
        assert not world.active and world.time < moment + 0.3


def random_script(rng, outcomes):
    def entry():
        return Scripted(
            rng.choice(outcomes),
            rng.choice([0.0, 0.05, 0.3, 2.0]),
            rng.choice([-0.5, 0.0, 0.5]),
            rng.choice([-1.0, 0.0, 1.0]),
            rng.choice([0, 0, 106]),
            after_cancel=rng.choice([0.0, 0.05, 0.5]),
        )

    return [entry() for _ in range(rng.randrange(1, 8))]


@pytest.mark.parametrize("seed", range(300))
def test_random_courses_end(seed):
    """With an outcome and a message, nothing left running, never two that command the robot."""
    rng = random.Random(seed)
    world = World(
        goal_x=rng.uniform(0.0, 3.0),
        plan=random_script(rng, [0, 0, 0, 54, 61, 75]),
        drive=random_script(rng, [0, 105, 106, 109, 114, 122]),
        recover=random_script(rng, [0, 150, 152, 180]),
    )
    world.values.update(
        planner_frequency=rng.choice([0.0, 1.0, 20.0]),
        oscillation_timeout=rng.choice([0.0, 0.5, 1.0]),
        oscillation_distance=rng.choice([0.0, 0.1, 0.5]),
        recovery_enabled=rng.random() < 0.9,
    )
    canceled = rng.random() < 0.5
    # Where all succeeds again and again but for a robot that moves to and fro, a client ends it.
    world.at(rng.uniform(0.0, 10.0) if canceled else 60.0, world.cancellation.cancel)
    end = world.run(*"abc"[: rng.randrange(4)])
    known = {0, 11, 13, 54, 61, 75, 106, 109, 114, 122}
    assert end.outcome in known
    assert (end.outcome == 11) == world.cancellation.canceled
    assert not world.active
