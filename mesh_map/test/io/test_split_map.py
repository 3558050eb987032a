"""Maps of meshes with copies of vertices along the seams of textures: no seam cuts the surface."""

import logging
from types import SimpleNamespace

import numpy as np
import pytest
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.refinement import refine
from mesh_map.io import map_messages
from mesh_map.io.map_source import MapSource
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.identity import geometry_uuid
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.edit import Edit
from seam_maps import MODELS, textured_terrain, write_maps, write_obj

LAYERS = [
    {"name": name, "type": "mesh_layers/" + kind, "params": params}
    for name, kind, params in (
        ("height", "HeightDiffLayer", {"radius": 0.4}),
        ("roughness", "RoughnessLayer", {"radius": 0.4}),
        ("steepness", "SteepnessLayer", {}),
        ("ridge", "RidgeLayer", {"radius": 0.4}),
        ("border", "BorderLayer", {}),
        ("clearance", "ClearanceLayer", {}),
        ("collision", "CollisionLayer", {}),
        ("values", "StoredLayer", {}),
        ("speed", "SpeedLimitLayer", {"face_attribute": "speed"}),
        ("forbidden", "LabelLayer", {"lethal": ["forbidden"]}),
        ("inflation", "InflationLayer", {"inputs": ["forbidden", "steepness"]}),
        ("sum", "SumCombinationLayer", {"inputs": ["height", "values"]}),
    )
]
LENGTH = 0.12


@pytest.fixture(params=MODELS)
def maps(request, tmp_path):
    return write_maps(tmp_path, MODELS[request.param]())


def loaded(path, layers=LAYERS, **options):
    source = MapSource(path)
    mesh_map = source.make_map(**options)
    mesh_map.compute_layers(list(layers), stored=source.stored_costs)
    return source, mesh_map


@pytest.mark.parametrize("length", [0.0, LENGTH])
def test_every_layer_is_that_of_the_mesh_without_textures(maps, length):
    """Bit for bit, and so is a plan."""
    found, plain = (loaded(path, max_edge_length=length)[1] for path in maps)
    assert plain.geometry.split is None and len(found.geometry.split.originals)
    assert found.vertices.tobytes() == plain.vertices.tobytes()
    assert found.faces.tobytes() == plain.faces.tobytes()
    assert found.vertex_normals.tobytes() == plain.vertex_normals.tobytes()
    assert found.topology.counts() == plain.topology.counts()
    assert not found.layer_errors and list(found.layers) == list(plain.layers)
    for name, layer in plain.layers.items():
        for ours, theirs in zip(found.layers[name].result, layer.result):
            assert (ours is None) == (theirs is None), name
            assert ours is None or ours.tobytes() == theirs.tobytes(), name
    costs = [mesh_map.planning_costs().costs.tobytes() for mesh_map in (found, plain)]
    assert costs[0] == costs[1]
    (ours, path), (theirs, expected) = (plan(mesh_map) for mesh_map in (found, plain))
    assert np.isfinite(ours).sum() > 5 and ours.tobytes() == theirs.tobytes()
    assert path.points.tobytes() == expected.points.tobytes() and len(path.faces) > 1
    faces = found.geometry.split.faces[path.faces]
    crossed = faces != found.faces[path.faces]
    assert crossed.any()  # corners of the faces on the way are copies: a seam is there


def plan(mesh_map):
    """(the potential of one corner of the map (V,), the path from the face farthest of it)."""
    goal = int(mesh_map.vertices.sum(1).argmin())
    field = WaveFrontSolver(mesh_map.geometry).solve(goal)
    potential = field.potential
    middle = mesh_map.vertices[mesh_map.faces].mean(axis=1)
    far = np.where(np.isfinite(potential[mesh_map.faces]).all(1), middle.sum(1), -np.inf).argmax()
    start = SimpleNamespace(face=int(far), position=middle[far].astype(np.float64))
    return potential, FieldTracer(mesh_map.geometry).path(field, start)


