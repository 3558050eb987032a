"""Maps from files, and layers stored in them."""

import logging
import math

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.costs.layer import LayerResult
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_msgs.identity import geometry_uuid
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from meshes import terrain

HEIGHT_DIFF = {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}


@pytest.fixture
def map_file(tmp_path):
    mesh = terrain(12)
    path = str(tmp_path / "map.h5")
    return MapFile.write(path, Mesh(mesh.vertices, mesh.faces, frame_id="hall"))


def loaded(path, layers=(HEIGHT_DIFF,), require_provenance=False, **options):
    """The source of a map, and the map with its layers as a node has it."""
    source = MapSource(path)
    source.require_provenance = require_provenance
    mesh_map = source.make_map(**options)
    mesh_map.compute_layers(
        list(layers), stored=source.stored_costs, on_trust=source.costs_on_trust
    )
    return source, mesh_map


def costs_of(path, layers=(HEIGHT_DIFF,), **options):
    return loaded(path, layers, **options)[1].layers["height_diff"].result.costs


@pytest.fixture
def parameters(map_file):
    """What is stored with the layer HEIGHT_DIFF of map_file, whose file says nothing of it yet."""
    source, mesh_map = loaded(map_file.path)
    source.save_layers(mesh_map.layers)
    found = map_file.layer_parameters("height_diff")
    MapFile.write(map_file.path, map_file.read(()))
    return found


def test_a_map_file(map_file):
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    assert source.is_map_file and mesh_map.frame_id == "hall" and mesh_map.uuid == map_file.uuid
    assert np.array_equal(mesh_map.vertices, map_file.vertices)
    assert np.array_equal(mesh_map.faces, map_file.faces)
    assert source.make_map("floor").frame_id == "floor"


MARKED = np.linspace(0, 1, 144).astype(np.float32)


def test_layers_are_reused_when_their_parameters_are_the_same(map_file, parameters):
    map_file.write_layers({"height_diff": (MARKED, parameters)})
    assert np.array_equal(costs_of(map_file.path), MARKED)
    threshold = dict(HEIGHT_DIFF, params={"threshold": 0.5, "factor": 0.1})
    assert np.array_equal(costs_of(map_file.path, [threshold]), MARKED)
    radius = dict(HEIGHT_DIFF, params={"radius": 0.2})
    assert not np.array_equal(costs_of(map_file.path, [radius]), MARKED)
    # What its values mean is not what they were computed with: files of before have it not.
    before = {key: value for key, value in parameters.items() if key != "layer_info"}
    assert len(before) == len(parameters) - 1
    map_file.write_layers({"height_diff": (MARKED, before)})
    assert np.array_equal(costs_of(map_file.path), MARKED)
    without = dict(HEIGHT_DIFF, params={"include_vertex": False})
    assert not np.array_equal(costs_of(map_file.path, [without]), MARKED)


def test_what_is_stored_says_how_and_for_what_it_was_computed(map_file, parameters):
    assert parameters.pop("layer_info")["comparison"] == "above"
    normals = parameters.pop("vertex_normals")
    assert len(normals) == 32 and set(normals) <= set("0123456789abcdef")
    kind = "mesh_layers/HeightDiffLayer"
    expected = {"radius": 0.3, "include_vertex": True, "large_faces": True}
    assert parameters == {"type": kind, "geometry": map_file.uuid, **expected}


@pytest.mark.parametrize(
    "change, said",
    [
        ({"geometry": None}, "does not say for which geometry"),
        ({"geometry": "f00"}, "other values of geometry"),
        ({"radius": 0.2, "vertex_normals": "0"}, "other values of radius, vertex_normals"),
        ({"type": "x"}, "other values of type"),
        ({"large_faces": None}, "other values of large_faces"),
        ({"more": 1}, "other values of more"),
        ({"more": 1, "layer_info": None}, "other values of more"),
    ],
)
def test_layers_of_other_parameters_are_computed(map_file, parameters, change, said, caplog):
    caplog.set_level(logging.INFO, "mesh_map")
    fresh = costs_of(map_file.path)
    changed = {k: v for k, v in dict(parameters, **change).items() if v is not None}
    map_file.write_layers({"height_diff": (MARKED, changed)})
    assert fresh.any() and np.array_equal(costs_of(map_file.path), fresh)
    assert "layer height_diff is computed anew: " in caplog.text and said in caplog.text


