"""Notices that the ROS master was restarted: the new one knows nothing of the nodes of before."""

import threading
import time
from typing import Any, Callable, Optional

import rosgraph

PERIOD = 2.0  # s between two questions


class MasterWatch:
    """Asks the master now and then whether it knows a service that rospy.init_node has made.

    rospy registers everything once: a restarted master knows only what is made later, and no
    parameter. As long as no master answers, nothing happens: connections between nodes need none.
    """

    def __init__(self, name: str, master: Optional[Any] = None) -> None:
        """
        Args:
            name: the full name of the node, which is registered.
            master: a rosgraph.Master; None: that of the environment.
        """
        self._service = name + "/get_loggers"
        self._master = master or rosgraph.Master(name)
        self._address = ""
        self.fault()

    def start(self, on_fault: Callable[[str], Any]) -> None:
        """Watch in a thread; `on_fault` is called once, with what `fault` says."""
        threading.Thread(
            target=self._run, args=(on_fault,), name="master watch", daemon=True
        ).start()

    def _run(self, on_fault: Callable[[str], Any]) -> None:
        fault = ""
        while not fault:
            time.sleep(PERIOD)
            fault = self.fault()
        on_fault(fault)

    def fault(self) -> str:
        """Why other nodes do not find this one any more; empty if they do, or no master answers."""
        try:
            address = self._master.lookupService(self._service)
            self._address = self._address or address
            if address == self._address:
                return ""
        except rosgraph.MasterError:  # There is no such service.
            pass
        except Exception:  # whatever the network makes of it
            return ""
        return (
            "the ROS master at %s does not know this node any more (was it restarted?), so that "
            "other nodes do not find it: start it again" % self._master.master_uri
        )
