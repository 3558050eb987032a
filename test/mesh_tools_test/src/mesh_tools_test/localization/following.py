"""A robot that is followed over its map: errors, times and states."""

import time
from typing import List, NamedTuple, Optional

import numpy as np
from mesh_localization.tracking.localizer import (
    BaseScan,
    Localizer,
    TrackingOptions,
    TrackingState,
)
from mesh_localization.tracking.ray_fates import RayFate
from mesh_map.registration.rigid import inverse, motion, numbers_of
from mesh_map.scans.lidar import Hidden, Lidar
from mesh_map.scans.recording import record_scans

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.scanned_world import SENSOR_HEIGHT
from mesh_tools_test.localization.worlds import DRIFT, LIDAR, RATE, RAYS, LocalizationWorld

FAR = 0.1  # m, beyond which a pose is wrong
SURE = np.diag(np.square([0.05, 0.05, 0.05, 0.02, 0.02, 0.02]))
ABOUT = np.diag(np.square([0.3, 0.3, 0.3, 0.06, 0.06, 0.06]))
OPTIONS = TrackingOptions(base_height=SENSOR_HEIGHT)  # the lidar is the base
STARTS, START_OFF, START_TURNED = 300, 0.5, np.radians(5)  # m and rad off


class Followed(NamedTuple):
    """Arrays (N,), one for each scan.

    errors: m; turned: rad off the truth; states: of TrackingState; deviations: m in the worst
    direction; odometry: m, errors of the odometry alone; seconds: of the processor, for a scan;
    before: share of the rays that end before the map; along, across: m off, in the robot's frame.
    """

    errors: np.ndarray
    turned: np.ndarray
    states: np.ndarray
    deviations: np.ndarray
    odometry: np.ndarray
    seconds: np.ndarray
    before: np.ndarray
    along: np.ndarray
    across: np.ndarray

    @property
    def wrong(self) -> np.ndarray:
        """Which poses are beyond FAR."""
        return self.errors > FAR

    @property
    def unsaid(self) -> int:
        """How many of these call themselves ok."""
        return int(np.count_nonzero(self.wrong & (self.states == TrackingState.OK)))


def follow(world: LocalizationWorld, count: int, hidden: Optional[Hidden] = None) -> Followed:
    """The first `count` scans of the drive; hidden: what hides the map, see Lidar.measure()."""
    random, rows = np.random.default_rng(0), []
    robot, begin = Localizer(world.target, OPTIONS), None
    drive = record_scans(
        world.truth,
        world.sensor,
        lidar=LIDAR,
        odometry=DRIFT.of(world.sensor),
        rate=RATE,
        hidden=hidden,
    )
    for (scan, truth, _), _ in zip(drive, range(count)):
        if begin is None:
            begin = truth
            robot.put(truth, SURE, scan.pose, scan.time)
        robot.move(scan.pose)
        chosen = rays_of(scan.points, random)
        origins = np.zeros(3) if scan.origins is None else scan.origins[chosen].astype(np.float64)
        sample = BaseScan(scan.points[chosen].astype(np.float64), origins, scan.time)
        before = time.process_time()
        estimate = robot.add(sample)
        seconds = time.process_time() - before
        assert estimate is not None and estimate.fates is not None
        off = numbers_of(inverse(truth) @ estimate.pose)
        fates = estimate.fates
        rows.append(
            (
                np.linalg.norm(off[:3]),
                np.linalg.norm(off[3:]),
                estimate.state,
                estimate.deviations[0],
                np.linalg.norm((inverse(truth) @ scan.pose)[:3, 3]),
                seconds,
                fates.count(RayFate.BEFORE) / max(1, len(fates.fates)),
                abs(off[0]),
                np.linalg.norm(off[1:3]),
            )
        )
    return Followed(*(np.array(column) for column in zip(*rows)))