def test_layers_are_found_under_another_name(map_file, parameters):
    """Another robot may call the same layer otherwise; its own name counts first."""
    map_file.write_layers({"steps": (MARKED, parameters)})
    assert np.array_equal(costs_of(map_file.path), MARKED)
    map_file.write_layers({"height_diff": (MARKED / 2, parameters)})
    assert np.array_equal(costs_of(map_file.path), MARKED / 2)
    map_file.write_layers({"height_diff": (MARKED / 2, dict(parameters, radius=0.2))})
    assert np.array_equal(costs_of(map_file.path), MARKED)


@pytest.mark.parametrize(
    "options", [{"up_direction": [0, 1, 0]}, {"normals": "angle"}, {"orient": True}]
)
def test_layers_of_another_view_of_the_geometry_are_computed(tmp_path, options):
    mesh = terrain(12)
    upside_down = Mesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]))
    path = MapFile.write(str(tmp_path / "map.h5"), upside_down).path
    source, mesh_map = loaded(path)
    source.save_layers(mesh_map.layers)
    file = MapFile(path)
    file.write_layers({"height_diff": (MARKED, file.layer_parameters("height_diff"))})
    assert np.array_equal(costs_of(path), MARKED)
    assert not np.array_equal(costs_of(path, **options), MARKED)
    source, mesh_map = loaded(path, **options)
    source.save_layers(mesh_map.layers)
    assert np.array_equal(costs_of(path, **options), mesh_map.layers["height_diff"].result.costs)
    again = MapSource(path)
    again.make_map(**options)
    assert again.stored_costs("height_diff", mesh_map.layers["height_diff"].identity) is not None


def test_a_layer_that_is_replaced_while_it_is_read(map_file, parameters, monkeypatch):
    """Between parameters and costs, another robot stores the layer with another radius."""
    map_file.write_layers({"height_diff": (MARKED, parameters)})
    source = MapSource(map_file.path)
    source.make_map()
    others = ("vertex_normals", "layer_info")
    fingerprint = {k: v for k, v in parameters.items() if k not in others}
    read = source._members.all_layer_parameters

    def interrupted():
        found = read()
        map_file.write_layers({"height_diff": (MARKED / 2, dict(parameters, radius=0.2))})
        monkeypatch.setattr(source._members, "all_layer_parameters", read)
        return found

    monkeypatch.setattr(source._members, "all_layer_parameters", interrupted)
    assert source.stored_costs("height_diff", fingerprint) is None
    map_file.write_layers({"height_diff": (MARKED, parameters)})
    assert np.array_equal(source.stored_costs("height_diff", fingerprint), MARKED)


def test_layers_of_a_replaced_file_are_computed_anew(map_file, parameters, caplog):
    fresh = costs_of(map_file.path)
    map_file.write_layers({"height_diff": (MARKED, parameters)})
    source = MapSource(map_file.path)
    MapFile.write(map_file.path, Mesh(np.ones((3, 3), np.float32), np.array([[0, 1, 2]])))
    mesh_map = source.make_map()
    mesh_map.compute_layers([HEIGHT_DIFF], stored=source.stored_costs)
    assert np.array_equal(mesh_map.layers["height_diff"].result.costs, fresh)
    assert "layer height_diff is computed anew" in caplog.text and "replaced" in caplog.text


