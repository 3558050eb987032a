"""The start of every node of ours."""

import sys
import time
from typing import Optional, Sequence

import rosgraph
import rospy

_INTERRUPTED = 130  # the exit code of shells for a program that SIGINT has ended


def init_node(name: str, argv: Optional[Sequence[str]] = None) -> None:
    """rospy.init_node, but without a roscore it says in one line that it waits, and for which one.

    rospy itself says so only in its log, which is not there before the node is; and with parameters
    on the command line it ends instead of waiting.

    Raises:
        SystemExit: Ctrl-C before the node is there (code 130), or a ROS_MASTER_URI that is no
            address (code 1, with a line that says so).
    """
    try:
        if not rosgraph.is_master_online():
            sys.stderr.write("%s: waiting for roscore at %s\n" % (name, rosgraph.get_master_uri()))
            sys.stderr.flush()
            while not rosgraph.is_master_online():
                time.sleep(0.5)
    except KeyboardInterrupt:
        raise SystemExit(_INTERRUPTED) from None
    except ValueError as error:
        hint = "set ROS_MASTER_URI to an address such as http://localhost:11311"
        raise SystemExit("%s: error: %s; %s" % (name, error, hint)) from None
    try:
        rospy.init_node(name, argv=argv)
    except rospy.ROSInitException:
        if not rospy.is_shutdown():
            raise
        raise SystemExit(_INTERRUPTED) from None
