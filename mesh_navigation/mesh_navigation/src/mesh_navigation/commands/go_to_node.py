"""The command go_to: one goal for move_base, or get_path, and what became of it."""

import argparse
import json
import math
import os
import signal
import sys
import time
from functools import partial
from typing import Any, Dict, List, Optional, Tuple

import rosgraph
import rospy
from mesh_msgs.init_node import init_node
from mesh_msgs_hdf5.commands.completion import wanted
from mesh_msgs_hdf5.commands.progress import ProgressLine
from rosgraph.names import is_legal_name

from mesh_msgs.text import one_line

from mesh_navigation.base.clock import Deadline
from mesh_navigation.base.messages import poses_from_path
from mesh_navigation.base.path import path_length
from mesh_navigation.client.navigation_result import NavigationError, NavigationResult
from mesh_navigation.client.navigator_node import MeshNavigator
from mesh_navigation.commands.command_line import (
    TROUBLE,
    CommandParser,
    complain,
    complete,
    is_number,
    number,
    tell,
    told,
)

PROGRAM = "go_to"
SERVER = "move_base_flex"
FAILED, INTERRUPTED = 1, 130


def main(argv: Optional[List[str]] = None) -> int:
    """Run the command; returns the exit code."""
    parser = make_parser()
    if wanted():
        complete(parser)
    words = rospy.myargv(sys.argv if argv is None else [PROGRAM, *argv])
    arguments = parsed(parser, words[1:])
    if arguments.timeout is not None and not _is_roscore_there(Deadline(arguments.timeout)):
        return TROUBLE
    init_node(f"{PROGRAM}_{os.getpid()}")
    try:
        code = _run(arguments)
        sys.stdout.flush()
        return code
    except NavigationError as error:
        complain(PROGRAM, str(error))
    except rospy.ROSInterruptException:
        complain(PROGRAM, "interrupted")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has gone, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return TROUBLE


