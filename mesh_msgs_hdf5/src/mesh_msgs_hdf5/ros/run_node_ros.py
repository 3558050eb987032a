"""How both nodes run."""
import sys
from contextlib import ExitStack
from typing import Any, Callable, ContextManager, Optional

import rospy
from mesh_msgs.init_node import init_node, spin, until_shutdown

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError


def run_node(name: str, running: Callable[[], ContextManager[Any]], about: Optional[str]) -> int:
    """Run a node until it is shut down; returns the exit code.

    running: a context in which the node works; it is left in the main thread, because Python starts
    no threads elsewhere at exit. about: what the node does, for --help.
    """
    try:
        init_node(name, about=about, package="mesh_msgs_hdf5")
        with ExitStack() as stack:
            with until_shutdown():
                stack.enter_context(running())
            spin()
    except (MapFileError, ValueError) as error:
        sys.stderr.write("%s: error: %s\n" % (name, one_line(str(error))))
        return 1
    except KeyboardInterrupt:
        return 130  # as shells say it: ended by a signal before it served anything
    except rospy.ROSInterruptException:
        pass
    return 0
