"""Controllers that block: the robot stands, and everybody gets an answer."""

import math
import threading
import time

import numpy as np
import pytest
from driving_fakes import (
    FORWARD,
    TOLERANCES,
    PlaneRobot,
    SystemClock,
    Told,
    plan_to,
    values_with,
)

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.robot import STOP, GuardedRobot
from mesh_navigation.execution.supervised_execution import SupervisedExecution
from mesh_navigation.plugins.controller import Command


class LiveRobot(PlaneRobot):
    """Moves by the computer's time."""

    def __init__(self):
        super().__init__()
        self.lock, self.time = threading.Lock(), time.monotonic()

    def state(self):
        with self.lock:
            self.advance(time.monotonic() - self.time)
            return super().state()

    def drive(self, velocity):
        with self.lock:
            self.advance(time.monotonic() - self.time)
            super().drive(velocity)


class World:
    def __init__(self, controller=None, on_cycle=None, **values):
        self.robot, self.cancellation, self.cycles = LiveRobot(), Cancellation(), []
        self.controller = controller or Told(Command(0, "", FORWARD))
        self.execution = SupervisedExecution(
            self.robot, SystemClock(), values_with(**values), on_cycle or self.cycles.append
        )

    def run(self, goal=0.4):
        result = self.execution.run(
            self.controller, plan_to(goal, 0.0), TOLERANCES, self.cancellation
        )
        self.number = len(self.robot.commands), len(self.cycles)
        assert result.message and self.robot.command == STOP
        assert not self.execution.replace(plan_to(1.0, 0.0), TOLERANCES)
        return result


def cancel_soon(world, seconds):
    timer = threading.Timer(seconds, world.cancellation.cancel, ["by a test"])
    timer.start()
    return timer


def test_a_good_controller_drives_as_ever():
    world = World()
    result = world.run()
    assert result.outcome == 0 and 0.3 <= result.final_pose.position[0]
    assert len(world.cycles) >= 5


@pytest.mark.parametrize("method", ["set_plan", "is_goal_reached", "compute_velocity"])
def test_cancel_of_a_controller_that_blocks(method):
    world, release = World(), threading.Event()

    def block(*_):
        release.wait(60)
        return Command(0, "", FORWARD) if method == "compute_velocity" else False

    setattr(world.controller, method, block)
    timer = cancel_soon(world, 0.3)
    result = world.run()
    assert result.outcome == ExePathOutcome.CANCELED
    assert "by a test" in result.message and "did not stop" in result.message
    # What it still says does not reach the robot, nor those who listen.
    release.set()
    time.sleep(0.3)
    assert (len(world.robot.commands), len(world.cycles)) == world.number
    timer.join()


def test_a_controller_that_listens_stops_in_time():
    world = World()

    def compute_velocity(state, cancellation):
        assert cancellation.wait(60)
        return Command(101, "I stop")

    world.controller.compute_velocity = compute_velocity
    timer = cancel_soon(world, 0.2)
    result = world.run()
    assert result.outcome == ExePathOutcome.CANCELED and "did not stop" not in result.message
    timer.join()


def test_patience_with_a_controller_that_blocks():
    release = threading.Event()
    world = World(
        Told(Command(0, "", FORWARD), lambda state: release.wait(60)), controller_patience=0.6
    )
    result = world.run()
    assert result.outcome == ExePathOutcome.PAT_EXCEEDED
    assert "controller_patience 0.60 s" in result.message and "did not stop" in result.message
    release.set()


def test_the_robot_stands_while_the_controller_takes_long():
    world, stood = World(), []

    def slow(state):
        end = time.monotonic() + 30
        while world.robot.command != STOP and time.monotonic() < end:
            time.sleep(0.01)
        stood.append(world.robot.command == STOP)
        return Command(0, "", FORWARD)

    world.controller.answers = [Command(0, "", FORWARD), slow, Command(0, "", FORWARD)]
    assert world.run().outcome == 0 and stood == [True]


def test_a_listener_that_fails():
    world = World(on_cycle=lambda cycle: 1 / 0)
    result = world.run()
    assert result.outcome == ExePathOutcome.INTERNAL_ERROR and "ZeroDivision" in result.message


def test_cancels_at_random_times():
    random = np.random.default_rng(5)
    for _ in range(40):
        world = World(controller_frequency=100.0)
        timer = cancel_soon(world, random.uniform(0.0, 0.1))
        result = world.run(goal=9.0)
        assert result.outcome == ExePathOutcome.CANCELED and "by a test" in result.message
        timer.join()


def test_without_a_pose():
    world = World(tf_timeout=0.1)
    world.robot.lost = "nowhere"
    result = world.run()
    text = "nowhere; waited for 0.1 s (tf_timeout)"
    assert result[:3] == (ExePathOutcome.TF_ERROR, text, None)
    assert math.isnan(result.dist_to_goal)


def test_a_new_plan():
    world = World()
    threading.Timer(0.3, world.execution.replace, [plan_to(0.6, 0.0), TOLERANCES]).start()
    result = world.run(goal=9.0)
    assert result.outcome == 0 and len(world.controller.plans) == 2


def test_a_robot_that_is_taken_away_stands():
    robot = LiveRobot()
    guarded = GuardedRobot(robot)
    guarded.drive(FORWARD)
    assert robot.command == FORWARD and guarded.trail is robot.trail
    guarded.close()
    assert robot.command == STOP
    robot.drive(FORWARD)
    guarded.drive(STOP)
    guarded.close()
    assert robot.command == FORWARD
    assert guarded.state().velocity == FORWARD