def test_infinite_parameters_are_stored_as_texts(map_file):
    """JSON has no infinite numbers."""
    source = MapSource(map_file.path)
    source.make_map()
    layer = TestLayer("endless")
    source.save_layers({"endless": layer})
    saved = MapFile(map_file.path).layer_parameters("endless")
    assert (saved["limit"], saved["list"], saved["table"]) == ("inf", [1, "-inf"], {"a": "inf"})
    assert np.array_equal(source.stored_costs("endless", layer.identity), MARKED)
    assert source.stored_costs("endless", dict(layer.identity, limit=1.0)) is None


class TestLayer:
    """What save_layers() looks at."""

    __test__ = False
    STORABLE = True
    UNIT, type_name = "", "test"
    params = {"enabled": True}
    identity = {"limit": math.inf, "list": (1, -math.inf), "table": {"a": math.inf}, "geometry": ""}

    def __init__(self, name):
        self.name, self.result = name, LayerResult(MARKED, MARKED > 2)

    def lethal_rule(self):
        """A layer of a stranger's."""
        raise RuntimeError("no idea")


def test_only_what_is_needed_is_read(map_file, monkeypatch):
    """A map may hold textures of gigabytes."""
    seen = []
    monkeypatch.setattr(
        type(MapSource(map_file.path)._members),
        "read",
        lambda self, members=None: seen.append(members) or map_file.read(members),
    )
    MapSource(map_file.path)
    assert seen == [("vertex_normals", "vertex_colors", "seam_originals")]


def test_save_and_load(map_file):
    before = map_file.layer_names()
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    mesh_map.compute_layers([HEIGHT_DIFF, dict(HEIGHT_DIFF, name="wide", params={"radius": 0.6})])
    assert map_file.layer_names() == before == []
    assert source.save_layers(mesh_map.layers) == ["height_diff", "wide"]
    saved = MapFile(map_file.path)
    assert saved.layer_names() == ["height_diff", "wide"]
    assert saved.layer_parameters("wide")["radius"] == 0.6
    for name, layer in mesh_map.layers.items():
        assert np.array_equal(saved.vertex_costs(name), layer.result.costs)
    assert saved.uuid == mesh_map.uuid
    again, other = loaded(map_file.path, [dict(HEIGHT_DIFF, name="a"), HEIGHT_DIFF])
    assert again.save_layers(other.layers) == ["a", "height_diff"]
    assert MapFile(map_file.path).layer_names() == ["a", "height_diff", "wide"]


def test_normals_are_stored_where_there_are_none(map_file):
    source, mesh_map = loaded(map_file.path)
    assert not map_file.has_normals
    source.save_layers(mesh_map.layers)
    assert np.array_equal(MapFile(map_file.path).vertex_normals, mesh_map.vertex_normals)
    marked = np.tile(np.float32([0, 1, 0]), (144, 1))
    map_file.update(Edit(vertex_normals=marked))
    source, mesh_map = loaded(map_file.path)
    assert np.array_equal(mesh_map.vertex_normals, marked)
    source.save_layers(mesh_map.layers)
    assert np.array_equal(MapFile(map_file.path).vertex_normals, marked)


def test_normals_that_somebody_else_has_stored_meanwhile_stay(map_file):
    source, mesh_map = loaded(map_file.path)
    marked = np.tile(np.float32([0, 1, 0]), (144, 1))
    map_file.update(Edit(vertex_normals=marked))
    source.save_layers(mesh_map.layers)
    assert np.array_equal(MapFile(map_file.path).vertex_normals, marked)


@pytest.mark.parametrize("times, given_up", [(0, False), (4, False), (5, True)])
def test_two_robots_store_at_once(map_file, monkeypatch, times, given_up):
    """Another one saves, with normals, while this one writes: then the file is read again."""
    source, mesh_map = loaded(map_file.path)
    update, seen = source._members.update, []
    marked = np.tile(np.float32([0, 1, 0]), (144, 1))

    def interrupted(edit):
        seen.append(edit.vertex_normals)
        if len(seen) > times:
            return update(edit)
        map_file.update(Edit(vertex_normals=marked, vertex_costs={"other": MARKED}))
        raise MapFileError("changed", map_file.path, "another program saved it meanwhile")

    monkeypatch.setattr(source._members, "update", interrupted)
    if given_up:
        with pytest.raises(MeshMapError, match="another program saved it meanwhile"):
            source.save_layers(mesh_map.layers)
    else:
        assert source.save_layers(mesh_map.layers) == ["height_diff"]
    assert [normals is None for normals in seen] == [False] + [True] * (len(seen) - 1)
    names = ["height_diff"] * (not given_up) + ["other"] * (times > 0)
    assert map_file.layer_names() == names
    assert times == 0 or np.array_equal(map_file.vertex_normals, marked)


