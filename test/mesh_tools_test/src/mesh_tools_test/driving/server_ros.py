"""The real server, measured: cycles while it drives and plans, get_path, memory."""

import os
import tempfile
import threading
import time
from typing import Any, List, NamedTuple, Optional, Tuple

import actionlib
import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import (
    ExePathActionFeedback,
    GetPathAction,
    GetPathGoal,
    MoveBaseAction,
    MoveBaseGoal,
)
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.planning import make_planner
from osmesa_harness.master import private_master
from std_msgs.msg import Float32

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.driving import server_nodes
from mesh_tools_test.driving.server_nodes import SERVER, Nodes
from mesh_tools_test.driving.trips import Trip, near_trip, trip
from mesh_tools_test.driving.worlds import DrivingWorld

PERIOD = 0.05  # s, of control cycles
PATIENCE = 300.0  # s, for anything
COMPARED = 20  # plans whose times are compared
LATE_SHARE, CYCLE, OVERHEAD = 0.1, 5.0, 50.0  # floors: %, ms, ms
DRIVEN_LONG = 60.0  # s: floors do not hold for less


class Control(NamedTuple):
    """How the robot was driven."""

    taken: np.ndarray
    """(N,) ms of each cycle."""
    gaps: np.ndarray
    """(M,) s from one command to the next, within drives."""
    outcomes: List[Tuple[int, str]]
    """Of the drives that ended."""


def measure(faces: int, minutes: float, plans: int) -> List[Figure]:
    """All of it; can be called once in a process."""
    with tempfile.TemporaryDirectory() as folder, private_master(os.environ) as environment:
        server_nodes.own_environment(environment)
        path = os.path.join(folder, "map.h5")
        world = server_nodes.stored_world(faces, path)
        rospy.init_node("navigation_benchmark", anonymous=True, disable_signals=True)
        for name, values in server_nodes.parameters(path, trip(world, 0).start).items():
            rospy.set_param(name, values)
        begin = time.monotonic()
        with server_nodes.running(environment, folder) as nodes:
            try:
                client = _client("get_path", GetPathAction)
                accepted = time.monotonic() - begin
                _plan(client, trip(world, 0), nodes)
                ready = time.monotonic() - begin
                at_first = nodes.memory()
                found = [
                    Figure("server: start to its actions", accepted, "s"),
                    Figure("  to its first plan", ready, "s"),
                ]
                found += overhead(world, client, nodes)
                found += control_figures(drives(world, nodes, 60.0 * minutes), 60.0 * minutes)
                found.append(Figure("memory of the server, ready", at_first, "MiB"))
                found.append(Figure("  after driving", nodes.memory(), "MiB"))
                found += memory(world, client, nodes, plans)
            finally:
                rospy.signal_shutdown("measured")
    return found


def overhead(world: DrivingWorld, client: Any, nodes: Nodes) -> List[Figure]:
    """What get_path takes beside the planner, which makes the same plans in this process."""
    planner = make_planner(world.mesh_map)
    asked, own = [], []
    for seed in range(1, COMPARED + 1):
        wanted = trip(world, seed)
        seconds, outcome = _plan(client, wanted, nodes)
        if outcome:
            continue  # The sensor has seen something on start or goal.
        asked.append(seconds)
        begin = time.monotonic()
        planner.make_plan(wanted.start, wanted.goal)
        own.append(time.monotonic() - begin)
    more = 1000.0 * (np.array(asked) - np.array(own))
    return [
        Figure("get_path, goal to result: median", 1000.0 * float(np.median(asked)), "ms"),
        Figure("  of that beside the planner", float(np.median(more)), "ms", floor=OVERHEAD),
    ]