def _is_roscore_there(deadline: Deadline) -> bool:
    """Wait for it, and say so; `init_node` itself would do it without end."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # rosgraph swallows KeyboardInterrupt
    roscore, told = f"roscore at {rosgraph.get_master_uri()}", False
    try:
        while not rosgraph.is_master_online():
            if not told:
                tell(PROGRAM, f"waiting for {roscore}")
                told = True
            if deadline.left == 0.0:
                complain(PROGRAM, f"there is no {roscore} within {deadline.seconds:g} s")
                return False
            time.sleep(0.1)
    except ValueError:  # no address: `init_node` says so
        pass
    return True


def _run(arguments: Any) -> int:
    yaw = None if arguments.yaw is None else math.radians(arguments.yaw)
    goal = arguments.x, arguments.y, arguments.z
    fields = {"frame_id": arguments.frame, "planner": arguments.planner}
    with ProgressLine(arguments.quiet) as progress:
        say = partial(told, PROGRAM)
        navigator = MeshNavigator(arguments.server, lambda text: progress.write(say(text)))
        progress.stage("waiting for the server")
        navigator.wait_until_ready(
            "get_path", *([] if arguments.plan_only else ["move_base"]), timeout=arguments.timeout
        )
        progress.stage("planning")
        begin = time.monotonic()
        if arguments.plan_only:
            result = navigator.get_path(*goal, yaw=yaw, timeout=arguments.timeout, **fields)
        else:
            remaining = Remaining()

            def on_feedback(feedback: Any) -> None:
                text, share = remaining.update(feedback)
                progress.stage(text)
                if share is not None:
                    progress.part(share)

            result = navigator.go_to(
                *goal,
                yaw=yaw,
                controller=arguments.controller,
                recovery_behaviors=arguments.recovery,
                on_feedback=on_feedback,
                timeout=arguments.timeout,
                **fields,
            )
    text = plan_text if arguments.plan_only else arrival_text
    sys.stdout.write(text(result, time.monotonic() - begin, arguments.json))
    if rospy.core.is_shutdown_requested():
        return INTERRUPTED
    return 0 if result.succeeded else FAILED


class _Parser(CommandParser):
    def error(self, message: str) -> None:
        # The space of `_plain` is not the user's.
        super().error(message.replace(": ' -", ": '-"))


def make_parser() -> argparse.ArgumentParser:
    """The parser of the arguments."""
    parser = _Parser(
        "clients",
        prog=PROGRAM,
        usage="%(prog)s X Y Z [YAW] [options]",
        description="Let the robot go to a place on the map, and wait until it is there. "
        "Ctrl+C stops it.",
        epilog="exit codes: 0 it is there (or there is a plan), 1 it is not, 2 wrong usage or no "
        "server, 130 Ctrl+C. example: rosrun mesh_navigation go_to 8 9 0.5",
    )
    for name in "XYZ":
        parser.add_argument(name.lower(), metavar=name, type=number, help="m")
    text = "heading at the goal in degrees (default: as the path arrives)"
    parser.add_argument("heading", metavar="YAW", nargs="?", type=number, help=text)
    parser.add_argument("--yaw", type=number, metavar="DEGREES", help="another way to say YAW")
    text = "of X Y Z (default: that of the map)"
    parser.add_argument("--frame", default="", metavar="FRAME", help=text)
    text = "node of the navigation server (default: %(default)s)"
    parser.add_argument("--server", default=SERVER, type=_node, metavar="NAME", help=text)
    text = "name of the {} (default: the server's first)"
    for kind in ("planner", "controller"):
        parser.add_argument(f"--{kind}", default="", metavar="NAME", help=text.format(kind))
    text = "recovery behavior, may be repeated (default: all of the server's)"
    parser.add_argument("--recovery", action="append", default=[], metavar="NAME", help=text)
    text = "stop if it is not there after so many seconds"
    parser.add_argument("--timeout", type=_seconds, metavar="S", help=text)
    text = "only plan, and say how long the way is"
    parser.add_argument("--plan-only", action="store_true", help=text)
    parser.add_argument("--json", action="store_true", help="output for programs")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress")
    return parser


def parsed(parser: argparse.ArgumentParser, words: List[str]) -> argparse.Namespace:
    """The arguments, YAW and --yaw as one ``yaw`` (degrees, or None)."""
    arguments = parser.parse_args([_plain(word) for word in words])
    if arguments.heading is not None and arguments.yaw is not None:
        parser.error("YAW and --yaw say the same; give one")
    if arguments.yaw is None:
        arguments.yaw = arguments.heading
    return arguments


def _plain(word: str) -> str:
    """argparse takes -1e-3 for an option, but nothing that has a space in it."""
    return f" {word}" if word.startswith("-") and is_number(word) else word


def _seconds(text: str) -> float:
    value = number(text)
    if value <= 0:
        raise ValueError(text)
    return value


def _node(text: str) -> str:
    if not text or not is_legal_name(text):
        raise ValueError(text)
    return text


_seconds.__name__, _node.__name__ = "number of seconds", "name of a node"


class Remaining:
    """How far the robot has come, from the feedback of move_base."""

    def __init__(self) -> None:
        self._first: Optional[float] = None

    def update(self, feedback: Any) -> Tuple[str, Optional[float]]:
        """A few words, and the share of the way (0 to 1) that lies behind, None if not known."""
        distance = float(feedback.dist_to_goal)
        if not math.isfinite(distance):
            return "driving", None
        if self._first is None:
            self._first = distance
        share = 1.0 - distance / self._first if self._first > 0.0 else None
        speed = feedback.last_cmd_vel.twist.linear.x
        degrees = math.degrees(abs(feedback.angle_to_goal))
        text = f"{distance:.2f} m to the goal, {degrees:.0f} degrees to turn, {speed:.2f} m/s"
        return text, None if share is None else max(0.0, share)


def arrival_text(result: NavigationResult, seconds: float, as_json: bool) -> str:
    """How going there ended, as lines."""
    values = {
        "dist_to_goal": _finite(result.details.dist_to_goal),
        "angle_to_goal": _finite(result.details.angle_to_goal),
        "seconds": seconds,
    }
    if as_json:
        return _json(result, values)
    pose = result.details.final_pose
    where = ""
    if pose.header.frame_id:  # no such pose where nothing was driven
        p = pose.pose.position
        where = f"; now at ({p.x:.2f}, {p.y:.2f}, {p.z:.2f}) in '{pose.header.frame_id}'"
        where += f", {values['dist_to_goal'] or 0.0:.2f} m from the goal"
        where += f", {math.degrees(values['angle_to_goal'] or 0.0):.1f} degrees from its heading"
    return f"{one_line(str(result))}\n{seconds:.1f} s{where}\n"


def plan_text(result: NavigationResult, seconds: float, as_json: bool) -> str:
    """How planning ended, as lines."""
    path = result.details.path
    positions = poses_from_path(path)[:, :3]
    length = path_length(positions) if len(positions) else None
    if as_json:
        return _json(
            result,
            {
                "length": length,
                "cost": _finite(result.details.cost),
                "seconds": seconds,
                "frame_id": path.header.frame_id,
                "positions": positions.tolist(),
            },
        )
    text = one_line(str(result)) + "\n"
    return text if length is None else f"{text}length {length:.3f} m, {1e3 * seconds:.0f} ms\n"


def _json(result: NavigationResult, values: Dict[str, Any]) -> str:
    first = {"outcome": result.outcome, "outcome_name": result.name, "message": result.message}
    return json.dumps({**first, **values}, allow_nan=False) + "\n"


def _finite(value: float) -> Optional[float]:
    return float(value) if math.isfinite(value) else None
