"""Opening a map reads no array, and reading one thing reads nothing else of it."""
import h5py
import numpy as np
import pytest
from map_samples import SAMPLES, assert_same, write_hdf5_map_io, write_lvr2_l1

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5 import chunks, guarded_group
from mesh_msgs_hdf5.map_file.reading.label_reader import LabelReader
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label


@pytest.fixture
def watch(monkeypatch):
    """A function; after its call the names of the datasets that are read are in its result."""

    def start():
        names, inside = [], []
        load, original = chunks.load, h5py.Dataset.__getitem__

        def noted(dataset):
            names.append(dataset.name)
            inside.append(True)
            try:
                return load(dataset)
            finally:
                inside.pop()

        def only_inside(self, key):
            assert inside, "%s was read past chunks.load" % self.name
            return original(self, key)

        monkeypatch.setattr(chunks, "load", noted)
        monkeypatch.setattr(h5py.Dataset, "__getitem__", only_inside)
        return names

    return start


def look(file):
    """All that takes no array."""
    assert file.vertex_count == 40 and file.face_count == 60
    file.layer_names(), file.face_attribute_names(), file.label_names(), file.texture_indices()
    file.frame_id, file.origin, file.crs, file.source, file.parts, file.other_contents()
    for name in file.layer_names():
        file.layer_parameters(name)
    file.all_layer_parameters()


@pytest.mark.parametrize("name", SAMPLES)
def test_opening_and_looking_around_reads_no_array(tmp_path, rich_mesh, watch, name):
    path = tmp_path / "a.h5"
    SAMPLES[name](path, rich_mesh)
    reads = watch()
    look(MapFile(path))
    assert reads == []
    MapFile(path).vertices
    assert len(reads) == 1


def test_the_uuid_of_a_file_of_ours_is_in_it(tmp_path, rich_mesh, watch):
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    write_hdf5_map_io(tmp_path / "b.h5", rich_mesh)
    reads = watch()
    file = MapFile(tmp_path / "a.h5")
    look(file)
    assert file.uuid and reads == []
    assert MapFile(tmp_path / "b.h5").uuid == file.uuid
    assert reads == ["/mesh/channels/vertices", "/mesh/channels/face_indices"]


# what is asked -> what is read of a file of hdf5_map_io, below /mesh
READS = {
    "vertices": ["channels/vertices"],
    "faces": ["channels/face_indices"],
    "vertex_normals": ["channels/vertex_normals"],
    "vertex_colors": ["channels/vertex_colors"],
    "texture_coordinates": ["textures/coords"],
    "materials": ["textures/materials", "textures/mat_face_indices"],
    "features": ["channels/texture_features/%d" % i for i in range(12)],
    ("vertex_costs", "height_diff"): ["channels/height_diff"],
    ("texture", 10): ["textures/images/10"],
    ("label", "tree_2"): ["labels/tree/2"],
    ("labels",): ["labels/tree/1", "labels/tree/2"],
}


@pytest.mark.parametrize("what", READS, ids=str)
def test_one_thing_is_read_without_the_others(tmp_path, rich_mesh, watch, what):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    reads = watch()
    ask(MapFile(path), what)
    assert reads == ["/mesh/" + place for place in READS[what]]


def ask(file, what):
    if isinstance(what, str):
        return getattr(file, what)
    return getattr(file, what[0])(*what[1:])


def test_a_face_attribute_is_read_without_the_others(tmp_path, rich_mesh, watch):
    file = MapFile.write(tmp_path / "a.h5", rich_mesh)
    reads = watch()
    assert_same(file.face_attribute("cost"), rich_mesh.face_attributes["cost"], "cost")
    assert reads == ["/mesh/face_attributes/cost"]


@pytest.mark.parametrize("what", READS, ids=str)
def test_everything_is_read_once(tmp_path, rich_mesh, watch, what):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    reads = watch()
    MapFile(path).read()
    assert sorted(reads) == sorted(set(reads))
    assert {"/mesh/" + place for place in READS[what]} <= set(reads)


def test_too_much_is_refused_before_any_of_it_is_read(tmp_path, rich_mesh, watch, monkeypatch):
    path = tmp_path / "a.h5"
    write_hdf5_map_io(path, rich_mesh)
    monkeypatch.setattr(guarded_group, "default_budget", lambda: 3000)
    reads = watch()
    with pytest.raises(MapFileError) as refused:
        MapFile(path).read()
    assert refused.value.code == "size" and reads == []


def sizes_of(path, place):
    with h5py.File(path, "r") as file:
        found = []
        file[place].visititems(
            lambda name, item: found.append(item.nbytes) if isinstance(item, h5py.Dataset) else None
        )
    return found


