"""Changes of the layers (or face attributes) of a map file by a command."""
from typing import Iterable, List

from mesh_msgs_hdf5.formats.any_mesh import Members
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.schema import check_layer_name


def names_of(file: Members, face: bool) -> List[str]:
    """The names of the layers, or of the face attributes."""
    return file.face_attribute_names() if face else file.layer_names()


def copied(file: Members, source: Members, name: str, new: str, face: bool, force: bool) -> Edit:
    """A layer of source, which has the same geometry as file, as layer new of file.

    force: it may replace one. Raises MapFileError.
    """
    _check_there(source, name, face)
    if not force:
        _check_new(file, new, face, "use --force to replace it")
    if source.path != file.path and source.uuid != file.uuid:
        message = "its geometry is another than that of %s" % source.path
        raise MapFileError("uuid", file.path, message, "a layer belongs to one geometry")
    edit = Edit()
    _set(edit, source, name, new, face)
    return edit


def deleted(file: Members, names: Iterable[str], face: bool) -> Edit:
    """Layers removed. Raises MapFileError."""
    edit = Edit()
    for name in names:
        _check_there(file, name, face)
        (edit.face_attributes if face else edit.vertex_costs)[name] = None
    return edit


def renamed(file: Members, old: str, new: str, face: bool) -> Edit:
    """A layer with another name. Raises MapFileError."""
    _check_there(file, old, face)
    _check_new(file, new, face, "delete it first, or choose another name")
    edit = Edit()
    _set(edit, file, old, new, face)
    (edit.face_attributes if face else edit.vertex_costs)[old] = None
    return edit


def _set(edit, source, name, new, face):
    if face:
        edit.face_attributes[new] = source.face_attribute(name)
        edit.face_parameters[new] = source.face_parameters(name)
    else:
        edit.vertex_costs[new] = source.vertex_costs(name)
        edit.layer_parameters[new] = source.layer_parameters(name)


def _what(face):
    return "face attribute" if face else "layer"


def _check_there(file, name, face):
    known = names_of(file, face)
    if name not in known:
        hint = "there are: " + ", ".join(known) if known else "the mesh has none"
        message = "there is no %s %r" % (_what(face), name)
        raise MapFileError("layer", file.path, message, hint)


def _check_new(file, name, face, hint):
    check_layer_name(file.path, name)
    if name in names_of(file, face):
        message = "there is a %s %r already" % (_what(face), name)
        raise MapFileError("exists", file.path, message, hint)