def test_what_is_shown_is_the_mesh_of_the_file(maps):
    """So it has the file's textures, and those who have its UUID know its vertices."""
    path = maps[0]
    _, mesh_map = loaded(path)
    file = MapFile(path).read()
    message = map_messages.geometry_message(mesh_map)
    geometry = message.mesh_geometry
    assert message.uuid == MapFile(path).uuid == geometry_uuid(file.vertices, file.faces)
    assert np.asarray(geometry.vertices).tobytes() == file.vertices.tobytes()
    assert np.asarray(geometry.faces).tobytes() == file.faces.tobytes()
    originals, count = file.seam_originals, len(mesh_map.vertices)
    for costs in [layer.result.costs for layer in mesh_map.layers.values()]:
        shown = map_messages.costs_message(mesh_map, "x", costs).mesh_vertex_costs.costs
        assert len(shown) == len(file.vertices)
        np.testing.assert_array_equal(shown[:count], costs)
        np.testing.assert_array_equal(shown[count:], costs[originals])
    normals = np.asarray(geometry.vertex_normals)
    assert np.array_equal(normals[count:], normals[originals])
    assert mesh_map.contents.read().textures.keys() == file.textures.keys()
    copies = "%s copies along seams" % format(len(originals), ",")
    assert "shown with " + copies in mesh_map.report()


def test_updates_change_copies_too(maps):
    _, mesh_map = loaded(maps[0], ())
    count, rng = len(mesh_map.vertices), np.random.default_rng(0)
    originals = mesh_map.geometry.split.originals
    before = rng.random(count).astype(np.float32)
    for share in (0.0, 0.1, 1.0):
        vertices = np.flatnonzero(rng.random(count) < share)
        after = before.copy()
        after[vertices] = rng.random(len(vertices))
        update = map_messages.update_message(mesh_map, "x", vertices, after[vertices])
        sparse = update.mesh_vertex_costs
        shown = np.concatenate([before, before[originals]])
        shown[np.asarray(sparse.vertices)] = np.asarray(sparse.costs)
        np.testing.assert_array_equal(shown, np.concatenate([after, after[originals]]))


def test_layers_are_stored_for_all_vertices_and_read_back(maps, caplog):
    source, mesh_map = loaded(maps[0])
    names = source.save_layers(mesh_map.layers)
    assert "height" in names and "inflation" in names
    file, originals = MapFile(maps[0]), mesh_map.geometry.split.originals
    for name in names:
        costs = mesh_map.layers[name].result.costs
        expected = np.concatenate([costs, costs[originals]])
        np.testing.assert_array_equal(file.vertex_costs(name), expected)
        info = file.layer_parameters(name)["layer_info"]
        lethal = mesh_map.layers[name].result.lethal
        assert info["lethal"] == lethal.sum() + lethal[originals].sum()
        assert info["unknown"] == np.isnan(expected).sum()
        assert file.layer_parameters(name)["geometry"] == file.parent_uuid
    assert len(file.vertex_normals) == file.vertex_count and file.uuid == mesh_map.uuid
    # what is stored is used, whoever computed it
    caplog.set_level(logging.INFO, "mesh_map")
    marked = np.linspace(0, 1, len(mesh_map.vertices)).astype(np.float32)
    shown = np.concatenate([marked, marked[originals]])
    parameters = file.layer_parameters("height")
    file.write_layers({"height": (shown, parameters)})
    again = loaded(maps[0])[1]
    np.testing.assert_array_equal(again.layers["height"].result.costs, marked)
    assert "steepness is computed anew" not in caplog.text
    # also that of the mesh without textures, which is the same surface
    MapFile(maps[1]).write_layers({"height": (marked, parameters)})
    assert np.array_equal(loaded(maps[1])[1].layers["height"].result.costs, marked)


def test_what_is_closed_on_one_side_of_a_seam_is_closed(maps):
    """Values of copies that somebody has edited: the largest counts, and NaN before it."""
    file = MapFile(maps[0])
    originals, count = file.seam_originals, len(file.read(()).vertices)
    values = np.zeros(count, np.float32)
    first = count - len(originals)
    values[first], values[first + 1] = np.inf, np.nan
    file.update(Edit(vertex_costs={"values": values}))
    source = MapSource(maps[0])
    found = source.make_map().contents.vertex_costs("values")
    expected = np.zeros(first, np.float32)
    expected[originals[0]] = np.inf
    expected[originals[1]] = np.nan
    np.testing.assert_array_equal(found, expected)


