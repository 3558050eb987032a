"""Small files that would take all memory or time: refused, with little of both.

Each is read in a process with an address space of MEMORY and an alarm; what it really took is
measured.
"""
import struct
import zlib

import h5py
import numpy as np
import pytest
from every_member import reading_members
from forked import outcomes

from mesh_msgs_hdf5.isolation import IsolatedMapFile
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5.hdf5_storage import RATIO_FREE_BYTES
from mesh_msgs_hdf5.model.errors import MapFileError

MEMORY = 1 << 30
MOST = 200 << 20


def replaced(group, name, **arguments):
    """A new dataset in the place of one."""
    if name in group:
        del group[name]
    return group.create_dataset(name, **arguments)


def declared(file):
    """12 TiB in 6 kB."""
    replaced(file["mesh/channels"], "vertices", shape=(1 << 40, 3), dtype="f4")


def declared_in_chunks(file):
    replaced(file["mesh/channels"], "vertices", shape=(1 << 40, 3), dtype="f4", chunks=(1 << 16, 3))


def overflowing(file):
    """Its number of bytes is 2^64 + 24, which is 24 to those who do not look."""
    rows = ((1 << 64) + 24) // 12 // 2 * 2
    replaced(file["mesh/channels"], "vertices", shape=(rows, 3), dtype="f4", chunks=(1 << 16, 3))


def deflated_zeros(file, name="vertices", size=4 << 30):
    """A thousandth of what it declares, all of it there."""
    rows, chunk = size // 12 // (1 << 20) * (1 << 20), 1 << 20
    dataset = replaced(
        file["mesh/channels"],
        name,
        shape=(rows, 3),
        dtype="f4",
        chunks=(chunk, 3),
        compression="gzip",
    )
    data = zlib.compress(bytes(12 * chunk), 9)
    for start in range(0, rows, chunk):
        dataset.id.write_direct_chunk((start, 0), data)


def deflated_layers(file):
    """Each small enough, but many."""
    replaced(file["mesh/channels"], "vertices", data=np.zeros((1 << 20, 3), "f4"))
    del file["mesh/channels/vertex_normals"], file["mesh/channels/vertex_colors"]
    deflated = zlib.compress(bytes(4 << 20), 9)
    for i in range(700):
        layer = file["mesh/channels"].create_dataset(
            "layer_%d" % i,
            shape=(1 << 20, 1),
            dtype="f4",
            chunks=(1 << 20, 1),
            compression="gzip",
        )
        layer.id.write_direct_chunk((0, 0), deflated)


def one_array_with_many_names(file):
    channels = file["mesh/channels"]
    channels["costs"] = np.zeros((40, 1), "f4")
    for i in range(60_000):
        channels.id.links.create_hard(b"layer_%d" % i, channels.id, b"costs")


def huge_chunk(file):
    """Whoever reads one number has to take memory for all."""
    dataset = replaced(
        file["mesh/channels"],
        "vertices",
        shape=(40, 3),
        dtype="f4",
        chunks=(100 << 20, 3),
        maxshape=(None, 3),
        compression="gzip",
    )
    dataset.id.write_direct_chunk((0, 0), zlib.compress(bytes(1000)))


def many_groups(file):
    """In the group of the mesh."""
    group = file["mesh"]
    for i in range(100_000):
        group.id.links.create_hard(b"g%d" % i, group.id, b"clustersets")


def many_groups_at_the_top(file):
    file.create_group("g")
    for i in range(100_000):
        file.id.links.create_hard(b"g%d" % i, file.id, b"g")


def deep_groups(file):
    group = file
    for _ in range(10_000):
        group = group.create_group("mesh" if group is file and "mesh" not in file else "g")


def deep_mesh(file):
    """The only mesh is below 10^4 groups."""
    file.move("mesh", "kept")
    group = file
    for _ in range(10_000):
        group = group.create_group("g")
    group["mesh"] = file["kept"]
    del file["kept"]


def many_labels(file):
    """10^5, half of them in one class."""
    labels = file["mesh"].require_group("labels")
    for name in ("tree", "house"):
        group = labels.require_group(name)
        group["x"] = np.arange(3, dtype="u4")
        for i in range(50_000):
            group.id.links.create_hard(b"%d" % i, group.id, b"x")


def labels_times_labels(file):
    """10^6 by 2000 links: a thousand names for a class with a thousand instances."""
    labels = file["mesh"].require_group("labels")
    group = labels.create_group("tree")
    group["0"] = np.arange(3, dtype="u4")
    for i in range(1, 1000):
        group.id.links.create_hard(b"%d" % i, group.id, b"0")
        labels.id.links.create_hard(b"tree%d" % i, labels.id, b"tree")


def huge_labels(file):
    """10,000 times the same face list, 1 MB long."""
    group = file["mesh"].require_group("labels").create_group("tree")
    group["0"] = np.zeros(1 << 18, "u4")
    for i in range(1, 10_000):
        group.id.links.create_hard(b"%d" % i, group.id, b"0")


def many_attributes(file):
    space = h5py.h5s.create(h5py.h5s.SCALAR)
    for i in range(100_000):
        h5py.h5a.create(file["mesh"].id, b"a%d" % i, h5py.h5t.STD_I8LE, space)


def huge_attribute(file):
    file["mesh"].attrs["source"] = np.zeros(40 << 20, "u1")


def huge_text(file):
    file["mesh"].attrs["source"] = np.bytes_(b"x" * (40 << 20))


def wild_length(file):
    """See damage(): a text of variable length that says it has 4 GB."""
    del file["mesh"].attrs["frame_id"]
    file["mesh"].attrs["frame_id"] = "a frame of 29 characters here"


