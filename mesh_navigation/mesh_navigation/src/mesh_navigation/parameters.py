"""Reading parameters that a class declares from what the user gave."""

from typing import Any, Dict, List, Mapping, Sequence, Tuple

from mesh_map.errors import MeshMapError
from mesh_map.parameter import Parameter, Value


def read_parameters(
    parameters: Sequence[Parameter], given: Mapping[str, Any]
) -> Tuple[Dict[str, Value], List[str]]:
    """The value of every parameter, and one sentence for each given value not used as it is.

    A number beyond its limits is moved to the limit, as dynamic_reconfigure does and configurations
    in the field rely on; in place of a value of another type the default is used. Names that are no
    parameter are left alone: users keep settings of other programs there.
    """
    values: Dict[str, Value] = {}
    complaints = []
    for parameter in parameters:
        try:
            value, complaint = parameter.checked(given.get(parameter.name, parameter.default))
        except MeshMapError as error:
            value = parameter.default
            complaint = f"{error}: the default {value!r} is used"
        values[parameter.name] = value
        if complaint:
            complaints.append(complaint)
    return values, complaints
