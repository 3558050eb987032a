"""The node without a roscore."""

import os
import socket
import subprocess


def test_it_says_what_it_waits_for():
    with socket.socket() as unused:  # Bound but not listening: nobody else can answer there.
        unused.bind(("localhost", 0))
        uri = f"http://localhost:{unused.getsockname()[1]}"
        node = subprocess.Popen(
            ["rosrun", "mesh_navigation", "mbf_mesh_nav", "_mesh_map/mesh_file:=map.h5"],
            env={**os.environ, "ROS_MASTER_URI": uri},
            stderr=subprocess.PIPE,
            text=True,
        )
        line = node.stderr.readline()
        still_running = node.poll() is None
        node.terminate()
        rest = node.communicate(timeout=30)[1]
    assert line == f"mbf_mesh_nav: waiting for roscore at {uri}\n"
    assert still_running and rest == ""
