"""What dynamic_reconfigure needs to know of parameters, made from their declarations.

dynamic_reconfigure has classes generated from .cfg files for this. Layers of any package have their
parameters in Python, so the same description is made of those when the node runs.
"""

import math
from typing import Any, Dict, Iterable, List, Tuple

from mesh_map.base.parameter import Parameter, Value

# bool before int: True is an int as well
_TYPES = {bool: "bool", int: "int", float: "double", str: "str"}
_INT_LIMITS = (-(2**31), 2**31 - 1)  # of the int32 of dynamic_reconfigure's messages


class ConfigType:
    """What dynamic_reconfigure.server reads of a generated configuration class.

    Attributes:
        defaults, min, max: name of a parameter -> value.
        config_description: all of them as one group.
    """

    def __init__(self, parameters: Iterable[Parameter]) -> None:
        """Describes the numbers, booleans and strings of the parameters; it has none for lists and
        dictionaries."""
        described = [_description(parameter) for parameter in parameters if is_described(parameter)]
        self.defaults, self.min, self.max = (
            {one["name"]: one[key] for one in described} for key in ("default", "min", "max")
        )
        self.config_description = {
            "name": "Default",
            "type": "",
            "state": True,
            "cstate": "true",
            "id": 0,
            "parent": 0,
            "parentname": "",
            "parentclass": "",
            "class": "DEFAULT",
            "field": "default",
            "upper": "DEFAULT",
            "lower": "groups",
            "parameters": described,
            "groups": [],
        }


def _description(parameter: Parameter) -> Dict[str, Any]:
    low, high = _limits(parameter)
    return {
        "name": parameter.name,
        "type": _TYPES[type(parameter.default)],
        "default": parameter.default,
        "min": low,
        "max": high,
        "level": 1,
        "description": parameter.description,
        "edit_method": _edit_method(parameter),
    }


def is_described(parameter: Parameter) -> bool:
    """Whether dynamic_reconfigure has a type for the values of this parameter."""
    return type(parameter.default) in _TYPES


def _limits(parameter: Parameter) -> Tuple[Value, Value]:
    kind = type(parameter.default)
    if kind is bool:
        return False, True
    if kind is str:
        return "", ""
    low, high = _INT_LIMITS if kind is int else (-math.inf, math.inf)
    low = low if parameter.minimum is None else parameter.minimum
    high = high if parameter.maximum is None else parameter.maximum
    if kind is int:
        low, high = max(low, _INT_LIMITS[0]), min(high, _INT_LIMITS[1])
    return kind(low), kind(high)


def _edit_method(parameter: Parameter) -> str:
    """The text that makes rqt_reconfigure and dynparam offer the choices by their names."""
    if not parameter.choices:
        return ""
    constants: List[Dict[str, Any]] = [
        {
            "name": choice or "none",
            "type": "str",
            "value": choice,
            "description": "",
            "ctype": "std::string",
            "cconsttype": "const char * const",
            "srcline": 0,
            "srcfile": "",
        }
        for choice in parameter.choices
    ]
    return repr({"enum": constants, "enum_description": parameter.description})
