"""Files that point out of themselves, or in a circle: nothing outside is read, nothing goes round.

The secret is a file full of one pattern, which must not come out of any member, nor get into what
is written.
"""
import os

import h5py
import numpy as np
import pytest
from every_member import reading_members

from mesh_msgs_hdf5 import isolation
from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError

SECRET = b"the password"  # 12 bytes, as a row of three floats
OF_EVERY_KIND = [
    "mesh",
    "mesh/channels",
    "mesh/channels/vertices",
    "mesh/channels/face_indices",
    "mesh/channels/vertex_normals",
    "mesh/channels/vertex_colors",
    "mesh/channels/height_diff",
    "mesh/channels/texture_features",
    "mesh/channels/texture_features/0",
    "mesh/face_attributes",
    "mesh/face_attributes/cost",
    "mesh/labels",
    "mesh/labels/tree",
    "mesh/labels/tree/1",
    "mesh/textures",
    "mesh/textures/coords",
    "mesh/textures/materials",
    "mesh/textures/mat_face_indices",
    "mesh/textures/images",
    "mesh/textures/images/0",
    "mesh/unknown",
    "unknown",
]


DATASETS = [
    place
    for place in OF_EVERY_KIND
    if place.endswith(("vertices", "normals", "diff", "/0", "cost", "/1", "coords", "unknown"))
]


@pytest.fixture(scope="module")
def secret_data(tmp_path_factory, rich_data):
    """The bytes of a map of everything that is made of the secret."""
    folder = tmp_path_factory.mktemp("secret")
    rows = np.frombuffer(SECRET * 40, "<f4").reshape(40, 3)
    (folder / "a.h5").write_bytes(rich_data)
    with h5py.File(folder / "a.h5") as file, h5py.File(folder / "secret.h5", "w") as secret:
        file.copy("mesh", secret)  # so that a link leads to what would be read
        for name in ("vertices", "vertex_normals"):
            secret["mesh/channels/" + name][...] = rows
        secret["unknown"] = rows
        secret["mesh/unknown"] = rows
    return (folder / "secret.h5").read_bytes()


@pytest.fixture
def whole(tmp_path, rich_data, secret_data):
    """A map of everything, in a folder with the secret in every form."""
    (tmp_path / "secret.txt").write_bytes(SECRET * 4000)
    (tmp_path / "secret.h5").write_bytes(secret_data)
    (tmp_path / "a.h5").write_bytes(rich_data)
    return tmp_path / "a.h5"


def in_place(file, place, link):
    """A link in the place of an object."""
    if place in file:
        del file[place]
    file[place] = link


def external_link(file, place, folder):
    in_place(file, place, h5py.ExternalLink(str(folder / "secret.h5"), "/" + place))


def soft_link_to_external(file, place, folder):
    file["way"] = h5py.ExternalLink(str(folder / "secret.h5"), "/")
    in_place(file, place, h5py.SoftLink("/way/" + place))


def soft_link_to_itself(file, place, folder):
    in_place(file, place, h5py.SoftLink("/" + place))


def soft_links_in_a_circle(file, place, folder):
    file["other"] = h5py.SoftLink("/" + place)
    in_place(file, place, h5py.SoftLink("/other"))


def dangling_link(file, place, folder):
    in_place(file, place, h5py.SoftLink("/no/where"))


LINKS = [external_link, soft_link_to_external]
TO_NOWHERE = [soft_link_to_itself, soft_links_in_a_circle, dangling_link]  # by turns
PLACED = [(place, link) for place in OF_EVERY_KIND for link in LINKS]
PLACED += [(place, TO_NOWHERE[i % len(TO_NOWHERE)]) for i, place in enumerate(OF_EVERY_KIND)]


def look_everywhere(path, strict=True):
    """Reads all members; {name: code of its error, or "good"}."""
    try:
        file = MapFile(path, strict=strict)
    except MapFileError as error:
        return {"opening": error.code}
    found = {}
    for name, member in reading_members(file):
        try:
            assert SECRET not in b"".join(bytes_in(member())), name
            found[name] = "good"
        except MapFileError as error:
            found[name] = error.code
            assert SECRET.decode() not in str(error)
    return found