def rays_of(points: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Indices of RAYS of a scan's points (N, 3), ascending."""
    return np.sort(random.permutation(len(points))[:RAYS])


def measure(world: LocalizationWorld, count: int) -> List[Figure]:
    """Errors and times along the drive."""
    found = follow(world, count)
    is_made = world.name == "reconstructed"
    angles = np.degrees(found.turned)
    figures = [
        Figure(
            "%s, %.2f M faces: error, median" % (world.name, len(world.geometry.faces) / 1e6),
            1e3 * float(np.median(found.errors)),
            "mm",
            "odometry",
            1e3 * float(np.median(found.odometry)),
            None if world.name == "corridor" else 15.0 if is_made else 5.0,
        ),
        Figure("  99 %", 1e3 * float(np.percentile(found.errors, 99)), "mm"),
        Figure("  turned, median", float(np.median(angles)), "deg", floor=0.3 if is_made else 0.1),
        Figure("  one scan, one core, median", _ms(found.seconds, 50), "ms", floor=20.0),
        Figure("  99 %", _ms(found.seconds, 99), "ms", floor=40.0),
    ]
    if world.name == "corridor":
        along = float(found.along[-1] / found.odometry[-1])
        return figures + [
            Figure("  across it, at most", 1e3 * float(found.across.max()), "mm", floor=20.0),
            Figure("  along it, of what odometry is off", along, "", floor=1.05),
            Figure(
                "  beyond 3 deviations along it",
                100.0 * float(np.mean(found.along > 3 * found.deviations)),
                "%",
                floor=0.0,
            ),
        ]
    share = 100.0 * float(found.wrong.mean())
    return figures + [
        Figure("  beyond 10 cm", share, "%", floor=1.0 if is_made else 0.0),
        Figure("  beyond 10 cm, and called ok", found.unsaid, "", floor=0),
        Figure("  called ok", 100.0 * float(np.mean(found.states == TrackingState.OK)), "%"),
    ]


def _ms(seconds: np.ndarray, percent: float) -> float:
    return 1e3 * float(np.percentile(seconds, percent))


def measure_obstacles(world: LocalizationWorld, count: int) -> List[Figure]:
    """With people around, where 30 % of the rays end."""
    found = follow(world, count, people())
    name = "%s, rays that end on people" % world.name
    return [
        Figure(name, 100.0 * float(found.before.mean()), "%"),
        Figure("  error, median", 1e3 * float(np.median(found.errors)), "mm"),
        Figure("  at most", 1e3 * float(found.errors.max()), "mm", floor=30.0),
    ]


def people(count: int = 14, seed: int = 1) -> Hidden:
    """Columns that go along with the lidar, 1 to 4 m away, from the ground to 0.6 m above it."""
    random = np.random.default_rng(seed)
    angles = random.uniform(0, 2 * np.pi, count)
    away = random.uniform(1.0, 4.0, count)
    radii = random.uniform(0.15, 0.45, count)

    def hidden(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        found = np.full(len(directions), np.inf)
        around = np.arctan2(directions[:, 1], directions[:, 0])
        flat = np.hypot(directions[:, 0], directions[:, 1])
        for angle, distance, radius in zip(angles, away, radii):
            apart = np.abs((around - angle + np.pi) % (2 * np.pi) - np.pi)
            ranges = distance / np.maximum(flat, 1e-3)
            heights = directions[:, 2] * ranges
            met = (apart < np.arcsin(radius / distance)) & (heights > -SENSOR_HEIGHT)
            met &= heights < 0.6
            found[met] = np.minimum(found[met], ranges[met])
        return found

    return hidden


def measure_starts(world: LocalizationWorld, count: int = STARTS) -> List[Figure]:
    """Poses anywhere on the drive, told 0.5 m and 5 degrees wrong."""
    random = np.random.default_rng(2)
    lidar = Lidar(world.truth, LIDAR)
    converged = unsaid = 0
    ends = world.sensor.times[[0, -1]]
    for truth in world.sensor.poses(random.uniform(*ends, count)):
        shift, turn = random.standard_normal((2, 3))
        off = np.concatenate(
            [START_OFF * shift / np.linalg.norm(shift), START_TURNED * turn / np.linalg.norm(turn)]
        )
        robot = Localizer(world.target, OPTIONS)
        robot.put(truth @ motion(off), ABOUT, np.eye(4), 0.0)
        estimate = None
        for number in range(4):
            points = lidar.measure(truth).points
            sample = points[rays_of(points, random)].astype(np.float64)
            estimate = robot.add(BaseScan(sample, np.zeros(3), (number + 1) / RATE))
        assert estimate is not None
        near = float(np.linalg.norm((inverse(truth) @ estimate.pose)[:3, 3])) <= FAR
        converged += near
        unsaid += not near and estimate.state == TrackingState.OK
    return [
        Figure(
            "%s, starts that do not converge" % world.name,
            100.0 * (1 - converged / count),
            "%",
            floor=1.0,
        ),
        Figure("  and do not say so", unsaid, "", floor=0),
    ]