def test_the_identity_is_that_of_the_content(map_file, monkeypatch):
    uuid = geometry_uuid(map_file.vertices, map_file.faces)
    for options in ({}, {"orient": True}, {"normals": "angle"}):
        geometry = MapSource(map_file.path).make_map(**options).geometry
        assert geometry.content_uuid == geometry.uuid == map_file.uuid == uuid
    source = MapSource(map_file.path)  # as if of another program, with a UUID of its own
    source.uuid = "of-somebody-else"
    monkeypatch.setattr(type(source._members), "schema_version", 0, raising=False)
    geometry = source.make_map().geometry
    assert (geometry.content_uuid, geometry.uuid) == (uuid, "of-somebody-else")


def test_turned_faces_are_stored_as_such(map_file):
    source, mesh_map = loaded(map_file.path, orient=True)
    source.save_layers(mesh_map.layers)
    assert map_file.layer_parameters("height_diff")["orient"] is True


@pytest.mark.parametrize("options", [{"normals": "angle"}, {"orient": True}])
def test_normals_of_one_robot_only_are_not_stored(map_file, options):
    source, mesh_map = loaded(map_file.path, **options)
    source.save_layers(mesh_map.layers)
    assert not MapFile(map_file.path).has_normals


def test_layers_that_are_not_to_be_stored_are_left_out(map_file):
    map_file.write_layers({"slope": (MARKED, None)})
    stored = {"name": "again", "type": "mesh_layers/StoredLayer", "params": {"layer": "slope"}}
    own = {"name": "slope", "type": "mesh_layers/StoredLayer", "params": {"scale": 2.0}}
    source, mesh_map = loaded(map_file.path, [stored, own, HEIGHT_DIFF])
    assert source.save_layers(mesh_map.layers) == ["height_diff"]
    assert np.array_equal(MapFile(map_file.path).vertex_costs("slope"), MARKED)
    source, mesh_map = loaded(map_file.path, [stored])
    with pytest.raises(MeshMapError, match="there are no layers to store"):
        source.save_layers(mesh_map.layers)


def write_obj(path):
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0.25\nf 1 2 3\n")
    return str(path)


def test_a_mesh_file_is_a_map_too(tmp_path):
    source = MapSource(write_obj(tmp_path / "mesh.obj"))
    mesh_map = source.make_map()
    assert not source.is_map_file and mesh_map.frame_id == "map" and len(mesh_map.uuid) == 36
    params = {"radius": 1.0, "large_faces": False}
    mesh_map.compute_layers([dict(HEIGHT_DIFF, params=params)], stored=source.stored_costs)
    assert mesh_map.layers["height_diff"].result.costs.tolist() == [0, 0, 0]
    with pytest.raises(MeshMapError, match="mesh.obj is no map file.*mesh_tool import"):
        source.save_layers(mesh_map.layers)


UTM = (565000.0, 5934000.0, 10.0)


