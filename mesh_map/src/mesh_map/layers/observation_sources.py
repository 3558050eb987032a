"""The sensors that a layer of obstacles listens to: their parameters, and whether they speak."""

import math
import threading
from typing import Any, Container, Dict, List, Mapping, NamedTuple, Optional, Tuple

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, checked_values

POINT_CLOUD, LASER_SCAN = "PointCloud2", "LaserScan"
UNTIL_NEXT = -1.0  # of "decay" and "observation_persistence"
UPDATE_RATE = Parameter(
    "expected_update_rate",
    1.0,
    0.0,
    86400.0,
    "seconds between two messages at most, or the layer is not current; 0: whatever comes",
    affects_costs=False,
)
LOWEST = Parameter(
    "min_obstacle_height",
    0.0,
    -10.0,
    10.0,
    "meters; points within are ground; below 0: those that deep below the surface mark it, too",
    affects_costs=False,
)
SOURCE_PARAMETERS = (
    Parameter("topic", "", description="to subscribe to; if empty, the name of the source"),
    Parameter(
        "data_type",
        POINT_CLOUD,
        description="of sensor_msgs",
        choices=(POINT_CLOUD, LASER_SCAN),
    ),
    Parameter("sensor_frame", "", description="frame of the sensor; if empty, that of messages"),
    UPDATE_RATE,
    Parameter(
        "observation_persistence", 0.0, UNTIL_NEXT, 86400.0, "as decay, for what this one marks"
    ),
    Parameter("marking", True, description="what it sees is an obstacle"),
    Parameter("clearing", False, description="remove what it sees past"),
    LOWEST,
    Parameter("max_obstacle_height", math.inf, 0.0, math.inf, "meters; higher points pass above"),
    Parameter("obstacle_range", math.inf, 0.0, math.inf, "meters, within which it marks"),
    Parameter("raytrace_range", math.inf, 0.0, math.inf, "meters, within which it clears"),
    Parameter("inf_is_valid", False, description="inf in a LaserScan: nothing up to range_max"),
)
# Where a source says nothing, the least of the layer's own parameters holds: name of a source -> of
# the layer.
_OF_THE_LAYER = {
    "sensor_frame": ("sensor_frame",),
    UPDATE_RATE.name: (UPDATE_RATE.name,),
    "observation_persistence": ("decay",),
    "min_obstacle_height": ("min_obstacle_height",),
    "max_obstacle_height": ("robot_height",),
    "obstacle_range": ("max_obstacle_dist", "obstacle_range"),
    "raytrace_range": ("raytrace_range",),
}
FOR_SOURCES = (
    Parameter(
        "max_obstacle_height",
        math.inf,
        0.0,
        math.inf,
        "meters; higher points pass above, whatever a source says",
        affects_costs=False,
    ),
    Parameter(
        "obstacle_range",
        math.inf,
        0.0,
        math.inf,
        "meters, within which sources mark that do not say it",
        affects_costs=False,
    ),
    Parameter(
        "raytrace_range",
        math.inf,
        0.0,
        math.inf,
        "meters, within which sources clear that do not say it",
        affects_costs=False,
    ),
)
"""Parameters of the layer that hold for sources as in costmap_2d, where ranges are looked for in
the namespaces around, and the layer leaves out what is too high after its sources have done so."""
_UNBOUNDED = {one.name: one.default for one in FOR_SOURCES}
_INSTEAD = {
    "max_obstacle_height": "robot_height says it",
    "obstacle_range": "max_obstacle_dist says it",
    "raytrace_range": "the layer clears as far as it sees",
}
WITHOUT_MEANING = {
    "combination_method": "lethal in any layer is lethal",
    "track_unknown_space": "what was never seen is as the other layers say",
    "transform_tolerance": "tf_tolerance says it",
    "origin_z": "there are no voxels",
    "z_resolution": "there are no voxels",
    "z_voxels": "there are no voxels",
    "unknown_threshold": "there are no voxels",
    "mark_threshold": "there are no voxels",
    "publish_voxel_map": "there are no voxels",
}
"""Parameters of costmap_2d's layers of obstacles that say nothing here, and why."""


class ObservationSource(NamedTuple):
    """A sensor: parameters as in SOURCE_PARAMETERS, after the name in "observation_sources", which
    is empty for the one of the layer's parameter "topic"."""

    name: str
    topic: str
    data_type: str
    sensor_frame: str
    expected_update_rate: float
    observation_persistence: float
    marking: bool
    clearing: bool
    min_obstacle_height: float
    max_obstacle_height: float
    obstacle_range: float
    raytrace_range: float
    inf_is_valid: bool

    def __str__(self) -> str:
        return "source %s (%s)" % (self.name, self.topic) if self.name else "topic " + self.topic


