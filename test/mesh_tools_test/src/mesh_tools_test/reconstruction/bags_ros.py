"""A bag of a drive to a saved map with layers, from a cold start of the command."""

import json
import math
import os
import subprocess
import tempfile
import time
from dataclasses import replace
from typing import Any, Dict, List, NamedTuple

from mesh_map.scans.bag_ros import write_bag
from mesh_map.scans.recording import Recording
from mesh_map.scans.trajectory import Trajectory
from mesh_msgs_hdf5.labels.map_contents import read_map

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.server_start import executable
from mesh_tools_test.reconstruction.scene import Scene

POINTS = 10_000_000
VOXEL = 0.05  # m
LAYERS = ("height_diff", "roughness", "steepness", "border", "inflation")
SECONDS = 60.0
_POSE_RATE, _BEGIN, _REVOLUTION = 50.0, 1000.0, 0.1  # Hz, s, s


class Made(NamedTuple):
    """What the command has made, in how many s and with how much memory (bytes) at most."""

    result: Dict[str, Any]
    seconds: float
    memory: int


def measure(scene: Scene, points: int = POINTS) -> List[Figure]:
    """Once, with at least so many points in the bag."""
    with tempfile.TemporaryDirectory() as folder:
        bag, output = os.path.join(folder, "drive.bag"), os.path.join(folder, "map.h5")
        written = write_drive(scene, bag, points)
        size = os.stat(bag).st_size
        made = reconstructed(bag, output)
        mesh, _ = read_map(output)
        if made.result["points"] < 0.99 * written:
            text = "of %d points in the bag, %d are in the map"
            raise RuntimeError(text % (written, made.result["points"]))
        if mesh.vertex_colors is None or not set(LAYERS) <= set(mesh.vertex_costs):
            raise RuntimeError("the map lacks colors, or layers: %s" % sorted(mesh.vertex_costs))
    name = "bag of %.1f M points to a map with %d layers" % (written / 1e6, len(LAYERS))
    return [
        Figure(name, made.seconds, "s", floor=SECONDS),
        Figure("  for a million points", made.seconds / (written / 1e6), "s/M"),
        Figure("  memory at most", made.memory / 1e6, "MB"),
        Figure("  size of the bag", size / 1e6, "MB"),
        Figure("  faces of the map", float(made.result["faces"]), ""),
    ]


def write_drive(scene: Scene, path: str, points: int) -> int:
    """Scans of at least so many points, with colors and with the motion of the robot in them, as a
    bag that is not in memory any more; returns how many there are."""
    sensor = scene.world.sensor
    later = Trajectory(sensor.times + _BEGIN, sensor.positions, sensor.orientations)
    world = scene.world._replace(sensor=later.resampled(_POSE_RATE))
    count = math.ceil(points / (1e6 * scene.points) * len(scene.scans))
    lidar = replace(scene.lidar, duration=_REVOLUTION)
    recording = Recording(world.sensor, world.sensor, 0.0, world.scans(lidar, count), count)
    written = write_bag(path, recording)
    with open(path, "rb") as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    return written


def reconstructed(bag: str, output: str) -> Made:
    """By the command as a process of its own.

    Raises:
        RuntimeError: it does not end with 0.
    """
    command = [executable("mesh_map", "reconstruct"), bag, output, "--voxel_size", str(VOXEL)]
    command += ["--layers", ",".join(LAYERS), "--json"]
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as errors:
        begin = time.perf_counter()
        process = subprocess.Popen(command, stdout=said, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        process.returncode = 0 if status == 0 else 1
        said.seek(0)
        errors.seek(0)
        if status:
            end = errors.read().decode(errors="replace").strip().splitlines()[-5:]
            raise RuntimeError("%s: wait status %d: %s" % (" ".join(command), status, end))
        return Made(json.loads(said.read().decode()), seconds, usage.ru_maxrss * 1024)
