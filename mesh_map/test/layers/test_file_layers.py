"""Layers that make costs of what is in the map file, against plain loops over faces."""

import math
import time

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.io.map_source import MapSource
from mesh_map.layers.labels import LabelLayer
from mesh_map.layers.file_layer import SpeedLimitLayer, StoredLayer
from mesh_map.map.attributes import vertex_costs
from mesh_map.map.mesh_map import MeshMap
from mesh_map.ros.labels_watch import LabelWatcher
from mesh_msgs.testing import wait_until
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.label_names import split_label
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from meshes import SMALL, small, terrain

INF, NAN = math.inf, math.nan


@pytest.fixture
def map_file(tmp_path):
    """144 vertices and 242 faces."""
    mesh = terrain(12)
    values = np.linspace(-1, 2, 144).astype(np.float32)
    values[:2] = np.inf, np.nan
    of_faces = np.linspace(-1, 2, 242).astype(np.float32)
    of_faces[[3, 50]] = np.inf, np.nan
    return MapFile.write(
        str(tmp_path / "map.h5"),
        Mesh(
            mesh.vertices,
            mesh.faces,
            vertex_costs={"values": values},
            face_attributes={
                "values": of_faces,
                "columns": np.stack([of_faces, -of_faces], 1),
                "numbers": np.arange(242) - 100,
            },
            labels={
                "forbidden_1": Label(np.arange(10, 20, dtype=np.uint32)),
                "forbidden_2": Label(np.array([100], np.uint32)),
                "grass": Label(np.arange(0, 60, dtype=np.uint32)),
                "mud_1": Label(np.arange(40, 80, dtype=np.uint32)),
                "path_1": Label(np.arange(70, 130, dtype=np.uint32)),
                "empty_1": Label(np.zeros(0, np.uint32)),
            },
        ),
    )


def result_of(layer, map_file):
    """What a layer of a class, with its name and parameters, gives for a map."""
    layer_type, name, params = layer
    made = layer_type(name, params)
    assert not made.warnings
    return made.evaluate(MapSource(map_file.path).make_map(), {})


def of_vertices_slowly(faces, costs, vertex_count):
    """vertex_costs(), vertex by vertex."""
    found = np.full(vertex_count, np.nan, np.float32)
    for vertex in range(vertex_count):
        around = costs[(faces == vertex).any(1)]
        if len(around):
            found[vertex] = INF if (around == INF).any() else around.max()
    return found


@small
def test_costs_of_faces_become_those_of_vertices(mesh):
    random = np.random.default_rng(4)
    costs = random.random(len(mesh.faces)).astype(np.float32)
    costs[random.random(len(costs)) < 0.1] = np.inf
    costs[random.random(len(costs)) < 0.1] = np.nan
    found = vertex_costs(costs, MeshGeometry(mesh.vertices, mesh.faces).topology)
    slowly = of_vertices_slowly(mesh.faces, costs, len(mesh.vertices))
    np.testing.assert_array_equal(found, slowly)
    assert found.dtype == np.float32 and len(SMALL) > 10


def scaled(value, scale=1.0, offset=0.0, minimum=0.0, maximum=INF):
    if value == INF or math.isnan(value):
        return value
    return max(min(scale * value + offset, maximum), minimum)


@pytest.mark.parametrize(
    "params",
    [
        {},
        {"scale": -1.0, "offset": 1.0},
        {"scale": 10.0, "offset": -1.0, "minimum": 0.5, "maximum": 4.0},
        {"scale": 0.0, "offset": 0.25},
        {"maximum": 0.0},
    ],
)
def test_stored_costs_are_scaled_and_limited(map_file, params):
    expected = np.array([scaled(v, **params) for v in map_file.vertex_costs("values").tolist()])
    found = result_of((StoredLayer, "values", params), map_file)
    np.testing.assert_array_equal(found.costs, expected.astype(np.float32))
    assert np.flatnonzero(found.lethal).tolist() == [0] and found.costs[0] == INF
    by_name = result_of((StoredLayer, "other", dict(params, layer="values")), map_file)
    np.testing.assert_array_equal(by_name.costs, found.costs)

    for attribute, column in (("values", 0), ("columns", 1)):
        values = map_file.face_attribute(attribute).reshape(242, -1)[:, column]
        expected = np.array([scaled(v if v != -INF else NAN, **params) for v in values.tolist()])
        expected = of_vertices_slowly(map_file.faces, expected.astype(np.float32), 144)
        given = dict(params, face_attribute=attribute, column=column)
        found = result_of((StoredLayer, "values", given), map_file)
        np.testing.assert_array_equal(found.costs, expected)
        np.testing.assert_array_equal(found.lethal, expected == INF)


