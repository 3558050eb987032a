"""Changes of a map, put together and taken apart."""
import dataclasses
from typing import Any, Dict

from mesh_msgs_hdf5.edit import Edit

_SINGLE = ("vertex_normals", "vertex_colors", "texture_coordinates", "materials", "features")


def merged(first: Edit, second: Edit) -> Edit:
    """One change that does what the two do one after the other."""
    values: Dict[str, Any] = {}
    for field in dataclasses.fields(Edit):
        old, new = getattr(first, field.name), getattr(second, field.name)
        if isinstance(new, dict) and field.name != "source":
            values[field.name] = {**old, **new}
        else:
            values[field.name] = old if new is None else new
    for costs, parameters in (
        ("vertex_costs", "layer_parameters"),
        ("face_attributes", "face_parameters"),
    ):
        # new values without parameters: the ones before were not computed like this
        lost = set(getattr(second, costs)) - set(getattr(second, parameters))
        values[parameters] = {k: v for k, v in values[parameters].items() if k not in lost}
    given = {name for name in _SINGLE if getattr(second, name) is not None}
    values["remove"] = (first.remove - given) | second.remove
    values.update(dict.fromkeys(second.remove))
    return Edit(**values)


def without(edit: Edit, done: Edit) -> Edit:
    """What of a change is left where `done`, an earlier state of it, has been made."""
    values: Dict[str, Any] = {}
    for field in dataclasses.fields(Edit):
        now, then = getattr(edit, field.name), getattr(done, field.name)
        if field.name == "remove":
            values[field.name] = now - then
        elif isinstance(now, dict) and field.name != "source":
            values[field.name] = {
                key: value
                for key, value in now.items()
                if key not in then or then[key] is not value
            }
        else:
            values[field.name] = None if now is then else now
    return Edit(**values)


def is_empty(edit: Edit) -> bool:
    """True if the change changes nothing."""
    return all(
        value is None or (isinstance(value, (dict, frozenset)) and not value)
        for value in vars(edit).values()
    )
