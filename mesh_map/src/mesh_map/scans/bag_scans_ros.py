"""Scans in bags: PointCloud2 and LaserScan, with poses of tf, odometry or a file."""

from collections import deque
from dataclasses import dataclass
from typing import Any, Deque, Iterator, List, NamedTuple, Optional, Sequence

import genpy
import numpy as np
from mesh_msgs.point_cloud import PointCloudError, cloud_rows
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose

from mesh_map.base.errors import MeshMapError
from mesh_map.scans.bag_file_ros import BagFile
from mesh_map.scans.bag_transforms_ros import (
    BagTransforms,
    Frames,
    NoPose,
    frame_name,
    odometry_topics,
    trajectory_pose,
    transform_topics,
)
from mesh_map.scans.cloud_files import as_scan
from mesh_map.scans.cloud_values import CloudValues, cloud_values, usable
from mesh_map.scans.laser_scan import scan_beams
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.motion import undo_motion
from mesh_map.scans.point_times import LONGEST, point_times
from mesh_map.scans.scan import Scan
from mesh_map.scans.scan_source import ScanSource, Step, no_scans
from mesh_map.scans.trajectory import Trajectory

CLOUD, LASER = "sensor_msgs/PointCloud2", "sensor_msgs/LaserScan"
STAMP, RECEIVED = CLOCKS = ("stamp", "received")
_PATIENCE = 2.0  # s of recording that a scan waits for its transforms
_MOST_WAITING = 64
_SHOWN = 8


@dataclass(frozen=True)
class BagOptions:
    """What of a bag is wanted.

    topics: with scans; none: the only one of its kind.
    frame: that the map is made in; "": map, or the root of tf, or that of the odometry.
    clock: when a scan was made: by its STAMP, or when it was RECEIVED by the recorder.
    """

    topics: Sequence[str] = ()
    frame: str = ""
    clock: str = STAMP


@dataclass
class _Waiting:
    """A scan that waits for its transforms."""

    position: int
    name: str
    frame: str
    stamp: Any
    received: float
    values: CloudValues
    offsets: Optional[np.ndarray]


class _Poses(NamedTuple):
    """Where poses come from, if not from transforms."""

    trajectory: Optional[Trajectory] = None
    by_number: Optional[List[ScanPose]] = None