def test_integers_and_a_threshold(map_file):
    params = {"face_attribute": "numbers", "threshold": 50}
    layer = StoredLayer("s", params)
    found = layer.evaluate(MapSource(map_file.path).make_map(), {})
    expected = np.maximum(np.arange(242) - 100, 0).astype(np.float32)
    expected = of_vertices_slowly(map_file.faces, expected, 144)
    np.testing.assert_array_equal(found.costs, expected)
    np.testing.assert_array_equal(found.lethal, expected > 50)
    assert 0 < found.lethal.sum() < 144
    layer.params["threshold"] = 100.0
    np.testing.assert_array_equal(layer.reuse(found.costs, None, {}).lethal, expected > 100)


@pytest.mark.parametrize("params, said", [({}, 1), ({"threshold": 0.5}, 0)])
def test_costs_of_another_layer_without_a_threshold_are_said(map_file, caplog, params, said):
    """What was lethal in them stands nowhere in the file."""
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    mesh_map.compute_layers([{"name": "border", "type": "mesh_layers/BorderLayer"}])
    source.save_layers(mesh_map.layers)
    result = result_of((StoredLayer, "border", params), map_file)
    assert np.array_equal(result.costs, mesh_map.layers["border"].result.costs)
    assert result.lethal.any() == (not said)
    told = [r.message for r in caplog.records if "set threshold, or list that type" in r.message]
    assert len(told) == said and all("costs of a mesh_layers/BorderLayer" in text for text in told)


def test_limits_the_wrong_way_round_are_refused(map_file):
    with pytest.raises(MeshMapError, match="minimum is 3, above maximum, 1"):
        result_of((StoredLayer, "values", {"minimum": 3.0, "maximum": 1.0}), map_file)


def test_numbers_beyond_float32_are_lethal(map_file):
    params = {"costs": {"mud": 1e39}, "preferred": ["grass"], "other_cost": 1e40}
    found = result_of((LabelLayer, "labels", params), map_file)
    expected = labeled_slowly(map_file, costs={"mud": INF}, preferred=["grass"], other_cost=INF)
    np.testing.assert_array_equal(found.costs, expected)
    assert 0 < found.lethal.sum() < 144
    found = result_of((StoredLayer, "values", {"scale": 1e38, "maximum": 1e39}), map_file)
    assert not found.lethal[2:100].any()
    found = result_of((StoredLayer, "values", {"scale": 1e39}), map_file)
    assert found.lethal[-1] and found.costs[-1] == INF


SPEEDS = [2.0, 1.0, 0.5, 0.1, 0.0, -1.0, INF, NAN]


@pytest.mark.parametrize(
    "params, costs",
    [
        ({}, [0, 0, 1, 9, INF, INF, 0, NAN]),
        ({"max_speed": 2.0, "min_speed": 0.1}, [0, 1, 3, INF, INF, INF, 0, NAN]),
        ({"default_speed": 0.25}, [0, 0, 1, 9, INF, INF, 0, 3]),
        ({"default_speed": 0.25, "min_speed": 0.3}, [0, 0, 1, INF, INF, INF, 0, INF]),
    ],
)
def test_speed_limits(map_file, params, costs):
    map_file.write_layers({"limits": (np.resize(SPEEDS, 144).astype(np.float32), None)})
    found = result_of((SpeedLimitLayer, "limits", params), map_file)
    np.testing.assert_array_equal(found.costs, np.resize(costs, 144).astype(np.float32))
    np.testing.assert_array_equal(found.lethal, np.resize(costs, 144) == INF)
    map_file.update(Edit(face_attributes={"limits": np.resize(SPEEDS, 242).astype(np.float32)}))
    found = result_of((SpeedLimitLayer, "s", dict(params, face_attribute="limits")), map_file)
    of_faces = np.resize(costs, 242).astype(np.float32)
    expected = of_vertices_slowly(map_file.faces, of_faces, 144)
    np.testing.assert_array_equal(found.costs, expected)


def test_weights_of_edges_are_travel_times():
    """Half a meter at 0.5 m/s, then the same at 0.25 m/s: the layer's cost is what it says."""
    layer = SpeedLimitLayer("s", {"max_speed": 2.0})
    costs = layer.costs_of(np.array([0.5, 0.25]))
    weights = 0.5 + 1.0 * 0.5 * costs  # edge_weight mean, edge_cost_factor 1
    np.testing.assert_allclose(weights / 2.0, [0.5 / 0.5, 0.5 / 0.25])