def test_arrays_each_of_which_may_be_read_are_too_much_together(
    tmp_path, rich_mesh, watch, monkeypatch
):
    rich_mesh.labels, rich_mesh.features = {}, None  # these are counted one by one
    file = MapFile.write(tmp_path / "a.h5", rich_mesh)
    sizes = sizes_of(file.path, "/mesh")
    assert max(sizes) < sum(sizes) // 2
    monkeypatch.setattr(guarded_group, "default_budget", lambda: sum(sizes) - 1)
    reads = watch()
    with pytest.raises(
        MapFileError, match="declare %d bytes, more than the %d " % (sum(sizes), sum(sizes) - 1)
    ) as refused:
        file.read()
    assert refused.value.code == "size" and reads == []
    monkeypatch.setattr(guarded_group, "default_budget", lambda: sum(sizes))
    assert_same(file.read().vertices, rich_mesh.vertices, "vertices")


def test_what_is_read_one_by_one_in_one_call_is_counted_together(tmp_path, rich_mesh, monkeypatch):
    faces = np.arange(len(rich_mesh.faces), dtype=np.uint32)
    rich_mesh.labels = {"tree_%d" % i: Label(faces) for i in range(40)}
    file = MapFile.write(tmp_path / "a.h5", rich_mesh)
    total = 40 * faces.nbytes
    monkeypatch.setattr(guarded_group, "default_budget", lambda: total - 1)
    assert all(len(file.label(text).faces) == len(faces) for text in file.label_names())
    wanted = "declare %d bytes, more than the %d " % (total, total - 1)
    with pytest.raises(MapFileError, match=wanted) as refused:
        file.labels()
    assert refused.value.code == "size"
    monkeypatch.setattr(guarded_group, "default_budget", lambda: total)
    assert len(file.labels()) == 40


def corrupt(path, places):
    """Overwrite the stored bytes of these datasets by noise; their headers stay whole."""
    with h5py.File(path, "r") as file:
        spans = []
        for place in places:
            for index in range(file[place].id.get_num_chunks()):
                chunk = file[place].id.get_chunk_info(index)
                spans.append((chunk.byte_offset, chunk.size))
    data = bytearray(path.read_bytes())
    for start, size in spans:
        data[start : start + size] = b"\xa5" * size
    path.write_bytes(data)
    assert spans


def test_damaged_neighbors_do_not_matter(tmp_path, rich_mesh):
    path = tmp_path / "a.h5"
    expected = write_lvr2_l1(path, rich_mesh)
    with h5py.File(path, "r") as file:
        places = []
        file.visititems(
            lambda name, item: places.append("/" + name) if hasattr(item, "shape") else None
        )
    kept = ["/mesh/channels/steepness", "/mesh/labels/tree/2", "/mesh/textures/2"]
    damaged = [place for place in places if place not in kept]
    assert len(damaged) > 12
    corrupt(path, damaged)
    file = MapFile(path)
    look(file)
    assert_same(file.vertex_costs("steepness"), expected.vertex_costs["steepness"], "steepness")
    assert_same(file.label("tree_2"), expected.labels["tree_2"], "tree_2")
    assert_same(file.texture(2), expected.textures[2], "texture")
    for what in ("vertices", "faces", "materials", ("vertex_costs", "height_diff"), ("texture", 0)):
        with pytest.raises(MapFileError) as refused:
            ask(file, what)
        assert refused.value.code == "damaged"


# (what is a link instead, what reading all then says)
LINKS = [
    ("channels/vertex_normals", h5py.SoftLink("/mesh/channels/vertices"), "link"),
    ("channels/height_diff", h5py.ExternalLink("/etc/passwd", "/x"), None),
    ("textures/coords", h5py.SoftLink("/nowhere"), "link"),
    ("textures/mat_face_indices", h5py.SoftLink("/mesh/textures/materials"), "link"),
    ("labels/tree", h5py.ExternalLink("other.h5", "/labels/tree"), None),
    ("labels", h5py.SoftLink("/mesh/channels"), "link"),
    ("textures/images/10", h5py.SoftLink("/mesh/textures/images/0"), "index"),
    ("channels/texture_features", h5py.SoftLink("/"), "link"),
]


