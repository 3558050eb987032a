"""The start of a node where there is no roscore."""

import os
import signal
import socket
import subprocess
import sys

import pytest

CODE = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
from mesh_msgs.init_node import init_node
init_node("name_of_the_node")
"""


def start(uri):
    return subprocess.Popen(
        [sys.executable, "-c", CODE],
        env={**os.environ, "ROS_MASTER_URI": uri},
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_it_says_what_it_waits_for_and_ends_without_a_word(number, code):
    with socket.socket() as unused:  # bound but not listening: nobody else can answer there
        unused.bind(("localhost", 0))
        uri = "http://localhost:%d" % unused.getsockname()[1]
        node = start(uri)
        line = node.stderr.readline()
        node.send_signal(number)
        rest = node.communicate(timeout=60)[1]
    assert line == "name_of_the_node: waiting for roscore at %s\n" % uri
    assert (rest, node.returncode) == ("", code)


def test_an_address_that_is_none_is_refused_in_one_line():
    node = start("nonsense")
    assert node.communicate(timeout=60)[1] == (
        "name_of_the_node: error: invalid master URI: nonsense; "
        "set ROS_MASTER_URI to an address such as http://localhost:11311\n"
    )
    assert node.returncode == 1
