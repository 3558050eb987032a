"""Generalized ICP of Open3D on the vertices of the map, where it is installed (python3-open3d)."""

import time
from typing import Any, List

import numpy as np
from mesh_map.registration.point_to_plane import RAYS
from mesh_map.registration.rigid import inverse, motion
from mesh_map.scans.lidar import Lidar

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.localization.following import FAR, rays_of
from mesh_tools_test.localization.worlds import LIDAR, LocalizationWorld

OFF, TURNED = 0.3, np.radians(3.4)  # m and rad that poses are off
COUNT = 60
_AROUND, _REACH = 30.0, 0.5  # m around the robot that are the map, and within which points match


def measure(world: LocalizationWorld, count: int = COUNT) -> List[Figure]:
    """Scans laid onto the map from 0.3 m and 3.4 degrees off, by both; no figures without
    Open3D."""
    try:
        import open3d
    except ImportError:
        return []
    random, lidar = np.random.default_rng(3), Lidar(world.truth, LIDAR)
    ends = world.sensor.times[[0, -1]]
    rows = []
    for truth in world.sensor.poses(random.uniform(*ends, count)):
        shift, turn = random.standard_normal((2, 3))
        shift, turn = OFF * shift / np.linalg.norm(shift), TURNED * turn / np.linalg.norm(turn)
        guess = truth @ motion(np.concatenate([shift, turn]))
        points = lidar.measure(truth).points
        sample = points[rays_of(points, random)].astype(np.float64)
        begin = time.process_time()
        ours = world.target.register(sample, guess, matching=RAYS, max_distance=1.0)
        middle = time.process_time()
        theirs = _generalized_icp(open3d, world.geometry.vertices, sample, guess)
        end = time.process_time()
        found = guess if ours is None else ours.pose
        rows.append((_off(truth, found), middle - begin, _off(truth, theirs), end - middle))
    errors, seconds, other_errors, other_seconds = np.array(rows).T
    name, peer = world.name, "GICP on vertices"
    return [
        Figure(
            "%s, one scan from 0.3 m off: median" % name,
            1e3 * float(np.median(errors)),
            "mm",
            peer,
            1e3 * float(np.median(other_errors)),
        ),
        Figure(
            "  95 %",
            1e3 * float(np.percentile(errors, 95)),
            "mm",
            peer,
            1e3 * float(np.percentile(other_errors, 95)),
        ),
        Figure(
            "  beyond 10 cm",
            100.0 * float(np.mean(errors > FAR)),
            "%",
            peer,
            100.0 * float(np.mean(other_errors > FAR)),
        ),
        Figure(
            "  processor time",
            1e3 * float(np.median(seconds)),
            "ms",
            peer,
            1e3 * float(np.median(other_seconds)),
        ),
    ]


def _generalized_icp(
    open3d: Any, vertices: np.ndarray, points: np.ndarray, guess: np.ndarray
) -> np.ndarray:
    near = vertices[np.linalg.norm(vertices - guess[:3, 3], axis=1) < _AROUND]
    clouds = [
        open3d.geometry.PointCloud(open3d.utility.Vector3dVector(each.astype(np.float64)))
        for each in (points, near)
    ]
    return open3d.pipelines.registration.registration_generalized_icp(
        *clouds, _REACH, guess
    ).transformation


def _off(truth: np.ndarray, pose: np.ndarray) -> float:
    return float(np.linalg.norm((inverse(truth) @ pose)[:3, 3]))