@pytest.mark.parametrize("place,link,code", LINKS, ids=[link[0] for link in LINKS])
def test_links_beside_what_is_read_do_not_matter(tmp_path, rich_mesh, place, link, code):
    """A link is refused where it stands for an array, and left alone where it is only a name."""
    path = tmp_path / "a.h5"
    expected = write_hdf5_map_io(path, rich_mesh)
    with h5py.File(path, "a") as file:
        del file["mesh"][place]
        file["mesh"][place] = link
    file = MapFile(path)
    assert_same(file.vertices, expected.vertices, "vertices")
    assert_same(file.vertex_costs("roughness"), expected.vertex_costs["roughness"], "roughness")
    if code:
        with pytest.raises(MapFileError) as refused:
            MapFile(path, strict=True).read()
        assert refused.value.code == code and place.split("/")[-1] in str(refused.value)
    else:
        file.read()
        assert file.other_contents() == ["/mesh/" + place]


@pytest.mark.parametrize(
    "members, datasets",
    [
        ((), []),
        (("vertex_normals", "source"), ["channels/vertex_normals"]),
        (("vertex_costs",), ["channels/Grün und weich", "channels/height_diff"]),
        (("labels", "textures"), ["labels/", "textures/images/"]),
    ],
)
def test_of_some_members_only_these_are_read(tmp_path, rich_mesh, watch, members, datasets):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    whole = MapFile(path).read()
    reads = watch()
    some = MapFile(path).read(members)
    always = ["channels/face_indices", "channels/vertices"]
    names = sorted(name.replace("/mesh/", "", 1) for name in reads)
    assert [n for n in names if not n.startswith(("labels/", "textures/images/"))] == sorted(
        always + [name for name in datasets if not name.endswith("/")]
    )
    for folder in ("labels/", "textures/images/"):
        assert any(n.startswith(folder) for n in names) == (folder in datasets)
    for name in members + ("vertices", "faces", "frame_id", "origin", "crs"):
        assert_same(getattr(some, name), getattr(whole, name), name)
    assert some.features is None and some.materials is None


def test_a_member_that_no_mesh_has(tmp_path, rich_mesh):
    MapFile.write(tmp_path / "a.h5", rich_mesh)
    with pytest.raises(MapFileError, match="a mesh has no member 'roughness'") as error:
        MapFile(tmp_path / "a.h5").read(("roughness",))
    assert error.value.code == "value"


def test_the_file_is_looked_through_once_however_much_is_in_it(tmp_path, monkeypatch):
    """Not once for each layer, face attribute and texture: thousands would take minutes."""
    looked = []
    original = guarded_group.children
    monkeypatch.setattr(
        guarded_group, "children", lambda *args: looked.append(args[1].name) or original(*args)
    )
    counts = []
    for number in (2, 30):
        path = tmp_path / ("%d.h5" % number)
        with h5py.File(path, "w") as file:
            part = file.create_group("mesh")
            part["channels/vertices"] = np.eye(3, dtype="f4")
            part["channels/face_indices"] = np.array([[0, 1, 2]], "u4")
            for i in range(number):
                part["channels/layer_%d" % i] = np.zeros(3, "f4")
                part["face_attributes/%d" % i] = np.zeros(1, "f4")
                part["textures/images/%d" % i] = np.zeros((1, 1, 3), "u1")
        del looked[:]
        mesh = MapFile(path).read()
        assert len(mesh.vertex_costs) == len(mesh.face_attributes) == len(mesh.textures) == number
        counts.append(len(looked))
    assert counts[0] == counts[1], looked


def test_a_label_is_found_without_looking_at_the_others(tmp_path, rich_mesh, monkeypatch):
    del rich_mesh.labels["grass_"]  # has the place of grass
    file = MapFile.write(tmp_path / "a.h5", rich_mesh)
    original, looks = LabelReader.label_paths, []
    monkeypatch.setattr(LabelReader, "label_paths", lambda self: looks.append(1) or original(self))
    for text, label in rich_mesh.labels.items():
        assert_same(file.label(text), label, text)
    assert not looks
    for text in (
        "tree/1",
        "tree/1_2",
        "tree\0_1",
        "tree_1\0",
        "\udcff_1",
        "",
        "_",
        ".._.",
        5,
        None,
    ):
        with pytest.raises(MapFileError) as refused:
            file.label(text)
        assert refused.value.code == "label" and "there is no label" in str(refused.value), text
    with h5py.File(file.path, "r+") as raw:
        labels = raw["mesh/labels"]
        labels["tree/1"].attrs["label"] = "oak_7"
        labels["tree/3"] = h5py.SoftLink("/mesh/labels/tree/2")
        labels["elm"] = h5py.SoftLink("/mesh/labels/tree")
    assert_same(file.label("oak_7"), rich_mesh.labels["tree_1"], "oak_7")  # not at its own place
    for text in ("tree_1", "tree_3", "elm_2"):
        with pytest.raises(MapFileError, match="there is no label"):
            file.label(text)
