"""Maps of refined meshes: what the file has is carried to them, and what they save back."""

import logging
import math

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_map.map.coarse_edges import coarse_remark
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world.solids import box, floor, joined, welded
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh

INF, NAN = math.inf, math.nan
LENGTH = 0.5
INFLATION = {
    "name": "inflation",
    "type": "mesh_layers/InflationLayer",
    "params": {"inputs": ["forbidden"], "lethal_value": -1, "repulsive_field": False},
}
FORBIDDEN = {
    "name": "forbidden",
    "type": "mesh_layers/LabelLayer",
    "params": {"lethal": ["forbidden"]},
}


def stored(**params):
    return {"name": "values", "type": "mesh_layers/StoredLayer", "params": params}


def hall():
    """A floor of two faces, and a box of twelve that stands on it and does not share vertices."""
    parts = joined(
        floor((0.0, 0.0), (8.0, 6.0), 9.0), welded(box((5.0, 4.0, 0.0), (6.0, 5.0, 2.0)))
    )
    vertices, faces = parts
    return np.float32(vertices), np.uint32(faces)


@pytest.fixture
def map_file(tmp_path):
    vertices, faces = hall()
    count = len(vertices)
    values = np.linspace(0.0, 1.1, count).astype(np.float32)
    values[-2:] = INF, NAN
    mesh = Mesh(
        vertices,
        faces,
        vertex_colors=(np.arange(3 * count).reshape(-1, 3) * 7 % 256).astype(np.uint8),
        vertex_costs={"values": values},
        face_attributes={"speed": np.arange(len(faces)).astype(np.float32)},
        texture_coordinates=np.random.default_rng(1).random((count, 2)).astype(np.float32),
        textures={0: np.zeros((4, 4, 3), np.uint8)},
        materials=Materials(
            np.array([[1, 2, 3], [4, 5, 6]], np.uint8),
            np.array([0, -1], np.int32),
            (np.arange(len(faces)) % 2).astype(np.uint32),
        ),
        labels={
            "forbidden": Label(np.array([1], np.uint32), (1, 2, 3)),
            "box": Label(np.arange(2, 14, dtype=np.uint32)),
        },
        frame_id="hall",
    )
    return MapFile.write(str(tmp_path / "map.h5"), mesh)


def refined(path, layers=(), **options):
    source = MapSource(path)
    mesh_map = source.make_map(**{"max_edge_length": LENGTH, **options})
    mesh_map.compute_layers(list(layers), stored=source.stored_costs)
    return source, mesh_map


def longest_edge(mesh_map):
    return float(mesh_map.geometry.edge_lengths.max())


def test_the_map_is_one_of_a_derived_mesh(map_file):
    _, mesh_map = refined(map_file.path)
    derived = mesh_map.geometry.derived
    assert longest_edge(mesh_map) <= LENGTH < longest_edge(MapSource(map_file.path).make_map())
    assert derived.parent_uuid == map_file.uuid != mesh_map.uuid == derived.uuid
    assert mesh_map.contents.uuid == mesh_map.uuid
    assert mesh_map.vertices[: map_file.vertex_count].tobytes() == map_file.vertices.tobytes()
    assert mesh_map.frame_id == "hall"
    assert "made of 14 faces" in mesh_map.report()
    again = refined(map_file.path)[1]
    assert again.uuid == mesh_map.uuid and again.geometry is mesh_map.geometry
    other = refined(map_file.path, max_edge_length=0.3)[1]
    assert other.uuid != mesh_map.uuid and longest_edge(other) <= 0.3


@pytest.mark.parametrize("length", [0.0, 50.0])
def test_where_no_edge_is_too_long_it_is_the_mesh_itself(map_file, length):
    source, mesh_map = refined(map_file.path, max_edge_length=length)
    assert mesh_map.uuid == map_file.uuid and mesh_map.geometry.derived is None
    assert mesh_map.contents is source.contents


def test_too_many_faces_are_said(map_file):
    with pytest.raises(MeshMapError, match="makes at least .* faces of 14, more than"):
        refined(map_file.path, max_edge_length=0.001)


def test_contents_of_the_file_fit_the_derived_mesh(map_file):
    source, mesh_map = refined(map_file.path)
    derived, contents = mesh_map.geometry.derived, mesh_map.contents
    parents = derived.face_parents
    assert set(contents.label_names()) == {"forbidden", "box"}
    assert parents[contents.label("forbidden").faces].tolist() == [1] * (parents == 1).sum()
    assert contents.label("forbidden").color == (1, 2, 3)
    assert np.array_equal(contents.labels()["box"].faces, np.flatnonzero(parents > 1))
    assert np.array_equal(contents.face_attribute("speed"), np.float32(parents))
    values = contents.vertex_costs("values")
    assert values.dtype == np.float32
    of_parent = map_file.vertex_costs("values")
    np.testing.assert_array_equal(values[: len(of_parent)], of_parent)
    near = ((derived.vertex_weights > 0) & np.isposinf(of_parent)[derived.vertex_parents]).any(1)
    assert near.sum() > 1 and np.array_equal(np.isposinf(values), near)
    free = np.isfinite(of_parent)[derived.vertex_parents].all(1)
    exact = (derived.vertex_weights[free] * of_parent[derived.vertex_parents[free]]).sum(1)
    np.testing.assert_allclose(values[free], exact, rtol=1e-6)
    assert contents.layer_names() == ["values"]
    assert len(source.vertex_colors) == len(mesh_map.vertices)


