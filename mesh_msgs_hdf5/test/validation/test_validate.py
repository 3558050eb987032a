"""The findings about meshes, against what is known of each and against slow and simple counts."""
import collections
import os
import subprocess
import sys

import numpy as np
import pytest
from mesh_msgs import zoo
from peak_memory import peak_memory

from mesh_msgs_hdf5 import _surface
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.convert import convert
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh
from mesh_msgs_hdf5.validation.findings import ERROR, NOTE, RULES, WARNING, counts
from mesh_msgs_hdf5.validation.validate import validate
from mesh_msgs_hdf5.validation.validate_shape import check_shape
from mesh_msgs_hdf5.validation.validate_topology import check_topology
from mesh_msgs_hdf5.validation.validate_values import (
    check_attribute,
    check_labels,
    check_layer,
    check_textures,
)

MESHES = [mesh for mesh in zoo.all_meshes() if len(mesh.faces)]
WORLD = zoo.outdoor_world(2000)
# trait -> rules of which at least one is broken exactly where the trait is there
TRAITS = {
    "boundary": {"boundary"},
    "degenerate": {"repeated_vertex", "zero_area", "sliver"},
    "isolated_vertices": {"isolated_vertices"},
    "duplicate_vertices": {"duplicate_vertices"},
    "duplicate_faces": {"duplicate_faces"},
    "far": {"far_from_origin"},
}
NOT_TRAITS = {
    "manifold": {"nonmanifold_edges", "nonmanifold_vertices"},
    "connected": {"components", "isolated_vertices"},
    "oriented": {"flipped_neighbors", "nonmanifold_edges"},
}


def findings(vertices, faces, normals=None):
    found = list(check_topology(len(vertices), faces)) + list(check_shape(vertices, faces, normals))
    assert all(f.rule in RULES and f.level in (WARNING, NOTE) for f in found)
    assert len({f.rule for f in found}) == len(found)
    return {f.rule: f for f in found}


@pytest.mark.parametrize("mesh", MESHES, ids=lambda mesh: mesh.name)
def test_findings_are_the_traits_of_the_zoo(mesh):
    found = set(findings(mesh.vertices, mesh.faces))
    for trait, rules in TRAITS.items():
        assert bool(rules & found) == (trait in mesh.traits), trait
    for trait, rules in NOT_TRAITS.items():
        # three faces at an edge: two of them run the same way, oriented or not
        if trait != "oriented" or "nonmanifold_edges" not in found:
            assert bool(rules & found) == (trait not in mesh.traits), trait


def slow_counts(vertices, faces):
    """Counts by dictionaries and searches: {rule: (count, first)}."""
    count = {}
    edges, fans = collections.defaultdict(list), collections.defaultdict(list)
    plain = [i for i, face in enumerate(faces.tolist()) if len(set(face)) == 3]
    for i in plain:
        face = faces[i].tolist()
        for k in range(3):
            edges[tuple(sorted((face[k], face[k - 2])))].append((i, face[k] < face[k - 2]))
            fans[face[k]].append(i)
    count["nonmanifold_edges"] = sum(len(sides) > 2 for sides in edges.values())
    count["boundary"] = sum(len(sides) == 1 for sides in edges.values())
    count["flipped_neighbors"] = sum(
        len(sides) == 2 and sides[0][1] == sides[1][1] for sides in edges.values()
    )
    count["nonmanifold_vertices"] = 0
    for vertex, around in fans.items():
        rest, bunches = set(around), 0
        while rest:
            bunches, todo = bunches + 1, [rest.pop()]
            while todo:
                here = set(faces[todo.pop()].tolist()) - {vertex}
                near = {i for i in rest if here & (set(faces[i].tolist()) - {vertex})}
                rest -= near
                todo += near
        count["nonmanifold_vertices"] += bunches > 1
    count["isolated_vertices"] = len(set(range(len(vertices))) - set(faces.ravel().tolist()))
    count["duplicate_faces"] = len(faces) - len({tuple(sorted(f)) for f in faces.tolist()})
    count["duplicate_vertices"] = len(vertices) - len({tuple(v) for v in (vertices + 0.0).tolist()})
    count["repeated_vertex"] = len(faces) - len(plain)
    return count


