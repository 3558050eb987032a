"""Applies an Edit to a part of a file that is being built."""
import h5py

from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.map_file.writing.texture_writer import has_lvr2_form
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.label_names import TEXT


def apply_edit(writer: ObjectWriter, part: h5py.Group, reader: MapReader, edit: Edit) -> None:
    """Change the group of a part, which is a copy of that of reader, as checked_edit gave it."""
    members = PartWriter(writer, part, has_lvr2_form(part))
    members.header(edit.frame_id, edit.origin, edit.crs, edit.source)
    channels = part[schema.CHANNELS]
    for name, channel in (("vertex_normals", schema.NORMALS), ("vertex_colors", schema.COLORS)):
        if _is_edited(edit, name):
            writer.remove(channels, channel)
        if getattr(edit, name) is not None:
            members.channel(channel, getattr(edit, name))
    _edit_named(
        *(writer, channels, reader.layer_places),
        *(edit.vertex_costs, edit.layer_parameters),
        *(members.layer, members.parameters),
    )
    _edit_named(
        *(writer, channels, reader.vertex_attribute_places),
        *(edit.vertex_attributes, edit.vertex_parameters),
        *(members.vertex_attribute, members.parameters),
    )
    _edit_named(
        *(writer, part.get(schema.FACE_ATTRIBUTES), reader.face_attribute_places),
        *(edit.face_attributes, edit.face_parameters),
        *(members.face_attribute, members.parameters),
    )
    _edit_textures(members, edit)
    if edit.labels:
        _edit_labels(writer, part, members, reader, edit)
    if _is_edited(edit, "features"):
        _remove_features(writer, channels, reader.own_paths())
    if edit.features is not None:
        members.features(edit.features)


def _is_edited(edit, name):
    return name in edit.remove or getattr(edit, name) is not None


def _edit_named(writer, group, places, arrays, parameters, write, write_parameters):
    """Change layers or attributes in their group, of which those at these places are there."""
    edited = set(arrays) | set(parameters)
    present = {name: way.rpartition("/")[2] for name, way in places.items() if name in edited}
    for name, values in arrays.items():
        if name in present:
            writer.remove(group, present[name])
        if values is not None:
            write(name, values, parameters.get(name))
    for name, value in parameters.items():
        if name not in arrays and name in present:
            write_parameters(group[present[name]], value)


def _edit_textures(members, edit):
    textures = members.textures
    if _is_edited(edit, "texture_coordinates"):
        textures.remove_coordinates()
    if edit.texture_coordinates is not None:
        textures.coordinates(edit.texture_coordinates)
    textures.remove_textures(edit.textures)
    images = {index: image for index, image in edit.textures.items() if image is not None}
    textures.textures(images)
    if _is_edited(edit, "materials"):
        textures.remove_materials()
    if edit.materials is not None:
        textures.materials(edit.materials)


def _edit_labels(
    writer: ObjectWriter,
    part: h5py.Group,
    members: PartWriter,
    reader: MapReader,
    edit: Edit,
) -> None:
    places, groups = reader.label_paths(), set()
    for text in sorted(reader.renamed_labels().difference(edit.labels)):
        # else its name would depend on the labels that are there now
        writer.text(part[schema.LABELS]["/".join(places[text])], TEXT, text)
    for text in edit.labels:
        if text in places:
            group, name = places[text]
            writer.remove(part[schema.LABELS][group], name)
            groups.add(group)
    for text, label in edit.labels.items():
        if label is not None:
            members.label(text, label, places.get(text))
    for name in groups:
        group = part[schema.LABELS][name]
        if not len(group) and not len(group.attrs):
            writer.remove(part[schema.LABELS], name)


def _remove_features(writer, channels, own):
    group = channels.get(schema.FEATURES)
    if isinstance(group, h5py.Group):
        for name in list(group):
            if "%s/%s" % (group.name, name) in own:
                writer.remove(group, name)