def test_textures_colors_and_materials_follow(map_file):
    mesh_map = refined(map_file.path)[1]
    derived, parent = mesh_map.geometry.derived, map_file.read()
    mesh = mesh_map.contents.read()
    assert mesh.uuid == mesh_map.geometry.content_uuid
    weights, parents = derived.vertex_weights, derived.vertex_parents
    uv = np.einsum("ij,ijk->ik", weights, parent.texture_coordinates[parents].astype(float))
    np.testing.assert_allclose(mesh.texture_coordinates, uv, atol=1e-6)
    colors = np.einsum("ij,ijk->ik", weights, parent.vertex_colors[parents].astype(float))
    assert np.array_equal(mesh.vertex_colors, np.rint(colors).astype(np.uint8))
    of_faces = parent.materials.face_materials[derived.face_parents]
    assert np.array_equal(mesh.materials.face_materials, of_faces)
    assert np.array_equal(mesh.materials.colors, parent.materials.colors)
    assert list(mesh.textures) == [0]


def test_layers_of_stored_values_and_of_labels(map_file):
    mesh_map = refined(map_file.path, [stored(), FORBIDDEN])[1]
    derived = mesh_map.geometry.derived
    expected = derived.vertex_values(map_file.vertex_costs("values"))
    np.testing.assert_array_equal(mesh_map.layers["values"].result.costs, expected)
    lethal = mesh_map.layers["forbidden"].result.lethal
    of_label = np.zeros(len(lethal), bool)
    of_label[derived.faces[derived.face_parents == 1]] = True
    assert np.array_equal(lethal, of_label)


def test_inflation_lives_on_the_vertices_between(map_file):
    """On the mesh as it is, all four corners of the floor are lethal or none is."""
    mesh_map = refined(map_file.path, [FORBIDDEN, INFLATION], max_edge_length=0.2)[1]
    costs = mesh_map.layers["inflation"].result.costs
    between = np.isfinite(costs) & (costs > 0)
    assert between.sum() > 100
    # The floor's second face is the triangle over the corners (0, 0), (8, 6) and (0, 6).
    x, y, z = mesh_map.vertices[between].T
    distances = np.abs(6 * x - 8 * y) / 10.0
    assert (z == 0).all() and (distances <= 0.4 + 0.2).all()


def test_labels_of_the_moment_are_carried(map_file):
    mesh_map = refined(map_file.path, [FORBIDDEN])[1]
    with LabelStore(map_file.path, "mesh") as store:
        store.set("forbidden", np.array([0], np.uint32), override=True)
        faces = mesh_map.contents.label("forbidden").faces
        assert set(mesh_map.geometry.derived.face_parents[faces].tolist()) == {0}


def test_saved_layers_are_those_of_the_parents_vertices(map_file, caplog):
    source, mesh_map = refined(
        map_file.path,
        [
            {"name": "height", "type": "mesh_layers/HeightDiffLayer"},
            {"name": "steepness", "type": "mesh_layers/SteepnessLayer"},
        ],
    )
    assert sorted(source.save_layers(mesh_map.layers)) == ["height", "steepness"]
    saved = MapFile(map_file.path)
    assert saved.uuid == map_file.uuid and saved.vertex_count == map_file.vertex_count
    for name in ("height", "steepness"):
        costs = mesh_map.layers[name].result.costs
        np.testing.assert_array_equal(saved.vertex_costs(name), costs[: saved.vertex_count])
        assert saved.layer_parameters(name)["geometry"] == mesh_map.geometry.content_uuid
    assert not saved.has_normals  # those of the derived mesh would be of no use
    # Nobody takes them for what was computed on the parent, or for all of the derived mesh.
    caplog.set_level(logging.INFO, "mesh_map")
    whole = MapSource(map_file.path)
    plain = whole.make_map()
    plain.compute_layers(
        [{"name": "height", "type": "mesh_layers/HeightDiffLayer"}], stored=whole.stored_costs
    )
    assert "layer height is computed anew" in caplog.text and "geometry" in caplog.text
    again = refined(map_file.path, [{"name": "height", "type": "mesh_layers/HeightDiffLayer"}])[1]
    np.testing.assert_array_equal(
        again.layers["height"].result.costs, mesh_map.layers["height"].result.costs
    )