class BagScans(ScanSource):
    """The scans of a bag.

    Args:
        path: of the bag.
        options: what of it is wanted.
        poses: of the sensor in the map, instead of transforms; None: none are given.
        static: messages with static transforms of bags before this one; grows.
        left_out: for counts.
    Attributes:
        frame: that the map is made in.
        topics: with the scans that are read.
    Raises:
        MapFileError: the bag cannot be read; no scans, no poses, or clocks that differ.
    """

    kind = "bag"

    def __init__(
        self,
        path: str,
        options: BagOptions,
        poses: Optional[List[ScanPose]],
        static: List[Any],
        left_out: LeftOutCounts,
    ) -> None:
        super().__init__(path, left_out)
        self._options, self._still = options, ""
        self._told_times = False
        with BagFile(path) as bag:
            self.topics = _scan_topics(bag, options.topics, self.notes)
            self._total = sum(bag.counts[topic] for topic in self.topics)
            self._transforms = BagTransforms(left_out, path, static)
            self._odometry: List[str] = []
            self._child = ""  # of odometry that stands for the sensor
            sensors = _sensor_frames(bag, self.topics)
            if poses is not None:
                self._poses = self._posed(poses)
                self.frame = options.frame or "map"
            else:
                self._poses = _Poses()
                frames = self._transforms.probe(bag)
                self.frame = self._fixed(bag, frames, sensors)
            for note in bag.notes:
                if note not in self.notes:
                    self.notes.append(note)

    def steps(self, start: int = 0) -> Iterator[Step]:
        waiting: Deque[_Waiting] = deque()
        position, total = 0, max(1, self._total)
        with BagFile(self.path) as bag:
            moving = [t for t in transform_topics(bag) if not t.endswith("tf_static")]
            transforms = [*moving, *self._odometry] if self._poses == _Poses() else []
            for found in bag.messages([*self.topics, *transforms]):
                if found.topic in transforms:
                    self._transforms.add(found.topic, found.message)
                    # The next scan may come when these transforms are forgotten.
                    if waiting and found.time.to_sec() - waiting[0].received > _PATIENCE:
                        yield from self._done(waiting, found.time.to_sec(), False)
                    continue
                position += 1
                self.part = position / total
                if position > start:
                    scan = self._decoded(found, position)
                    if scan is None:
                        yield from self._done(waiting, found.time.to_sec(), True)
                        yield Step(position, None)
                    else:
                        waiting.append(scan)
                yield from self._done(waiting, found.time.to_sec(), False)
            yield from self._done(waiting, np.inf, True)
            for note in bag.notes:
                if note not in self.notes:
                    self.notes.append(note)

    # Where poses come from

    def _posed(self, poses: List[ScanPose]) -> _Poses:
        if all(pose.time is not None for pose in poses) and poses:
            by_time = {pose.time: pose.matrix for pose in poses}
            times = sorted(time for time in by_time if time is not None)
            return _Poses(Trajectory.of_matrices([by_time[time] for time in times], times))
        if len(poses) != self._total:
            text = "there are %d poses without times (KITTI), but %d scans on %s"
            hint = "poses with times (TUM) fit by them"
            text = text % (len(poses), self._total, ", ".join(self.topics))
            raise no_scans(self.path, text, hint)
        return _Poses(by_number=poses)

    def _fixed(self, bag: BagFile, frames: Frames, sensors: List[str]) -> str:
        """The frame of the map; refuses bags that say no poses."""
        wanted, sensor = frame_name(self._options.frame), sensors[0]
        fixed = wanted or frames.fixed(sensor)
        odometry = odometry_topics(bag)
        if odometry and not frames.fixed(sensor) and wanted not in frames.chain(sensor):
            frames, fixed = self._by_odometry(bag, odometry, sensor)
            fixed = wanted or fixed
        if not fixed:
            self._no_pose(frames, sensor)
        self._still = fixed if fixed in sensors else ""
        if fixed not in frames.names() and not self._still:
            known = ", ".join(frames.names()[:_SHOWN]) or "none"
            hint = "frames are: %s; --frame names one" % known
            raise no_scans(self.path, "tf has no frame %s" % fixed, hint)
        several = [child for child, above in frames.parents.items() if len(above) > 1]
        if several:
            text = "%s: frame %s has several parents in tf (%s): each counts while it is the newest"
            parents = ", ".join(sorted(frames.parents[sorted(several)[0]]))
            self.notes.append(text % (self.path, sorted(several)[0], parents))
        if not wanted:
            self.notes.append(
                "%s: the map is in frame %s (--frame names another)" % (self.path, fixed)
            )
        if not self._still:
            self._check_clocks(bag, frames)
        return fixed

    def _by_odometry(self, bag: BagFile, odometry: List[str], sensor: str) -> Any:
        best = max(odometry, key=lambda topic: bag.counts[topic])
        frames = self._transforms.probe(bag, [best])
        self._odometry = [best]
        fixed = frames.fixed(sensor)
        text = "%s: tf does not say where the sensor was; poses are those of %s"
        self.notes.append(text % (self.path, best))
        if not fixed:
            message = next(iter(bag.messages([best], most=1))).message
            self._child = frame_name(message.child_frame_id)
            fixed = frames.fixed(self._child) or frame_name(message.header.frame_id)
            text = "%s: nothing says where frame %s is on %s: it is taken to be the same"
            self.notes.append(text % (self.path, sensor, self._child))
        return frames, fixed

    def _no_pose(self, frames: Frames, sensor: str) -> None:
        names = frames.names()
        if not names:
            text = "there is neither tf nor odometry in it, so nobody says where the sensor was"
        elif sensor not in names:
            text = "the scans are in frame %s, which tf does not have (it has %s)"
            text %= sensor, ", ".join(names[:_SHOWN])
        else:
            text = "tf moves nothing between frame %s of the scans and %s"
            text %= sensor, frames.chain(sensor)[-1]
        hint = "--poses FILE (TUM or KITTI) says it; --frame %s is for a sensor that stood still"
        raise no_scans(self.path, text, hint % sensor)

    def _check_clocks(self, bag: BagFile, frames: Frames) -> None:
        times = _stamps(bag, self.topics, self._options.clock)
        if times is None or frames.times is None:
            return
        first, last = frames.times
        if times[0] > last or times[1] < first:
            text = (
                "the scans are of %.3f to %.3f s, but tf of %.3f to %.3f s: their clocks differ, or"
                " they are of different drives"
            )
            hint = "--clock received takes the time of recording for that of the scans"
            if self._options.clock == RECEIVED:
                hint = "--poses FILE gives poses by the clock of the scans"
            raise no_scans(self.path, text % (*times, first, last), hint)

    # One scan

    def _decoded(self, found: Any, position: int) -> Optional[_Waiting]:
        """What a message has; None where there is nothing to use."""
        message, name = found.message, "scan %d of %s" % (position, found.topic)
        stamp = found.time if self._options.clock == RECEIVED else message.header.stamp
        stamp = genpy.Time(stamp.secs, stamp.nsecs)
        offsets: Optional[np.ndarray] = None
        try:
            if hasattr(message, "ranges"):
                values, offsets = _laser_values(message)
            else:
                values = cloud_values(cloud_rows(message))
        except (PointCloudError, MeshMapError) as error:
            self.left_out.add("unreadable", name, reason=str(error))
            return None
        if not len(values):
            self.left_out.add("empty", name)
            return None
        if offsets is not None:
            values = CloudValues(values.points, None, values.intensities, offsets)
        used = usable(values, self.left_out, name)
        if not len(used):
            self.left_out.add("empty", name)
            return None
        if offsets is not None:
            offsets = used.times
        elif used.times is not None:
            times = point_times(used.times, stamp.to_sec())
            offsets = times.offsets
            if offsets is None:
                self.left_out.add("no_times", name, reason=times.reason)
        frame = frame_name(message.header.frame_id)
        return _Waiting(position, name, frame, stamp, found.time.to_sec(), used, offsets)

    def _done(self, waiting: Deque[_Waiting], now: float, final: bool) -> Iterator[Step]:
        """Those whose poses are known by now, or never will be."""
        while waiting:
            first = waiting[0]
            late = final or now - first.received > _PATIENCE or len(waiting) > _MOST_WAITING
            try:
                scan: Optional[Scan] = self._scan(first)
            except NoPose as error:
                if not late:
                    return
                self.left_out.add("no_pose", first.name, reason=str(error))
                scan = None
            waiting.popleft()
            yield Step(first.position, scan)

    def _scan(self, found: _Waiting) -> Scan:
        poses, offsets = self._poses, found.offsets
        if poses.by_number is not None:
            matrix = poses.by_number[found.position - 1].matrix
            still = undo_motion(found.values, None, lambda _: matrix)
        else:
            still = undo_motion(found.values, offsets, lambda offset: self._pose(found, offset))
        time = found.stamp.to_sec() + still.offset
        return as_scan(still.values, still.pose, time, found.name)

    def _pose(self, found: _Waiting, offset: float) -> np.ndarray:
        if self._poses.trajectory is not None:
            return trajectory_pose(self._poses.trajectory, found.stamp, offset)
        frame = self._child or found.frame
        return self._transforms.pose(self.frame, frame, found.stamp, offset)


