"""Obstacles that a sensor sees, on the faces below them."""

import math
import threading
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.parameter import Parameter
from mesh_map.base.query_arguments import number, points_array, vector
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.layers.cloud_view import CloudView
from mesh_map.layers.obstacles import CloudPoints, ObstacleMarks, find_obstacles
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import NO_FACE

UNTIL_NEXT_CLOUD = -1.0  # of "decay"


@dataclass(frozen=True)
class DirectionParameter(Parameter):
    """A direction: a list of three numbers, not all 0."""

    def checked(self, value: Any) -> Tuple[Any, str]:
        try:
            direction = tuple(number(part, self.name) for part in value)
        except (TypeError, ValueError):
            direction = ()
        if len(direction) != 3 or not 0 < math.hypot(*direction) < math.inf:
            raise self._wrong(value, "three numbers, not all 0")
        return direction, ""


def _parameter(name: str, default: Any, text: str, *limits: float) -> Parameter:
    return Parameter(name, default, *(limits or (None, None)), text, affects_costs=False)


OBSTACLE_PARAMETERS = (
    _parameter("topic", "", "sensor_msgs/PointCloud2 to subscribe to"),
    Parameter(
        "qos",
        "Reliable",
        description="of ROS 2; without effect",
        affects_costs=False,
        choices=("Reliable", "BestEffort"),
    ),
    _parameter("robot_height", math.inf, "meters; higher points pass above", 0.0, math.inf),
    _parameter("min_obstacle_height", 0.0, "meters; points within are ground", 0.0, 10.0),
    _parameter("max_obstacle_dist", math.inf, "meters from the sensor", 0.0, math.inf),
    _parameter("min_obstacle_dist", 0.0, "meters; nearer is the robot itself", 0.0, 100.0),
    _parameter("tf_tolerance", 0.1, "seconds to wait for a transform", 0.0, 10.0),
    DirectionParameter(
        "down_axis", (0.0, 0.0, -1.0), description="in axis_frame", affects_costs=False
    ),
    _parameter(
        "axis_frame",
        "",
        "frame of down_axis; if empty, the parameter robot_frame above, else that of the map",
    ),
    _parameter(
        "sensor_frame", "", "frame at whose origin the sensor is; if empty, that of the clouds"
    ),
    _parameter(
        "decay",
        10.0,
        "seconds without being seen; 0: until cleared; below 0: until the next cloud",
        UNTIL_NEXT_CLOUD,
        86400.0,
    ),
    _parameter("clearing", True, "remove what a later cloud sees past"),
    _parameter("clearing_angle", 1.0, "degrees; cells of the view of a cloud", 0.1, 10.0),
    _parameter("clearing_margin", 0.2, "meters that it has to see beyond a mark", 0.0, 10.0),
)


def contradictions(params: Mapping[str, Any]) -> List[str]:
    """One line for each pair of limits between which there is nothing."""
    return [
        "%s %g is not below %s %g: no point is an obstacle" % (low, params[low], high, params[high])
        for low, high in (
            ("min_obstacle_height", "robot_height"),
            ("min_obstacle_dist", "max_obstacle_dist"),
        )
        if not params[low] < params[high]
    ]


class CloudSummary(NamedTuple):
    """What became of the points of a cloud: numbers of each.

    points: all; not_finite, out_of_range, ground, elsewhere (with no surface below, or too high
    above it) and obstacles add up to that.
    obstacle_faces: on which the obstacles stand.
    removed_marks: of earlier clouds, that were seen past or are too old.
    """

    points: int
    not_finite: int
    out_of_range: int
    ground: int
    elsewhere: int
    obstacles: int
    obstacle_faces: int
    removed_marks: int


