"""Starting a node of ours."""
import sys
import time

import rosgraph
import rospy


def init_node(name: str) -> None:
    """rospy.init_node, but without a roscore it says once that it waits, and for which one.

    rospy itself would say so only in its log, which is not there before the node is.
    """
    if not rosgraph.is_master_online():
        sys.stderr.write("%s: waiting for roscore at %s\n" % (name, rosgraph.get_master_uri()))
        sys.stderr.flush()
        while not rosgraph.is_master_online():
            time.sleep(0.5)
    rospy.init_node(name)
