"""The values of an Edit, checked against the file that it is for."""
import dataclasses
import functools
from typing import Any, Dict

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.check import (
    check_names_apart,
    checked_attribute,
    checked_channel,
    checked_costs,
    checked_crs,
    checked_features,
    checked_image,
    checked_label,
    checked_materials,
    checked_object,
    checked_origin,
    checked_texture_coordinates,
)
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.edit import CostsUpdate, Edit
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import check_label
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials

_KINDS = {"materials": Materials, "features": Features, "frame_id": str}
REMOVABLE = ("features", "materials", "texture_coordinates", "vertex_colors", "vertex_normals")


def checked_edit(edit: Edit, reader: MapReader) -> Edit:
    """The Edit with all arrays as the file that is read will have them.

    Features of which there are none become a removal. Raises MapFileError with the path of reader.
    """
    path, vertices, faces = reader.path, reader.vertex_count, reader.face_count
    _check_kinds(path, edit)
    _check_removals(path, edit)
    checked = dataclasses.replace(edit, remove=frozenset(edit.remove))
    for name, kind in (("vertex_normals", schema.NORMALS), ("vertex_colors", schema.COLORS)):
        values = getattr(edit, name)
        if values is not None:
            setattr(checked, name, checked_channel(path, kind, values, vertices))
    layers, attributes = reader.layer_names(), reader.face_attribute_names()
    of_vertices = reader.vertex_attribute_names()
    for check, changes, present in (
        (schema.check_layer_name, edit.vertex_costs, layers),
        (schema.check_vertex_attribute_name, edit.vertex_attributes, of_vertices),
        (schema.check_face_attribute_name, edit.face_attributes, attributes),
        (check_label, edit.labels, reader.label_names() if edit.labels else ()),
    ):
        for name in set(changes).difference(present):
            check(path, name)
    checked.vertex_costs = _each(
        edit.vertex_costs, lambda name, costs: checked_costs(path, name, costs, vertices)
    )
    checked.vertex_costs.update(_updated(path, edit.costs_updates, checked.vertex_costs, reader))
    checked.costs_updates = {}
    for place, count in (("vertex", vertices), ("face", faces)):
        changes = getattr(edit, place + "_attributes")
        values = _each(changes, functools.partial(checked_attribute, path, place), count)
        setattr(checked, place + "_attributes", values)
    check_names_apart(path, edit.vertex_costs, edit.vertex_attributes)  # not even to be removed
    check_names_apart(path, set(edit.vertex_costs).union(layers), edit.vertex_attributes)
    check_names_apart(path, edit.vertex_costs, of_vertices)
    checked.labels = _each(edit.labels, lambda text, label: checked_label(path, text, label, faces))
    checked.textures = _each(edit.textures, lambda index, image: checked_image(path, index, image))
    if edit.texture_coordinates is not None:
        checked.texture_coordinates = checked_texture_coordinates(
            path, edit.texture_coordinates, vertices
        )
    checked.materials = _checked_materials(edit, reader)
    if edit.features is not None:
        checked.features = checked_features(path, edit.features)
        if checked.features is None:
            checked.remove |= {"features"}
    _check_header(path, edit, checked)
    for what, parameters, changes, present in (
        ("layer", edit.layer_parameters, edit.vertex_costs, layers),
        ("vertex attribute", edit.vertex_parameters, edit.vertex_attributes, of_vertices),
        ("face attribute", edit.face_parameters, edit.face_attributes, attributes),
    ):
        _check_parameters(path, what, parameters, changes, present)
    return checked


def _check_kinds(path, edit):
    """Refuse what is no Edit as its class describes it, before it looks like a damaged file."""
    for field in dataclasses.fields(edit):
        name, value = field.name, getattr(edit, field.name)
        kind = dict if field.default is dataclasses.MISSING else _KINDS.get(name)
        if kind is not None and value is not None and not isinstance(value, kind):
            _refuse_kind(path, "%s of the edit" % name, value, kind)
        for key in value if kind is dict else ():
            if not isinstance(key, (int, np.integer) if name == "textures" else str):
                message = "%s of the edit has the key %s" % (name, one_line(repr(key))[:80])
                raise MapFileError("value", path, message, "see the class Edit")
    for text, label in edit.labels.items():
        if label is not None and not isinstance(label, Label):
            _refuse_kind(path, "label %r" % text, label, Label)


def _refuse_kind(path, what, value, kind):
    message = "%s is a %s, not a %s" % (what, type(value).__name__, kind.__name__)
    raise MapFileError("value", path, message, "see the class Edit")


def _each(values: Dict[Any, Any], check, *more: Any) -> Dict[Any, Any]:
    return {
        key: None if value is None else check(key, value, *more) for key, value in values.items()
    }


def _updated(path, updates, costs, reader):
    """The layers of which some values change, as they will be."""
    present = set(reader.layer_names()) if updates else ()
    for name, update in updates.items():
        if not isinstance(update, CostsUpdate):
            _refuse_kind(path, "the update of layer %r" % name, update, CostsUpdate)
        changed = update.changed
        if getattr(changed, "shape", None) != (reader.vertex_count,) or changed.dtype != bool:
            text = "the update of layer %r has no array of %d bools that says which values change"
            text %= name, reader.vertex_count
            raise MapFileError("shape", path, text, "see the class CostsUpdate")
        if costs.get(name) is None:
            text = "layer %r has an update, but no values in vertex_costs" % name
            raise MapFileError("value", path, text, "see the class Edit")
        there = reader.vertex_costs(name) if name in present else None
        yield name, update.applied(costs[name], there)


def _check_removals(path, edit):
    for name in edit.remove:
        if name not in REMOVABLE:
            raise MapFileError(
                "value",
                path,
                "%s cannot be removed" % one_line(repr(name))[:80],
                "one of: %s" % ", ".join(REMOVABLE),
            )
        if getattr(edit, name) is not None:
            raise MapFileError(
                "value", path, "%s are both given and to be removed" % name, "do one of the two"
            )


def _checked_materials(edit, reader):
    """Every material that will be in the file needs its texture there."""
    path, faces = reader.path, reader.face_count
    gone = {index for index, image in edit.textures.items() if image is None}
    if edit.materials is None and not gone or "materials" in edit.remove:
        return None
    textures = (set(reader.texture_indices()) | set(edit.textures)) - gone
    if edit.materials is not None:
        return checked_materials(path, edit.materials, faces, textures)
    present = reader.materials
    if present is not None:
        checked_materials(path, present, faces, textures)
    return None


def _check_header(path: PathLike, edit: Edit, checked: Edit) -> None:
    if edit.frame_id is not None:
        schema.check_frame_id(path, edit.frame_id)
    if edit.origin is not None:
        checked.origin = checked_origin(path, edit.origin)
    if edit.crs is not None:
        checked_crs(path, edit.crs)
    if edit.source is not None:
        checked_object(path, schema.SOURCE, edit.source)


def _check_parameters(path, what, parameters, edited, present):
    for name, value in parameters.items():
        if value is not None:
            checked_object(path, "the parameters of %s %s" % (what, name), value)
        will_be = edited[name] is not None if name in edited else name in present
        if value and not will_be:
            raise MapFileError(
                "layer",
                path,
                "there is no %s %r to have parameters" % (what, name),
                "%ss of this file: %s" % (what, ", ".join(present) or "none"),
            )
