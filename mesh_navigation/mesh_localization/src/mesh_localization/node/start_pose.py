"""A pose that somebody tells, put onto the ground of a map."""

import math
from typing import Dict, List, NamedTuple, Optional

import numpy as np
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex

_UPWARD = 0.2  # least z of a normal of the ground
_STEP = 1e-3  # m below a surface, where the next one is looked for
_MOST_SURFACES = 1000
_FOOT = 0.3  # m around, whose mean tilt the robot has
_AROUND = 12  # places there
_UNEVEN = 0.5  # m that they may be above or below
_HEIGHT_VARIANCE, _TILT_VARIANCE = 0.1**2, 0.1**2  # of a pose on the ground


class Start(NamedTuple):
    """pose: (4, 4) of the base in the map; covariance: (6, 6) about the map's axes as ROS has it:
    m, then rad; what is not above 0 on its diagonal is not known."""

    pose: np.ndarray
    covariance: np.ndarray


def on_ground(
    index: SpatialIndex, normals: np.ndarray, pose: np.ndarray, base_height: float
) -> Optional[np.ndarray]:
    """The pose of a robot whose wheels are on the ground straight above or below.

    Of several storeys that which is nearest. The heading stays, the tilt is that of the ground.

    Args:
        index, normals: of the map; (F, 3) of its faces.
        pose: (4, 4) of the base in the map, or of the ground there.
        base_height: m of the base above the ground.
    Returns:
        (4, 4); None where there is no ground.
    """
    x, y, z = pose[:3, 3]
    heights = _ground_heights(index, normals, x, y)
    if not heights:
        return None
    height = min(heights, key=lambda other: abs(other - z))
    up = _up_direction(index, normals, np.array([x, y, height]))
    ahead = np.array([pose[0, 0], pose[1, 0], 0.0])
    if np.hypot(*ahead[:2]) < 1e-6:  # it looks straight up
        ahead = np.array([1.0, 0.0, 0.0])
    ahead[2] = -(up[:2] @ ahead[:2]) / up[2]
    ahead /= np.linalg.norm(ahead)
    placed = np.eye(4)
    placed[:3, :3] = np.stack([ahead, np.cross(up, ahead), up], axis=1)
    placed[:3, 3] = np.array([x, y, height]) + base_height * up
    return placed


def _ground_heights(index: SpatialIndex, normals: np.ndarray, x: float, y: float) -> List[float]:
    """m of all ground on a vertical line."""
    heights: List[float] = []
    top = 1e6
    for _ in range(_MOST_SURFACES):
        hit = index.cast(origin=(x, y, top), direction=(0.0, 0.0, -1.0))
        if hit is None:
            break
        top = float(hit.position[2])
        if normals[hit.face][2] > _UPWARD:
            heights.append(top)
        top -= _STEP * max(1.0, abs(top) * 1e-3)
    return heights


def _up_direction(index: SpatialIndex, normals: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(3,) of length 1: the normal of the plane through the ground around."""
    angles = 2 * math.pi * np.arange(_AROUND) / _AROUND
    ring = _FOOT * np.stack([np.cos(angles), np.sin(angles), np.zeros(_AROUND)], axis=1)
    origins = place + ring + [0.0, 0.0, _UNEVEN]
    down = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
    hits = index.cast_batch(
        origins=origins, directions=down, max_distance=2 * _UNEVEN, back_end="native"
    )
    met = np.flatnonzero(hits.faces != NO_FACE)
    met = met[normals[hits.faces[met], 2] > _UPWARD]
    heights = _UNEVEN - hits.distances[met]
    # Its plane goes through the place itself, which is known best.
    slopes, _, rank, _ = np.linalg.lstsq(ring[met, :2], heights, rcond=None)
    up = np.array([-slopes[0], -slopes[1], 1.0]) if rank == 2 else np.array([0.0, 0.0, 1.0])
    return up / np.linalg.norm(up)


def start_covariance(given: np.ndarray, variances: Dict[int, float]) -> np.ndarray:
    """(6, 6) about the map's axes, of a pose that was put onto the ground, which says its height
    and how it is tilted.

    Args:
        given: (6, 6), of people; what is not above 0 on its diagonal is not known.
        variances: index -> m^2 or rad^2 where it says nothing: of x, y and the heading.
    """
    of_ground = {2: _HEIGHT_VARIANCE, 3: _TILT_VARIANCE, 4: _TILT_VARIANCE}
    covariance = (given + given.T) / 2 if np.isfinite(given).all() else np.zeros((6, 6))
    for place, variance in {**variances, **of_ground}.items():
        if place in of_ground or not covariance[place, place] > 0:
            covariance[place, :] = covariance[:, place] = 0.0
            covariance[place, place] = variance
    if np.linalg.eigvalsh(covariance)[0] <= 0:
        covariance = np.diag(np.diag(covariance))
    return covariance


def turned_covariance(covariance: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """(6, 6) of a pose about the axes of a frame, of (6, 6) about those of another one.

    Args:
        covariance: m, then rad, as ROS has it.
        pose: (4, 4) of the other frame in that one.
    """
    turn = np.zeros((6, 6))
    turn[:3, :3] = turn[3:, 3:] = pose[:3, :3]
    return turn @ covariance @ turn.T
