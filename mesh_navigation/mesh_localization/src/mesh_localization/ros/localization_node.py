"""The node mesh_localization: where the robot is on a mesh, by its sensors and its odometry."""

import queue
import sys
import time
from collections import Counter
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

import numpy as np
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped
from mesh_map.base.errors import MeshMapError, error_line
from mesh_map.base.parameter import misspelled, read_parameters
from mesh_map.ros.log import forward_log
from mesh_map.ros.parameter_server import ParameterServer
from mesh_msgs.diagnostics_ros import ERROR, OK, WARN, Diagnostics, Status
from mesh_msgs.init_node import init_node, spin, until_shutdown
from sensor_msgs.msg import LaserScan, PointCloud2

from mesh_localization.node.messages import pose_matrix
from mesh_localization.node.parameters import (
    DYNAMIC_PARAMETERS,
    LASER_SCAN,
    PARAMETERS,
    SensorSource,
    check_frames,
    range_limits,
    sensor_sources,
    start_of,
    start_variances,
    tracking_options,
)
from mesh_localization.node.session import Report, LocalizationSession
from mesh_localization.node.start_pose import Start, turned_covariance
from mesh_localization.node.through_counts import ThroughCounts
from mesh_localization.relocalization.global_search import PoseFit
from mesh_localization.relocalization.pose_sampling import SearchRegion
from mesh_localization.ros.localization_topics_ros import LocalizationTopics
from mesh_localization.ros.map_ros import LocalizationMap, MapWatch
from mesh_localization.ros.odometry_ros import OdometryTransforms
from mesh_localization.ros.relocalization_ros import Question, Relocalization
from mesh_localization.sensing.placed_scan import PlacedScan, joined_scan
from mesh_localization.sensing.scan_intake import ScanIntake, Unusable
from mesh_localization.sensing.sensor_scan import SensorScan, cloud_scan, laser_scan
from mesh_localization.tracking.localizer import TrackingState

_LOOK = 0.01  # s of the computer's time between two looks
_JUMP = 1.0  # s that time jumps back when a bag begins again
_AHEAD = 0.5  # s that a stamp may be ahead of time
_BUFFER = 1 << 26  # bytes; with less, rospy keeps old clouds in the socket
_FRESH = 1.0  # s, the age of scans by which the robot is looked for
_COMPLAINTS = 10.0  # s between two warnings about a sensor
_LEVELS = {TrackingState.LOST: ERROR, TrackingState.UNCERTAIN: WARN, TrackingState.OK: OK}


