"""Poses of a loop by odometry that drifts, refined by the scans."""

import time
from dataclasses import astuple
from typing import List, Sequence

import numpy as np
from mesh_map.reconstruction.pose_refinement import refine_poses
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.trajectory import Trajectory

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.scanned_world import LOOP, Places, scanned_world
from mesh_tools_test.reconstruction.scene import VOXEL, Scene

DRIFT = OdometryDrift(slip=0.005, yaw=0.001, height=0.001, noise=0.002)  # in these proportions
END = 0.5  # m from the truth, after the loop
RATE = 2.0  # scans in a second, at 1 m/s
MOST = 0.03  # m


def measure(scene: Scene, places: Places = LOOP, end: float = END) -> List[Figure]:
    """Once, on a loop through places of the world, with odometry that ends so many m off."""
    world = scanned_world(len(scene.world.mesh.faces), places=places)
    sensor = world.sensor
    drift = drift_that_ends(sensor, end)
    count = int(RATE * (sensor.times[-1] - sensor.times[0]))
    scans, truths = [], []
    for each in world.scans(scene.lidar, count, drift=drift):
        scans.append(each.scan)
        truths.append(each.truth)
    given = [scan.pose for scan in scans]
    begin = time.perf_counter()
    refined = refine_poses(scans, voxel_size=VOXEL)
    seconds = time.perf_counter() - begin
    peer = "as given"
    before, after = (position_errors(poses, truths) for poses in (given, refined.poses))
    turned_before, turned = (turn_errors(poses, truths) for poses in (given, refined.poses))
    return [
        Figure("length of the loop", sensor.length, "m"),
        Figure("poses off the truth: RMS", rms(after), "m", peer, rms(before), MOST),
        Figure("  at the end", float(after[-1]), "m", peer, float(before[-1])),
        Figure("  at most", float(after.max()), "m", peer, float(before.max())),
        Figure("  turned: RMS", rms(turned), "deg", peer, rms(turned_before)),
        Figure("scans laid onto others", refined.key_scans - refined.lost, ""),
        Figure("  onto nothing", refined.lost, ""),
        Figure("loops closed", refined.loops, ""),
        Figure("time of a scan", seconds / count, "s"),
    ]


def drift_that_ends(truth: Trajectory, distance: float, seed: int = 0) -> OdometryDrift:
    """DRIFT so much smaller or larger that its last position is so many m from the true one."""
    factor = 1.0
    for _ in range(20):
        drift = OdometryDrift(*(factor * value for value in astuple(DRIFT)))
        off = np.linalg.norm(drift.of(truth, seed).positions[-1] - truth.positions[-1])
        factor *= distance / off
    return drift


def position_errors(poses: Sequence[np.ndarray], truths: Sequence[np.ndarray]) -> np.ndarray:
    """(N,) m."""
    return np.linalg.norm(np.array(poses)[:, :3, 3] - np.array(truths)[:, :3, 3], axis=1)


def turn_errors(poses: Sequence[np.ndarray], truths: Sequence[np.ndarray]) -> np.ndarray:
    """(N,) degrees."""
    turns = np.einsum("nji,njk->nik", np.array(truths)[:, :3, :3], np.array(poses)[:, :3, :3])
    # Of small angles, the cosine says too little: the skew part is twice the sine.
    skew = np.stack(
        [
            turns[:, 2, 1] - turns[:, 1, 2],
            turns[:, 0, 2] - turns[:, 2, 0],
            turns[:, 1, 0] - turns[:, 0, 1],
        ],
        axis=1,
    )
    sines, cosines = np.linalg.norm(skew, axis=1), np.trace(turns, axis1=1, axis2=2) - 1.0
    return np.degrees(np.arctan2(sines, cosines))


def rms(values: np.ndarray) -> float:
    """The root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