@pytest.mark.parametrize(
    "params, message",
    [
        ({"layer": "gone"}, "there is no layer 'gone'.*values"),
        ({}, "there is no layer 's'"),
        ({"face_attribute": "gone"}, "there is no face attribute 'gone'.*columns, numbers, values"),
        ({"face_attribute": "columns", "column": 2}, "columns has no column 2.*0 to 1"),
        ({"face_attribute": "values", "column": 1}, "has no column 1.*0 to 0"),
    ],
)
@pytest.mark.parametrize("layer_type", [StoredLayer, SpeedLimitLayer])
def test_what_is_not_there_is_said(map_file, layer_type, params, message):
    with pytest.raises(MeshMapError, match=message):
        result_of((layer_type, "s", params), map_file)


@pytest.mark.parametrize("layer_type", [StoredLayer, SpeedLimitLayer, LabelLayer])
def test_a_map_without_a_file(layer_type):
    mesh = terrain(3)
    layer = layer_type("values")
    with pytest.raises(MeshMapError, match="the map was not read from a file"):
        layer.compute(MeshMap(mesh.vertices, mesh.faces), {})


def labeled_slowly(file, lethal=(), costs=None, preferred=(), other_cost=0.5):
    """LabelLayer, vertex by vertex."""
    labels, faces = file.labels(), file.faces

    def named(face, names):
        return [
            name
            for name in names
            for text, label in labels.items()
            if face in label.faces and name in (text, split_label(text)[0])
        ]

    found = []
    for vertex in range(file.vertex_count):
        around = np.flatnonzero((faces == vertex).any(1))
        prices = [(costs or {})[name] for face in around for name in named(face, costs or {})]
        if any(named(face, lethal) for face in around):
            found.append(INF)
        elif prices:
            found.append(max(prices))
        elif not preferred or any(named(face, preferred) for face in around):
            found.append(0.0)
        else:
            found.append(other_cost)
    return np.array(found, np.float32)


@pytest.mark.parametrize(
    "params",
    [
        {},
        {"lethal": ["forbidden"]},
        {"lethal": ["forbidden_2"], "other_cost": 0.75},
        {"costs": {"grass": 0.5, "mud": 2.0, "forbidden_1": INF, "empty": 9.0}},
        {"costs": {"mud": 0.1, "grass": 0.5}},
        {"costs": {"mud": 0.5, "path": 0.2, "grass": 0.1}},
        {"preferred": ["path"]},
        {"lethal": ["forbidden", "mud_1"], "preferred": ["path", "grass"], "other_cost": 3.0},
        {"lethal": ["forbidden"], "costs": {"mud": 0, "grass": 1}, "preferred": ["path_1"]},
        {"lethal": ["grass"], "costs": {"grass": 1.0}, "preferred": ["grass"]},
    ],
)
def test_labels(map_file, params, caplog):
    found = result_of((LabelLayer, "labels", params), map_file)
    expected = labeled_slowly(map_file, **params)
    np.testing.assert_array_equal(found.costs, expected)
    np.testing.assert_array_equal(found.lethal, expected == INF)
    empty = "empty" in params.get("costs", {})
    assert not caplog.records and (empty or len(set(expected.tolist())) > 1 or not params)


def test_labels_that_are_not_there_are_named(map_file, caplog):
    params = {"lethal": ["forbiden"], "costs": {"tree": 1.0, "mud": 1.0}}
    found = result_of((LabelLayer, "areas", params), map_file)
    np.testing.assert_array_equal(found.costs, labeled_slowly(map_file, costs={"mud": 1.0}))
    assert [record.getMessage() for record in caplog.records] == [
        "layer areas: the map has no labels forbiden, tree "
        "(classes: empty, forbidden, grass, mud, path)"
    ]


@pytest.mark.parametrize(
    "params, message",
    [
        ({"lethal": "forbidden"}, "lethal is 'forbidden', but it has to be a list"),
        ({"lethal": [3]}, "lethal has 3, but it has to name labels"),
        ({"preferred": [""]}, "preferred has '', but it has to name labels"),
        ({"costs": ["mud"]}, "costs is .*, but it has to be a dictionary"),
        ({"costs": {"mud": -1}}, "costs has 'mud': -1"),
        ({"costs": {"mud": NAN}}, "costs has 'mud': nan"),
        ({"costs": {"mud": True}}, "costs has 'mud': True"),
        ({"costs": {"mud": "1"}}, "costs has 'mud': '1'"),
        ({"costs": {3: 1.0}}, "costs has 3: 1.0"),
    ],
)
def test_bad_parameters_of_labels(map_file, params, message):
    with pytest.raises(MeshMapError, match=message):
        result_of((LabelLayer, "labels", params), map_file)