def _scan_topics(bag: BagFile, wanted: Sequence[str], notes: List[str]) -> List[str]:
    kinds = {
        kind: sorted(topic for topic, each in bag.topics.items() if each == kind)
        for kind in (CLOUD, LASER)
    }
    known = ["%s (%d)" % (topic, bag.counts[topic]) for each in kinds.values() for topic in each]
    if wanted:
        names = ["/" + topic.lstrip("/") for topic in wanted]
        missing = [topic for topic in names if topic not in bag.topics]
        odd = [topic for topic in names if bag.topics.get(topic, CLOUD) not in (CLOUD, LASER)]
        if missing or odd:
            text = "there is no topic %s" % missing[0] if missing else ""
            text = text or "topic %s has %s, which are no scans" % (odd[0], bag.topics[odd[0]])
            raise no_scans(bag.path, text, "topics with scans: " + (", ".join(known) or "none"))
        return sorted(set(names))
    chosen = kinds[CLOUD] or kinds[LASER]
    if not chosen:
        types = sorted({*bag.topics.values()})
        hint = "it has %s" % (", ".join(types[:_SHOWN]) or "no messages")
        raise no_scans(bag.path, "there is no topic with PointCloud2 or LaserScan", hint)
    if len(chosen) > 1:
        text = "there are %d topics with scans, which may show the same" % len(chosen)
        hint = "--topic names one, or several: %s" % ", ".join(known)
        raise no_scans(bag.path, text, hint)
    if kinds[CLOUD] and kinds[LASER]:
        text = "%s: %s is not used: --topic names it"
        notes.append(text % (bag.path, ", ".join(kinds[LASER])))
    return chosen


def _sensor_frames(bag: BagFile, topics: Sequence[str]) -> List[str]:
    """The frames of the first scans of the topics."""
    found = []
    for topic in topics:
        for first in bag.messages([topic], most=1):
            found.append(frame_name(first.message.header.frame_id))
    if not found:
        text = "there is no message on %s" % ", ".join(topics)
        raise no_scans(bag.path, text, "was it recorded while the sensor was running?")
    return found


def _stamps(bag: BagFile, topics: Sequence[str], clock: str) -> Optional[List[float]]:
    """[first, last] s of the scans."""
    recorded = bag.times(topics)
    if recorded is None or clock == RECEIVED:
        return recorded
    ends = [*bag.messages(topics, most=1), *bag.messages(topics, recorded[1] - 1e-3)]
    times = [found.message.header.stamp.to_sec() for found in ends]
    return [min(times), max(times)]


def _laser_values(message: Any) -> Any:
    """(CloudValues, offsets from the stamp or None) of what a LaserScan has met."""
    beams = scan_beams(message)
    points = beams.ranges[beams.met, None] * beams.directions[beams.met]
    intensities = np.asarray(message.intensities, np.float32)
    measured = intensities[beams.met] if len(intensities) == len(beams.ranges) else None
    values = CloudValues(points, None, measured)
    step = float(message.time_increment)
    if not 0 < step * len(beams.ranges) <= LONGEST:
        return values, None
    return values, (step * np.arange(len(beams.ranges)))[beams.met]