@pytest.mark.parametrize("seed", range(6))
def test_counts_are_those_of_a_slow_search(seed):
    rng = np.random.default_rng(seed)
    vertices = rng.integers(0, 4, (30, 3)).astype(np.float32)
    vertices[5] = -0.0
    vertices[6] = 0.0
    faces = rng.integers(0, 26, (40, 3)).astype(np.uint32)
    faces[30:] = faces[:10, [1, 2, 0]]
    found = findings(vertices, faces)
    for rule, count in slow_counts(vertices, faces).items():
        assert (found[rule].count if rule in found else 0) == count, rule
        first = found[rule].first if rule in found else None
        if rule == "duplicate_faces":
            known = [tuple(sorted(face)) for face in faces.tolist()]
            assert first == next(i for i, face in enumerate(known) if face in known[:i])
        if rule == "repeated_vertex" and first is not None:
            assert first == next(i for i, face in enumerate(faces.tolist()) if len(set(face)) < 3)


def shapes_by_numpy(vertices, faces):
    """Twice the areas (F,), squares of the longest edges, z of the normals, normals of vertices."""
    a, b, c = np.moveaxis(vertices[faces].astype(np.float64), 1, 0)
    crosses = np.cross(b - a, c - a)
    edges = [((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))]
    around = np.zeros((len(vertices), 3))
    for axis in range(3):
        weights = np.repeat(crosses[:, axis], 3)
        around[:, axis] = np.bincount(faces.ravel(), weights, minlength=len(vertices))
    return np.linalg.norm(crosses, axis=1), np.max(edges, 0), np.sign(crosses[:, 2]), around


@pytest.mark.parametrize("scale", [1.0, 1e-3, 4567.8])
def test_areas_and_normals_are_those_of_numpy_to_the_last_bit(scale):
    vertices = WORLD.vertices * np.float32(scale)
    found = _surface._shapes(vertices, WORLD.faces)
    for one, other in zip(found, shapes_by_numpy(vertices, WORLD.faces)):
        assert np.array_equal(one, other)


def test_a_large_mesh_takes_little_memory():
    grid = zoo.grid(500)
    normals = np.tile(np.float32([0, 0, 1]), (len(grid.vertices), 1))
    findings(grid.vertices[:4], np.uint32([[0, 1, 2], [0, 2, 3]]), normals[:4])  # what is imported
    with peak_memory() as growth:
        assert set(findings(grid.vertices, grid.faces, normals)) == {"boundary"}
        assert growth() * 1024 < 100 * len(grid.faces)  # 1.5 GB for 10 million, with the mesh


def test_indices_that_are_none_do_not_reach_the_loops():
    vertices, wrong = np.zeros((3, 3), np.float32), np.uint32([[0, 1, 3]])
    for call in (
        lambda: _surface._surface(wrong, 3),
        lambda: _surface._repeated_faces(wrong, 3),
        lambda: _surface._shapes(vertices, wrong),
    ):
        with pytest.raises(IndexError):
            call()


def test_a_large_world_has_the_parts_that_it_was_made_of():
    found = findings(WORLD.vertices, WORLD.faces)
    assert set(found) <= {"boundary", "components", "sliver"}
    assert found["components"].count > 1


def test_the_real_meshes(real_mesh):
    garden, _ = read_mesh(real_mesh("botanical_garden_gazebo.ply"))
    found = findings(garden.vertices, garden.faces, garden.vertex_normals)
    assert found["components"].count == 382 and found["nonmanifold_vertices"].count == 1139
    assert "nonmanifold_edges" not in found
    tray, _ = read_mesh(real_mesh("tray.ply"))
    found = findings(tray.vertices, tray.faces, tray.vertex_normals)
    assert found["boundary"].count == 96
    assert not {"nonmanifold_edges", "nonmanifold_vertices", "flipped_neighbors"} & set(found)


