"""Where a sensor was, by the transforms or the odometry in a bag."""

from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

import genpy
import numpy as np
import tf2_py
from mesh_msgs.transform import TransformError, rotation_and_translation
from geometry_msgs.msg import TransformStamped

from mesh_map.scans.bag_file_ros import BagFile
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.trajectory import Trajectory

ODOMETRY = "nav_msgs/Odometry"
_TF_TYPES = ("tf2_msgs/TFMessage", "tf/tfMessage")
_CACHE = 60.0  # s that transforms are kept: lookups go through all that are newer
_PROBED = 500  # messages at the beginning by which frames are known
_LAST = 1.0  # s at the end
_AUTHORITY = "bag"
_STATIC = "tf_static"


class NoPose(Exception):
    """There is no pose of a frame at a time; str() says why."""


class Frames(NamedTuple):
    """What a bag says of frames.

    parents: child -> parents, of all transforms.
    moving: children that move.
    times: (first, last) s of what moves; None where nothing does.
    """

    parents: Dict[str, Set[str]]
    moving: Set[str]
    times: Optional[Tuple[float, float]]

    def chain(self, frame: str) -> List[str]:
        """A frame, and those above it up to the root."""
        found = [frame]
        while True:
            above = sorted(self.parents.get(found[-1], set()).difference(found))
            if not above:
                return found
            found.append(above[0])

    def fixed(self, frame: str) -> str:
        """What a map of a sensor in this frame is best made in: map, else the root; "" where
        nothing moves between the two."""
        chain = self.chain(frame)
        wanted = "map" if "map" in chain else chain[-1]
        return wanted if self.moving.intersection(chain[: chain.index(wanted)]) else ""

    def names(self) -> List[str]:
        """All frames, sorted."""
        return sorted({*self.parents, *(p for all_of in self.parents.values() for p in all_of)})


def frame_name(text: str) -> str:
    """Without the slash that tf, before tf2, put before names."""
    return text.lstrip("/")


def transform_topics(bag: BagFile) -> List[str]:
    """The topics with transforms."""
    return sorted(topic for topic, kind in bag.topics.items() if kind in _TF_TYPES)


def odometry_topics(bag: BagFile) -> List[str]:
    """The topics with odometry."""
    return sorted(topic for topic, kind in bag.topics.items() if kind == ODOMETRY)


