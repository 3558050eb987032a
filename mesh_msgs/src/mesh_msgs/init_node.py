"""The start and the end of every node of ours."""

import io
import logging
import os
import signal
import sys
import threading
import time
from contextlib import contextmanager
from typing import Any, Callable, Iterator, List, Optional, Sequence

import rosgraph
import rospy

from mesh_msgs.master_watch import MasterWatch
from mesh_msgs.text import read_more

_LOG = logging.getLogger("mesh_msgs")
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_HELP = """usage: %s [_PARAMETER:=VALUE ...] [NAME:=OTHER_NAME ...]

%s
"""
# Set where the node is shut down because the master does not know it any more.
_forgotten = threading.Event()


def init_node(
    name: str,
    argv: Optional[Sequence[str]] = None,
    about: Optional[str] = None,
    package: str = "",
) -> None:
    """rospy.init_node, but without a roscore it says in one line that it waits, and for which one.

    rospy itself says so only in its log, which is not there before the node is; and with parameters
    on the command line it ends instead of waiting. SIGINT and SIGTERM shut the node down as ever,
    but cannot hang it. What is logged is there at once, also in files and pipes. To be called in
    the main thread, which then ends with `spin`.

    A node that a restarted roscore does not know says so and shuts down, as by SIGTERM.

    Args:
        name, argv: as of rospy.init_node.
        about: what the node does, which -h or --help prints instead of starting it.
        package: one of ours, whose README.md has its parameters, topics and services; --help then
            says where.

    Raises:
        SystemExit: after that (code 0), a signal before the node is there (code 128 + its number,
            as shells say it), or a ROS_MASTER_URI that is no address (code 1, with a line that says
            so).
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # where rospy writes what is no warning
    if about and {"-h", "--help"}.intersection(sys.argv[1:] if argv is None else argv):
        sys.stdout.write(_HELP % (name, about.strip()))
        if package:
            page = "nodes.html#" + name.replace("_", "-")
            sys.stdout.write("\n" + read_more(package, page))
        raise SystemExit(0)
    received: List[int] = []
    _handle_signals(lambda number, _frame: received.append(number))
    try:
        _wait_for_master(name, received)
    except ValueError as error:
        hint = "set ROS_MASTER_URI to an address such as http://localhost:11311"
        raise SystemExit("%s: error: %s; %s" % (name, error, hint)) from None
    _handle_signals(lambda number, _frame: (received.append(number), _shut_down(number)))
    if not received:
        try:
            rospy.init_node(name, argv=argv, disable_signals=True)
        except rospy.ROSInitException:
            if not received:
                raise
    if received:
        raise SystemExit(128 + received[0])
    MasterWatch(rospy.get_name()).start(_end_forgotten)


def spin() -> None:
    """rospy.spin, which returns when the node is shut down, at once if it is already.

    Raises:
        SystemExit: with code 1, if it is shut down because roscore was restarted.
    """
    rospy.spin()
    if _forgotten.is_set():
        raise SystemExit(1)


@contextmanager
def until_shutdown() -> Iterator[None]:
    """Errors within count only as long as nobody has told the node to shut down.

    A shutdown works in a thread of its own and closes topics at any moment, before
    rospy.is_shutdown() says so. What was using or making one meets whatever rospy makes of that.
    """
    try:
        yield
    except Exception:
        if not rospy.core.is_shutdown_requested():
            raise
        _LOG.debug("left undone by the shutdown", exc_info=True)


def _end_forgotten(fault: str) -> None:
    if rospy.core.is_shutdown_requested():  # It takes itself off the master.
        return
    rospy.logfatal("%s: %s", rospy.get_name(), fault)
    _forgotten.set()
    os.kill(os.getpid(), signal.SIGTERM)


def _wait_for_master(name: str, received: List[int]) -> None:
    """Wait until there is a roscore, or a signal; rosgraph itself swallows KeyboardInterrupt."""
    if rosgraph.is_master_online():
        return
    sys.stderr.write("%s: waiting for roscore at %s\n" % (name, rosgraph.get_master_uri()))
    sys.stderr.flush()
    while not received and not rosgraph.is_master_online():
        time.sleep(0.2)


def _handle_signals(handler: Callable[[int, Any], Any]) -> None:
    for number in _SIGNALS:
        signal.signal(number, handler)


def _shut_down(number: int) -> None:
    """Shut the node down in a thread of its own.

    rospy's own handler works in the main thread: where it interrupts a call to roscore there, it
    waits forever for a lock that the call holds.
    """
    threading.Thread(target=rospy.signal_shutdown, args=("signal %d" % number,)).start()
