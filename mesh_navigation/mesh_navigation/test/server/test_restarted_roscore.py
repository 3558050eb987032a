"""All nodes of this repository, when their roscore is killed and started again."""

import contextlib
import os
import socket
import subprocess
from xmlrpc.client import ServerProxy

import rosgraph
import roslib.packages

from mesh_map.base.end_watch import END_SECONDS
from mesh_msgs import zoo
from mesh_msgs.master_watch import PERIOD
from mesh_msgs.testing import listens, process_has_ended, wait_until
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

# Of each its package, an argument, and what it says once all of it is there.
NODES = {
    "label_manager": ("mesh_msgs_hdf5", "_folder_path:={folder}", "labels are kept in"),
    "hdf5_map_server": ("mesh_msgs_hdf5", "_inputFile:={map}", "serving"),
    "goal_bridge": ("mesh_navigation", "", "then for goals on"),
    "surface_robot": ("mesh_navigation", "_mesh_file:={map}", "the robot is at"),
    "mesh_map": ("mesh_map", "_mesh_file:={map} _shutdown_timeout:=60", "is ready after"),
    "mbf_mesh_nav": (
        "mesh_navigation",
        "_mesh_map/mesh_file:={map} _shutdown_timeout:=60",
        "ready, map of",
    ),
}


GUARD = "/mbf_mesh_nav_velocity_guard"


def pid_of(node, master):
    """Of a node's process; None while there is no such node."""
    try:
        with ServerProxy(master.lookupNode(node)) as its:
            return its.getPid("/test")[2]
    except (OSError, rosgraph.MasterError):
        return None


def known_guards(master):
    """Whatever a master knows of guards: their topics and services."""
    return [
        name
        for kind in master.getSystemState()
        for name, nodes in kind
        if any(node.endswith("_velocity_guard") for node in nodes)
    ]


def test_how_soon_they_end():
    """It is promised to be within 10 s; how long it takes, a busy machine decides."""
    assert PERIOD + END_SECONDS < 10.0


def test_they_end_and_say_why(tmp_path):
    """What goes on with nobody finding it looks alive and is not."""
    mesh, path = zoo.grid(), tmp_path / "map.h5"
    MapFile.write(str(path), Mesh(vertices=mesh.vertices, faces=mesh.faces))
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        port = unused.getsockname()[1]
    uri = f"http://127.0.0.1:{port}"
    environment = {**os.environ, "ROS_MASTER_URI": uri, "ROS_IP": "127.0.0.1"}
    started = []

    def start(name, *command):
        with open(tmp_path / f"{name}.log", "w") as log:
            child = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
        started.append(child)
        return child

    def start_master():
        child = start("rosmaster", "rosmaster", "--core", "-p", str(port))
        wait_until(lambda: listens(port), "the master")
        return child

    closing = contextlib.ExitStack()
    try:
        first = start_master()
        nodes = {}
        for name, (package, argument, _) in NODES.items():
            program = roslib.packages.find_node(package, name)[0]
            arguments = argument.format(map=path, folder=tmp_path).split()
            nodes[name] = start(name, program, *arguments)
        for name, (_, _, sentence) in NODES.items():
            log = tmp_path / f"{name}.log"
            wait_until(lambda: sentence in log.read_text(), name, 180)
        known = rosgraph.Master("/test", uri)
        closing.callback(known.handle("close"))
        guard = wait_until(lambda: pid_of(GUARD, known), "the guard")
        first.kill()
        first.wait()
        start_master()
        codes = {name: child.wait(60) for name, child in nodes.items()}
        wait_until(lambda: process_has_ended(guard), "the guard's end")
        wait_until(lambda: not known_guards(known), "its end for the master")
    finally:
        closing.close()
        for child in started:
            child.kill()
            child.wait()
    said = {name: (tmp_path / f"{name}.log").read_text() for name in NODES}
    assert codes == {name: 1 for name in NODES}, said
    for name, text in said.items():
        assert f"/{name}: the ROS master at {uri} does not know this node" in text
        assert "Traceback" not in text
