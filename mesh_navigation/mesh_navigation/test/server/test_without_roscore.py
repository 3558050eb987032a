"""The node without a roscore."""

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path


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


def test_an_interrupt_while_modules_are_loaded(tmp_path):
    package = tmp_path / "mesh_navigation" / "server" / "ros"
    package.mkdir(parents=True)
    for folder in (package, *package.parents[:2]):
        (folder / "__init__.py").write_text("")
    interrupt = "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n"
    (package / "mbf_server_node.py").write_text(interrupt)
    node = Path(__file__).resolve().parents[2] / "nodes" / "mbf_mesh_nav"
    ended = subprocess.run(
        [sys.executable, node],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])},
        stderr=subprocess.PIPE,
        timeout=30,
    )
    assert (ended.returncode, ended.stderr) == (-signal.SIGINT, b"")
