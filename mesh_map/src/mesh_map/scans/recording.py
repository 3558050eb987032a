"""Scans recorded along a path, with the truth beside what the robot believes."""

from typing import Any, Iterator, NamedTuple, Optional, Union

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.scans.lidar import Hidden, Lidar, LidarModel, LidarScan
from mesh_map.scans.scan import Scan
from mesh_map.scans.trajectory import Trajectory

SCAN_RATE = 10.0  # Hz


class Recording(NamedTuple):
    """A drive of a robot with a lidar, as it is written into files.

    truth, odometry: of the robot's base in the map's frame, with the same times and the same first
        pose.
    sensor_height: m of the lidar above the base.
    scans: of the lidar; can be gone through once.
    count: how many scans there are.
    frame_id: of the map.
    """

    truth: Trajectory
    odometry: Trajectory
    sensor_height: float
    scans: Iterator["RecordedScan"]
    count: int
    frame_id: str = "map"


class RecordedScan(NamedTuple):
    """A scan and what is true.

    scan: as a mapper gets it: the motion in it is undone as far as odometry knows it, and its pose
        is that of the odometry.
    truth: (4, 4) float64, the true pose of the sensor in the map at the time of the scan.
    measured: the revolution as the sensor gave it out.
    """

    scan: Scan
    truth: np.ndarray
    measured: LidarScan


def record_scans(
    surface: Any,
    poses: Union[Trajectory, np.ndarray],
    *,
    lidar: LidarModel = LidarModel(),
    odometry: Optional[Trajectory] = None,
    rate: float = SCAN_RATE,
    seed: int = 0,
    colors: Optional[Any] = None,
    reflectances: Optional[Any] = None,
    hidden: Optional[Hidden] = None,
) -> Iterator[RecordedScan]:
    """Scans of a mesh, one after the other; the same arguments record the same, to the last bit.

    Args:
        surface, colors, reflectances: see Lidar.
        poses: of the sensor in the map's frame. A trajectory: scans begin at the first of its times
            and then every 1 / `rate` s, as long as a whole revolution is within it. (N, 4, 4): a
            scan at each, 1 / `rate` s apart, where the sensor stands, whatever the duration of a
            revolution is.
        lidar: what the lidar is.
        odometry: what the robot believes of the sensor's poses, such as by
            `OdometryDrift(yaw=0.01).of(trajectory)`; None: the truth.
        rate: scans in a second (Hz).
        seed: of noise and dropouts.
        hidden: what hides the mesh, see Lidar.measure().

    Raises:
        MeshMapError: at once, whatever of this makes no scans.
    """
    if not 0 < rate < np.inf:
        raise MeshMapError("scans at %s Hz" % rate, "a finite number above 0 is needed")
    sensor = Lidar(surface, lidar, seed=seed, colors=colors, reflectances=reflectances)
    if isinstance(poses, Trajectory):
        times, trajectory = scan_times(poses, rate, lidar.duration), poses
    else:
        times = np.arange(len(poses)) / rate
        trajectory = Trajectory.of_matrices(poses, times)
    moving = isinstance(poses, Trajectory)
    return _recorded(sensor, trajectory, odometry or trajectory, times, moving, hidden)


def scan_times(trajectory: Trajectory, rate: float, duration: float) -> np.ndarray:
    """(N,) s at which scans begin so that each of them ends within a trajectory.

    Raises:
        MeshMapError: a trajectory that is shorter than a scan.
    """
    begin, end = trajectory.times[0], trajectory.times[-1]
    if end - begin < duration:
        text = "the trajectory takes %.3g s, a revolution of the lidar %.3g s"
        raise MeshMapError(text % (end - begin, duration), "take a longer one")
    count = int(np.floor((end - begin - duration) * rate + 1e-9)) + 1
    return begin + np.arange(count) / rate


def _recorded(
    sensor: Lidar,
    trajectory: Trajectory,
    odometry: Trajectory,
    times: np.ndarray,
    moving: bool,
    hidden: Optional[Hidden],
) -> Iterator[RecordedScan]:
    truths = trajectory.poses(times)
    for number, (time, truth) in enumerate(zip(times.tolist(), truths)):
        measured = sensor.measure(trajectory if moving else truth, time, hidden)
        name = "scan %d" % number
        if moving:
            scan = measured.undistorted(odometry, name)
        else:
            pose = odometry.poses([time])[0]
            scan = Scan(
                measured.points, pose, None, measured.colors, measured.intensities, time, name
            )
        yield RecordedScan(scan, truth, measured)
