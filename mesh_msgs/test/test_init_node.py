"""The start of a node where there is no roscore."""

import os
import select
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


# What is written while the node waits for roscore.
TALKING = """
import sys, threading
threading.Timer(0.5, sys.stdout.write, ["logged\\n"]).start()
"""


def start(uri, code=CODE):
    environment = {**os.environ, "ROS_MASTER_URI": uri}
    environment.pop("PYTHONUNBUFFERED", None)
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )


def test_what_is_logged_goes_through_pipes_at_once():
    with socket.socket() as unused:
        unused.bind(("localhost", 0))
        node = start("http://localhost:%d" % unused.getsockname()[1], TALKING + CODE)
        assert select.select([node.stdout], [], [], 60)[0], "nothing comes"
        assert node.poll() is None and node.stdout.readline() == "logged\n"
        node.send_signal(signal.SIGTERM)
        node.communicate(timeout=60)


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


@pytest.mark.parametrize("option", ["-h", "--help"])
def test_help_needs_no_roscore(option):
    """What the node does, and the end."""
    code = CODE.replace('node")', 'node", about="Serves tea.")')
    node = start("http://localhost:1", f"import sys; sys.argv[1:] = ['{option}']" + code)
    told, errors = node.communicate(timeout=60)
    assert (node.returncode, errors) == (0, "")
    assert told.startswith("usage: name_of_the_node") and told.endswith("\nServes tea.\n")


def test_help_of_our_nodes_says_where_more_is_told():
    code = CODE.replace('node")', 'node", about="Serves tea.", package="tea_house")')
    node = start("http://localhost:1", "import sys; sys.argv[1:] = ['--help']" + code)
    told = node.communicate(timeout=60)[0]
    assert "\nServes tea.\n\nMore:\n" in told
    assert "$(rospack find tea_house)/README.md\n" in told
    assert "build/docs/html/reference/nodes.html#name-of-the-node, " in told