class LocalizationNode:
    """Follows the robot in the thread of `run`; other threads leave scans and jobs for it."""

    def __init__(self) -> None:
        """
        Raises:
            MeshMapError: sensors or frames that cannot be used.
        """
        forward_log()
        given = dict(rospy.get_param("~", {}) or {})
        self._values = _checked(given)
        check_frames(self._values)
        self._sensors = {one.name: one for one in sensor_sources(self._values, given)}
        self._start = start_of(self._values, given)
        self._session = LocalizationSession(
            tracking_options(self._values),
            self._values["base_height"],
            start_variances(self._values),
        )
        self._jobs: "queue.SimpleQueue[Callable[[], None]]" = queue.SimpleQueue()
        self._map: Optional[LocalizationMap] = None
        self._start_message: Optional[PoseWithCovarianceStamped] = None  # waits for the map
        self._report = Report(TrackingState.LOST, self._session.map_fault)
        self._through = ThroughCounts()
        self._seconds = 0.0  # of the computer's time that the last scan took
        self._unusable: "Counter[str]" = Counter()
        self._faults: Dict[str, str] = {}  # of sensors whose last message was not used
        self._complained: Dict[str, float] = {}
        self._heard: Dict[str, float] = {}  # s, when something was used of a sensor
        self._scans: Dict[str, PlacedScan] = {}  # the newest of each sensor
        self._mounting_fault = ""
        self._now = self._correction_due = 0.0
        self._asked: Mapping[str, Any] = self._values  # what is to hold, once its turn comes
        self._change(self._values)

    def run(self) -> None:
        """Localize the robot until the node is shut down."""
        values = self._values
        self._odometry = OdometryTransforms(values["odom_frame_id"], values["base_frame_id"])
        self._intake = ScanIntake(self._decode, self._odometry.place, values["tf_timeout"])
        self._topics = LocalizationTopics(values["odom_frame_id"])
        if self._start is not None:
            self._session.begin_at(self._start)
        for source in self._sensors.values():
            self._subscribe(source)
        rospy.Subscriber("initialpose", PoseWithCovarianceStamped, self._on_start, queue_size=1)
        self._maps = MapWatch(values, lambda found: self._jobs.put(partial(self._take_map, found)))
        self._relocalization = Relocalization(self._question, self._found)
        Diagnostics("localization", self._status)
        ParameterServer(rospy.get_name(), DYNAMIC_PARAMETERS, values, self._reconfigure)
        while not rospy.is_shutdown():
            self._intake.wait(_LOOK)
            now = rospy.Time.now()
            if not now:
                continue  # no clock yet
            self._watch_time(now.to_sec())
            self._do_jobs()
            for sensor, result in self._intake.next():
                if isinstance(result, Unusable):
                    self._refuse(sensor, result.reason)
                    continue
                try:
                    self._use(sensor, result)
                except Exception as error:  # of one scan; others go on
                    if rospy.core.is_shutdown_requested():
                        raise
                    self._refuse(sensor, error_line(error))
            self._look(rospy.Time.now())

    # What comes

    def _subscribe(self, source: SensorSource) -> None:
        kind = LaserScan if source.data_type == LASER_SCAN else PointCloud2
        rospy.Subscriber(
            source.topic, kind, self._on_scan, source.name, queue_size=1, buff_size=_BUFFER
        )

    def _on_scan(self, message: Any, sensor: str) -> None:
        self._intake.put(sensor, message)

    def _on_start(self, message: PoseWithCovarianceStamped) -> None:
        self._jobs.put(partial(self._begin, message))

    def _decode(self, sensor: str, message: Any) -> SensorScan:
        stamp, now = message.header.stamp.to_sec(), rospy.get_time()
        if not stamp:
            raise MeshMapError("it has no stamp")
        if now - stamp > self._values["lost_timeout"]:
            text = "it is %.1f s old by its stamp"
            raise MeshMapError(text % (now - stamp), "bags need use_sim_time, computers one clock")
        if stamp - now > _AHEAD:
            text = "its stamp is %.1f s ahead of time"
            raise MeshMapError(text % (stamp - now), "bags need use_sim_time, computers one clock")
        decode = laser_scan if self._sensors[sensor].data_type == LASER_SCAN else cloud_scan
        return decode(message, range_limits(self._values))

    def _refuse(self, sensor: str, reason: str) -> None:
        """Say that a message cannot be used, not too often."""
        topic = rospy.resolve_name(self._sensors[sensor].topic)
        self._unusable[sensor] += 1
        fault = "what comes from %s cannot be used: %s" % (topic, reason)
        self._faults[sensor] = self._session.scan_fault = fault
        wall = time.monotonic()
        if wall - self._complained.get(sensor, -_COMPLAINTS) >= _COMPLAINTS:
            self._complained[sensor] = wall
            rospy.logwarn("%s: %s", rospy.get_name(), fault)

    def _take_map(self, found: LocalizationMap) -> None:
        self._map = found
        self._through.clear()
        self._session.take_map(found.target, rospy.get_time())
        message, self._start_message = self._start_message, None
        if message is not None:
            self._begin(message)

    def _begin(self, message: PoseWithCovarianceStamped) -> None:
        """Somebody says where the robot is."""
        if self._map is None:
            self._start_message = message
            return
        frame, source = self._map.frame, message.header.frame_id.lstrip("/")
        try:
            pose = pose_matrix(message.pose.pose)
            covariance = np.array(message.pose.covariance, np.float64).reshape(6, 6)
            if source != frame:
                between = self._odometry.between(frame, source, rospy.Time())
                pose, covariance = between @ pose, turned_covariance(covariance, between)
        except MeshMapError as error:
            rospy.logwarn("%s: initialpose cannot be used: %s", rospy.get_name(), error)
            return
        self._relocalization.give_up()
        self._session.begin_at(Start(pose, covariance))

    def _question(self, nearby: bool) -> Question:
        """What is looked for; from another thread.

        Raises:
            MeshMapError: nothing can be.
        """
        found, values, now = self._map, self._values, rospy.get_time()
        if found is None:
            raise MeshMapError(self._maps.fault)
        region = None
        if nearby:
            estimate = self._report.estimate
            if estimate is None:
                raise MeshMapError("nothing is known of where it is", "relocalize looks everywhere")
            region = SearchRegion(estimate.pose[:3, 3], values["relocalization_radius"])
        scans = [one for one in list(self._scans.values()) if now - one.scan.time < _FRESH]
        if not scans:
            faults = list(self._faults.values()) or ["no sensor tells anything"]
            raise MeshMapError("there is no scan of this second: %s" % faults[0])
        options, height = tracking_options(values), values["base_height"]
        return Question(found.geometry, joined_scan(scans), options, height, region)

    def _found(self, fit: PoseFit, scan: PlacedScan) -> None:
        """Where the robot was when a scan was made; from another thread."""
        self._jobs.put(lambda: self._session.put(fit.pose, fit.covariance, scan, rospy.get_time()))

    # What is done

    def _watch_time(self, now: float) -> None:
        if now < self._now - _JUMP:
            text = "%s: time has jumped back by %.1f s: localization begins anew"
            rospy.logwarn(text, rospy.get_name(), self._now - now)
            self._intake.clear()
            self._session.begin_anew()
            self._topics.begin_anew()
            self._relocalization.give_up()
            self._scans.clear()
            self._correction_due = now
            if self._start is not None:
                self._session.begin_at(self._start)
        self._now = now

    def _do_jobs(self) -> None:
        while True:
            try:
                job = self._jobs.get_nowait()
            except queue.Empty:
                return
            job()

    def _use(self, sensor: str, scan: PlacedScan) -> None:
        self._faults.pop(sensor, None)
        self._heard[sensor] = rospy.get_time()
        self._scans[sensor] = scan
        begin = time.monotonic()
        report = self._session.add(scan)
        if report is None or self._map is None:
            return
        self._seconds = time.monotonic() - begin
        self._tell(report, max(scan.stamp, rospy.Time.now()))
        fault, self._mounting_fault = self._mounting_fault, self._session.mounting_fault
        if self._mounting_fault and not fault:
            rospy.logwarn("%s: %s", rospy.get_name(), self._mounting_fault)
        self._topics.tell_scan(report, scan, self._map.frame)
        estimate = report.estimate
        if report.state == TrackingState.OK and estimate is not None and estimate.fates is not None:
            self._through.add(self._map.target, scan.scan, estimate.fates, estimate.pose)

    def _look(self, now: rospy.Time) -> None:
        """What time alone changes, and what is repeated."""
        if self._map is None:
            self._session.map_fault = self._maps.fault
        self._session.search_note = self._relocalization.progress
        report = self._session.look(now.to_sec(), self._odometry.now)
        if self._session.start_refusal:
            text = "%s: initialpose cannot be used: %s"
            rospy.logwarn(text, rospy.get_name(), self._session.start_refusal)
            self._session.start_refusal = ""
        self._tell(report, now)
        if self._map is not None:
            self._topics.tell_through(self._through, self._map.frame, now)

    def _tell(self, report: Report, now: rospy.Time) -> None:
        values, frame = self._values, "" if self._map is None else self._map.frame
        of_scan = report.estimate is not None and report.estimate.fates is not None
        if report.is_known and values["tf_broadcast"]:
            if of_scan or now.to_sec() >= self._correction_due:
                self._correction_due = now.to_sec() + 1 / values["transform_rate"]
                ahead = rospy.Duration.from_sec(values["transform_tolerance"])
                self._topics.tell_correction(report, frame, now + ahead)
        self._topics.tell_state(report, frame or values["global_frame_id"] or "map", now)
        if report.state != self._report.state:
            self._log(report)
        self._report = report

    def _log(self, report: Report) -> None:
        if report.state == TrackingState.OK:
            rospy.loginfo("%s: the robot is localized", rospy.get_name())
        elif report.state == TrackingState.UNCERTAIN:
            text = "%s: it is not sure where the robot is: %s"
            rospy.logwarn(text, rospy.get_name(), report.reason)
        else:
            rospy.logwarn("%s: the robot is lost: %s", rospy.get_name(), report.reason)

    # Parameters and diagnostics

    def _reconfigure(self, given: Mapping[str, Any]) -> Mapping[str, Any]:
        """Parameters told by dynamic_reconfigure; all that are in force."""
        values, complaints = read_parameters(DYNAMIC_PARAMETERS, given, self._asked)
        for complaint in complaints:
            rospy.logwarn("parameter ~%s", complaint)
        self._asked = values
        self._jobs.put(partial(self._change, values))
        return values

    def _change(self, values: Mapping[str, Any]) -> None:
        self._values = dict(values)
        self._session.take_options(tracking_options(values))
        self._session.least_motion = values["update_min_d"], values["update_min_a"]

    def _status(self) -> Status:
        """For /diagnostics; from another thread."""
        report, faults = self._report, list(self._faults.values())
        faults += [self._mounting_fault] if self._mounting_fault else []
        faults += self._silent_sensors(rospy.get_time())
        if self._values["tf_broadcast"]:
            text = (
                "%s publishes where frame %s is, too: end one of the two, or set tf_broadcast false"
            )
            odometry = self._values["odom_frame_id"]
            faults += [text % (other, odometry) for other in self._odometry.others()]
        values: Dict[str, Any] = {"state": report.state.name}
        if report.estimate is not None:
            position, rotation = report.estimate.deviations
            values["explained"] = "%.3f" % report.explained
            values["residual"] = "%.4f m" % report.residual
            values["deviation"] = "%.3f m, %.4f rad" % (position, rotation)
            values["time of a scan"] = "%.1f ms" % (1000 * self._seconds)
        for name, source in self._sensors.items():
            counts = self._intake.dropped[name], self._unusable[name]
            count_text = "%d messages replaced by newer ones, %d not usable"
            values["sensor " + source.topic] = count_text % counts
        if self._map is not None:
            values["map"] = self._map.geometry.uuid
        if report.state == TrackingState.OK:
            if faults:
                return Status(WARN, "; ".join(faults), values)
            return Status(OK, "the robot is localized", values)
        return Status(_LEVELS[report.state], report.reason, values)

    def _silent_sensors(self, now: float) -> List[str]:
        """A sentence for each sensor of which nothing was used for long; others may do their work,
        but not what they cannot see."""
        limit, found = self._values["lost_timeout"], []
        for name, source in self._sensors.items():
            heard = self._heard.setdefault(name, now)
            if now - heard > limit and name not in self._faults:
                text = "nothing was used of %s for %.1f s"
                found.append(text % (rospy.resolve_name(source.topic), now - heard))
        return found


def _checked(given: Mapping[str, Any]) -> Dict[str, Any]:
    values, complaints = read_parameters(PARAMETERS, given)
    known = [parameter.name for parameter in PARAMETERS]
    known += values["observation_sources"].split()
    for complaint in complaints:
        rospy.logwarn("parameter ~%s", complaint)
    for sentence in misspelled(given, known):
        rospy.logwarn("%s: %s", rospy.get_name(), sentence)
    return values


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the node until it is shut down; returns the exit code."""
    init_node("mesh_localization", argv=arguments, about=__doc__, package="mesh_localization")
    try:
        with until_shutdown():
            LocalizationNode().run()
    except MeshMapError as error:
        sys.stderr.write("%s: error: %s\n" % (rospy.get_name(), error))
        return 1
    spin()  # The node is shut down: this says whether it failed.
    return 0
