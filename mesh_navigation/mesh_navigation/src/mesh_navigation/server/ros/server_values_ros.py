"""The parameters of the server itself, from the parameter server and dynamic_reconfigure."""

from collections import UserDict
from typing import Any, Dict, Iterable, List, Mapping, Tuple

import rospy

from mesh_map.base.parameter import Value, misspelled, read_parameters
from mesh_map.ros.parameter_server import ParameterServer

from mesh_navigation.body.robot_shape import SHAPE_PARAMETERS
from mesh_navigation.execution.server_parameters import (
    DYNAMIC_PARAMETERS,
    GUARD_PARAMETERS,
    PARAMETERS,
    RESTORE_DEFAULTS,
)
from mesh_navigation.plugins.plugin_list import PluginList

# What else is below the node: the map, and the least cost that check_pose_cost calls inscribed.
_BESIDE = ("mesh_map", "cost_limit")


class ServerValues(UserDict):
    """Values by name, always those of now."""

    def __init__(self) -> None:
        """Reads what the user gave, logs what of it cannot be used, and serves changes."""
        given = rospy.get_param("~", {})
        self.data, complaints = read_parameters(PARAMETERS, given or {})
        self.data[RESTORE_DEFAULTS] = False
        _log(complaints)
        self.guard, complaints = read_parameters(GUARD_PARAMETERS, self["guard"])
        """The values of the guard's parameters."""
        _log([f"guard/{complaint}" for complaint in complaints])
        self._server = ParameterServer(
            rospy.get_name(), DYNAMIC_PARAMETERS, self.data, self._change
        )

    def _change(self, given: Dict[str, Value]) -> Mapping[str, Value]:
        self.data, complaints = changed_values(self.data, given)
        _log(complaints)
        return self.data


def misspelled_names(given: Mapping[str, Any], kinds: Iterable[PluginList]) -> List[str]:
    """One sentence for each name below the node that is nearly one that is read there: a default
    would count in its place, which may be that of a smaller or slower robot.

    Args:
        given: all parameters of the node.
        kinds: its plugins, whose parameters are below their names.
    """
    known = [parameter.name for parameter in (*PARAMETERS, *SHAPE_PARAMETERS)] + list(_BESIDE)
    for plugins in kinds:
        known += [plugins.kind.parameter.lstrip("~"), *plugins.names]
    guard = given.get("guard")
    names = [parameter.name for parameter in GUARD_PARAMETERS]
    of_guard = misspelled(guard, names) if isinstance(guard, Mapping) else []
    return misspelled(given, known) + [f"guard/{complaint}" for complaint in of_guard]


def changed_values(
    present: Mapping[str, Value], given: Mapping[str, Any]
) -> Tuple[Dict[str, Value], List[str]]:
    """All values after a change, and one sentence for each that could not be used as it is.

    The parameter restore_defaults brings back the defaults of all that may change, and is false
    again after that; what is given beside it is forgotten.
    """
    if given.get(RESTORE_DEFAULTS) is True:
        defaults = {parameter.name: parameter.default for parameter in DYNAMIC_PARAMETERS}
        return {**present, **defaults}, []
    return read_parameters(DYNAMIC_PARAMETERS, given, present)


def _log(complaints: List[str]) -> None:
    for complaint in complaints:
        rospy.logwarn("parameter ~%s", complaint)