def test_a_mesh_file_in_national_coordinates_needs_an_origin(tmp_path):
    path = tmp_path / "mesh.obj"
    corners = "v 565000.1 5934000 10", "v 565001.1 5934000 10", "v 565000 5934001.3 10"
    path.write_text("\n".join(corners) + "\nf 1 2 3\n")
    with pytest.raises(MeshMapError, match=r"obj: float32 would change.* \[565001.0, 5934001.0"):
        MapSource(str(path))
    parameters = map_parameters({"mesh_file": str(path), "origin": list(UTM)})
    mesh_map = MapSource(str(path), origin=parameters.origin).make_map()
    assert np.array_equal(mesh_map.vertices, np.float32([[0.1, 0, 0], [1.1, 0, 0], [0, 1.3, 0]]))
    assert tuple(mesh_map.origin) == UTM
    other = MapSource(str(path), origin=(565001.0, *UTM[1:])).make_map()
    assert other.vertices[0, 0] == np.float32(-0.9) and other.origin[0] == 565001.0
    assert map_parameters({"mesh_file": str(path)}).origin is None
    with pytest.raises(MeshMapError, match="origin"):
        MapSource(str(path), origin=(1.0, "x"))


def test_a_map_file_stores_its_origin(tmp_path):
    mesh = terrain(12)
    path = MapFile.write(str(tmp_path / "a.h5"), Mesh(mesh.vertices, mesh.faces, origin=UTM)).path
    mesh_map, again = (MapSource(path, origin=given).make_map() for given in (None, UTM))
    assert tuple(mesh_map.origin) == UTM and again.geometry is mesh_map.geometry
    with pytest.raises(MeshMapError, match="stores .*565000.*leave it out.*import --origin"):
        MapSource(path, origin=(0.0, 0.0, 0.0))
    # The same vertices elsewhere are another geometry.
    moved = MapFile.write(str(tmp_path / "b.h5"), Mesh(mesh.vertices, mesh.faces)).path
    assert MapSource(moved).make_map().origin.tolist() == [0, 0, 0]


def test_nothing_to_save(map_file):
    with pytest.raises(MeshMapError, match="there are no layers to store"):
        MapSource(map_file.path).save_layers({})


@pytest.mark.parametrize(
    "content", [None, b"", b"version https://git-lfs.github.com/spec/v1\n", b"\x89HDF\r\n\x1a\n"]
)
def test_files_that_are_no_maps(tmp_path, content):
    path = tmp_path / "map.h5"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(MeshMapError) as error:
        MapSource(str(path))
    assert str(path) in str(error.value) and "\n" not in str(error.value)
    with pytest.raises(MeshMapError):
        MapSource(str(tmp_path))


def test_one_bad_value_does_not_make_a_map_useless(map_file, caplog):
    """A stored layer, normals and a label with a bad value each: the map is loaded, and says so."""
    h5py = pytest.importorskip("h5py")
    count = map_file.vertex_count
    normals = np.tile(np.float32([0, 0, 1]), (count, 1))
    map_file.update(
        Edit(vertex_normals=normals, labels={"tree_1": Label(np.arange(5, dtype=np.uint32))})
    )
    with h5py.File(map_file.path, "r+") as file:
        file["mesh/channels/vertex_normals"][3] = np.nan
        file["mesh/labels/tree/1"][2] = 10**6
    with caplog.at_level(logging.WARNING):
        source, mesh_map = loaded(map_file.path)
        for _ in range(2):
            assert source.contents.label("tree_1").faces.tolist() == [0, 1, 3, 4]
            assert list(source.contents.labels()) == ["tree_1"]
    assert np.isfinite(mesh_map.vertex_normals).all()
    said = [record.getMessage() for record in caplog.records]
    assert len([line for line in said if "1 normals of" in line]) == 1, said
    assert len([line for line in said if "1 of 5 faces of label tree_1" in line]) == 1, said


def test_vertices_that_float32_would_change_too_much_are_refused(tmp_path, map_file):
    h5py = pytest.importorskip("h5py")
    mesh = map_file.read()
    with h5py.File(tmp_path / "far.h5", "w") as file:
        file["mesh/channels/vertices"] = mesh.vertices.astype("f8") + [4e5, 5.8e6, 0]
        file["mesh/channels/face_indices"] = mesh.faces
    with pytest.raises(MeshMapError, match="float32 would change its coordinates"):
        MapSource(str(tmp_path / "far.h5"))