def observation_sources(params: Mapping[str, Any]) -> Tuple[List[ObservationSource], List[str]]:
    """The sources that the parameters of a layer name, and one line for each warning.

    Args:
        params: checked; of each source a dictionary of its name.
    Raises:
        MeshMapError: a value that cannot be used; it is named.
    """
    names = params["observation_sources"].split()
    if "," in params["observation_sources"]:
        text = "observation_sources is %r" % params["observation_sources"]
        raise MeshMapError(text, "spaces alone are between names")
    if not names:
        given = {"topic": params["topic"], "clearing": params["clearing"]}
        odd = [one.name for one in FOR_SOURCES if params[one.name] != one.default]
        text = "%s says nothing here without observation_sources: %s"
        warnings = [text % (name, _INSTEAD[name]) for name in odd]
        return [_source("", given, {**params, **_UNBOUNDED})[0]], warnings
    found, warnings = [], []
    for name in dict.fromkeys(names):
        source, remarks = _source(name, {"topic": name, **params[name]}, params)
        _check(source)
        if not params[name]:
            warnings.append("source %s: nothing is set below its name" % name)
        found.append(source)
        warnings += remarks
    if not any(source.marking for source in found):
        raise MeshMapError("none of the sources %s marks" % params["observation_sources"])
    if params["topic"]:
        warnings.append("topic %s is left out: observation_sources says more" % params["topic"])
    return found, warnings


def _source(
    name: str, given: Mapping[str, Any], params: Mapping[str, Any]
) -> Tuple[ObservationSource, List[str]]:
    inherited = {own: min(params[one] for one in other) for own, other in _OF_THE_LAYER.items()}
    try:
        values, limited = checked_values(SOURCE_PARAMETERS, {**inherited, **given})
        if limited:
            raise MeshMapError("; ".join(limited).replace(" is used", " is as far as it goes"))
    except MeshMapError as error:
        raise MeshMapError("source %s: %s" % (name, error)) from error
    warnings = []
    unknown = ", ".join(sorted(str(other) for other in given if other not in values))
    if unknown:
        known = ", ".join(sorted(values))
        warnings.append("unknown parameters: %s (known: %s)" % (unknown, known))
    if not values["topic"]:
        values["topic"] = name
    highest = "max_obstacle_height"
    values[highest] = min(values[highest], params[highest])
    return ObservationSource(name, **values), ["source %s: %s" % (name, w) for w in warnings]


def _check(source: ObservationSource) -> None:
    """MeshMapError: it can do nothing."""
    if not (source.marking or source.clearing):
        raise MeshMapError("source %s: it neither marks nor clears" % source.name)
    if source.marking and not source.min_obstacle_height < source.max_obstacle_height:
        raise MeshMapError(
            "source %s marks nothing: min_obstacle_height %g is not below max_obstacle_height %g"
            % (source.name, source.min_obstacle_height, source.max_obstacle_height)
        )
    if source.marking and not source.obstacle_range > 0.0:
        raise MeshMapError("source %s marks nothing: obstacle_range is 0" % source.name)


def source_params(given: Mapping[str, Any], own: Container[str]) -> Dict[str, Mapping[str, Any]]:
    """name -> what is given below it, of the sources that the parameters of a layer name.

    Args:
        given: parameters of the layer, not checked.
        own: names of those that are the layer's.
    Raises:
        MeshMapError: a name that is one of them, or what is no dictionary.
    """
    names = given.get("observation_sources", "")
    found: Dict[str, Mapping[str, Any]] = {}
    for name in names.split() if isinstance(names, str) else ():
        if name in own:
            raise MeshMapError("observation_sources: %s is a parameter of the layer" % name)
        found[name] = given.get(name, {})
        if not isinstance(found[name], Mapping):
            raise MeshMapError("source %s is %r, not a dictionary" % (name, found[name]))
    return found


class SensorWatch:
    """Whether a sensor speaks: messages that can be used, by any one clock. From any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()  # held for moments
        self._heard: Optional[float] = None
        self._age = 0.0  # s, of what was heard last, when it came
        self._missed = ""

    def spoke(self, now: float, rate: float, seen: Optional[float] = None) -> float:
        """A message came that can be used, of what was seen then (None: now). Returns for
        how long before (s) there was silence, that is, beyond the expected rate."""
        silent = now - self.last_sight(now, rate)
        with self._lock:
            self._heard, self._missed = now, ""
            self._age = 0.0 if seen is None else now - seen
        return silent

    def missed(self, reason: str) -> None:
        """A message came that cannot be used."""
        self._missed = reason

    def last_sight(self, now: float, rate: float) -> float:
        """Up to when it was watched what there is (s): not beyond the expected rate."""
        silent = self._silent(now, rate)
        return now - max(0.0, silent) if rate and silent is not None else now

    def silence(self, source: ObservationSource, now: float) -> str:
        """Why what it told is not current; empty while it is."""
        rate = source.expected_update_rate
        silent = self._silent(now, rate)
        if not rate:
            return ""
        if silent is not None and silent <= 0.0:
            return self._delay(source)
        since = "yet" if silent is None else "for %d s" % (silent + rate)
        return "nothing usable came from %s %s (expected_update_rate is %g s)%s: %s" % (
            source,
            since,
            rate,
            ", but: " + self._missed if self._missed else "",
            "start the sensor, see that TF has its frame, or set expected_update_rate 0",
        )

    def _delay(self, source: ObservationSource) -> str:
        with self._lock:
            age = self._age
        if age <= source.expected_update_rate:
            return ""
        text = "what comes from %s is %.1f s old by its stamp when it comes (%s is %g s): %s"
        advice = "see what delays it, and that both clocks are the same, or allow for it"
        return text % (source, age, UPDATE_RATE.name, source.expected_update_rate, advice)

    def _silent(self, now: float, rate: float) -> Optional[float]:
        """Seconds beyond the expected rate, below 0 before; None where it never spoke."""
        with self._lock:
            if self._heard is None:
                return None
            self._heard = min(self._heard, now)  # the clock may be set back
            return now - self._heard - rate