class ObstacleLayer(Layer):
    """Vertices of faces on which something stands are lethal; all others cost 0.

    insert_cloud() casts each point of a cloud down onto the mesh, as the released layer did, and
    marks the face that it meets. A mark goes when a later cloud sees past it (see CloudView), when
    it is older than "decay", or by clear(); in the released layer, each cloud replaced the one
    before, which "decay" -1 still says.

    Parameters take effect with the next cloud. Any thread may call any method.

    Attributes:
        last_cloud: CloudSummary of the last cloud; None before.
    """

    PARAMETERS = OBSTACLE_PARAMETERS
    STORABLE = False
    ROS_ADAPTER = "mesh_map.ros.obstacle_adapter.ObstacleAdapter"

    def __init__(
        self, name: str, params: Optional[Mapping[str, Any]] = None, type_name: str = ""
    ) -> None:
        super().__init__(name, params, type_name)
        self.warnings += contradictions(self.params)
        self.last_cloud: Optional[CloudSummary] = None
        self._lock = threading.Lock()
        self._geometry: Optional[MeshGeometry] = None
        self._marks = ObstacleMarks(0)

    def checked_changes(self, values: Mapping[str, Any]) -> Tuple[Dict[str, Any], List[str]]:
        params, warnings = super().checked_changes(values)
        return params, warnings + contradictions(params)

    @property
    def marked_faces(self) -> np.ndarray:
        """(K,) uint32, ascending: the faces on which something stands."""
        return read_only(self._marks.faces)

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        # As quick as an update could be: that, too, would have to copy V numbers.
        costs = np.zeros(len(mesh_map.vertices), np.float32)
        if self._geometry is mesh_map.geometry:
            costs[mesh_map.faces[self.marked_faces]] = np.inf
        return LayerResult(read_only(costs), costs > 0)

    def insert_cloud(
        self, mesh_map: MeshMap, points: Any, origin: Any, stamp: float, down: Optional[Any] = None
    ) -> int:
        """Takes a cloud; the result of the layer follows with compute() or update().

        Args:
            mesh_map: of the layer.
            points: (N, 3) meters, in the frame of the map; those that are not finite are counted
                and nothing else.
            origin: (3,), of the sensor, in that frame.
            stamp: seconds, of any one clock. If it is set back, marks count as seen then.
            down: (3,), where the surface is from an obstacle; None for below, as the map sees it.
        Returns:
            how many faces are marked that were not before, or no longer.
        Raises:
            ValueError: wrong shapes, a stamp that is not finite, or down of length 0.
        """
        points, origin, stamp = (
            points_array(points, "points"),
            vector(origin, "origin"),
            _time(stamp),
        )
        if down is None:
            down = -np.asarray(mesh_map.geometry.up)
        down = vector(down, "down")
        if not 0 < np.linalg.norm(down) < np.inf:
            raise ValueError("down has to be a direction, not %s" % down)
        found = find_obstacles(
            mesh_map.spatial_index,
            points,
            origin,
            down,
            nearest=self.params["min_obstacle_dist"],
            farthest=self.params["max_obstacle_dist"],
            lowest=self.params["min_obstacle_height"],
            highest=self.params["robot_height"],
        )
        with self._lock:
            marks, before = self._marks_of(mesh_map), self._marks.faces
            count = len(marks.times)
            marks.set_back(stamp)
            if self.params["decay"] < 0:
                marks.keep(np.zeros(count, np.bool_))
            elif self.params["clearing"]:
                self._clear_seen(points, origin, found)
            self._forget_older(stamp)
            removed = count - len(marks.times)
            obstacles = found.faces != NO_FACE
            marks.add(found.faces[obstacles], points[obstacles], stamp)
            self.last_cloud = _summary(found, removed)
            return _differences(before, marks.faces)

    def decay(self, now: float) -> int:
        """Forgets what has not been seen for longer than the parameter "decay" says.

        Args:
            now: seconds, of the clock of the stamps.
        Returns:
            how many faces are no longer marked.
        Raises:
            ValueError: a time that is not finite.
        """
        now = _time(now)
        with self._lock:
            before = self._marks.faces
            self._marks.set_back(now)
            self._forget_older(now)
            return _differences(before, self._marks.faces)

    def clear(self) -> int:
        """Forgets all obstacles. Returns how many faces were marked."""
        with self._lock:
            count = len(self._marks.faces)
            self._marks.keep(np.zeros(len(self._marks.times), np.bool_))
            return count

    def _marks_of(self, mesh_map: MeshMap) -> ObstacleMarks:
        if self._geometry is not mesh_map.geometry:
            self._marks = ObstacleMarks(len(mesh_map.faces))
            self._geometry = mesh_map.geometry
        return self._marks

    def _clear_seen(self, points: np.ndarray, origin: np.ndarray, found: CloudPoints) -> None:
        if not len(self._marks.times) or not found.finite.any():
            return
        view = CloudView(
            points[found.finite] - origin,
            found.ground[found.finite],
            math.radians(self.params["clearing_angle"]),
        )
        offsets = self._marks.points - origin
        self._marks.keep(~view.sees_past(offsets, self.params["clearing_margin"]))

    def _forget_older(self, now: float) -> None:
        if self.params["decay"] > 0:
            self._marks.keep(self._marks.times >= now - self.params["decay"])


def _time(value: Any) -> float:
    seconds = number(value, "the time")
    if not math.isfinite(seconds):
        raise ValueError("the time has to be finite, not %g" % seconds)
    return seconds


def _differences(before: np.ndarray, after: np.ndarray) -> int:
    return len(np.setxor1d(before, after, assume_unique=True))


def _summary(found: CloudPoints, removed_marks: int) -> CloudSummary:
    faces = found.faces[found.faces != NO_FACE]
    total, finite, in_range = (len(found.faces), int(found.finite.sum()), int(found.in_range.sum()))
    ground = int(found.ground.sum())
    return CloudSummary(
        points=total,
        not_finite=total - finite,
        out_of_range=finite - in_range,
        ground=ground,
        elsewhere=in_range - ground - len(faces),
        obstacles=len(faces),
        obstacle_faces=len(np.unique(faces)),
        removed_marks=removed_marks,
    )
