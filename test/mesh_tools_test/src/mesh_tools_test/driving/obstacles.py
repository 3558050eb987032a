"""A hall where something is put in the robot's way, which only its sensor tells of."""

from typing import Any, Dict, List, Optional, Tuple

import numpy as np
from mesh_map.map.mesh_map import MeshMap
from mesh_map.scans.lidar import LidarModel
from mesh_msgs import zoo
from mesh_navigation.base.pose import Pose, rotate
from mesh_navigation.simulation.obstacles import Obstacle
from mesh_navigation.simulation.robot_lidar import RobotLidar
from mesh_navigation.simulation.simulated_robot import SimulatedRobot

from mesh_tools_test.driving.worlds import layer, with_layers

SIZE, CELL = 12.0, 0.15  # m, of the hall and of its faces
SENSOR_HEIGHT, SCAN_PERIOD = 0.8, 0.2  # m and s
RADIUS = 0.3  # m, of the robot
OBSTACLE_LAYER = "obstacle"


def hall_layers() -> List[Dict[str, Any]]:
    """Obstacles of a sensor, and what the robot keeps from them."""
    return [
        layer(
            OBSTACLE_LAYER,
            "Obstacle",
            topic="/points",
            robot_height=1.0,
            min_obstacle_height=0.1,
            max_obstacle_dist=8.0,
            decay=2.0,
        ),
        layer(
            "inflation",
            "Inflation",
            inscribed_radius=RADIUS,
            inflation_radius=0.8,
            inscribed_value=1.5,
            repulsive_field=False,
        ),
    ]


def hall_mesh() -> Any:
    """A level floor from (0, 0, 0) to (`SIZE`, `SIZE`, 0)."""
    return zoo.grid(cells=int(SIZE / CELL), size=SIZE)


def hall() -> MeshMap:
    """The floor with its layers."""
    mesh = hall_mesh()
    return with_layers(MeshMap(mesh.vertices, mesh.faces), hall_layers())


class Watcher:
    """A sensor on the robot, whose clouds go to the obstacle layer of its map; what `drive` takes
    as `on_step`.

    Attributes:
        mesh_map: with that layer.
        present: obstacles that stand there.
        nearest: m, the least distance of the robot from one of them; inf before.
        dropped_at: (3,) m, where it was when one was put there; None before.
    """

    def __init__(self, mesh_map: MeshMap) -> None:
        self.mesh_map = mesh_map
        self._lidar = RobotLidar(mesh_map, LidarModel(noise=0.01))
        self._next = 0.0
        self._planned: List[Tuple[float, Obstacle]] = []
        self.present: List[Obstacle] = []
        self.nearest = np.inf
        self.dropped_at: Optional[np.ndarray] = None

    def drop(self, obstacle: Obstacle, at_x: float) -> None:
        """Put an obstacle there as soon as the robot is beyond x = `at_x` (m)."""
        self._planned.append((at_x, obstacle))

    def __call__(self, now: float, robot: SimulatedRobot) -> None:
        pose = robot.body.pose
        for planned in [each for each in self._planned if pose.position[0] > each[0]]:
            self._planned.remove(planned)
            self.present.append(planned[1])
            self.dropped_at = pose.position
        for obstacle in self.present:
            self.nearest = min(self.nearest, distance(obstacle, pose.position))
        if now >= self._next - 1e-9:
            self._next = now + SCAN_PERIOD
            self._look(pose, now)

    def _look(self, pose: Pose, now: float) -> None:
        up = rotate(pose.orientation, np.array([0.0, 0.0, SENSOR_HEIGHT]))
        sensor = pose._replace(position=pose.position + up)
        self._lidar.follow(now, sensor)
        scan = self._lidar.scan(self.present)
        assert scan is not None  # a revolution takes no time
        cloud = scan.points.astype(np.float64)
        axes = np.stack([rotate(pose.orientation, axis) for axis in np.eye(3)])
        one: Any = self.mesh_map.layers[OBSTACLE_LAYER]
        one.insert_cloud(self.mesh_map, cloud @ axes + sensor.position, sensor.position, now)
        self.mesh_map.refresh_layer(OBSTACLE_LAYER)


def column(x: float, y: float, radius: float = 0.3) -> Obstacle:
    """A cylinder of 1 m that stands on the floor there."""
    return Obstacle.checked("cylinder", Pose.at((x, y, 0.5)), (2 * radius, 2 * radius, 1.0))


def distance(obstacle: Obstacle, point: np.ndarray) -> float:
    """m on the floor from a point to an upright cylinder; below 0 within it."""
    offset = point[:2] - obstacle.pose.position[:2]
    return float(np.hypot(*offset) - obstacle.size[0] / 2)