def test_normals_and_which_way_up():
    grid = zoo.grid(3)
    up = np.tile(np.float32([0, 0, 1]), (len(grid.vertices), 1))
    assert not set(findings(grid.vertices, grid.faces, up)) - {"boundary"}
    up[2], up[4], up[5] = (0, 0, 0), (0, 0, 2), (0, 0, -1)
    found = findings(grid.vertices, grid.faces, up)
    assert [found[r].first for r in ("normal_zero", "normal_length", "normal_flipped")] == [2, 4, 5]
    assert all(found[r].count == 1 for r in ("normal_zero", "normal_length", "normal_flipped"))
    found = findings(grid.vertices, grid.faces[:, ::-1].copy())
    assert found["faces_down"].count == len(grid.faces)


def of(rows):
    return [(f.rule, f.level, f.where, f.first, f.count) for f in rows]


def test_values_of_layers_attributes_labels_and_textures():
    nan, inf = np.nan, np.inf
    layer = check_layer("slope", np.float32([1, -1, nan, inf, -2]))
    assert of(layer) == [
        ("layer_negative", WARNING, "layer slope", 1, 2),
        ("layer_unknown", NOTE, "layer slope", 2, 1),
    ]
    assert of(check_layer("x", np.float32([nan, nan]))) == [
        ("layer_all_unknown", WARNING, "layer x", None, None)
    ]
    assert not list(check_layer("x", np.float32([0, inf])))
    values = np.float64([[1, 2], [1, nan], [inf, 0]])
    assert of(check_attribute("face", "n", values)) == [
        ("attribute_not_finite", NOTE, "face attribute n", 1, 2)
    ]
    assert not list(check_attribute("face", "n", np.arange(3)))
    faces = {"a_1": [5, 1], "b": [], "c_1": [2, 1, 5], "d_1": [5, 7]}
    labels = {text: Label(np.array(of, dtype=np.uint32)) for text, of in faces.items()}
    assert of(check_labels(labels, 8)) == [
        ("label_empty", WARNING, "label b", None, None),
        ("labels_overlap", WARNING, "label c_1", 1, 2),
        ("labels_overlap", WARNING, "label d_1", 5, 1),
    ]
    materials = Materials(
        np.zeros((3, 3), dtype=np.uint8), np.int32([-1, 4, 4]), np.uint32([0, 2, 2])
    )
    assert of(check_textures([4, 6], materials, None)) == [
        ("texture_unused", WARNING, "texture 6", None, None),
        ("texture_coordinates_missing", WARNING, "textures", None, None),
        ("material_unused", WARNING, "materials", 1, 1),
    ]
    assert not list(check_textures([], None, None))


@pytest.fixture
def grid_map(tmp_path):
    mesh = zoo.grid(3)
    MapFile.write(tmp_path / "grid.h5", Mesh(mesh.vertices, mesh.faces))
    return tmp_path / "grid.h5"


@pytest.mark.parametrize("profile", ["s1", "lvr2", "both", "ros2"])
def test_a_map_over_which_lvr2_ends_is_noted_with_the_way_out(tmp_path, rich_mesh, profile):
    path, target = str(tmp_path / "a.h5"), str(tmp_path / "b.h5")
    MapFile.write(path, rich_mesh)
    convert(path, target, profile=profile)
    found = [f for f in validate(target) if f.rule == "lvr2_textures"]
    assert len(found) == (profile == "s1")
    for finding in found:
        assert (finding.level, finding.where) == (NOTE, "textures") and finding.rule in RULES
        for words in ("mesh_tool convert --for lvr2", "hdf5_map_io finds no materials", "both"):
            assert words in finding.message
    assert not [f for f in validate(target) if f.level == ERROR]


