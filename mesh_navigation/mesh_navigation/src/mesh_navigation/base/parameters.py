"""Reading parameters that a class declares from what the user gave."""

from typing import Any, Dict, List, Mapping, Sequence, Tuple

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, Value


def read_parameters(
    parameters: Sequence[Parameter], given: Mapping[str, Any]
) -> Tuple[Dict[str, Value], List[str]]:
    """The value of every parameter, and one sentence for each given value not used as it is.

    A number beyond its limits is moved to the limit, as dynamic_reconfigure does and configurations
    in the field rely on; in place of a value of another type the default is used. Names that are no
    parameter are left alone: users keep settings of other programs there.
    """
    defaults = {parameter.name: parameter.default for parameter in parameters}
    return _replaced(parameters, defaults, given, "the default {!r} is used")


def changed_parameters(
    parameters: Sequence[Parameter], present: Mapping[str, Value], given: Mapping[str, Any]
) -> Tuple[Dict[str, Value], List[str]]:
    """As `read_parameters`, for values that change: what is not given, or wrong, stays as it is.

    Args:
        parameters: all that the class declares.
        present: their values now.
        given: what shall change.
    """
    return _replaced(parameters, present, given, "it stays {!r}")


def _replaced(
    parameters: Sequence[Parameter],
    present: Mapping[str, Value],
    given: Mapping[str, Any],
    otherwise: str,
) -> Tuple[Dict[str, Value], List[str]]:
    values = dict(present)
    complaints = []
    for parameter in parameters:
        name = parameter.name
        if name not in given:
            continue
        try:
            values[name], complaint = parameter.checked(given[name])
        except MeshMapError as error:
            complaint = f"{error}: {otherwise.format(present[name])}"
        if complaint:
            complaints.append(complaint)
    return values, complaints