def test_textures_follow_a_refinement(maps):
    """As they do when the mesh with copies itself is refined, but with other numbers."""
    source, mesh_map = loaded(maps[0], (), max_edge_length=LENGTH)
    file, geometry = MapFile(maps[0]).read(), mesh_map.geometry
    direct = refine(file.vertices, file.faces, LENGTH)
    shown = mesh_map.contents.read()
    assert geometry.derived.parent_uuid == MapFile(maps[0]).uuid
    assert np.array_equal(shown.vertices[shown.faces], direct.vertices[direct.faces])
    uv = direct.vertex_values(file.texture_coordinates)
    assert np.array_equal(shown.texture_coordinates[shown.faces], uv[direct.faces])
    assert shown.parent_faces.tobytes() == mesh_map.faces.tobytes()
    assert shown.parent_vertices.tobytes() == mesh_map.vertices.tobytes()
    assert len(shown.textures) == 1
    message = map_messages.geometry_message(mesh_map)
    assert message.uuid == geometry.derived.uuid
    assert np.array_equal(message.mesh_geometry.faces, shown.faces)
    assert np.array_equal(message.mesh_geometry.vertices, shown.vertices)


def test_saved_layers_of_a_refinement(maps):
    source, mesh_map = loaded(maps[0], LAYERS[:1], max_edge_length=LENGTH)
    source.save_layers(mesh_map.layers)
    file = MapFile(maps[0])
    first = len(file.vertex_costs("height")) - len(file.seam_originals)
    costs = mesh_map.layers["height"].result.costs[:first]
    expected = np.concatenate([costs, costs[file.seam_originals]])
    np.testing.assert_array_equal(file.vertex_costs("height"), expected)


@pytest.mark.parametrize("length", [0.0, LENGTH])
def test_colors_are_those_of_all_vertices(tmp_path, maps, length):
    mesh = MapFile(maps[0]).read()
    colors = np.random.default_rng(0).integers(0, 256, (len(mesh.vertices), 3)).astype(np.uint8)
    MapFile(maps[0]).update(Edit(vertex_colors=colors))
    source, mesh_map = loaded(maps[0], (), max_edge_length=length)
    if not length:
        assert np.array_equal(source.vertex_colors, colors)
        return
    direct = refine(mesh.vertices, mesh.faces, length)
    faces = mesh_map.geometry.split.faces
    expected = direct.vertex_values(colors)[direct.faces]
    assert np.array_equal(source.vertex_colors[faces], expected)


def test_turned_faces_are_shown_turned(maps):
    _, mesh_map = loaded(maps[0], (), orient=True, up_direction=(0.0, 0.0, -1.0))
    assert mesh_map.geometry.orientation.turned.any() or len(mesh_map.faces) == 12
    split = mesh_map.geometry.split
    assert np.array_equal(split.parent_faces, mesh_map.faces)
    message = map_messages.geometry_message(mesh_map)
    assert np.array_equal(message.mesh_geometry.faces, split.faces)
    assert message.uuid == MapFile(maps[0]).uuid


def test_a_mesh_of_another_format(tmp_path):
    """Its seams are split when it is opened, and its surface is whole."""
    model = textured_terrain()
    source, mesh_map = loaded(write_obj(tmp_path, model), LAYERS[:1])
    assert np.array_equal(mesh_map.vertices, model[0]) and np.array_equal(mesh_map.faces, model[1])
    assert mesh_map.geometry.split is not None and len(source.contents.read().textures) == 1
    assert mesh_map.geometry.content_uuid == geometry_uuid(*model[:2])


def test_a_map_without_table_is_as_it_was(maps):
    """Imported by a version of before: its seams are borders."""
    mesh = MapFile(maps[0]).read()
    uuid, mesh.seam_originals = mesh.uuid, None
    MapFile.write(maps[0], mesh)
    _, mesh_map = loaded(maps[0], LAYERS[:1])
    assert mesh_map.geometry.split is None and mesh_map.uuid == uuid
    assert len(mesh_map.vertices) == len(mesh.vertices)
    assert mesh_map.geometry.content_uuid == uuid


def test_a_general_derived_mesh_is_the_same(maps):
    """The split mesh is a derived mesh of the one that maps are of."""
    _, mesh_map = loaded(maps[0], ())
    split = mesh_map.geometry.split
    assert isinstance(split, DerivedMesh)
    assert split.parent_vertex_count == len(mesh_map.vertices)
    assert np.array_equal(split.parent_vertices, mesh_map.vertices)
