"""A private ROS master inside this process: never left behind, and parallel runs do not meet."""

import contextlib
import os
from typing import Dict, Iterator, Mapping


@contextlib.contextmanager
def private_master(environment: Mapping[str, str]) -> Iterator[Dict[str, str]]:
    """Runs a ROS master on a free port of the loop-back interface; yields nodes' environment.

    There is no rosout node: what nodes log goes to their own output.
    """
    os.environ.pop("ROS_HOSTNAME", None)
    os.environ["ROS_IP"] = "127.0.0.1"
    # Imported late: rosmaster configures logging when it is imported, which programs
    # without a master of their own need not wait for.
    from rosmaster.master import Master

    master = Master(port=0)
    master.start()
    try:
        changed = dict(environment)
        changed.pop("ROS_HOSTNAME", None)
        changed["ROS_IP"] = "127.0.0.1"
        changed["ROS_MASTER_URI"] = master.uri
        yield changed
    finally:
        master.stop()
