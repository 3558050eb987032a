"""The end of a node with plugins."""

import rospy

from mesh_map.base.end_watch import END_SECONDS, end_when_told
from mesh_map.base.parameter import Parameter, read_parameters

SHUTDOWN_TIMEOUT = Parameter(
    "shutdown_timeout",
    END_SECONDS,
    0.1,
    3600.0,
    "time from SIGINT or SIGTERM to the end of the node, whatever its plugins do (s)",
)


def watch_end() -> None:
    """From now on, this node ends when it is told to, as its parameter ``shutdown_timeout`` says.

    To be called once, in the main thread, before a plugin is loaded.
    """
    name = SHUTDOWN_TIMEOUT.name
    values, complaints = read_parameters(
        (SHUTDOWN_TIMEOUT,), {name: rospy.get_param("~" + name, END_SECONDS)}
    )
    for complaint in complaints:
        rospy.logwarn("%s", complaint)
    end_when_told(values[name])
