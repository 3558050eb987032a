"""The lidar of a simulated robot: what it measures from where the robot was meanwhile."""

from collections import deque
from functools import partial
from typing import Any, Deque, Mapping, Optional, Sequence, Tuple

import numpy as np

from mesh_map.scans.lidar import Lidar, LidarModel, LidarScan
from mesh_map.scans.trajectory import Trajectory

from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.simulation.obstacles import Obstacle, ray_distances


class RobotLidar:
    """A lidar that follows the poses of a robot; obstacles hide the mesh."""

    def __init__(self, surface: Any, model: LidarModel = LidarModel(), seed: int = 0) -> None:
        """
        Args:
            surface: a `MeshMap` or `MeshGeometry`.
            model: what it is.
            seed: of noise and dropouts.
        """
        self._lidar = Lidar(surface, model, seed=seed)
        self._poses: Deque[Tuple[float, Pose]] = deque()

    def follow(self, time: float, pose: Pose) -> None:
        """Where the sensor is in the map's frame at a time (s). Time that jumps back, or farther
        than a revolution, begins anew."""
        last = self._poses[-1][0] if self._poses else time
        if time < last or time > last + max(self.duration, 1.0):
            self.begin_anew()
        elif self._poses and time == last:
            self._poses.pop()
        self._poses.append((time, pose))
        # The newest one that is not needed for the next revolution stays: it begins behind that.
        while len(self._poses) > 1 and self._poses[1][0] <= time - self.duration:
            self._poses.popleft()

    def begin_anew(self) -> None:
        """Forget where the sensor was, such as when the robot was put elsewhere."""
        self._poses.clear()

    @property
    def duration(self) -> float:
        """s of a revolution."""
        return self._lidar.model.duration

    def scan(self, obstacles: Sequence[Obstacle] = ()) -> Optional[LidarScan]:
        """The revolution that ends where the sensor is now; None before it was followed for one.

        Args:
            obstacles: that hide the mesh, and each other.
        """
        if not self._poses:
            return None
        hidden = partial(ray_distances, obstacles) if obstacles else None
        time, pose = self._poses[-1]
        if not self.duration:
            return self._lidar.measure(pose_matrix(pose), time, hidden)
        begin = time - self.duration
        if begin < self._poses[0][0]:
            return None
        times, poses = zip(*self._poses)
        positions = np.stack([each.position for each in poses])
        orientations = np.stack([each.normalized().orientation for each in poses])
        trajectory = Trajectory(np.array(times), positions, orientations)
        return self._lidar.measure(trajectory, begin, hidden)


def pose_matrix(pose: Pose) -> np.ndarray:
    """(4, 4) from the frame with that pose into the map's."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([rotate(pose.orientation, axis) for axis in np.eye(3)]).T
    matrix[:3, 3] = pose.position
    return matrix


def lidar_model(values: Mapping[str, Any]) -> LidarModel:
    """The lidar that parameters of the node describe; those that contradict each other are put in
    order. A revolution takes no longer than the time between two clouds.

    Args:
        values: of all parameters.
    """
    elevations = values["scan_lowest"], values["scan_highest"]
    rate, most = values["scan_rate"], values["scan_max_range"]
    period = 1 / rate if rate else np.inf
    return LidarModel(
        rings=values["scan_rings"],
        columns=values["scan_columns"],
        lowest=min(elevations),
        highest=max(elevations),
        min_range=min(values["scan_min_range"], most / 2),
        max_range=most,
        noise=values["scan_noise"],
        dropout=values["scan_dropout"],
        reflect_range=values["scan_reflect_range"] or np.inf,
        duration=min(values["scan_duration"], period),
    )
