"""Nodes whose roscore was restarted."""

import os
import socket
import subprocess
import sys

import pytest
import rosgraph

from mesh_msgs.master_watch import MasterWatch
from mesh_msgs.testing import listens, wait_until

NODE = """
from mesh_msgs import init_node, master_watch
master_watch.PERIOD = 0.1
init_node.init_node("watched")
import rospy
rospy.on_shutdown(lambda: print("stopped"))
print("started")
init_node.spin()
"""


class Master:
    """Answers with an address, or an error."""

    master_uri = "http://robot:11311"

    def __init__(self, answer):
        self.answer = answer

    def lookupService(self, name):
        assert name == "/watched/get_loggers"
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


UNKNOWN, SILENT = rosgraph.MasterError("unknown service"), ConnectionRefusedError()


@pytest.mark.parametrize(
    "answers, fault",
    [
        (["here", "here", SILENT, "here"], False),
        (["here", rosgraph.MasterFailure("busy")], False),
        (["here", SILENT, UNKNOWN], True),
        (["here", "elsewhere"], True),  # another node has the name
        ([SILENT, SILENT, "here"], False),
        ([SILENT, UNKNOWN], True),
    ],
)
def test_what_the_master_answers(answers, fault):
    master = Master(answers[0])
    watch = MasterWatch("/watched", master)
    for master.answer in answers[1:-1]:
        assert watch.fault() == ""
    master.answer = answers[-1]
    found = watch.fault()
    assert bool(found) == fault
    if fault:
        assert "http://robot:11311" in found and "start it again" in found


def test_a_node_whose_master_is_restarted_ends_and_says_so():
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        port = unused.getsockname()[1]
    uri = f"http://127.0.0.1:{port}"
    environment = {**os.environ, "ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
    processes = []

    def start(*command):
        processes.append(
            subprocess.Popen(
                command,
                env=environment,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                universal_newlines=True,
            )
        )
        return processes[-1]

    def start_master():
        master = start("rosmaster", "--core", "-p", str(port))
        wait_until(lambda: listens(port), "the master")
        return master

    try:
        master = start_master()
        node = start(sys.executable, "-c", NODE)
        assert node.stdout.readline() == "started\n"
        master.kill()
        with pytest.raises(subprocess.TimeoutExpired):  # It goes on without a master.
            node.wait(2.0)
        start_master()
        output, errors = node.communicate(timeout=60)
    finally:
        for process in processes:
            process.kill()
            process.communicate()
    assert (node.returncode, output) == (1, "stopped\n")
    assert f"/watched: the ROS master at {uri} does not know this node any more" in errors
    assert "Traceback" not in errors
