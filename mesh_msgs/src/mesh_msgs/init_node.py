"""The start of every node of ours."""

import sys
import time
from typing import Optional, Sequence

import rosgraph
import rospy


def init_node(name: str, argv: Optional[Sequence[str]] = None) -> None:
    """rospy.init_node, but without a roscore it says in one line that it waits, and for which one.

    rospy itself says so only in its log, which is not there before the node is; and with parameters
    on the command line it ends instead of waiting.
    """
    if not rosgraph.is_master_online():
        sys.stderr.write("%s: waiting for roscore at %s\n" % (name, rosgraph.get_master_uri()))
        sys.stderr.flush()
        while not rosgraph.is_master_online():
            time.sleep(0.5)
    rospy.init_node(name, argv=argv)
