"""A second part of a map file, for LVR2 alone, beside the one that hdf5_map_io reads.

LVR2's MeshIO (up to 2024-11) takes every child of textures for an image, and hdf5_map_io wants the
groups and tables there that MeshIO ends over. No one group suits both; but MeshIO is told the name
of its part, and hdf5_map_io always reads /mesh. The vertices, faces and layers are stored once,
under the names of both parts; pictures twice, for LVR2 declares their width first.
"""
import h5py

from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import is_dataset_of_this_file
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter, free
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.map_file.writing.texture_writer import LVR2_MATERIALS, TextureWriter
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.mesh import Mesh


def lvr2_part_name(part: str) -> str:
    """The name of the part for LVR2 beside this one."""
    return "%s_lvr2" % (part or "mesh")


def write_lvr2_part(writer: ObjectWriter, file: h5py.File, part: str, mesh: Mesh) -> str:
    """Write it of a part that is in the file; returns its name.

    It takes the place of one that was written before, and of nothing else.
    """
    way, _, name = lvr2_part_name(part).rpartition("/")
    above = file["/" + way]
    there = above.get(name)
    if isinstance(there, h5py.Group) and there.attrs.get(schema.LVR2_PART_OF) is not None:
        writer.remove(above, name)
    group = writer.group(above, name if name not in above else free(above, name))
    for key, text in schema.LVR2_ATTRIBUTES.items():
        writer.attribute(group, key, text)
    writer.text(group, schema.LVR2_PART_OF, part or "/")
    writer.text(group, schema.UUID, mesh.uuid)
    PartWriter(writer, group).header(mesh.frame_id, mesh.origin, mesh.crs)
    channels = writer.group(group, schema.CHANNELS)
    stored = file["/" + part][schema.CHANNELS]
    for key in stored:
        if is_dataset_of_this_file(stored, key):
            writer.further_name(stored[key], channels, key)
    for key in (schema.TEXTURES, LVR2_MATERIALS):
        writer.group(group, key)
    textures = TextureWriter(writer, group, lvr2=True)
    if mesh.texture_coordinates is not None:
        textures.coordinates(mesh.texture_coordinates)
    textures.textures(mesh.textures)
    if mesh.materials is not None:
        textures.materials(mesh.materials)
    writer.note(
        "LVR2 reads the part %s, hdf5_map_io the part %s: name it to LVR2's programs; it stays as "
        "it is when the map is edited (convert --for both makes it anew)",
        group.name[1:],
        part or "/",
    )
    return str(group.name[1:])