def test_a_good_map_has_notes_only(grid_map):
    assert {(f.rule, f.level) for f in validate(str(grid_map))} == {("boundary", NOTE)}


def test_what_lies_beside_a_map(grid_map):
    stale = grid_map.parent / (".grid.h5.0011.mesh_msgs_hdf5.tmp")
    other = grid_map.parent / (".other.h5.0011.mesh_msgs_hdf5.tmp")
    stale.write_bytes(b"half")
    other.write_bytes(b"half")
    with LabelStore(grid_map) as store:
        assert "journal" not in {f.rule for f in validate(str(grid_map))}
        store.set("tree_1", [1, 2])
        store.set("tree_2", [3])
    found = {f.rule: f for f in validate(str(grid_map))}
    assert found["stale_temporary"].count == 1 and stale.name in found["stale_temporary"].message
    assert "grid.h5.journal" in found["journal"].message and found["journal"].count == 2
    mesh = zoo.grid(4)
    MapFile.write(grid_map, Mesh(mesh.vertices, mesh.faces))
    (journal,) = [f for f in validate(str(grid_map)) if f.rule == "journal"]
    assert "another" in journal.message or "geometry" in journal.message, journal
    stale.write_bytes(b"half")
    with stale.open("rb") as held:  # a program that saves at this moment
        code = "import fcntl, sys; fcntl.flock(0, fcntl.LOCK_EX); print(1, flush=True); input()"
        code = code.replace("input()", "import time; time.sleep(60)")
        saving = subprocess.Popen([sys.executable, "-c", code], stdin=held, stdout=subprocess.PIPE)
    try:
        saving.stdout.readline()
        assert "stale_temporary" not in {f.rule for f in validate(str(grid_map))}
    finally:
        saving.kill()
        saving.communicate()


def test_every_member_is_looked_at_although_one_is_broken(grid_map):
    h5py = pytest.importorskip("h5py")
    with h5py.File(grid_map, "r+") as file:
        channels = file["mesh/channels"]
        channels["broken"] = np.zeros((16, 1), dtype="f4")
        channels["vertex_normals"] = np.full((16, 3), np.nan, dtype="f4")
        channels["slope"] = np.full((16, 1), -1, dtype="f4")
        file["mesh/labels/tree/1"] = np.array([99], dtype="u4")
        channels["vertices"][3] = 7
    found = validate(str(grid_map))
    assert [f.level for f in found] == sorted(
        (f.level for f in found), key=(ERROR, WARNING, NOTE).index
    )
    errors = {f.where: f.rule for f in found if f.level == ERROR}
    assert errors == {
        "vertex_normals": "not_finite",
        "label tree_1": "index",
        "uuid": "uuid_mismatch",
    }
    assert ("layer_negative", "layer slope") in {(f.rule, f.where) for f in found}
    assert counts(found)[ERROR] == 3


def test_the_uuid_of_other_peoples_files(grid_map):
    h5py = pytest.importorskip("h5py")
    with h5py.File(grid_map, "r+") as file:
        del file["mesh"].attrs["schema_version"]
        file["mesh"].attrs["uuid"] = "mesh"
    assert ("uuid_mismatch", WARNING) in {(f.rule, f.level) for f in validate(str(grid_map))}
    with h5py.File(grid_map, "r+") as file:
        del file["mesh"].attrs["uuid"]
    assert ("uuid_missing", WARNING) in {(f.rule, f.level) for f in validate(str(grid_map))}


@pytest.mark.parametrize("content", [b"", b"nothing", b"\x89HDF\r\n\x1a\n"])
def test_a_file_that_cannot_be_read_is_one_error(tmp_path, content):
    (tmp_path / "a.h5").write_bytes(content)
    (finding,) = validate(str(tmp_path / "a.h5"))
    assert finding.level == ERROR and finding.where == "file" and os.path.exists(tmp_path / "a.h5")
    (finding,) = validate(str(tmp_path / "missing.h5"))
    assert finding.rule == "missing"
