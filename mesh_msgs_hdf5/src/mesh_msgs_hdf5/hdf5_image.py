"""Builds the bytes of a map file in memory, and verifies them by reading them again."""
from typing import Dict, Optional, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.check import identical, to_json
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.hdf5_files import building, image_of, reading_image
from mesh_msgs_hdf5.hdf5_guard import children
from mesh_msgs_hdf5.map_reader import MapReader
from mesh_msgs_hdf5.mesh import Mesh

# rows of a chunk: small enough for HDF5's chunk cache (1 MiB), large enough to compress as well as
# one big chunk
CHUNK_ROWS = 32768
_MAX_FIXED_BYTES = 60_000  # HDF5 allows 64 kB for an attribute and what describes it
# deflate is read by every HDF5; levels above 1 cost time and gain 1 %
_STORED = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def mesh_image(path: PathLike, mesh: Mesh, part: str) -> bytes:
    """The bytes of a new map file with this mesh (as check.checked_mesh returns it).

    Path is for errors.
    """
    with building(path) as file:
        group = file
        for name in schema.part_path(path, part):
            group = group.create_group(name)
        for name in schema.GROUPS:
            group.create_group(name)
        for name, text in schema.LVR2_ATTRIBUTES.items():
            group.attrs[name] = text
        group.attrs[schema.SCHEMA_VERSION] = np.int32(schema.VERSION)
        _store_text(group, schema.FRAME_ID, mesh.frame_id)
        _store_text(group, schema.UUID, mesh.uuid)
        _store_text(group, schema.SOURCE, to_json(path, schema.SOURCE, mesh.source))
        channels = group[schema.CHANNELS]
        for name, array in (
            (schema.VERTICES, mesh.vertices),
            (schema.FACES, mesh.faces),
            (schema.NORMALS, mesh.vertex_normals),
            (schema.COLORS, mesh.vertex_colors),
        ):
            if array is not None:
                _store(channels, name, array)
        for name, costs in mesh.vertex_costs.items():
            _store_layer(path, channels, name, costs, mesh.layer_parameters.get(name))
        image = image_of(file)
    _verify(path, image, part, mesh)
    return image


def image_with_layers(
    path: PathLike,
    source: h5py.File,
    part: str,
    layers: Dict[str, Tuple[np.ndarray, Optional[dict]]],
) -> bytes:
    """The bytes of the open file `source` with these layers added or replaced.

    layers: {name: ((V,) float32, parameters)}.

    Everything else is copied as it is stored: unknown groups, attributes, compressed chunks, links
    (not followed).
    """
    components = schema.part_path(path, part) + [schema.CHANNELS]
    with building(path) as file:
        old, new = source["/"], file["/"]
        for depth in range(len(components) + 1):
            _copy_attributes(old, new)
            inner = components[depth] if depth < len(components) else None
            replaced = {inner} if inner else set(layers)
            _copy_children(path, old, new, replaced)
            if inner:
                old, new = old[inner], new.create_group(inner)
        for name, (costs, parameters) in layers.items():
            _store_layer(path, new, name, costs, parameters)
        image = image_of(file)
    expected = MapReader(source, path, part).mesh()
    for name, (costs, parameters) in layers.items():
        expected.vertex_costs[name] = costs
        expected.layer_parameters[name] = parameters or {}
    _verify(path, image, part, expected, source)
    return image


def _store(group, name, array):
    chunks = (min(len(array), CHUNK_ROWS),) + array.shape[1:]
    return group.create_dataset(name, data=array, chunks=chunks, **_STORED)


def _store_layer(path, channels, name, costs, parameters):
    stored = _store(channels, name, costs.reshape(-1, 1))
    if parameters:
        text = to_json(path, "%s of layer %s" % (schema.PARAMETERS, name), parameters)
        _store_text(stored, schema.PARAMETERS, text)


def _store_text(owner, name, text):
    """Store an attribute of fixed length, UTF-8.

    Those of variable length lie in a heap, on whose damage HDF5 1.10 loops for ever.
    """
    data = text.encode("utf-8")
    if len(data) > _MAX_FIXED_BYTES:
        owner.attrs[name] = text
    else:
        owner.attrs.create(name, data, dtype=h5py.string_dtype("utf-8", len(data)))


def _copy_children(path, old, new, replaced):
    for name in children(path, old):
        key = name.encode("utf-8")
        if name in replaced:
            continue
        kind = old.id.links.get_info(key).type
        if kind == h5py.h5l.TYPE_HARD:
            h5py.h5o.copy(old.id, key, new.id, key)
        elif kind == h5py.h5l.TYPE_SOFT:
            new[name] = h5py.SoftLink(old.id.links.get_val(key).decode("utf-8", "surrogateescape"))
        elif kind == h5py.h5l.TYPE_EXTERNAL:
            link = old.get(name, getlink=True)
            new[name] = h5py.ExternalLink(link.filename, link.path)
        else:
            raise MapFileError(
                "link", path, "%s is a link of an unknown kind" % old[name].name, "remove it first"
            )


def _copy_attributes(old, new):
    """Bit for bit, whatever the type: only the type's own conversion to memory and back is used."""
    for index in range(h5py.h5a.get_num_attrs(old.id)):
        source = h5py.h5a.open(old.id, index=index)
        target = h5py.h5a.create(new.id, source.name, source.get_type(), source.get_space())
        if source.get_space().get_simple_extent_type() != h5py.h5s.NULL:
            values = np.zeros(source.shape, dtype=source.dtype)
            source.read(values)
            target.write(values)


def _texts(path, parameters):
    return {name: to_json(path, name, value) for name, value in parameters.items() if value}


def _verify(path, image, part, mesh, source=None):
    """Read an image again; refuse it unless it holds exactly this mesh and all names of source."""
    with reading_image(image, path) as file:
        reader = MapReader(file, path, part)
        found = reader.mesh()
        same = all(
            identical(getattr(found, name), getattr(mesh, name))
            for name in ("vertices", "faces", "vertex_normals", "vertex_colors")
        )
        same &= set(found.vertex_costs) == set(mesh.vertex_costs)
        same = same and all(
            identical(found.vertex_costs[name], costs) for name, costs in mesh.vertex_costs.items()
        )
        same &= found.frame_id == mesh.frame_id
        same &= _texts(path, found.layer_parameters) == _texts(path, mesh.layer_parameters)
        if source is not None:
            old, new = source["/"], file["/"]
            for name in schema.part_path(path, part) + [schema.CHANNELS]:
                same &= set(children(path, old)) <= set(children(path, new))
                same &= set(old.attrs) == set(new.attrs)
                old, new = old[name], new[name]
    if not same:
        raise MapFileError(
            "save", path, "the new file does not read back as what was to be saved", "report this"
        )
