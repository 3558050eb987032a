"""What the node knows of the robot: the map, the start, the scans, and the state that follows."""

import math
from typing import Callable, Dict, NamedTuple, Optional

import numpy as np
from mesh_map.base.errors import MeshMapError
from mesh_map.registration.point_to_plane import RAYS, PlaneTarget
from mesh_map.registration.rigid import inverse, moved, numbers_of

from mesh_localization.node.start_pose import (
    Start,
    on_ground,
    start_covariance,
    turned_covariance,
)
from mesh_localization.sensing.placed_scan import PlacedScan
from mesh_localization.tracking.localizer import (
    Estimate,
    Localizer,
    TrackingOptions,
    TrackingState,
)
from mesh_localization.tracking.odometry_model import turn_of
from mesh_localization.tracking.ray_fates import RayFate, ray_fates

OdometryNow = Callable[[], np.ndarray]
"""(4, 4) of the base in the odometry's frame now; MeshMapError: it is not known, and why."""

_HALF_TURN = np.diag([1.0, -1.0, -1.0, 1.0])  # about x
_TURNED_PERIOD = 2.0  # s between two looks whether a sensor is upside down
_TURNED_REACH = 1.0  # m
_TURNED_SHARE = 0.3  # of all rays, that the map has to explain then
_AGREED = 0.2, 0.1  # m and rad, within which a search has found the robot where it is
_SILENT = 0.3  # s without a scan, from which on odometry alone says where the robot is
_NOT_TOLD = "it has not been told where it is: set a pose on initialpose, or call relocalize"


class Report(NamedTuple):
    """What is known now.

    Attributes:
        state, reason: the reason is for people, empty where the state is OK.
        estimate: None before the robot was put anywhere.
        explained: share of the rays of the last scan that the map explains; NaN: not known.
        residual: m, of these; NaN: not known.
    """

    state: TrackingState
    reason: str
    estimate: Optional[Estimate] = None
    explained: float = math.nan
    residual: float = math.nan

    @property
    def is_known(self) -> bool:
        """Whether a correction may be published."""
        return self.estimate is not None and self.state != TrackingState.LOST


