"""A robot followed over a map, from scan to scan."""

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Optional, Tuple

import numpy as np
from mesh_map.registration.point_to_plane import RAYS, PlaneTarget, Registration
from mesh_map.registration.rigid import inverse, motion, numbers_of

from mesh_localization.tracking.ground_contact import GroundContact
from mesh_localization.tracking.mounting_watch import MountingWatch
from mesh_localization.tracking.odometry_model import OdometryModel, OdometryMotion
from mesh_localization.tracking.ray_fates import RayFate, RayFates, ray_fates

_RANGE_NOISE = 0.01  # m, the least deviation of a distance
_CORRELATED = 50.0  # rays that err together: neighbors meet the same error of the map
_FLOOR = np.array([1e-3, 1e-3, 1e-3, 2e-4, 2e-4, 2e-4])  # m and rad that one scan cannot be below
_REACH = 3.0  # deviations within which the surface is looked for
_LEAST_REACH, _MOST_REACH = 0.3, 2.0  # m
_NEAREST = 0.1  # m within which points count in the end
_STEPS = 15  # on rough ground rays go on to meet other faces, to and fro by less than a millimeter
_NEARBY = 1.0  # m around a pose that was told, within which a better one is looked for
_AROUND = 1.5  # deviations
_FEW, _CLEARLY = 500, 0.05  # rays for that, and the share of them by which a better one is
_GATE = 5.0  # deviations that a scan may be off the odometry
_ARM = 5.0  # m at which the uncertain heading of a pose moves points
_SCATTER = 5.0  # times the usual residual, that a point may be off the surface
_LEAST_TOLERANCE = 0.04  # m
_LEARNED = 0.02  # by each scan, of the usual residual
_OPEN = 0.5  # of the rays that the map explains, from which on a view is open
_AGREED = 0.1, 0.03  # m and rad, that poses of scans which agree are apart
_UNSURE = np.diag(np.square([0.5, 0.5, 0.3, 0.1, 0.1, 0.2]))  # of who is lost


class TrackingState(IntEnum):
    """How well the robot knows where it is; as in mesh_msgs/LocalizationState."""

    LOST = 0
    UNCERTAIN = 1
    OK = 2


@dataclass(frozen=True)
class TrackingOptions:
    """When a pose is believed.

    Attributes:
        odometry: what odometry is off.
        base_height: m of the base above the ground on which the robot stands; None: it flies, or
            climbs walls.
        tolerance: m from the surface, up to which the map explains a point; less once the robot
            is followed and scans scatter less.
        ok_share: of the rays that meet the map, how many have to end on it while the robot is
            followed.
        sure_share: the same, of who was put somewhere, was lost, or is elsewhere than odometry
            allows: on open ground a wrong place explains nine rays of ten.
        lost_share: below it the robot is lost.
        least_share: of all rays, how many the map has to explain; with fewer the view is hidden.
        least_rays: the same, their number.
        confirmations: scans one after the other that have to agree before a pose is believed.
        lost_scans: scans one after the other that are below `lost_share` until the robot is lost;
            unbelieved_scans: that are not believed; of a hidden view only where it was open in the
            scan before.
        ok_deviation, lost_deviation: (m, rad), standard deviations in the worst direction from
            which on the state is uncertain, and lost.
        silence: s without a scan that was believed until it is uncertain; lost_silence: until it
            is lost.
    """

    odometry: OdometryModel = field(default_factory=OdometryModel)
    base_height: Optional[float] = None
    tolerance: float = 0.1
    ok_share: float = 0.9
    sure_share: float = 0.95
    lost_share: float = 0.75
    least_share: float = 0.2
    least_rays: int = 40
    confirmations: int = 3
    lost_scans: int = 2
    unbelieved_scans: int = 6
    ok_deviation: Tuple[float, float] = (0.1, 0.1)
    lost_deviation: Tuple[float, float] = (3.0, 0.7)
    silence: float = 0.5
    lost_silence: float = 2.0