class BagTransforms:
    """The transforms of a bag, filled while it is read.

    Args:
        left_out: counts what is no rotation and translation.
        where: the bag, for that.
        static: messages with static transforms, of bags that were recorded before; grows by those
            of this one.
    """

    def __init__(self, left_out: LeftOutCounts, where: str, static: List[Any]) -> None:
        self._buffer = tf2_py.BufferCore(genpy.Duration.from_sec(_CACHE))
        self._left_out, self._where = left_out, where
        self._typed = TransformStamped()  # tf2 complains of the classes that rosbag makes
        self._latest = -np.inf
        self._first = np.inf
        self._parents: Dict[str, Set[str]] = {}
        self._moving: Set[str] = set()
        self.static = static
        for message in static:
            self.add(_STATIC, message)

    def probe(self, bag: BagFile, odometry: Sequence[str] = ()) -> Frames:
        """Static transforms are taken, and frames and times of all others looked at.

        Args:
            odometry: topics that count as transforms, too.
        """
        topics = [*transform_topics(bag), *odometry]
        static = [topic for topic in topics if topic.endswith(_STATIC)]
        for found in bag.messages(static):
            self.static.append(found.message)
            self.add(found.topic, found.message)
        moving = [topic for topic in topics if topic not in static]
        ends = bag.times(moving)
        probed = list(bag.messages(moving, most=_PROBED))
        if ends is not None:
            probed += bag.messages(moving, ends[1] - _LAST)
        first, last = np.inf, -np.inf
        for found in probed:
            for transform in _transforms(found.message):
                time = transform.header.stamp.to_sec()
                first, last = min(first, time), max(last, time)
                child = frame_name(transform.child_frame_id)
                parent = frame_name(transform.header.frame_id)
                if child != parent:
                    self._parents.setdefault(child, set()).add(parent)
                    self._moving.add(child)
        return Frames(self._parents, self._moving, (first, last) if first <= last else None)

    def add(self, topic: str, message: Any) -> None:
        """The transforms of a message of tf, or that of an odometry."""
        static = topic.endswith(_STATIC)
        for transform in _transforms(message):
            child = frame_name(transform.child_frame_id)
            parent = frame_name(transform.header.frame_id)
            try:
                rotation_and_translation(transform)
                fault = "" if child and parent and child != parent else "from %r to %r"
            except TransformError as error:
                fault = str(error)
            if fault:
                fault = fault % (child, parent) if "%r" in fault else fault
                self._left_out.add("odd_transform", self._where, reason=fault)
                continue
            _copy(transform, parent, child, self._typed)
            if static:
                self._parents.setdefault(child, set()).add(parent)
                self._buffer.set_transform_static(self._typed, _AUTHORITY)
                continue
            time = transform.header.stamp.to_sec()
            if time < self._latest - _CACHE:
                continue  # older than what is kept, which tf2 would complain of on stderr
            self._first, self._latest = min(self._first, time), max(self._latest, time)
            self._buffer.set_transform(self._typed, _AUTHORITY)

    def pose(self, fixed: str, frame: str, stamp: genpy.Time, offset: float) -> np.ndarray:
        """(4, 4) float64 of a frame in the fixed one.

        Args:
            offset: s from the stamp.
        Raises:
            NoPose: there is none.
        """
        if fixed == frame:
            return np.eye(4)
        nanoseconds = stamp.to_nsec() + round(offset * 1e9)
        if nanoseconds <= 0:  # which tf2 takes for "the latest"
            raise NoPose("its stamp is %.9g s" % (nanoseconds * 1e-9))
        try:
            found = self._buffer.lookup_transform_core(fixed, frame, genpy.Time(0, nanoseconds))
        except tf2_py.LookupException:
            known = set(self._parents) | {p for all_of in self._parents.values() for p in all_of}
            missing = [name for name in (fixed, frame) if name not in known] or [frame]
            raise NoPose("tf has no frame %s" % missing[0]) from None
        except tf2_py.ConnectivityException:
            text = "frames %s and %s are in different trees of tf"
            raise NoPose(text % (fixed, frame)) from None
        except tf2_py.ExtrapolationException:
            text = "tf is there from %.3f to %.3f s, its time is %.3f s"
            raise NoPose(text % (self._first, self._latest, nanoseconds * 1e-9)) from None
        except tf2_py.TransformException as error:
            raise NoPose(str(error)) from error
        rotation, translation = rotation_and_translation(found)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, translation
        return pose


def _copy(source: Any, parent: str, child: str, target: TransformStamped) -> None:
    """A transform between these frames."""
    target.header.frame_id, target.child_frame_id = parent, child
    target.header.stamp = source.header.stamp
    for ours, theirs in (
        (target.transform.translation, source.transform.translation),
        (target.transform.rotation, source.transform.rotation),
    ):
        for name in ours.__slots__:
            setattr(ours, name, getattr(theirs, name))


def _transforms(message: Any) -> List[Any]:
    if hasattr(message, "transforms"):
        return list(message.transforms)
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    made = TransformStamped(header=message.header, child_frame_id=message.child_frame_id)
    made.transform.translation.x = place.x
    made.transform.translation.y = place.y
    made.transform.translation.z = place.z
    made.transform.rotation = turn
    return [made]


def trajectory_pose(trajectory: Trajectory, stamp: genpy.Time, offset: float) -> np.ndarray:
    """(4, 4) of a trajectory at a time.

    Raises:
        NoPose: it is before the first, or after the last.
    """
    time = stamp.to_sec() + offset
    first, last = trajectory.times[[0, -1]]
    if not first <= time <= last:
        text = "the poses are of %.3f to %.3f s, its time is %.3f s"
        raise NoPose(text % (first, last, time))
    return trajectory.poses(np.array([time]))[0]
