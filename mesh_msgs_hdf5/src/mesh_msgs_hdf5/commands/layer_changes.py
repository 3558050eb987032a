"""Changes of the layers (or attributes) of a map file by a command.

place: "vertex" or "face" for the attributes there; None for layers.
"""
from typing import Iterable, List, NamedTuple, Optional

from mesh_msgs_hdf5.formats.any_mesh import Members
from mesh_msgs_hdf5.model.carried_mesh import not_silent
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.layer_meaning import KEY
from mesh_msgs_hdf5.model.schema import check_layer_name
from mesh_msgs_hdf5.model.seams import split_mesh

Place = Optional[str]


class _Kind(NamedTuple):
    """what: for people; the others: names of members, of an Edit and of a mesh."""

    what: str
    values: str
    parameters: str
    names_of: str
    value_of: str
    parameters_of: str


_KINDS = {
    None: _Kind(
        "layer",
        *("vertex_costs", "layer_parameters"),
        *("layer_names", "vertex_costs", "layer_parameters"),
    )
}
for _place in ("vertex", "face"):
    _KINDS[_place] = _Kind(
        _place + " attribute",
        *(_place + "_attributes", _place + "_parameters"),
        *(_place + "_attribute_names", _place + "_attribute", _place + "_parameters"),
    )


def what(place: Place) -> str:
    """One of them, for people."""
    return _KINDS[place].what


def names_of(file: Members, place: Place) -> List[str]:
    """The names of the layers, or of the attributes."""
    return getattr(file, _KINDS[place].names_of)()


def copied(file: Members, source: Members, name: str, new: str, place: Place, force: bool) -> Edit:
    """A layer of source as layer new of file: they have the same geometry, or one that differs by
    copies of vertices along seams of textures only.

    force: it may replace one. Raises MapFileError.
    """
    _check_there(source, name, place)
    if not force:
        _check_new(file, new, place, "use --force to replace it")
    edit = Edit()
    _set(edit, source, name, new, place)
    if source is not file and source.uuid != file.uuid:
        parents = {each.uuid: each.parent_uuid or each.uuid for each in (source, file)}
        if parents[source.uuid] != parents[file.uuid]:
            message = "its geometry is another than that of %s" % source.path
            raise MapFileError("uuid", file.path, message, "a layer belongs to one geometry")
        if place != "face":
            values = getattr(edit, _KINDS[place].values)
            values[new] = _along_seams(values[new], source, file, place)
            _forget_counts(edit.layer_parameters.get(new))
    return edit


def _along_seams(values, source, file, place):
    """(V_file, ...) of values (V_source, ...): through the mesh without copies, which both have."""
    split = split_mesh(source)
    if split is not None and place is None:
        values = split.parent_vertex_values(values)
    elif split is not None:
        values = values[: split.parent_vertex_count]
    split = split_mesh(file)
    return values if split is None else split.vertex_values(values)


def _forget_counts(parameters):
    """The numbers of lethal and unknown vertices, which are others with other copies."""
    info = (parameters or {}).get(KEY)
    if isinstance(info, dict):
        for key in ("lethal", "unknown"):
            info.pop(key, None)


def deleted(file: Members, names: Iterable[str], place: Place) -> Edit:
    """Layers removed. Raises MapFileError."""
    edit = Edit()
    for name in names:
        _check_there(file, name, place)
        getattr(edit, _KINDS[place].values)[name] = None
    return edit


def renamed(file: Members, old: str, new: str, place: Place) -> Edit:
    """A layer with another name. Raises MapFileError."""
    _check_there(file, old, place)
    _check_new(file, new, place, "delete it first, or choose another name")
    edit = Edit()
    _set(edit, file, old, new, place)
    getattr(edit, _KINDS[place].values)[old] = None
    return edit


def _set(edit, source, name, new, place):
    kind = _KINDS[place]
    getattr(edit, kind.values)[new] = getattr(source, kind.value_of)(name)
    parameters = getattr(source, kind.parameters_of)(name)
    if place is None and new != name:  # the names of some are trusted
        parameters = not_silent(parameters, "another name (%s)" % name)
    getattr(edit, kind.parameters)[new] = parameters


def _check_there(file, name, place):
    known = names_of(file, place)
    if name not in known:
        hint = "there are: " + ", ".join(known) if known else "the mesh has none"
        message = "there is no %s %r" % (what(place), name)
        raise MapFileError("layer", file.path, message, hint)


def _check_new(file, name, place, hint):
    check_layer_name(file.path, name)
    if name in names_of(file, place):
        message = "there is a %s %r already" % (what(place), name)
        raise MapFileError("exists", file.path, message, hint)