@dataclass(frozen=True)
class BaseScan:
    """Points of one scan in the frame of the robot's base at one moment.

    Attributes:
        points: (N, 3) m.
        origins: (N, 3) or (3,) m, where the sensor was.
        time: s.
        sensor: its name.
    """

    points: np.ndarray
    origins: np.ndarray
    time: float
    sensor: str = ""

    def part(self, most: int) -> "BaseScan":
        """At most so many of the points, evenly."""
        step = max(1, -(-len(self.points) // most))
        origins = self.origins if self.origins.ndim == 1 else self.origins[::step]
        return replace(self, points=self.points[::step], origins=origins)


@dataclass(frozen=True)
class Estimate:
    """What is known after a scan.

    Attributes:
        pose: (4, 4) of the base in the map.
        covariance: (6, 6) of it in the frame of the base: m, then rad.
        correction: (4, 4), the odometry's frame in the map.
        state, reason: whether to believe it; the reason is for people, empty where the state is ok.
        fates: of the rays at this pose; None without a scan.
        time: s of the scan.
        told: in how many of the six directions the scan told where the robot is.
    """

    pose: np.ndarray
    covariance: np.ndarray
    correction: np.ndarray
    state: TrackingState
    reason: str
    fates: Optional[RayFates]
    time: float
    told: int = 0

    @property
    def deviations(self) -> Tuple[float, float]:
        """(m, rad), standard deviations in the worst direction."""
        return deviations_of(self.covariance)


def deviations_of(covariance: np.ndarray) -> Tuple[float, float]:
    """(m, rad): standard deviations of a pose (6, 6) in the worst direction."""
    values = [np.linalg.eigvalsh(covariance[i : i + 3, i : i + 3])[-1] for i in (0, 3)]
    return math.sqrt(max(values[0], 0.0)), math.sqrt(max(values[1], 0.0))


class _Match:
    """A scan laid onto the map, and how well it fits there."""

    def __init__(
        self, found: Optional[Registration], fates: RayFates, predicted: np.ndarray
    ) -> None:
        self.found, self.fates = found, fates
        self.pose = predicted if found is None else found.pose
        self.off = np.zeros(6) if found is None else numbers_of(inverse(predicted) @ found.pose)


class Localizer:
    """Follows one robot over one map. It belongs to one thread at a time.

    Each scan is laid onto the map where odometry says that the robot is, by point-to-plane
    registration of its rays, with odometry as the prior. A scan that lies elsewhere than odometry
    allows is not believed until others agree.
    """

    def __init__(self, target: PlaneTarget, options: TrackingOptions = TrackingOptions()) -> None:
        """
        Args:
            target: the map.
            options: when a pose is believed.
        """
        self.target, self.options = target, options
        self._mounting = MountingWatch()
        self._pose: Optional[np.ndarray] = None  # at the last scan that was believed, or put
        self._covariance = np.zeros((6, 6))
        self._motion = OdometryMotion(np.eye(4))  # since then
        self._good = self._bad = self._strange = 0
        self._agreed: list = (
            []
        )  # corrections of scans that agree with each other, not with odometry
        self._state, self._reason = TrackingState.LOST, "it has not been told where it is"
        self._followed = False  # from scan to scan, not just put or lost
        self._was_open = False  # whether the view was open before it was hidden
        self._believed = -math.inf  # s, the time of the last scan that was
        self._residual = options.tolerance / _SCATTER  # m, as scans have it that are believed

    @property
    def state(self) -> TrackingState:
        """That of the last estimate."""
        return self._state

    @property
    def mounting_fault(self) -> str:
        """What is always off where sensors sit on the robot, as a sentence; empty: nothing."""
        return self._mounting.fault

    def put(
        self, pose: np.ndarray, covariance: np.ndarray, odometry: np.ndarray, time: float
    ) -> None:
        """Begin at a pose that somebody tells.

        Args:
            pose: (4, 4) of the base in the map.
            covariance: (6, 6) of it in the frame of the base; 0 is taken for a millimeter.
            odometry: (4, 4) of the base in the frame of the odometry, at the same time.
            time: s.
        """
        self._pose, self._covariance = pose, covariance + np.diag(_FLOOR**2)
        self._motion = OdometryMotion(odometry)
        self._good = self._bad = self._strange = 0
        self._agreed = []
        self._state, self._reason = (
            TrackingState.UNCERTAIN,
            "no scan has confirmed the pose it was told",
        )
        self._followed, self._believed = False, time
        self._residual = self.options.tolerance / _SCATTER

    def move(self, odometry: np.ndarray) -> None:
        """Where the base is now in the frame of the odometry, (4, 4)."""
        self._motion.add(odometry)

    def predicted(self) -> Optional[np.ndarray]:
        """(4, 4) of the base in the map by odometry and the ground; None before it was put
        anywhere."""
        found = self._prior()
        return None if found is None else found[0]

    def _prior(self) -> Optional[Tuple[np.ndarray, np.ndarray]]:
        """The pose before a scan, and its covariance (6, 6)."""
        if self._pose is None:
            return None
        pose = self._pose @ self._motion.step
        covariance = self._motion.grown(self._covariance, self.options.odometry)
        ground = self._ground
        return (pose, covariance) if ground is None else ground.put_down(pose, covariance)

    @property
    def _ground(self) -> Optional[GroundContact]:
        height = self.options.base_height
        return None if height is None else GroundContact(self.target, height)

    def estimate(self, time: float) -> Optional[Estimate]:
        """What is known now, without a new scan; None before it was put anywhere."""
        found = self._prior()
        if found is None:
            return None
        predicted, covariance = found
        self._judge_silence(time - self._believed)
        self._judge_deviations(covariance)
        return self._told(predicted, covariance, None, time)

    def add(self, scan: BaseScan) -> Optional[Estimate]:
        """Lay a scan onto the map; `move` has told where odometry says that it was made.

        Returns:
            None before the robot was put anywhere.
        """
        found = self._prior()
        if found is None:
            return None
        predicted, covariance = found
        if self._state == TrackingState.LOST:
            covariance = covariance + _UNSURE
        match = self._matched(scan, predicted, covariance, True)
        share = self.options.ok_share if self._followed else self.options.sure_share
        if not self._followed:
            match = self._best_around(scan, predicted, covariance, match)
        believed = self._is_good(match, share) and self._is_allowed(match, covariance)
        if not believed:
            free = self._agreed_upon(scan, predicted, covariance)
            match, believed = free or match, free is not None
            if self._agreed:  # as wide as what may be true
                off = numbers_of(inverse(predicted) @ self._agreed[-1] @ self._motion.newest)
                covariance = covariance + np.outer(off, off)
        if believed:
            assert match.found is not None
            self._agreed, self._believed = [], scan.time
            pose = match.found.pose
            covariance = _posterior(match.found, covariance)
            self._pose, self._covariance = pose, covariance
            if self._followed and match.found.told == 6:
                ground = self._ground
                height = math.nan if ground is None else ground.height(pose)
                self._mounting.add(scan.sensor, match.off[:3], height)
            motion = self._motion
            before = () if match.found.told == 6 else (motion.driven, motion.turned)
            self._motion = OdometryMotion(motion.newest, *before)
        else:
            pose = predicted
        self._judge(match.fates, believed)
        self._judge_silence(scan.time - self._believed)
        self._judge_deviations(covariance)
        if self._state == TrackingState.LOST:
            self._followed = False
        elif self._state == TrackingState.OK:
            self._followed = True
        told = match.found.told if believed and match.found is not None else 0
        return self._told(pose, covariance, match.fates, scan.time, told)

    def _matched(
        self, scan: BaseScan, predicted: np.ndarray, covariance: np.ndarray, with_prior: bool
    ) -> _Match:
        position, rotation = deviations_of(covariance)
        reach = _REACH * (position + _ARM * rotation)
        prior = None
        if with_prior:
            prior = np.linalg.inv(covariance) * _RANGE_NOISE**2 * _CORRELATED
        found = self.target.register(
            scan.points,
            predicted,
            origins=scan.origins,
            prior=prior,
            matching=RAYS,
            max_distance=min(max(_LEAST_REACH, reach), _MOST_REACH),
            min_distance=_NEAREST,
            steps=_STEPS,
        )
        pose = predicted if found is None else found.pose
        return _Match(found, self._fates(scan, pose), predicted)

    def _best_around(
        self, scan: BaseScan, predicted: np.ndarray, covariance: np.ndarray, match: _Match
    ) -> _Match:
        """The match, or a better one from somewhere else around where the robot is told to be: all
        rays of who is told to be behind a wall meet that."""
        few = scan.part(_FEW)
        prior = np.linalg.inv(covariance) * _RANGE_NOISE**2 * _CORRELATED
        near = self.target.register(
            few.points, predicted, origins=few.origins, prior=prior, max_distance=_NEARBY
        )
        begins = [] if near is None else [near.pose]
        side = min(_AROUND * deviations_of(covariance)[0], _NEARBY)
        for angle in np.arange(8) * math.pi / 4:
            shift = np.array([side * math.cos(angle), side * math.sin(angle), 0.0, 0.0, 0.0, 0.0])
            begins.append(predicted @ motion(shift))
        best, most = None, _fit(self._fates(few, match.pose))
        for begin in begins:
            found = self._laid(few, begin, side)
            fit = _fit(self._fates(few, found.pose)) if found is not None else -1.0
            if found is not None and fit > most + _CLEARLY:
                best, most = found.pose, fit
        if best is None:
            return match
        found = self._laid(scan, best, _LEAST_REACH)
        return _Match(found, self._fates(scan, best if found is None else found.pose), predicted)

    def _laid(self, scan: BaseScan, begin: np.ndarray, reach: float) -> Optional[Registration]:
        return self.target.register(
            scan.points,
            begin,
            origins=scan.origins,
            matching=RAYS,
            max_distance=reach,
            min_distance=_NEAREST,
            steps=_STEPS,
        )

    def _fates(self, scan: BaseScan, pose: np.ndarray) -> RayFates:
        most = self.options.tolerance
        tolerance = min(max(_SCATTER * self._residual, min(_LEAST_TOLERANCE, most)), most)
        return ray_fates(self.target, scan.points, scan.origins, pose, tolerance)

    def _is_good(self, match: _Match, share: float) -> bool:
        fates = match.fates
        return match.found is not None and fates.share >= share and not self._is_hidden(fates)

    def _is_hidden(self, fates: RayFates) -> bool:
        options, explained = self.options, fates.count(RayFate.EXPLAINED)
        return explained < max(options.least_rays, options.least_share * len(fates.fates))

    @staticmethod
    def _is_allowed(match: _Match, covariance: np.ndarray) -> bool:
        """Whether odometry may be so much off."""
        return bool(match.off @ np.linalg.solve(covariance, match.off) <= _GATE**2)

    def _agreed_upon(
        self, scan: BaseScan, predicted: np.ndarray, covariance: np.ndarray
    ) -> Optional[_Match]:
        """The scan where it fits without odometry, once so many in turn have agreed on it."""
        free = self._matched(scan, predicted, covariance + _UNSURE, False)
        if not self._is_good(free, self.options.sure_share) or free.found.told < 6:
            self._agreed = []
            return None
        if self._agreed:
            expected = self._agreed[-1] @ self._motion.newest
            apart = numbers_of(inverse(expected) @ free.found.pose)
            if np.linalg.norm(apart[:3]) > _AGREED[0] or np.linalg.norm(apart[3:]) > _AGREED[1]:
                self._agreed = []
        self._agreed.append(free.found.pose @ inverse(self._motion.newest))
        return free if len(self._agreed) >= self.options.confirmations else None

    def _judge(self, fates: RayFates, believed: bool) -> None:
        """The state after a scan."""
        options = self.options
        self._good = self._good + 1 if believed else 0
        hidden = self._is_hidden(fates)
        bad = fates.share < options.lost_share and not hidden and not believed
        self._bad = self._bad + 1 if bad else 0
        explained = fates.count(RayFate.EXPLAINED) / max(1, len(fates.fates))
        if not hidden:
            self._was_open = believed and explained > _OPEN
        # People come into the view one after the other; all of it at once is another place.
        self._strange = 0 if believed or (hidden and not self._was_open) else self._strange + 1
        if believed:
            # As a mean of the first scans, then slowly: a wrong place is not learned.
            rate = max(_LEARNED, 1 / self._good)
            self._residual += rate * (fates.residual - self._residual)
        why = "%.0f %% of the rays that meet the map go through it" % (100 - 100 * fates.share)
        if hidden:
            text = "the map explains %d of %d rays: the view is hidden, or it is another map"
            why = text % (fates.count(RayFate.EXPLAINED), len(fates.fates))
        elif self._agreed:
            why = "scans fit the map elsewhere than odometry allows"
        if self._good >= options.confirmations:
            self._state, self._reason = TrackingState.OK, ""
        elif self._bad >= options.lost_scans or self._strange >= options.unbelieved_scans:
            self._state, self._reason = TrackingState.LOST, why
        elif believed:
            text = "%d of %d scans have confirmed the pose"
            self._state = TrackingState.UNCERTAIN
            self._reason = text % (self._good, options.confirmations)
        elif self._state != TrackingState.LOST:
            self._state, self._reason = TrackingState.UNCERTAIN, why

    def _judge_silence(self, silence: float) -> None:
        options = self.options
        if silence > options.lost_silence and self._state != TrackingState.LOST:
            why = " (%s)" % self._reason if self._reason else ""
            self._state = TrackingState.LOST
            self._reason = "no scan was believed for %.1f s%s" % (silence, why)
        elif silence > options.silence and self._state == TrackingState.OK:
            self._good, self._state = 0, TrackingState.UNCERTAIN
            self._reason = "no scan was believed for %.1f s" % silence

    def _judge_deviations(self, covariance: np.ndarray) -> None:
        options, found = self.options, deviations_of(covariance)
        text = "the pose is sure to %.2f m and %.2f rad only" % found
        limits = (
            (TrackingState.LOST, options.lost_deviation),
            (TrackingState.UNCERTAIN, options.ok_deviation),
        )
        for state, most in limits:
            if self._state > state and (found[0] > most[0] or found[1] > most[1]):
                self._state, self._reason = state, text

    def _told(
        self,
        pose: np.ndarray,
        covariance: np.ndarray,
        fates: Optional[RayFates],
        time: float,
        told: int = 0,
    ) -> Estimate:
        correction = pose @ inverse(self._motion.newest)
        return Estimate(pose, covariance, correction, self._state, self._reason, fates, time, told)


def _fit(fates: RayFates) -> float:
    """Of all rays those that are explained less those that go through the map, -1 to 1."""
    explained, through = fates.count(RayFate.EXPLAINED), fates.count(RayFate.THROUGH)
    return (explained - through) / max(1, len(fates.fates))


def _posterior(found: Registration, covariance: np.ndarray) -> np.ndarray:
    """(6, 6) in the frame of the pose that was found."""
    variance = max(found.residual, _RANGE_NOISE) ** 2 * _CORRELATED
    known = np.linalg.inv(np.linalg.inv(covariance) + found.information / variance)
    return known + np.diag(_FLOOR**2)