def bytes_in(value):
    """The bytes of all arrays and texts in a value."""
    if isinstance(value, np.ndarray):
        yield value.tobytes()
    elif isinstance(value, str):
        yield value.encode("utf-8", "surrogateescape")
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from bytes_in(key)
            yield from bytes_in(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from bytes_in(item)
    elif hasattr(value, "__dataclass_fields__"):
        yield from bytes_in(vars(value))


def write_again(path):
    """All that writes a new file from an old one."""
    for function in (
        lambda: MapFile(path).write_layers({"new": (np.ones(40, np.float32), None)}),
        lambda: isolated("convert", path, path.parent / "converted.h5"),
        lambda: isolated("repack", path, path.parent / "repacked.h5"),
    ):
        try:
            function()
        except MapFileError as error:
            assert error.code != "crashed", error
    for name in ("a.h5", "converted.h5", "repacked.h5"):
        place = path.parent / name
        if place.exists():
            yield place


def test_the_secret_would_be_seen(whole):
    """What these tests look for is there to be found."""
    assert SECRET in b"".join(bytes_in(MapFile(whole.parent / "secret.h5").vertex_normals))
    with h5py.File(whole, "r+") as file:
        external_link(file, "mesh/channels/vertex_normals", whole.parent)
        assert SECRET in file["mesh/channels/vertex_normals"][()].tobytes()


@pytest.mark.parametrize("place,link", PLACED, ids=lambda value: getattr(value, "__name__", value))
def test_no_link_is_followed(whole, place, link):
    with h5py.File(whole, "r+") as file:
        link(file, place, whole.parent)
    found = look_everywhere(whole)
    kinds = set(found.values())
    assert kinds <= {"good", "link", "part", "no_mesh", "layer", "label", "index", "value"}, found
    if place in ("mesh/channels/vertices", "mesh/channels/face_indices"):
        assert found == {"opening": "link"}
    elif place in ("mesh/textures/coords", "mesh/textures/materials", "mesh/textures"):
        assert found["read"] == "link" and found["vertices"] == "good"
    elif place.startswith("mesh/channels/vertex"):
        assert found.get("read", found.get("opening")) == "link"
    tolerant = look_everywhere(whole, strict=False)  # leaves it out, and does not follow it either
    assert set(tolerant.values()) <= kinds | {"good", "index", "layer", "label"}, tolerant
    if "opening" not in found:
        assert tolerant["read"] == "good", tolerant
    if link is not external_link and place not in ("unknown", "mesh/channels/vertex_normals"):
        return
    for new in write_again(whole):
        assert SECRET not in new.read_bytes()
        with h5py.File(new) as file:
            kept = [file.get(place, getlink=True)] if place in file else []
            assert not [link for link in kept if getattr(link, "filename", "").endswith(".txt")]


def external_storage(file, place, folder):
    parent, _, name = place.rpartition("/")
    in_place_of(file, place)
    (file[parent] if parent else file).create_dataset(
        name, shape=(40, 3), dtype="f4", external=[(str(folder / "secret.txt"), 0, 480)]
    )


def external_storage_relative(file, place, folder):
    parent, _, name = place.rpartition("/")
    in_place_of(file, place)
    (file[parent] if parent else file).create_dataset(
        name, shape=(40, 3), dtype="f4", external=[("secret.txt", 0, 480)]
    )


def virtual_dataset(file, place, folder):
    parent, _, name = place.rpartition("/")
    in_place_of(file, place)
    layout = h5py.VirtualLayout((40, 3), "f4")
    layout[:] = h5py.VirtualSource(
        str(folder / "secret.h5"), "mesh/channels/vertex_normals", shape=(40, 3)
    )
    (file[parent] if parent else file).create_virtual_dataset(name, layout)


def in_place_of(file, place):
    if place in file:
        del file[place]


@pytest.mark.parametrize(
    "storage,code",
    [(external_storage, "external"), (external_storage_relative, "external")]
    + [(virtual_dataset, "virtual")],
    ids=lambda value: getattr(value, "__name__", value),
)
@pytest.mark.parametrize("place", DATASETS)
def test_nothing_stored_elsewhere_is_read(whole, place, storage, code):
    with h5py.File(whole, "r+") as file:
        storage(file, place, whole.parent)
    found = look_everywhere(whole)
    assert code in found.values() or not {"external", "virtual"} & set(found.values())
    tolerant = look_everywhere(whole, strict=False)
    assert (
        tolerant.get("read", "good") == "good"
        or tolerant["vertices"] != "good"
        or (tolerant["faces"] != "good")
    )
    if "unknown" in place:
        assert set(found.values()) == {"good"}
    if "unknown" in place or place == "mesh/channels/vertex_normals":
        for new in write_again(whole):
            assert SECRET not in new.read_bytes()


def test_a_hard_link_may_lead_to_a_group_above(whole, rich_mesh):
    """Circles of hard links, everywhere that we walk."""
    with h5py.File(whole, "r+") as file:
        for place in (
            "circle",
            "mesh/circle",
            "mesh/labels/circle",
            "mesh/labels/tree/circle",
            "mesh/textures/circle",
            "mesh/textures/images/7",
            "mesh/face_attributes/circle",
            "mesh/channels/circle",
            "mesh/channels/texture_features/circle",
        ):
            file[place] = file["/"] if place == "circle" else file["mesh"]
    found = look_everywhere(whole)
    assert set(found.values()) <= {"good", "shape"} and found["vertices"] == "good"
    news = list(write_again(whole))
    for new in news:
        assert identical(MapFile(new).vertices, rich_mesh.vertices)
        assert new.stat().st_size < 5_000_000


@pytest.mark.parametrize("kind", ["object", "region"])
def test_references_are_not_followed(whole, kind):
    with h5py.File(whole, "r+") as file:
        vertices = file["mesh/channels/vertices"]
        value = vertices.ref if kind == "object" else vertices.regionref[:10]
        dtype = h5py.ref_dtype if kind == "object" else h5py.regionref_dtype
        file["mesh"].attrs["crs"] = value
        file["mesh"].attrs["source"] = value
        layer = file["mesh/channels"].create_dataset("layer", (40, 1), dtype)
        layer[0, 0] = value
        del file["mesh/labels/tree/1"]
        file["mesh/labels/tree"].create_dataset("1", (3,), dtype)[0] = value
    found = look_everywhere(whole)
    assert found["crs"] == found["source"] == "value" and found["label"] == "dtype"
    assert found["vertices"] == "good" and found["read"] in ("value", "dtype")
    assert "layer" not in MapFile(whole).layer_names()


def test_filters_that_are_not_known(whole):
    with h5py.File(whole, "r+") as file:
        costs = file["mesh/channels/height_diff"][()]
        del file["mesh/channels/height_diff"]
        dataset = file["mesh/channels"].create_dataset("height_diff", data=costs, scaleoffset=2)
        del file["mesh/channels/vertex_normals"]
        plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plist.set_chunk((40, 3))
        plist.set_filter(32004, h5py.h5z.FLAG_OPTIONAL, (0,))  # LZ4, optional: stored without
        h5py.h5d.create(
            file["mesh/channels"].id,
            b"vertex_normals",
            h5py.h5t.IEEE_F32LE,
            h5py.h5s.create_simple((40, 3)),
            plist,
        )
        assert dataset.scaleoffset
    found = look_everywhere(whole)
    assert found["vertex_costs"] == found["vertex_normals"] == found["read"] == "filter"
    assert found["vertices"] == "good"


def test_links_of_a_class_that_nobody_knows(whole):
    """As h5py cannot make them, an external link is given another number."""
    with h5py.File(whole, "r+") as file:
        for name in ("SIFT", "class_id", "echo", "flow", "id", "intensity", "vertex_normals"):
            del file["mesh/channels/" + name]  # of few names a group has no checksum
        file["mesh/channels"]["vertex_normals"] = h5py.ExternalLink("secret.h5", "/x")
    data = bytearray(whole.read_bytes())
    start = data.rindex(b"vertex_normals", 0, data.index(b"secret.h5\0"))
    kind = data.rindex(b"\x40", start - 16, start)
    data[kind] = 70
    whole.write_bytes(data)
    with h5py.File(whole) as file:
        channels = file["mesh/channels"]
        assert channels.id.links.get_info(b"vertex_normals").type == 70
    found = look_everywhere(whole)
    assert found.get("read", found.get("opening")) in ("link", "damaged")
    assert "good" not in [found.get("vertex_normals")]


def test_no_plugin_of_a_filter_is_loaded(whole, monkeypatch):
    """Even where the environment names a folder of them."""
    assert os.environ.get("HDF5_PLUGIN_PRELOAD") != "::"
    monkeypatch.setitem(isolation.FUNCTIONS, "env", ("os", "getenv"))
    assert isolated("env", "HDF5_PLUGIN_PRELOAD") == "::"
