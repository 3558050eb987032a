"""Which inputs are what: bags, clouds, folders of clouds, and map files, as sources of scans."""

import os
from dataclasses import dataclass
from typing import Any, Dict, List, NamedTuple, Optional, Sequence

import numpy as np
from mesh_msgs_hdf5.files.probe import HDF5_SIGNATURE, check_name, read_head
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, read_poses

from mesh_map.scans.cloud_files import SUFFIXES, CloudFiles, cloud_paths
from mesh_map.scans.left_out import LeftOutCounts
from mesh_map.scans.map_scans import MapScans
from mesh_map.scans.scan_source import ScanSource, no_scans
from mesh_map.scans.trajectory import Trajectory

POSES_IN_FOLDER = "poses.txt"  # as mesh_tool scans extract writes them
_BAG, _CLOUDS, _FOLDER, _MAP = "bag", "clouds", "folder", "map"
_FAR = 1e4  # m from its sensor no cloud is


@dataclass(frozen=True)
class InputOptions:
    """What of the inputs is wanted, and what they do not say themselves.

    topics, frame, clock: see `BagOptions`.
    poses: a file of poses, in the form of TUM or KITTI, or None.
    sensor: (3,) m where the sensor was in the frame of clouds, or None.
    """

    topics: Sequence[str] = ()
    frame: str = ""
    clock: str = "stamp"
    poses: Optional[str] = None
    sensor: Optional[Sequence[float]] = None

    def stored(self) -> Dict[str, Any]:
        """What json can write: all but the frame, which is that of the map."""
        sensor = None if self.sensor is None else list(self.sensor)
        values = {"topics": list(self.topics), "clock": self.clock}
        return {**values, "poses": self.poses, "sensor": sensor}


class OpenedInputs(NamedTuple):
    """sources: one for each input, in their order; frame: that the map is made in; notes: what is
    to be said of the inputs together."""

    sources: List[ScanSource]
    frame: str
    notes: List[str]


def open_inputs(
    paths: Sequence[str],
    options: InputOptions,
    left_out: LeftOutCounts,
    static: Optional[List[Any]] = None,
) -> OpenedInputs:
    """Open inputs; all that can be seen without reading them is refused now.

    Args:
        paths: of files and folders.
        options: see there.
        left_out: takes what is left out, also while sources are read.
        static: messages with static transforms of bags that were opened before; grows.
    Raises:
        MapFileError: one cannot be read, or has no scans, or there are no poses for them.
    """
    kinds = [_kind(path) for path in paths]
    files = {
        path: [path] if kind == _CLOUDS else cloud_paths(path)
        for path, kind in zip(paths, kinds)
        if kind in (_CLOUDS, _FOLDER)
    }
    notes: List[str] = []
    poses = None if options.poses is None else read_poses(options.poses)
    if poses is not None and not poses:
        raise no_scans(str(options.poses), "it has no poses", "one for each scan, a line each")
    by_cloud = _cloud_poses(files, poses, options, _BAG in kinds, notes)
    sources: List[ScanSource] = []
    frame, static = options.frame, [] if static is None else static
    for path, kind in zip(paths, kinds):
        if kind == _BAG:
            bag = _bag(path, options, frame, poses, static, left_out)
            given = [pose.matrix for pose in poses or ()]
            bag.identity = np.array(given, np.float64).tobytes()
            frame = frame or bag.frame
            sources.append(bag)
        elif kind == _MAP:
            scans = MapScans(path, left_out)
            frame = frame or scans.frame
            sources.append(scans)
        else:
            sensor = None if options.sensor is None else np.array(options.sensor, np.float64)
            sources.append(CloudFiles(path, files[path], by_cloud[path], sensor, left_out))
            given = [pose.matrix for pose in by_cloud[path] if pose is not None]
            sources[-1].identity = np.array(given, np.float64).tobytes()
    if options.poses is not None and not files and _BAG not in kinds:
        notes.append("--poses is not used: the scans of map files have their own")
    if options.sensor is None:
        _check_posed([each for each in sources if isinstance(each, CloudFiles)], notes)
    for source in sources:
        source.options = options.stored()
        notes += [note for note in source.notes if note not in notes]
    return OpenedInputs(sources, frame or "map", notes)


