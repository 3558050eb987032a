"""The real server and a simulated robot as processes, on a large map."""

import contextlib
import os
import subprocess
from pathlib import Path
from typing import Any, Dict, Iterator, List, NamedTuple

from mesh_map.io.map_source import MapSource
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation.base.pose import Pose

from mesh_tools_test.base.noisy_world import noisy_world
from mesh_tools_test.driving.worlds import DrivingWorld, layer, robot_layers

SERVER, ROBOT = "/move_base_flex", "/surface_robot"
CLOUDS = "/cloud"


def server_layers() -> List[Dict[str, Any]]:
    """Those of a robot outdoors, one of them with what its sensor sees."""
    layers = robot_layers(step=0.4)
    obstacles = layer(
        "obstacle",
        "Obstacle",
        topic=CLOUDS,
        robot_height=0.7,
        min_obstacle_height=0.2,
        max_obstacle_dist=8.0,
        decay=2.0,
    )
    return layers[:-1] + [obstacles] + layers[-1:]


def stored_world(faces: int, path: str) -> DrivingWorld:
    """The outdoor world of about that many faces, stored in a file with its layers."""
    rough = noisy_world(faces)
    MapFile.write(path, Mesh(vertices=rough.vertices, faces=rough.faces))
    source = MapSource(path)
    mesh_map = source.make_map()
    mesh_map.compute_layers(server_layers())
    if mesh_map.layer_errors:
        raise RuntimeError("layers are left out: %s" % mesh_map.layer_errors)
    source.save_layers(mesh_map.layers)
    return DrivingWorld("large", mesh_map)


def parameters(path: str, start: Pose) -> Dict[str, Any]:
    """Of both nodes, by their names."""
    layers = server_layers()
    mesh_map: Dict[str, Any] = {entry["name"]: entry["params"] for entry in layers}
    mesh_map["layers"] = [{"name": each["name"], "type": each["type"]} for each in layers]
    mesh_map["mesh_file"] = path
    yaw = 2.0 * float(start.orientation[2])
    return {
        SERVER: {
            "mesh_map": mesh_map,
            "planner_frequency": 1.0,
            "controller_frequency": 20.0,
            "planners": [
                {"name": "wave_front_planner", "type": "wave_front_planner/WaveFrontPlanner"}
            ],
        },
        ROBOT: {"initial_pose": [*map(float, start.position), yaw]},
    }


class Nodes(NamedTuple):
    """What runs."""

    server: "subprocess.Popen[bytes]"
    robot: "subprocess.Popen[bytes]"
    log: Path
    """What the server prints."""

    def memory(self, field: str = "VmRSS") -> float:
        """MiB of the server."""
        with open("/proc/%d/status" % self.server.pid, encoding="ascii") as file:
            return next(int(line.split()[1]) for line in file if line.startswith(field)) / 1024

    def check(self) -> None:
        """RuntimeError if one has ended."""
        for name, process in (("server", self.server), ("robot", self.robot)):
            if process.poll() is not None:
                raise RuntimeError("the %s has ended: %s" % (name, self.printed()))

    def printed(self) -> str:
        """All that the server has printed."""
        return self.log.read_text(encoding="utf-8", errors="replace")


@contextlib.contextmanager
def running(environment: Dict[str, str], folder: str) -> Iterator[Nodes]:
    """Both nodes, ended politely."""
    log = Path(folder) / "server.log"
    with contextlib.ExitStack() as stack:
        processes = []
        for node, name, path in (
            ("mbf_mesh_nav", SERVER, log),
            ("surface_robot", ROBOT, Path(folder) / "robot.log"),
        ):
            output = stack.enter_context(open(path, "wb"))
            command = ["rosrun", "mesh_navigation", node, "__name:=" + name[1:]]  # which becomes it
            process = subprocess.Popen(
                command,
                env=dict(environment, ROS_LOG_DIR=folder, PYTHONUNBUFFERED="1"),
                stdout=output,
                stderr=subprocess.STDOUT,
            )
            stack.callback(_end, process)
            processes.append(process)
        yield Nodes(*processes, log)


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.terminate()
    try:
        process.wait(30)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def own_environment(environment: Dict[str, str]) -> None:
    """Talk to the same master as the nodes."""
    os.environ["ROS_MASTER_URI"] = environment["ROS_MASTER_URI"]
