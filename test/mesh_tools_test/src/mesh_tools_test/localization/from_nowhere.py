"""Robots found on a large map of two storeys by one scan."""

import math
import time
from typing import List, NamedTuple, Optional, Tuple

import numpy as np
from mesh_localization.relocalization.global_search import GlobalSearch, SearchState
from mesh_localization.tracking.localizer import BaseScan
from mesh_map.registration.rigid import inverse, numbers_of
from mesh_map.scans.lidar import Lidar, LidarModel

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.storeys_world import StoreysWorld, storeys_world

PLACES = 50
LIDAR = LidarModel(rings=16, columns=360, noise=0.015)
LASER = LidarModel(rings=1, columns=720, lowest=0.0, highest=0.0, noise=0.015)
LASER_VIEW = math.radians(270)
RAYS = 2000
SENSOR = 0.6  # m above the ground
HIDDEN = 0.3  # share of the view, behind things that are not on the map
_THINGS, _NEAR = 3, (1.0, 3.0)  # that hide it, and how many m away they are
RIGHT = 0.1, math.radians(2)  # m and rad from the truth
MOST_WRONG, MOST_SECONDS = 5.0, 10.0  # %, and s


class _Found(NamedTuple):
    """right: whether it was; said: whether it was believed; distance: m from the truth."""

    right: bool
    said: bool
    distance: float
    seconds: float
    core_seconds: float


def measure(places: int = PLACES, world: Optional[StoreysWorld] = None) -> List[Figure]:
    """All places, each one scan: of a lidar, with things in its view, and of a laser scanner.

    Floors hold for the lidar on 100 x 100 m and two cores.

    Args:
        places: how many.
        world: where; None: 100 x 100 m.
    """
    world = storeys_world() if world is None else world
    poses = world.poses(places)
    figures = [
        *_figures("lidar", _all(world, poses, LIDAR, 0.0), True),
        *_figures("lidar, %.0f %% hidden" % (100 * HIDDEN), _all(world, poses, LIDAR, HIDDEN)),
        *_figures("laser scanner", _all(world, poses, LASER, 0.0)),
    ]
    return figures


def _all(world: StoreysWorld, poses: np.ndarray, model: LidarModel, hidden: float) -> List[_Found]:
    search = GlobalSearch(world.mesh)
    sensor = Lidar(world.mesh, model)
    found = []
    for number, pose in enumerate(poses):
        scan = _scan(sensor, pose, hidden, np.random.default_rng(number))
        begin = time.perf_counter(), time.process_time()
        result = search.search(scan)
        seconds = time.perf_counter() - begin[0], time.process_time() - begin[1]
        distance, angle = (math.inf, math.inf)
        if result.best is not None:
            distance, angle = _off(result.best.pose, pose)
        is_right = distance < RIGHT[0] and angle < RIGHT[1]
        found.append(_Found(is_right, result.state == SearchState.FOUND, distance, *seconds))
    return found


def _scan(sensor: Lidar, pose: np.ndarray, hidden: float, random: np.random.Generator) -> BaseScan:
    """In the frame of a base on the ground."""
    place = pose.copy()
    place[:3, 3] += SENSOR * pose[:3, 2]
    points = sensor.measure(place).points.astype(np.float64)
    around = np.arctan2(points[:, 1], points[:, 0])
    if sensor.model.rings == 1:
        points = points[abs(around) < LASER_VIEW / 2]
    points = random.permutation(points)[:RAYS]
    around = np.arctan2(points[:, 1], points[:, 0])
    for middle in random.uniform(-np.pi, np.pi, _THINGS if hidden else 0):
        aside = abs((around - middle + np.pi) % (2 * np.pi) - np.pi)
        behind = aside < hidden * np.pi / _THINGS
        ranges = np.linalg.norm(points[behind], axis=1)
        points[behind] *= np.minimum(1.0, random.uniform(*_NEAR) / ranges)[:, None]
    up = np.array([0.0, 0.0, SENSOR])
    return BaseScan(points + up, up, 0.0)


def _off(pose: np.ndarray, truth: np.ndarray) -> Tuple[float, float]:
    numbers = numbers_of(inverse(truth) @ pose)
    return float(np.linalg.norm(numbers[:3])), float(np.linalg.norm(numbers[3:]))


def _figures(name: str, found: List[_Found], has_floors: bool = False) -> List[Figure]:
    count = len(found)
    right = [each for each in found if each.right and each.said]
    doubted = [each for each in found if not each.said]
    silent = count - len(right) - len(doubted)
    floors = (MOST_WRONG, 0.0, MOST_SECONDS) if has_floors else (None, None, None)
    seconds = [each.seconds for each in found]
    figures = [
        Figure("from nowhere, %s: not right" % name, 100 - 100 * len(right) / count, "%"),
        Figure("  said so", 100 * len(doubted) / count, "%"),
        Figure("  wrong and believed", 100 * silent / count, "%"),
        Figure("  time: median", float(np.median(seconds)), "s"),
        Figure("  time: most", max(seconds), "s"),
        Figure(
            "  on all cores: median", float(np.median([each.core_seconds for each in found])), "s"
        ),
    ]
    if right:
        middle = float(np.median([each.distance for each in right]))
        figures.append(Figure("  off where right: median", 1000 * middle, "mm"))
    for place, floor in zip((0, 2, 4), floors):
        figures[place] = figures[place]._replace(floor=floor)
    return figures