class LocalizationSession:
    """Follows the robot over maps that come and change. It belongs to one thread.

    Attributes:
        target: the map; None: there is none.
        map_fault: why there is no map.
        scan_fault: why the last scan was not used; empty where it was.
        search_note: that the robot is being looked for on the map; empty where it is not.
        start_refusal: why a start could not be taken; empty where it could.
    """

    def __init__(
        self,
        options: TrackingOptions,
        base_height: float,
        variances: Dict[int, float],
        least_motion: "tuple[float, float]" = (0.0, 0.0),
    ) -> None:
        """
        Args:
            options: when a pose is believed.
            base_height: m of the base above the ground.
            variances: of starts that do not say them, see `start_covariance`.
            least_motion: (m, rad) from scan to scan; with less, scans are left out.
        """
        self.least_motion = least_motion
        self.target: Optional[PlaneTarget] = None
        self.map_fault = "there is no map yet"
        self.scan_fault = self.search_note = self.start_refusal = ""
        self._options, self._variances, self._height = options, variances, base_height
        self._localizer: Optional[Localizer] = None
        self._start: Optional[Start] = None  # that waits for map and odometry
        self._start_fault = ""
        self._added: Optional[PlacedScan] = None
        self._explained = self._residual = math.nan
        self._turned_fault, self._turned_time = "", -math.inf

    def begin_anew(self) -> None:
        """Forget the robot, and the start that waits; the map stays."""
        self._localizer = self._start = self._added = None
        self._start_fault = self.scan_fault = self._turned_fault = ""
        self._turned_time = -math.inf
        self._explained = self._residual = math.nan

    def take_options(self, options: TrackingOptions) -> None:
        """Other options, from the next scan on."""
        self._options = options
        if self._localizer is not None:
            self._localizer.options = options

    def take_map(self, target: PlaneTarget, time: float) -> None:
        """A map, or another one: on that the robot is where it was, but not sure of it."""
        self.target, self.map_fault = target, ""
        localizer = self._localizer
        if localizer is None:
            return
        known = localizer.estimate(time)
        if known is None or known.state == TrackingState.LOST:
            localizer.target = target  # who is lost stays lost
            return
        odometry = inverse(known.correction) @ known.pose
        self._localizer = Localizer(target, self._options)
        self._localizer.put(known.pose, known.covariance, odometry, time)

    def begin_at(self, start: Start) -> None:
        """The robot is here, as soon as there are a map and odometry."""
        self._start, self.start_refusal = start, ""

    def put(self, pose: np.ndarray, covariance: np.ndarray, scan: PlacedScan, time: float) -> None:
        """A scan was found to lie here. A robot that is OK there already goes on as it is.

        Args:
            pose: (4, 4) of the base in the map when the scan was made.
            covariance: (6, 6) about the axes of the base.
            scan: and where odometry was.
            time: s, of now: a search takes longer than the silence after which a robot is lost.
        """
        assert self.target is not None
        known = None if self._localizer is None else self._localizer.estimate(time)
        if known is not None and known.state == TrackingState.OK:
            off = numbers_of(inverse(known.correction @ scan.odometry) @ pose)
            if np.linalg.norm(off[:3]) < _AGREED[0] and np.linalg.norm(off[3:]) < _AGREED[1]:
                return
        self._start = self._added = None
        self._localizer = Localizer(self.target, self._options)
        self._localizer.put(pose, covariance, scan.odometry, time)
        self._turned_fault = self._start_fault = self.start_refusal = ""

    @property
    def mounting_fault(self) -> str:
        """What is always off where sensors sit on the robot; empty: nothing."""
        return "" if self._localizer is None else self._localizer.mounting_fault

    def look(self, time: float, odometry_now: OdometryNow) -> Report:
        """What is known now, without a new scan.

        Args:
            time: s.
            odometry_now: asked where it is needed.
        """
        self._take_start(time, odometry_now)
        localizer = self._localizer
        if localizer is None:
            return self._report(None)
        if self._added is None or time - self._added.scan.time > _SILENT:
            try:
                localizer.move(odometry_now())
            except MeshMapError:
                pass  # scans cannot be placed either, which is told
        return self._report(localizer.estimate(time))

    def add(self, scan: PlacedScan) -> Optional[Report]:
        """Lay a scan onto the map; None where that was not done."""
        self.scan_fault = ""
        self._take_start(scan.scan.time, lambda: scan.odometry)
        localizer = self._localizer
        if localizer is None or self._is_left_out(scan):
            return None
        localizer.move(scan.odometry)
        estimate = localizer.add(scan.scan)
        assert estimate is not None and estimate.fates is not None
        self._added = scan
        fates = estimate.fates
        self._explained, self._residual = fates.share, fates.residual
        self._look_whether_turned(scan, estimate)
        return self._report(estimate)

    def _is_left_out(self, scan: PlacedScan) -> bool:
        """Whether the robot has not moved enough since the last scan."""
        last, localizer = self._added, self._localizer
        if last is None or localizer is None or localizer.state != TrackingState.OK:
            return False
        if scan.scan.time - last.scan.time > 0.5 * self._options.silence:
            return False
        step = inverse(last.odometry) @ scan.odometry
        driven, turned = float(np.linalg.norm(step[:3, 3])), turn_of(step)
        return driven < self.least_motion[0] and turned < self.least_motion[1]

    def _take_start(self, time: float, odometry_now: OdometryNow) -> None:
        start, target = self._start, self.target
        if start is None or target is None:
            return
        try:
            odometry = odometry_now()
        except MeshMapError as error:
            self._start_fault = "the pose that it was told waits for odometry: %s" % error
            return
        self._start, self._start_fault = None, ""
        pose = on_ground(target.index, target.normals, start.pose, self._height)
        if pose is None:
            self.start_refusal = "there is no ground above or below (%.2f, %.2f)" % tuple(
                start.pose[:2, 3]
            )
            return
        covariance = start_covariance(start.covariance, self._variances)
        self._localizer = Localizer(target, self._options)
        self._localizer.put(pose, turned_covariance(covariance, inverse(pose)), odometry, time)
        self._added, self._turned_fault = None, ""

    def _report(self, estimate: Optional[Estimate]) -> Report:
        if self.target is None:
            return Report(TrackingState.LOST, self.map_fault)
        if estimate is None:
            fault = self._start_fault or self.start_refusal or _NOT_TOLD
            return Report(TrackingState.LOST, self._with_faults(fault))
        if estimate.state == TrackingState.OK:
            reason = ""
        else:
            reason = self._with_faults(estimate.reason)
        last = self._added
        if last is None or estimate.time - last.scan.time > self._options.silence:
            return Report(estimate.state, reason, estimate)
        return Report(estimate.state, reason, estimate, self._explained, self._residual)

    def _with_faults(self, reason: str) -> str:
        parts = reason, self._turned_fault, self.scan_fault, self.search_note
        return "; ".join(part for part in parts if part)

    def _look_whether_turned(self, scan: PlacedScan, estimate: Estimate) -> None:
        """Whether the scan of a robot that is not known fits if its sensor is turned over."""
        assert self.target is not None and estimate.fates is not None
        if estimate.state == TrackingState.OK:
            self._turned_fault = ""
            return
        time = scan.scan.time
        if not _TURNED_PERIOD <= abs(time - self._turned_time):
            return
        self._turned_time = time
        turn = scan.sensor @ _HALF_TURN @ inverse(scan.sensor)
        points = moved(turn, scan.scan.points)
        origins = moved(turn, np.broadcast_to(scan.scan.origins, points.shape))
        found = self.target.register(
            points,
            estimate.pose,
            origins=origins,
            matching=RAYS,
            max_distance=_TURNED_REACH,
        )
        self._turned_fault = ""
        if found is not None:
            options = self._options
            fates = ray_fates(self.target, points, origins, found.pose, options.tolerance)
            many = _TURNED_SHARE * len(points)
            before = estimate.fates.count(RayFate.EXPLAINED)
            explained = fates.count(RayFate.EXPLAINED)
            if fates.share >= options.ok_share and explained >= max(many, 1.5 * before):
                self._turned_fault = (
                    "the scan fits upside down: frame %s is the wrong way up in TF" % scan.frame
                )