def test_labels_of_a_journal_count_at_once(map_file):
    """A forbidden area was drawn a moment ago, and the owner of the labels did not save it yet."""
    mesh_map = MapSource(map_file.path).make_map()
    layer = LabelLayer("areas", {"lethal": ["forbidden", "wall"]})
    before = layer.evaluate(mesh_map, {})
    version = mesh_map.contents.labels_version()
    assert mesh_map.contents.labels_version() == version
    with LabelStore(map_file.path) as store:
        store.set("wall_1", np.array([200, 201]))
        store.delete("forbidden_1")
        assert mesh_map.contents.labels_version() != version
        assert "wall_1" in mesh_map.contents.label_names()
        after = layer.update(mesh_map, {}, np.zeros(0, np.uint32), before)
        expected = np.zeros(144, np.bool_)
        expected[map_file.faces[[100, 200, 201]]] = True
        np.testing.assert_array_equal(after.lethal, expected)
        assert "wall_1" not in map_file.label_names()
        store.save()
        np.testing.assert_array_equal(layer.compute(mesh_map, {}).lethal, expected)


def test_labels_of_another_mesh_are_not_taken(map_file):
    """The file is replaced after the mesh was read, and before the first look at its labels."""
    mesh_map = MapSource(map_file.path).make_map()
    other = terrain(13)
    forbidden = {"forbidden_1": Label(np.arange(5, dtype=np.uint32))}
    MapFile.write(map_file.path, Mesh(other.vertices, other.faces, labels=forbidden))
    layer = LabelLayer("areas", {"lethal": ["forbidden"]})
    for _ in range(2):
        with pytest.raises(MeshMapError, match="another program has replaced the mesh"):
            layer.evaluate(mesh_map, {})
    MapFile.write(map_file.path, Mesh(mesh_map.vertices, mesh_map.faces, labels=forbidden))
    assert layer.evaluate(mesh_map, {}).lethal.any()


def test_labels_of_a_mesh_in_another_format(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    mesh_map = MapSource(str(path)).make_map()
    assert mesh_map.contents.label_names() == [] and mesh_map.contents.labels_version() == 0
    layer = LabelLayer("areas", {"preferred": ["path"]})
    assert layer.evaluate(mesh_map, {}).costs.tolist() == [0.5] * 3


def test_a_running_map_follows_its_labels(map_file, monkeypatch):
    monkeypatch.setattr(LabelWatcher, "PERIOD", 0.02)
    mesh_map = MapSource(map_file.path).make_map()
    params = {"lethal": ["wall"]}
    mesh_map.compute_layers([{"name": "areas", "type": "mesh_layers/LabelLayer", "params": params}])
    refreshed = []

    def refresh():
        refreshed.append(1)
        mesh_map.refresh_layer("areas")

    watcher = LabelWatcher("/map/areas", mesh_map, mesh_map.layers["areas"], refresh)
    try:
        with LabelStore(map_file.path) as store:
            store.set("wall_1", np.array([200, 201]))
            assert wait_until(lambda: np.isposinf(mesh_map.costs).any())
            lethal = np.zeros(144, np.bool_)
            lethal[map_file.faces[[200, 201]]] = True
            assert np.array_equal(np.isposinf(mesh_map.costs), lethal) and refreshed
            store.delete("wall_1")
            assert wait_until(lambda: not np.isposinf(mesh_map.costs).any())
        time.sleep(0.2)  # the end of the store changes the files once more
        count = len(refreshed)
        time.sleep(0.2)
        assert len(refreshed) == count  # nothing has changed, so nothing is evaluated
    finally:
        watcher.shutdown()


def test_a_map_that_cannot_be_followed_is_said_once(map_file, monkeypatch, caplog):
    monkeypatch.setattr(LabelWatcher, "PERIOD", 0.01)
    mesh_map = MapSource(map_file.path).make_map()
    layer = LabelLayer("areas")
    layer.evaluate(mesh_map, {})

    def refresh():
        layer.evaluate(mesh_map, {})

    watcher = LabelWatcher("/map/areas", mesh_map, layer, refresh)
    try:
        MapFile.write(map_file.path, Mesh(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]])))
        assert wait_until(lambda: "cannot follow the labels" in caplog.text)
        time.sleep(0.2)
    finally:
        watcher.shutdown()
    assert caplog.text.count("cannot follow the labels") == 1 and "replaced" in caplog.text
