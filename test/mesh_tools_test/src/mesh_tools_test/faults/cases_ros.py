"""Faults: what is done, from when on the robot has to stand, and until when."""

import contextlib
import math
import os
import signal
import threading
import time
from pathlib import Path
from typing import Callable, ContextManager, Dict, Iterator, NamedTuple

import rospy
from dynamic_reconfigure.client import Client
from mesh_msgs.testing import wait_until
from std_srvs.srv import Trigger

from mesh_tools_test.driving.obstacles import RADIUS
from mesh_tools_test.driving.server_nodes import SERVER
from mesh_tools_test.faults import stage_ros
from mesh_tools_test.faults.stage_ros import GOAL, PATIENCE, Goal, Stage
from mesh_tools_test.faults.verdicts import Run

SILENCE = 0.3  # s without the server or its guard, from which on it is a fault
REPLACED = 1.0  # s until the server ends a guard that is stuck, and starts the next one
AT_X = 3.0  # m, where the robot then is
NEARER = 0.02  # m that the robot may come nearer to a wall than its radius
SEEN = 0.5  # s of driving, after which the robot can still brake before a wall
_TRIES = 3
_LONGEST, _AFTER = 5.0, 0.5  # s: how long a stop is waited for, and looked at


class Fault:
    """From when on the robot has to stand, and until when (s, monotonic)."""

    def __init__(self, begin: float = 0.0) -> None:
        self.begin, self.end = begin, math.inf


class Case(NamedTuple):
    """A kind of fault."""

    text: str
    happen: Callable[[Stage], ContextManager[Fault]]
    """While it is open, the fault is there."""
    outlasts: bool
    """Whether it is there until the goal is answered, or only until the robot stands."""


def run(stage: Stage, case: Case) -> Run:
    """One drive with one fault; another one where it was over before anybody saw it begin, as on a
    machine so busy that the server still has the robot where the drive before has ended."""
    for _ in range(_TRIES):
        found = _run_once(stage, case)
        if not (found.remark and found.answer == "SUCCESS"):
            break
    return found


def _run_once(stage: Stage, case: Case) -> Run:
    stage.reset()
    begin = time.monotonic()
    goal = Goal(stage.navigator)
    try:
        stage.wait(lambda: goal.answer or is_under_way(stage), None)
        if goal.answer or not is_under_way(stage):
            why = goal.message or "no answer"
            remark = "the drive did not begin: " + why
            return Run(math.inf, 0, 0.0, goal.answer, goal.message, remark)
        with case.happen(stage) as fault:
            if case.outlasts:
                stage.wait(lambda: goal.answer, None)
            else:
                stage.wait(lambda: not stage.record.moving, None, _LONGEST)
                time.sleep(_AFTER)
            fault.end = min(fault.end, time.monotonic())
        stage.wait(lambda: goal.answer, None)
        answer = goal.answer
    finally:
        goal.end()
    stage.record.update()
    stop = stage.record.stop_after(fault.begin)
    moves = stage.record.moves_between(stop, fault.end)
    room = stage.room(begin) + NEARER
    return Run(stop - fault.begin, moves, room, answer, goal.message)


def is_under_way(stage: Stage) -> bool:
    """Whether the robot is in the middle of its drive."""
    return bool(AT_X < stage.record.position()[0] < GOAL[0] - 1.0 and stage.record.moving)


@contextlib.contextmanager
def tf_stops(stage: Stage) -> Iterator[Fault]:
    stage.tf.turn(False)
    yield Fault(stage.tf.last + stage_ros.ODOM_TIMEOUT)
    stage.tf.turn(True)


@contextlib.contextmanager
def cloud_stops(stage: Stage) -> Iterator[Fault]:
    stage.clouds.turn(False)
    yield Fault(stage.clouds.last + stage_ros.CLOUD_TIMEOUT)
    stage.clouds.turn(True)


@contextlib.contextmanager
def planner_holds(stage: Stage) -> Iterator[Fault]:
    path = stage.notes / "holding"
    asked = threading.Thread(
        target=lambda: stage.navigator.get_path(*GOAL, planner="holding"), daemon=True
    )
    asked.start()
    begin = _noted(path)
    fault = Fault(begin + SILENCE)
    fault.end = begin + stage_ros.HELD
    yield fault
    asked.join()
    path.unlink()


@contextlib.contextmanager
def controller_blocks(stage: Stage) -> Iterator[Fault]:
    path = stage.notes / "blocking"
    path.touch()
    yield Fault(_noted(path) + SILENCE)
    path.unlink()


@contextlib.contextmanager
def server_killed(stage: Stage) -> Iterator[Fault]:
    begin = time.monotonic()
    stage.kill_server()
    yield Fault(begin)
    stage.start_server()


@contextlib.contextmanager
def guard_killed(stage: Stage) -> Iterator[Fault]:
    pid = stage.guard().getPid("/faults")[2]
    fault = Fault(time.monotonic())
    os.kill(pid, signal.SIGKILL)
    fault.end = fault.begin  # the next one may drive on as soon as it is there
    yield fault


@contextlib.contextmanager
def guard_stopped(stage: Stage) -> Iterator[Fault]:
    pid = stage.guard().getPid("/faults")[2]
    begin = time.monotonic()
    os.kill(pid, signal.SIGSTOP)
    fault = Fault(begin + SILENCE)
    fault.end = begin + REPLACED
    try:
        yield fault
        wait_until(lambda: not Path("/proc/%d" % pid).exists(), "the end of the guard")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)


@contextlib.contextmanager
def map_reloaded(stage: Stage) -> Iterator[Fault]:
    fault = Fault(time.monotonic())
    rospy.ServiceProxy(SERVER + "/reload_map", Trigger)()
    yield fault


@contextlib.contextmanager
def layer_fails(stage: Stage) -> Iterator[Fault]:
    client = Client(SERVER + "/mesh_map/border", PATIENCE)
    path = stage.notes / "failing"
    path.touch()
    client.update_configuration({"border_cost": 0.5})  # which the failing layer reads
    yield Fault(_noted(path))
    path.unlink()
    client.update_configuration({"border_cost": 1.0})
    client.close()


@contextlib.contextmanager
def wall_appears(stage: Stage) -> Iterator[Fault]:
    speed, braking = stage_ros.SPEED, stage_ros.SPEED / stage_ros.ACCELERATION
    stage.put_wall(RADIUS + speed * SEEN + speed * braking / 2)
    # When who uses all of that room stands; who keeps more of it may still look for another path.
    fault = Fault(time.monotonic() + SEEN + braking)
    fault.end = fault.begin
    yield fault


def _noted(path: Path) -> float:
    """The moment in a file of a plugin that fails, as soon as it is there."""
    return float(wait_until(lambda: path.exists() and path.read_text(), "%s of the plugin" % path))


CASES: Dict[str, Case] = {
    "tf": Case("TF stops", tf_stops, True),
    "cloud": Case("cloud stops", cloud_stops, False),
    "lock": Case("planner holds lock", planner_holds, False),
    "controller": Case("controller blocks", controller_blocks, True),
    "server": Case("server killed", server_killed, True),
    "guard": Case("guard killed", guard_killed, False),
    "stuck": Case("guard stopped", guard_stopped, False),
    "map": Case("map reloaded", map_reloaded, True),
    "layer": Case("layer fails", layer_fails, True),
    "wall": Case("wall appears", wall_appears, True),
}
