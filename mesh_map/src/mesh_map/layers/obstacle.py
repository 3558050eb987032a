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
from mesh_map.layers.observation_sources import (
    FOR_SOURCES,
    LOWEST,
    UNTIL_NEXT,
    UPDATE_RATE,
    WITHOUT_MEANING,
    ObservationSource,
    SensorWatch,
    observation_sources,
    source_params,
)
from mesh_map.layers.obstacles import CloudPoints, ObstacleMarks, find_obstacles
from mesh_map.layers.robot_outline import RobotOutline, on_level
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.hits import NO_FACE

Transform = Tuple[np.ndarray, np.ndarray]  # rotation (3, 3) and translation (3,), meters


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
    _parameter("observation_sources", "", "names of several sources in place of topic"),
    UPDATE_RATE,
    Parameter(
        "qos",
        "Reliable",
        description="of ROS 2; without effect",
        affects_costs=False,
        choices=("Reliable", "BestEffort"),
    ),
    _parameter("robot_height", math.inf, "meters; higher points pass above", 0.0, math.inf),
    LOWEST,
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
        UNTIL_NEXT,
        86400.0,
    ),
    _parameter("clearing", True, "remove what a later cloud sees past"),
    _parameter("clearing_angle", 1.0, "degrees; cells of the view of a cloud", 0.1, 10.0),
    _parameter("clearing_margin", 0.2, "meters that it has to see beyond a mark", 0.0, 10.0),
    _parameter("footprint_clearing_enabled", True, "remove what is under the robot itself"),
    _parameter("footprint", (), "corners [[x, y], ...] in robot_frame, meters"),
    _parameter("robot_radius", 0.0, "of a round robot, meters; 0: none", 0.0, 100.0),
    *FOR_SOURCES,
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
    before, which "decay" -1 still says. While its source is silent, a mark does not get older, and
    silence() says why the layer is not current.

    Parameters take effect with the next cloud. Any thread may call any method.

    Attributes:
        last_cloud: CloudSummary of the last cloud; None before.
        body: what the robot covers where the parameters of the layer do not say it.
    """

    PARAMETERS = OBSTACLE_PARAMETERS
    STORABLE = False
    ROS_ADAPTER = "mesh_map.ros.obstacle_adapter.ObstacleAdapter"

    def __init__(
        self, name: str, params: Optional[Mapping[str, Any]] = None, type_name: str = ""
    ) -> None:
        super().__init__(name, params, type_name)
        self.last_cloud: Optional[CloudSummary] = None
        self.body = RobotOutline()
        self._lock = threading.Lock()
        self._geometry: Optional[MeshGeometry] = None
        self._watches: Dict[str, SensorWatch] = {}
        self._marks: Dict[str, ObstacleMarks] = {}  # by the names of sources
        self._faces = _NO_FACES

    def _checked(self, given: Mapping[str, Any]) -> Tuple[Dict[str, Any], List[str]]:
        own = {parameter.name for parameter in self.all_parameters()}
        of_sources = source_params(given, own)
        rest = {name: value for name, value in given.items() if name not in of_sources}
        odd = [name for name in WITHOUT_MEANING if rest.pop(name, None) is not None]
        params, warnings = super()._checked(rest)
        params.update(of_sources)
        _outline(params)  # refuses what is none
        warnings += ["%s says nothing here: %s" % (name, WITHOUT_MEANING[name]) for name in odd]
        return params, warnings + observation_sources(params)[1] + contradictions(params)

    @property
    def sources(self) -> List[ObservationSource]:
        """What the layer gets its data from; a single one without a name, unless the parameter
        "observation_sources" names some."""
        return observation_sources(self.params)[0]

    @property
    def outline(self) -> RobotOutline:
        """What is cleared under the robot; nothing where "footprint_clearing_enabled" is false."""
        if not self.params["footprint_clearing_enabled"]:
            return RobotOutline()
        return _outline(self.params) or self.body

    @property
    def marked_faces(self) -> np.ndarray:
        """(K,) uint32, ascending: the faces on which something stands."""
        return self._faces

    def silence(self, now: float) -> str:
        """Why the layer is not current: which sources are silent, and what to do; empty while none
        is. Quick.

        Args:
            now: seconds, of the clock of the stamps.
        """
        found = (self._watch(source.name).silence(source, now) for source in self.sources)
        return "; ".join(filter(None, found))

    def missed(self, source: str, reason: str) -> None:
        """A message of a source came that cannot be used."""
        self._watch(source).missed(reason)

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        # As quick as an update could be: that, too, would have to copy V numbers.
        costs = np.zeros(len(mesh_map.vertices), np.float32)
        if self._geometry is mesh_map.geometry:
            costs[mesh_map.faces[self.marked_faces]] = np.inf
        return LayerResult(read_only(costs), costs > 0)

    def insert_cloud(
        self,
        mesh_map: MeshMap,
        points: Any,
        origin: Any,
        stamp: float,
        down: Optional[Any] = None,
        *,
        source: str = "",
        free: Any = (),
        robot: Optional[Transform] = None,
        seen: Optional[float] = None,
    ) -> int:
        """Takes a cloud; the result of the layer follows with compute() or update().

        Args:
            mesh_map: of the layer.
            points: (N, 3) meters, in the frame of the map; those that are not finite are counted
                and nothing else. If none is, the source is blind, and not heard by it; an empty
                cloud says that nothing is there.
            origin: (3,), of the sensor, in that frame.
            stamp: seconds, of any one clock. If it is set back, marks count as seen then.
            down: (3,), where the surface is from an obstacle; None for below, as the map sees it.
            source: its name; empty for the one without.
            free: (K, 3), up to where rays of the sensor have met nothing.
            robot: from its frame to that of the map; what stands under it is cleared.
            seen: seconds, of the same clock: when the sensor saw that, which may be long ago; None
                for the stamp. See silence().
        Returns:
            how many faces are marked that were not before, or no longer.
        Raises:
            ValueError: wrong shapes, a stamp that is not finite, down of length 0, or no such
                source.
        """
        points, origin, stamp = (
            points_array(points, "points"),
            vector(origin, "origin"),
            _time(stamp),
        )
        free = points_array(free, "free") if len(free) else np.zeros((0, 3))
        if down is None:
            down = -np.asarray(mesh_map.geometry.up)
        down = vector(down, "down")
        if not 0 < np.linalg.norm(down) < np.inf:
            raise ValueError("down has to be a direction, not %s" % down)
        sensor = next((one for one in self.sources if one.name == source), None)
        if sensor is None:
            raise ValueError("there is no source %r" % source)
        found = find_obstacles(
            mesh_map.spatial_index,
            points,
            origin,
            down,
            nearest=self.params["min_obstacle_dist"],
            farthest=sensor.obstacle_range,
            lowest=sensor.min_obstacle_height,
            highest=sensor.max_obstacle_height,
        )
        with self._lock:
            own, count = self._marks_of(mesh_map, source), self._mark_count()
            for marks in self._marks.values():
                marks.set_back(stamp)
            if len(free) or not len(points) or found.finite.any():
                silent = self._watch(source).spoke(stamp, sensor.expected_update_rate, seen)
                own.postpone(silent)
            if sensor.observation_persistence < 0:
                own.keep(np.zeros(len(own.times), np.bool_))
            if sensor.clearing:
                self._clear_seen(sensor, points, origin, found, free)
            self._forget_older(stamp)
            removed = count - self._mark_count()
            obstacles = found.faces != NO_FACE
            if sensor.marking:
                own.add(found.faces[obstacles], points[obstacles], stamp)
            if robot is not None:
                self._clear_under(mesh_map, *robot)
            self.last_cloud = _summary(found, removed)
            return self._changes()

    def decay(self, now: float) -> int:
        """Forgets what has not been seen for longer than the parameter "decay" says, but for the
        time in which its source was silent.

        Args:
            now: seconds, of the clock of the stamps.
        Returns:
            how many faces are no longer marked.
        Raises:
            ValueError: a time that is not finite.
        """
        now = _time(now)
        with self._lock:
            for marks in self._marks.values():
                marks.set_back(now)
            self._forget_older(now)
            return self._changes()

    def clear(self) -> int:
        """Forgets all obstacles. Returns how many faces were marked."""
        with self._lock:
            for marks in self._marks.values():
                marks.keep(np.zeros(len(marks.times), np.bool_))
            return self._changes()

    def _watch(self, source: str) -> SensorWatch:
        return self._watches.setdefault(source, SensorWatch())

    def _marks_of(self, mesh_map: MeshMap, source: str) -> ObstacleMarks:
        if self._geometry is not mesh_map.geometry:
            self._marks, self._faces = {}, _NO_FACES
            self._geometry = mesh_map.geometry
        if source not in self._marks:
            self._marks[source] = ObstacleMarks(len(mesh_map.faces))
        return self._marks[source]

    def _mark_count(self) -> int:
        return sum(len(marks.times) for marks in self._marks.values())

    def _changes(self) -> int:
        """Takes note of the faces that are marked now; how many differ from those before."""
        before, found = self._faces, [marks.faces for marks in self._marks.values()]
        if len(found) == 1:
            self._faces = found[0]
        elif found:
            self._faces = read_only(np.unique(np.concatenate(found)))
        return len(np.setxor1d(before, self._faces, assume_unique=True))

    def _clear_seen(
        self,
        sensor: ObservationSource,
        points: np.ndarray,
        origin: np.ndarray,
        found: CloudPoints,
        free: np.ndarray,
    ) -> None:
        ends = np.concatenate([points[found.finite], free])
        if not self._mark_count() or not len(ends):
            return
        ground = np.append(found.ground[found.finite], np.zeros(len(free), np.bool_))
        view = CloudView(ends - origin, ground, math.radians(self.params["clearing_angle"]))
        for marks in self._marks.values():
            offsets = marks.points - origin
            gone = view.sees_past(offsets, self.params["clearing_margin"])
            gone &= np.linalg.norm(offsets, axis=1) <= sensor.raytrace_range
            marks.keep(~gone)

    def _clear_under(
        self, mesh_map: MeshMap, rotation: np.ndarray, translation: np.ndarray
    ) -> None:
        outline = self.outline
        for marks in self._marks.values():
            under = outline.covers(rotation, translation, marks.points)
            corners = mesh_map.vertices[mesh_map.faces[marks.mark_faces[under]]]
            under[under] = on_level(rotation, translation, corners)
            marks.keep(~under)

    def _forget_older(self, now: float) -> None:
        for source in self.sources:
            persistence, marks = source.observation_persistence, self._marks.get(source.name)
            if persistence > 0 and marks is not None:
                watch = self._watch(source.name)
                seen = watch.last_sight(now, source.expected_update_rate)
                marks.keep(marks.times >= seen - persistence)


def _outline(params: Mapping[str, Any]) -> RobotOutline:
    return RobotOutline(params["footprint"], params["robot_radius"])


_NO_FACES = read_only(np.zeros(0, np.uint32))


def _time(value: Any) -> float:
    seconds = number(value, "the time")
    if not math.isfinite(seconds):
        raise ValueError("the time has to be finite, not %g" % seconds)
    return seconds


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
