"""The command go_to: one goal for move_base, or get_path, and what became of it."""

import math
import os
import signal
import sys
import time
from typing import Any, List, Optional

import rosgraph
import rospy
from mesh_msgs_hdf5.completion import wanted
from mesh_msgs_hdf5.progress import Progress

from mesh_msgs.init_node import init_node

from mesh_navigation.command_line import TROUBLE, complain, complete, tell
from mesh_navigation.go_to_arguments import PROGRAM, make_parser, parsed
from mesh_navigation.go_to_report import Remaining, arrival_text, plan_text
from mesh_navigation.goals_ros import Deadline
from mesh_navigation.navigation_result import NavigationError
from mesh_navigation.navigator_node import MeshNavigator

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
    navigator = MeshNavigator(arguments.server, tell)
    yaw = None if arguments.yaw is None else math.radians(arguments.yaw)
    goal = arguments.x, arguments.y, arguments.z
    fields = {"frame_id": arguments.frame, "planner": arguments.planner}
    with Progress(arguments.quiet) as progress:
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
