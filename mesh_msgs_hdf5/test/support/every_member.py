"""All that a MapFile offers, whatever that is, for tests that hold for each member."""
from typing import Any, Callable, Iterator, Tuple

from mesh_msgs_hdf5.map_file import MapFile

WRITING = {"update", "write_layers", "write"}
WRITING |= {"write_part", "rename_part", "delete_part", "copy_part"}
# of the methods that need some; in the file of the fixture rich_mesh
ARGUMENTS = {
    "vertex_costs": ["height_diff"],
    "layer_parameters": ["height_diff"],
    "vertex_attribute": ["SIFT"],
    "vertex_parameters": ["SIFT"],
    "face_attribute": ["cost"],
    "face_parameters": ["cost"],
    "label": ["tree_1"],
    "texture": [0],
}


def public_names(file: MapFile) -> list:
    """The names of all attributes, properties and methods, sorted."""
    names = {*vars(MapFile), *vars(file)}
    return sorted(name for name in names if not name.startswith("_"))


def reading_members(file: MapFile) -> Iterator[Tuple[str, Callable[[], Any]]]:
    """(name, function that reads it) of each member that reads the file."""
    for name in public_names(file):
        if name not in WRITING:
            yield name, lambda name=name: _value(file, name)


def _value(file, name):
    value = getattr(file, name)
    return value(*ARGUMENTS.get(name, [])) if callable(value) else value