def huge_image(file):
    images = file["mesh"].require_group("textures").require_group("images")
    replaced(images, "0", shape=(1 << 20, 1 << 20, 3), dtype="u1", chunks=(512, 512, 3))


def deflated_image(file):
    images = file["mesh"].require_group("textures").require_group("images")
    image = replaced(
        images,
        "0",
        shape=(1 << 15, 1 << 15, 3),
        dtype="u1",
        chunks=(1 << 12, 1 << 12, 3),
        compression="gzip",
    )
    data = zlib.compress(bytes(3 << 24), 9)
    for i in range(8):
        for j in range(8):
            image.id.write_direct_chunk((i << 12, j << 12, 0), data)


def huge_fields(file):
    """A record of materials of 1 GB each."""
    kind = np.dtype(
        {
            "names": ["textureIndex", "r", "g", "b"],
            "formats": ["<i4", "u1", "u1", "u1"],
            "offsets": [0, 4, 5, 6],
            "itemsize": 1 << 30,
        }
    )
    textures = file["mesh"].require_group("textures")
    replaced(textures, "materials", shape=(1 << 10,), dtype=kind)
    replaced(textures, "mat_face_indices", data=np.zeros(60, "u4"))


def huge_number(file):
    """A float of 100 MB."""
    kind = h5py.h5t.IEEE_F32LE.copy()
    kind.set_size(100 << 20)
    space = h5py.h5s.create_simple((40, 3))
    del file["mesh/channels/vertices"]
    h5py.h5d.create(file["mesh/channels"].id, b"vertices", kind, space)


def long_json(file):
    file["mesh"].attrs["source"] = np.bytes_(b"[" * (1 << 19))


def many_features(file):
    group = file["mesh/channels"].require_group("texture_features")
    group["0"] = np.zeros(64, "f4")
    group["0"].attrs["vector"] = np.zeros(3, "f4")
    for i in range(1, 120_000):
        group.id.links.create_hard(b"%d" % i, group.id, b"0")


# the code that reading everything ends with; "good": it cannot be told from a large map
BOMBS = {
    declared: {"size"},
    declared_in_chunks: {"size"},
    overflowing: {"size"},
    deflated_zeros: {"size"},
    deflated_layers: {"size"},
    one_array_with_many_names: {"size"},
    huge_chunk: {"size"},
    many_groups: {"good", "size"},
    many_groups_at_the_top: {"good", "size"},
    deep_groups: {"good"},
    deep_mesh: {"no_mesh", "part"},
    many_labels: {"size"},
    labels_times_labels: {"size"},
    huge_labels: {"size"},
    many_attributes: {"good"},
    huge_attribute: {"size"},
    huge_text: {"size"},
    wild_length: {"damaged", "size", "frame"},
    huge_image: {"size"},
    deflated_image: {"size"},
    huge_fields: {"size", "dtype"},
    huge_number: {"dtype", "size", "damaged"},
    long_json: {"good"},  # left out, with a note
    many_features: {"size"},
}
NEW_FORMAT = {many_attributes, huge_attribute, huge_text, long_json}


def damage(path, bomb):
    """What h5py cannot write."""
    if bomb is wild_length:
        data = path.read_bytes()
        assert data.count(struct.pack("<I", 29)) >= 1
        path.write_bytes(data.replace(struct.pack("<I", 29), struct.pack("<I", 0xFFFFFFFF)))


def read_all(path):
    """[code of read(), codes of all members]; "good" for none."""
    code, codes = "good", set()
    try:
        file = MapFile(path)
    except MapFileError as error:
        return error.code, []
    for name, member in reading_members(file):
        try:
            member()
        except MapFileError as error:
            codes.add(error.code)
            code = error.code if name == "read" else code
    return code, sorted(codes)


@pytest.mark.parametrize("bomb", BOMBS, ids=lambda bomb: bomb.__name__)
def test_bombs_are_refused(tmp_path, full_mesh, bomb):
    path = tmp_path / "a.h5"
    if bomb in NEW_FORMAT:  # the older format has no attribute above 64 kB
        MapFile.write(tmp_path / "old.h5", full_mesh)
        with h5py.File(path, "w", libver="latest") as file:
            with h5py.File(tmp_path / "old.h5") as old:
                for name in old["mesh"]:
                    old.copy("mesh/" + name, file.require_group("mesh"))
                file["mesh"].attrs["schema_version"] = 1
            bomb(file)
    else:
        MapFile.write(path, full_mesh)
        with h5py.File(path, "r+") as file:
            del file["mesh"].attrs["uuid"]
            bomb(file)
    damage(path, bomb)
    ((_, outcome),) = outcomes(read_all, [path], seconds=120, memory=MEMORY)
    assert not isinstance(outcome, str), outcome
    (code, codes), peak = outcome
    print(bomb.__name__, path.stat().st_size, code, codes, "%d MB" % (peak >> 20))
    assert code in BOMBS[bomb] and peak < MOST


def test_a_large_array_that_is_all_there_is_no_bomb(tmp_path, full_mesh):
    """Above the size from which the ratio counts."""
    path = tmp_path / "a.h5"
    MapFile.write(path, full_mesh)
    rows = RATIO_FREE_BYTES // 12 + 1
    noise = np.random.default_rng(3).integers(0, 256, 12 << 16, np.uint8).tobytes()
    with h5py.File(path, "r+") as file:
        del file["mesh"].attrs["uuid"]
        dataset = replaced(
            file["mesh/channels"], "vertices", shape=(rows, 3), dtype="f4", chunks=(1 << 16, 3)
        )
        finite = (np.frombuffer(noise, "<u4") & 0x3FFFFFFF).tobytes()
        for start in range(0, rows, 1 << 16):
            dataset.id.write_direct_chunk((start, 0), finite)
    shape = IsolatedMapFile(path).vertices.shape
    assert shape == (rows, 3)