def _kind(path: str) -> str:
    check_name(path)
    if os.path.isdir(path):
        return _FOLDER
    head = read_head(path)
    if head.startswith(b"#ROSBAG") or path.lower().endswith((".bag", ".bag.active")):
        return _BAG
    if head.startswith(HDF5_SIGNATURE):
        return _MAP
    if path.lower().endswith(SUFFIXES):
        return _CLOUDS
    text = "it is no bag, no cloud (%s), no folder of clouds and no map file" % ", ".join(SUFFIXES)
    raise no_scans(path, text, "convert the cloud to one of these")


def _bag(
    path: str,
    options: InputOptions,
    frame: str,
    poses: Optional[List[ScanPose]],
    static: List[Any],
    left_out: LeftOutCounts,
) -> Any:
    try:
        from mesh_map.scans.bag_scans_ros import BagOptions, BagScans
    except ImportError as error:
        text = "bags are read by rosbag and tf2, which are not there: %s" % error
        raise no_scans(path, text, "apt-get install python3-rosbag python3-tf2") from error
    wanted = BagOptions(tuple(options.topics), frame, options.clock)
    return BagScans(path, wanted, poses, static, left_out)


def _cloud_poses(
    files: Dict[str, List[str]],
    poses: Optional[List[ScanPose]],
    options: InputOptions,
    with_bags: bool,
    notes: List[str],
) -> Dict[str, List[Optional[ScanPose]]]:
    """Input -> a pose, or None, for each of its clouds."""
    found: Dict[str, List[Optional[ScanPose]]] = {}
    every = [file for each in files.values() for file in each]
    if poses is not None and every:
        given = _matched(every, poses, options.poses or "", with_bags)
        for path, each in files.items():
            found[path], given = given[: len(each)], given[len(each) :]
        return found
    for path, each in files.items():
        beside = os.path.join(path, POSES_IN_FOLDER)
        found[path] = [None] * len(each)
        if os.path.isdir(path) and os.path.isfile(beside):
            in_folder = read_poses(beside)
            if len(in_folder) != len(each):
                text = "it has %d poses for %d clouds" % (len(in_folder), len(each))
                hint = "a line for each; another file by --poses"
                raise no_scans(beside, text, hint)
            found[path] = list(in_folder)
            notes.append("%s: poses are those of %s" % (path, beside))
    return found


def _matched(
    every: List[str], poses: List[ScanPose], path: str, with_bags: bool
) -> List[Optional[ScanPose]]:
    """A pose for each cloud: in their order, or by the times that are the names of the clouds."""
    timed = all(pose.time is not None for pose in poses)
    if len(every) == len(poses) and not (with_bags and timed):
        return list(poses)
    names = [os.path.splitext(os.path.basename(file))[0] for file in every]
    try:
        times = np.array([float(name) for name in names])
    except ValueError:
        times = np.zeros(0)
    if not (timed and len(times)):
        text = "it has %d poses for %d clouds" % (len(poses), len(every))
        hint = "a line for each, in the order of the clouds; or TUM, and clouds named by their time"
        raise no_scans(path, text, hint)
    by_time = {float(pose.time or 0.0): pose.matrix for pose in poses}
    trajectory = Trajectory.of_matrices([by_time[t] for t in sorted(by_time)], sorted(by_time))
    first, last = trajectory.times[[0, -1]]
    outside = np.flatnonzero((times < first) | (times > last))
    if len(outside):
        text = "its poses are of %.3f to %.3f s, %d of %d clouds by their names are not, first %s"
        text %= first, last, len(outside), len(every), every[outside[0]]
        raise no_scans(path, text, "poses from before the first to after the last are needed")
    matrices = trajectory.poses(times)
    return [ScanPose(matrix, time) for matrix, time in zip(matrices, times.tolist())]


def _check_posed(clouds: List[CloudFiles], notes: List[str]) -> None:
    """Refuse several clouds without poses; of a single one it is said."""
    unposed = [file for source in clouds for file in source.unposed]
    if not unposed:
        return
    if sum(len(source.files()) for source in clouds) > 1:
        text = "it has no pose, nor have %d others, so nobody says where the sensor was"
        hint = "--poses FILE (TUM or KITTI), or --sensor X,Y,Z in the frame of the clouds"
        raise no_scans(unposed[0], text % (len(unposed) - 1), hint)
    if max(source.far for source in clouds) > _FAR:
        text = "its coordinates are more than %g km from 0, where its sensor was not"
        hint = "--sensor X,Y,Z says where it was, in the same coordinates"
        raise no_scans(unposed[0], text % (_FAR / 1000), hint)
    text = "%s has no pose: its sensor is taken to be at its 0, 0, 0 (--sensor or --poses say more)"
    notes.append(text % unposed[0])
