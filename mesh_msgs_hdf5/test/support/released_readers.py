"""Map files read as the released programs read them, with plain h5py, from their interfaces alone.

Where one of them ends or reads past an array, ReaderEnds is raised.
"""
import h5py
import numpy as np

_NATIVE = {np.dtype(t) for t in ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")}


class ReaderEnds(Exception):
    """What would have been an exception that nobody catches, or worse."""


def _is(group, io, kind):
    """LVR2 compares the type of an attribute, too: texts of variable length alone."""
    for name, expected in (("IO", io), ("CLASS", kind)):
        if name not in group.attrs:
            return False
        what = group.attrs.get_id(name).get_type()
        if not what.is_variable_str() or group.attrs[name] != expected:
            return False
    return True


def _channels(group):
    """Every dataset of LVR2's number types; it asks each for its second dimension."""
    found = {}
    for name in group:
        if isinstance(group[name], h5py.Dataset) and group[name].dtype in _NATIVE:
            if group[name].ndim != 2:
                raise ReaderEnds("%s has %d dimensions" % (group[name].name, group[name].ndim))
            if group[name].size:
                found[name] = group[name][()]
    return found


def lvr2_mesh_io(path, part, geometry):
    """MeshIO::load of LVR2: (channels, index -> image, (handles, colors)); None: no mesh.

    geometry: "channels" until 2024-11, "geometry" since.
    """
    with h5py.File(path, "r") as file:
        if part not in file or not _is(file[part], "MeshIO", "MeshBuffer"):
            return None
        group = file[part]
        if geometry not in group:
            return None
        channels, images, materials = _channels(group[geometry]), {}, None
        for name in group.get("textures", ()):
            found = group["textures"][name]
            if not isinstance(found, h5py.Dataset):
                raise ReaderEnds("%s is no dataset" % found.name)
            if found.dtype.names:
                raise ReaderEnds("%s is no array of bytes" % found.name)
            if found.ndim == 3:
                width, height, planes = found.shape
                images[int(name)] = found[()].reshape(height, width, planes)
        if "texture_handles" in group.get("materials", ()):
            materials = tuple(group["materials"][n][()] for n in ("texture_handles", "rgb_color"))
        return channels, images, materials


def map3d_of_ros2(path):
    """(vertices, faces, colors, normals, layers) as RViz's Map3D of ROS 2 loads /mesh."""
    loaded = lvr2_mesh_io(path, "mesh", "geometry")
    if loaded is None:
        raise ReaderEnds("NO MESH")
    channels = loaded[0]
    with h5py.File(path, "r") as file:
        attributes = file["mesh"].get("vertex_attributes")
        if attributes is None or not _is(attributes, "PointCloudIO", "PointBuffer"):
            raise ReaderEnds("no vertex attributes")
        found = _channels(attributes)
    if not found:
        raise ReaderEnds("nothing in the vertex attributes")
    shape = (len(channels["vertices"]), 1)
    layers = {n: v[:, 0] for n, v in found.items() if v.dtype == np.float32 and v.shape == shape}
    wanted = ("vertices", "face_indices", "vertex_colors", "vertex_normals")
    return tuple(channels.get(name) for name in wanted) + (layers,)


def mesh_map_of_ros2(path, part, layers):
    """(vertices, faces, {layer: (V,)}, vertex normals) as mesh_map of ROS 2 reads them."""
    with h5py.File(path, "r") as file:
        group = file[part]
        geometry, attributes = group["geometry"], group["vertex_attributes"]
        costs = {}
        for name in layers:
            if name in attributes:
                assert attributes[name].dtype == np.float32 and attributes[name].shape[1] == 1
                costs[name] = attributes[name][:, 0]
        normals = attributes["vertex_normals"][()] if "vertex_normals" in attributes else None
        return geometry["vertices"][()], geometry["face_indices"][()], costs, normals


def labels_of_ros2(path, part):
    """class_instance -> faces, from [K,1]."""
    with h5py.File(path, "r") as file:
        labels = file[part].get("labels", {})
        found = {}
        for group in labels:
            for name in labels[group]:
                assert labels[group][name].ndim == 2 and labels[group][name].dtype == np.uint32
                found["%s_%s" % (group, name)] = labels[group][name][:, 0]
        return found


def hdf5_map_io(path):
    """(channels of two dimensions, index -> image, materials, faces' materials) of /mesh."""
    with h5py.File(path, "r") as file:
        channels = file["mesh/channels"]
        two = {n: channels[n][()] for n in channels if getattr(channels[n], "ndim", 0) == 2}
        textures = file["mesh/textures"]
        images = {int(n): textures["images"][n][()] for n in textures.get("images", ())}
        materials = textures["materials"][()] if "materials" in textures else None
        faces = textures["mat_face_indices"][()] if "mat_face_indices" in textures else None
        return two, images, materials, faces
