"""How a declared parameter is written: its default, and its range."""
import math
from typing import Any, Iterable, List, Sequence, Tuple

from mesh_map.base.parameter import Parameter

from mesh_tools_test.reference.markdown import code, plain, table

HEADER = ("parameter", "type", "default", "range", "meaning")
_TYPES = {bool: "bool", int: "int", float: "float", str: "string", tuple: "list", dict: "dict"}


def value_text(value: Any) -> str:
    """A value as YAML has it; a number with seven digits at most."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return ("%.7g" % value) if value != int_or_none(value) else "%.1f" % value
    if isinstance(value, str):
        return value or '""'
    if isinstance(value, tuple):
        return "[%s]" % ", ".join(value_text(one) for one in value)
    return str(value)


def int_or_none(value: float) -> Any:
    """A float as a whole number, None where it is none."""
    return int(value) if math.isfinite(value) and value == int(value) else None


def range_text(parameter: Parameter) -> str:
    """Its limits, or its choices; "" where it has neither."""
    if parameter.choices:
        return ", ".join(parameter.choices)
    if parameter.minimum is None and parameter.maximum is None:
        return ""
    low = "-inf" if parameter.minimum is None else "%.7g" % parameter.minimum
    high = "inf" if parameter.maximum is None else "%.7g" % parameter.maximum
    return "%s to %s" % (low, high)


def parameter_table(parameters: Iterable[Tuple[str, Parameter]]) -> str:
    """A row for each, by the name that it has where it is used, with the columns of HEADER."""
    rows: List[Sequence[str]] = [
        (
            code(name),
            _TYPES[type(parameter.default)],
            code(value_text(parameter.default)),
            plain(range_text(parameter)),
            plain(parameter.description),
        )
        for name, parameter in parameters
    ]
    return table(HEADER, rows)