def test_flat_faces_have_their_own_normals(map_file):
    """Whatever is between the corners of a box is flat, also where the file has round normals."""
    vertices, faces = welded(box((0.0, 0.0, 0.0), (4.0, 4.0, 4.0)))
    round_normals = vertices - vertices.mean(0)
    round_normals /= np.linalg.norm(round_normals, axis=1)[:, None]
    MapFile.write(
        map_file.path,
        Mesh(np.float32(vertices), np.uint32(faces), vertex_normals=np.float32(round_normals)),
    )
    mesh_map = refined(map_file.path)[1]
    normals, points = mesh_map.vertex_normals, mesh_map.vertices
    np.testing.assert_allclose(normals[: len(vertices)], round_normals, atol=1e-6)
    outer = (points == 0.0) | (points == 4.0)
    inside = outer.sum(1) == 1
    assert inside.sum() > 100
    expected = np.where(outer, np.sign(points - 2.0), 0.0)
    np.testing.assert_allclose(normals[inside], expected[inside], atol=1e-6)


def test_the_parameter(map_file, caplog):
    values = {"mesh_file": map_file.path, "max_edge_length": 1}
    assert map_parameters(values).geometry["max_edge_length"] == 1.0
    assert map_parameters({"mesh_file": map_file.path}).geometry["max_edge_length"] == 0.0
    with pytest.raises(MeshMapError, match="max_edge_length"):
        map_parameters(dict(values, max_edge_length="short"))
    assert map_parameters(dict(values, max_edge_length=-1)).geometry["max_edge_length"] == 0.0
    assert "max_edge_length is -1, outside of [0" in caplog.text


def test_large_faces_are_said_with_the_way_out(map_file):
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    assert coarse_remark(mesh_map) == ""
    remark = coarse_remark(mesh_map, {"the robot's radius": 0.25})
    assert "100 % of the surface" in remark and "the robot's radius, 0.25 m" in remark
    assert "the longest has 10 m" in remark and "max_edge_length: 0.12, half" in remark
    assert "0.25 where no passage is narrow" in remark
    assert coarse_remark(mesh_map, {"the robot's radius": 0.0}) == ""
    assert coarse_remark(mesh_map, {"the robot's radius": 10.1}) == ""
    mesh_map.compute_layers([FORBIDDEN, INFLATION])
    remark = coarse_remark(mesh_map, {"the robot's radius": 0.3})
    assert "inscribed_radius of layer inflation, 0.25 m" in remark
    finer = refined(map_file.path, [FORBIDDEN, INFLATION], max_edge_length=0.25)[1]
    assert coarse_remark(finer, {"the robot's radius": 0.3}) == ""


def ledge(size, edge, rise):
    """(V,3), (F,3): a floor whose half is higher, with one steep row of faces between."""
    vertices, faces = floor((0.0, 0.0), (size, size), edge)
    vertices = np.array(vertices)
    vertices[vertices[:, 0] > 0.5 * size + 0.25 * edge, 2] += rise
    return np.float32(vertices), np.uint32(faces)


@pytest.mark.parametrize("rise, steep", [(0.45, 240), (0.2, 0)])
def test_a_step_without_a_vertex_between_its_ends_is_said_however_small_it_is(rise, steep):
    """Both ends of a step are level: within the radius layers have nothing to compare it with."""
    mesh_map = MeshMap(*ledge(12.0, 0.1, rise))
    remark = coarse_remark(mesh_map, {"the robot's radius": 0.25})
    assert ("%d faces steeper than 45 degrees" % steep in remark) == (steep > 0)
    assert ("of the surface" in remark, "up to 0.45 m" in remark) == (False, steep > 0)
    assert bool(remark) == (steep > 0) == ("max_edge_length: 0.12" in remark)
    assert coarse_remark(mesh_map, {"the robot's radius": 0.5}) == ""
    height_diff = {"name": "steps", "type": "mesh_layers/HeightDiffLayer"}
    robot = {"the robot's radius": 0.25}
    cases = [({}, False), ({"large_faces": False}, True), ({"enabled": False}, True)]
    for params, said in (*cases, ({"threshold": 0.3, "radius": 0.3}, True)):
        mesh_map.compute_layers([dict(height_diff, params=params)])
        assert bool(coarse_remark(mesh_map, robot)) == (said and steep > 0), params


def test_a_layer_that_is_not_enabled_has_no_radius(map_file):
    source = MapSource(map_file.path)
    mesh_map = source.make_map()
    off = dict(INFLATION, params=dict(INFLATION["params"], enabled=False))
    mesh_map.compute_layers([FORBIDDEN, off])
    assert coarse_remark(mesh_map) == ""


def test_some_long_edges_at_the_rim_are_not_said(tmp_path):
    fine = floor((0.0, 0.0), (10.0, 10.0), 0.1)
    sliver = np.array([[0.0, -1.0, 0.0], [9.0, -1.0, 0.0], [9.0, -0.9, 0.0]]), np.array([[0, 1, 2]])
    vertices, faces = joined(fine, sliver)
    path = MapFile.write(
        str(tmp_path / "map.h5"), Mesh(np.float32(vertices), np.uint32(faces))
    ).path
    assert coarse_remark(MapSource(path).make_map(), {"the robot's radius": 0.25}) == ""