def drives(world: DrivingWorld, nodes: Nodes, seconds: float) -> Control:
    """Drive from goal to goal, with a plan every second, while clouds come."""
    client = _client("move_base", MoveBaseAction)
    taken: List[float] = []
    stamps: List[List[float]] = []

    def note_feedback(message: ExePathActionFeedback) -> None:
        if stamps:
            stamps[-1].append(message.feedback.last_cmd_vel.header.stamp.to_sec())

    subscribers = [
        rospy.Subscriber(
            SERVER + "/mesh_controller/cycle_time",
            Float32,
            lambda message: taken.append(1000.0 * message.data),
            queue_size=1000,
        ),
        rospy.Subscriber(
            SERVER + "/exe_path/feedback", ExePathActionFeedback, note_feedback, queue_size=1000
        ),
    ]
    outcomes: List[Tuple[int, str]] = []
    end, seed = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        goal = MoveBaseGoal(target_pose=stamped(trip(world, seed).goal))
        seed += 1
        stamps.append([])
        result = _ask(client, goal, nodes, end)
        if result is not None:
            outcomes.append((result.outcome, result.message))
    for subscriber in subscribers:
        subscriber.unregister()
    gaps = [np.diff(some) for some in stamps if len(some) > 1]
    return Control(np.array(taken), np.concatenate(gaps or [np.zeros(0)]), outcomes)


def control_figures(control: Control, seconds: float) -> List[Figure]:
    """Of the cycles of drives; RuntimeError if there were none."""
    if not len(control.taken) or not len(control.gaps):
        raise RuntimeError("nothing was driven: %s" % control.outcomes[:3])
    long = seconds >= DRIVEN_LONG
    late = 100.0 * float((control.gaps > 1.5 * PERIOD).mean())
    good = sum(outcome < 10 for outcome, _ in control.outcomes)
    p50, p99 = np.percentile(control.taken, (50, 99))
    return [
        Figure("driving for %.0f s: cycles" % seconds, float(len(control.taken)), ""),
        Figure("  median", float(p50), "ms"),
        Figure("  99 %", float(p99), "ms", floor=CYCLE if long else None),
        Figure("  longest", float(control.taken.max()), "ms"),
        Figure("  commands late by half a cycle", late, "%", floor=LATE_SHARE if long else None),
        Figure("  longest time between two", 1000.0 * float(control.gaps.max()), "ms"),
        Figure("  drives that arrived", float(good), "of %d" % len(control.outcomes)),
    ]


def memory(world: DrivingWorld, client: Any, nodes: Nodes, plans: int) -> List[Figure]:
    """Of the server, after some and after many plans."""
    quarter = 0.0
    for number in range(plans):
        _plan(client, near_trip(world, number), nodes)
        if number == plans // 4:
            quarter = nodes.memory()
    return [
        Figure("  after %d plans" % (plans // 4), quarter, "MiB"),
        Figure("  after %d plans" % plans, nodes.memory(), "MiB"),
        Figure("  at most", nodes.memory("VmHWM"), "MiB"),
    ]


def stamped(pose: Pose) -> PoseStamped:
    """A message of a pose in the map's frame."""
    message = PoseStamped()
    message.header.frame_id = "map"
    position, turn = message.pose.position, message.pose.orientation
    position.x, position.y, position.z = map(float, pose.position)
    turn.x, turn.y, turn.z, turn.w = map(float, pose.orientation)
    return message


def _client(name: str, kind: Any) -> Any:
    client = actionlib.ActionClient(SERVER + "/" + name, kind)
    if not client.wait_for_server(rospy.Duration(PATIENCE)):
        raise RuntimeError("there is no action %s" % name)
    return client


def _plan(client: Any, wanted: Trip, nodes: Nodes) -> Tuple[float, int]:
    """Seconds from the goal to the result of a plan, and its outcome."""
    goal = GetPathGoal(use_start_pose=True)
    goal.start_pose, goal.target_pose = stamped(wanted.start), stamped(wanted.goal)
    begin = time.monotonic()
    result = _ask(client, goal, nodes)
    return time.monotonic() - begin, int(result.outcome)


def _ask(client: Any, goal: Any, nodes: Nodes, end: Optional[float] = None) -> Any:
    """The result of a goal; it is canceled at the end, if that comes before, and the result None.

    Raises:
        RuntimeError: it does not end.
    """
    done = threading.Event()

    def watch(handle: Any) -> None:
        if handle.get_comm_state() == actionlib.CommState.DONE:
            done.set()

    handle = client.send_goal(goal, transition_cb=watch)
    limit = time.monotonic() + PATIENCE if end is None else end
    while not done.wait(min(1.0, max(0.01, limit - time.monotonic()))):
        nodes.check()
        if time.monotonic() > limit:
            handle.cancel()
            if end is None or not done.wait(10.0):
                raise RuntimeError("a goal does not end: %s" % nodes.printed()[-2000:])
            return None
    return handle.get_result()
