"""The parameters of the layer of obstacles."""

import math
from dataclasses import dataclass
from typing import Any, List, Mapping, Tuple

from mesh_map.parameter import Parameter
from mesh_map.query_arguments import number

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


def _parameter(name: str, default: Any, low: Any, high: Any, text: str) -> Parameter:
    return Parameter(name, default, low, high, text, affects_costs=False)


OBSTACLE_PARAMETERS = (
    _parameter("topic", "", None, None, "sensor_msgs/PointCloud2 to subscribe to"),
    Parameter(
        "qos",
        "Reliable",
        description="of ROS 2; without effect",
        affects_costs=False,
        choices=("Reliable", "BestEffort"),
    ),
    _parameter("robot_height", math.inf, 0.0, math.inf, "meters; higher points pass above"),
    _parameter("min_obstacle_height", 0.0, 0.0, 10.0, "meters; points within are ground"),
    _parameter("max_obstacle_dist", math.inf, 0.0, math.inf, "meters from the sensor"),
    _parameter("min_obstacle_dist", 0.0, 0.0, 100.0, "meters; nearer is the robot itself"),
    _parameter("tf_tolerance", 0.1, 0.0, 10.0, "seconds to wait for a transform"),
    DirectionParameter(
        "down_axis", (0.0, 0.0, -1.0), description="in axis_frame", affects_costs=False
    ),
    _parameter(
        "axis_frame",
        "",
        None,
        None,
        "frame of down_axis; if empty, the parameter robot_frame above, else that of the map",
    ),
    _parameter(
        "sensor_frame",
        "",
        None,
        None,
        "frame at whose origin the sensor is; if empty, that of the clouds",
    ),
    _parameter(
        "decay",
        10.0,
        UNTIL_NEXT_CLOUD,
        86400.0,
        "seconds without being seen; 0: until cleared; below 0: until the next cloud",
    ),
    _parameter("clearing", True, None, None, "remove what a later cloud sees past"),
    _parameter("clearing_angle", 1.0, 0.1, 10.0, "degrees; cells of the view of a cloud"),
    _parameter("clearing_margin", 0.2, 0.0, 10.0, "meters that it has to see beyond a mark"),
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
