"""Border loops and holes closed: what was one surface is one again, with no new fault."""

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.border_loops import border_loops
from mesh_map.geometry.components import face_areas
from mesh_map.geometry.hole_filling import LoopFate, fill_holes
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology
from mesh_map.layers.threshold_layer import BorderLayer
from mesh_map.map.mesh_map import MeshMap
from mesh_map.spatial.spatial_index import SpatialIndex
from mesh_msgs import zoo
from meshes import small, soup, terrain


def topology(mesh):
    return Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))


def punched(mesh, centers, radius):
    """The faces of a mesh without those around some places, and how many loops that makes."""
    middles = mesh.vertices[mesh.faces].mean(1)
    near = np.zeros(len(middles), bool)
    for center in centers:
        near |= np.linalg.norm(middles[:, :2] - center, axis=1) < radius
    return mesh.faces[~near]


def loops_of(found):
    return [found.vertices[a:b].tolist() for a, b in zip(found.offsets[:-1], found.offsets[1:])]


@small
def test_loops_are_simple_and_have_every_border_edge_once(mesh):
    found = border_loops(mesh.faces, len(mesh.vertices))
    of_mesh = topology(mesh)
    sides = set()
    for loop in loops_of(found):
        assert len(set(loop)) == len(loop) >= 3
        sides |= set(zip(loop, loop[1:] + loop[:1]))
    assert len(sides) == len(found.vertices)
    edges = {tuple(sorted(side)) for side in sides}
    borders = set(map(tuple, of_mesh.edges[of_mesh.border_edges].tolist()))
    assert edges <= borders and len(borders) == len(edges) + found.open_edges
    for begin, end in zip(found.offsets[:-1], found.offsets[1:]):
        for place in range(begin, end):
            face = mesh.faces[found.faces[place]].tolist()
            following = found.vertices[place + 1 if place + 1 < end else begin]
            at = face.index(found.vertices[place])
            assert face[(at + 1) % 3] == following
    assert np.isclose(
        found.perimeters(mesh.vertices).sum(),
        sum(np.linalg.norm(mesh.vertices[a] - mesh.vertices[b]) for a, b in sides),
    )


def test_holes_that_touch_are_two_loops():
    mesh = zoo.grid(6, 6.0)
    cells = mesh.vertices[mesh.faces].mean(1)[:, :2].astype(int)
    gone = (cells == (2, 2)).all(1) | (cells == (3, 3)).all(1)
    faces = mesh.faces[~gone]
    loops = loops_of(border_loops(faces, len(mesh.vertices)))
    assert sorted(map(len, loops)) == [4, 4, 24]
    done = fill_holes(mesh.vertices, faces, max_perimeter=5.0)
    assert done.counts()["filled"] == 2 and done.counts()["outer"] == 1
    now = topology(done.derived)
    assert not now.non_manifold_vertices.any() and now.border_edges.sum() == 24


@small
@pytest.mark.parametrize("refine", [True, False])
def test_no_fault_is_made(mesh, refine):
    before = topology(mesh)
    for vertices, faces in ((mesh.vertices, mesh.faces), (mesh.vertices, mesh.faces[::2])):
        done = fill_holes(
            vertices,
            faces,
            max_perimeter=1e9,
            flatness=1e9,
            keep_outer=False,
            refine=refine,
        )
        if done.derived is None:
            continue
        before = Topology(faces=faces, vertex_count=len(vertices))
        derived, after = done.derived, topology(done.derived)
        assert np.array_equal(derived.faces[: len(faces)], faces)
        assert np.array_equal(derived.vertices[: len(vertices)], vertices)
        for name in ("non_manifold_edges", "inconsistent_edges", "duplicate_faces"):
            assert getattr(after, name).sum() == getattr(before, name).sum(), name
        assert after.border_edges.sum() < before.border_edges.sum()
        new = derived.faces[done.new_faces]
        assert (face_areas(derived.vertices, new) > 0.0).all()
        assert refine or len(derived.vertices) == len(vertices)


def test_a_punched_plane_is_the_plane_again():
    mesh = zoo.jittered_plane(30, 3.0)
    faces = punched(mesh, [(0.8, 0.9), (2.1, 1.9), (1.0, 2.2)], 0.22)
    done = fill_holes(mesh.vertices, faces, max_perimeter=3.0)
    derived = done.derived
    assert done.counts() == {**dict.fromkeys(done.counts(), 0), "filled": 3, "outer": 1}
    assert np.isclose(face_areas(derived.vertices, derived.faces).sum(), 9.0)  # nothing twice
    assert (MeshGeometry(derived.vertices, derived.faces).face_normals[:, 2] > 0.999).all()
    # edges as long as those around, and no slivers
    new = derived.vertices[derived.faces[done.new_faces]].astype(float)
    sides = np.linalg.norm(np.roll(new, -1, 1) - new, axis=2)
    assert sides.max() < 0.3 and 0.07 < sides.mean() < 0.13
    heights = 2.0 * face_areas(derived.vertices, derived.faces[done.new_faces]) / sides.max(1)
    assert np.percentile(heights / sides.max(1), 5) > 0.15
    # values are interpolated: x of new vertices, up to how they were moved to the middle
    x = derived.vertex_values(mesh.vertices[:, 0])
    assert np.abs(x - derived.vertices[:, 0]).max() < 1e-6


def test_faces_belong_to_the_face_beside():
    mesh = zoo.jittered_plane(30, 3.0)
    faces = punched(mesh, [(1.5, 1.5)], 0.25)
    derived = fill_holes(mesh.vertices, faces, max_perimeter=3.0).derived
    middles = derived.vertices[derived.faces].mean(1)
    gaps = np.linalg.norm(middles - middles[derived.face_parents], axis=1)
    assert gaps.max() < 0.4
    left = np.flatnonzero(mesh.vertices[faces].mean(1)[:, 0] < 1.5)
    of_label = derived.faces_of(left)
    assert (middles[of_label, 0] < 1.6).all()
    assert (np.delete(middles, of_label, axis=0)[:, 0] > 1.4).all()


@pytest.mark.parametrize("around", [(40, 12), (90, 30)])
def test_long_loops_are_closed_too(around):
    torus = zoo.torus(*around)
    ring = torus.vertices[torus.faces].mean(1)
    faces = torus.faces[~(np.hypot(ring[:, 0] - 2.0, ring[:, 1]) < 0.9)]
    done = fill_holes(torus.vertices, faces, max_perimeter=1e3, flatness=1.0, keep_outer=False)
    assert done.counts()["filled"] == len(done.fates) == 2
    assert not topology(done.derived).border_edges.any()


def test_a_loop_of_many_vertices_is_cut_ear_by_ear():
    count = 400
    angle = np.arange(count) * 2.0 * np.pi / count
    inner = (
        np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], 1)
        * (1 + 0.3 * np.cos(5 * angle))[:, None]
    )
    outer = np.stack([2 * np.cos(angle), 2 * np.sin(angle), 0.0 * angle], 1)
    i = np.arange(count)
    j = (i + 1) % count
    faces = np.concatenate([np.stack([i, i + count, j + count], 1), np.stack([i, j + count, j], 1)])
    vertices = np.concatenate([inner, outer]).astype(np.float32)
    done = fill_holes(vertices, faces.astype(np.uint32), max_perimeter=20.0)
    assert done.counts()["filled"] == 1
    area = 0.5 * np.abs(np.cross(outer[i, :2], outer[j, :2])).sum()
    assert np.isclose(face_areas(done.derived.vertices, done.derived.faces).sum(), area, rtol=1e-5)


def test_outer_borders_doorways_and_uneven_loops_stay():
    mesh = terrain()
    faces = punched(mesh, [(1.0, 1.0), (3.0, 2.5)], 0.3)
    fates = fill_holes(mesh.vertices, faces, max_perimeter=1e3).fates
    assert sorted(fates) == [LoopFate.FILLED, LoopFate.FILLED, LoopFate.OUTER]
    limited = fill_holes(mesh.vertices, faces, max_perimeter=0.5)
    assert limited.derived is None and not limited.new_faces.any()
    assert limited.counts()["long"] == 2 and "2 longer than the limit" in limited.report()
    assert fill_holes(mesh.vertices, faces, max_perimeter=9, flatness=1e-4).counts()["uneven"] == 2
    wall = mesh.vertices[:, [2, 0, 1]]
    steep = fill_holes(wall, faces, max_perimeter=9.0, max_slope=45.0)
    assert steep.counts()["steep"] == 2 and steep.derived is None
    assert (
        fill_holes(wall, faces, max_perimeter=9.0, max_slope=45.0, up=(1, 0, 0)).counts()["filled"]
        == 2
    )
    # a piece of ground whose border is short is no hole, even where that is not said
    alone = zoo.grid(3, 0.15)
    for keep in (True, False):
        assert fill_holes(alone.vertices, alone.faces, keep_outer=keep).derived is None


def test_what_stands_in_a_hole_is_not_crossed():
    mesh = zoo.grid(12, 1.2)
    faces = punched(mesh, [(0.6, 0.6)], 0.2)
    pole = np.float32([[0.6, 0.58, -1], [0.6, 0.62, -1], [0.6, 0.6, 1]])
    vertices = np.concatenate([mesh.vertices, pole])
    count = len(mesh.vertices)
    with_pole = np.concatenate([faces, np.uint32([[count, count + 1, count + 2]])])
    done = fill_holes(vertices, with_pole, max_perimeter=3.0)
    assert done.derived is None and done.counts()["crossing"] == 1
    assert fill_holes(mesh.vertices, faces, max_perimeter=3.0).counts()["filled"] == 1


def test_closed_solids_and_double_borders():
    sphere = zoo.sphere(3)
    assert len(fill_holes(sphere.vertices, sphere.faces).fates) == 0
    faces = sphere.faces[20:]
    done = fill_holes(sphere.vertices, faces, max_perimeter=20.0, flatness=1.0)
    assert not topology(done.derived).border_edges.any()
    origin = SpatialIndex(done.derived.vertices, done.derived.faces)
    assert origin.closest(point=(0, 0, 0)).distance > 0.6
    # two loops at the same places, of faces that do not share vertices: a slit has no area
    slit = zoo.duplicate_vertex()
    assert (
        fill_holes(slit.vertices, slit.faces, max_perimeter=9.0, keep_outer=False).derived is None
    )


def test_a_border_layer_finds_no_phantom_borders():
    mesh = terrain()
    faces = punched(mesh, [(1.0, 1.0), (3.0, 2.5), (2.0, 2.0)], 0.14)
    derived = fill_holes(mesh.vertices, faces, max_perimeter=2.0).derived
    layer = BorderLayer("border", {}, "mesh_layers/BorderLayer")
    costs = layer.evaluate(MeshMap(derived.vertices, derived.faces), {}).costs
    on_border = np.zeros(len(mesh.vertices), bool)
    on_border[np.flatnonzero(costs > 0.0)] = True  # new vertices would be out of range
    used = np.zeros(len(mesh.vertices), bool)
    used[faces] = True
    on_border &= used
    outside = (mesh.vertices[:, :2] <= 0.06).any(1) | (mesh.vertices[:, :2] >= 3.84).any(1)
    assert outside[on_border].all()


@pytest.mark.parametrize(
    "options,text",
    [
        ({"max_perimeter": -1.0}, "max_perimeter"),
        ({"max_perimeter": float("nan")}, "max_perimeter"),
        ({"flatness": -0.1}, "flatness"),
        ({"max_slope": 91.0}, "max_slope"),
        ({"max_perimeter": 3.0, "face_limit": 3}, "more new faces than 3"),
    ],
)
def test_limits_out_of_range_are_refused(options, text):
    mesh = zoo.jittered_plane(30, 3.0)
    with pytest.raises(MeshMapError, match=text):
        fill_holes(mesh.vertices, punched(mesh, [(1.5, 1.5)], 0.25), **options)


def test_no_mesh_is_refused():
    mesh = soup(1)
    broken = mesh.vertices.copy()
    broken[3] = np.nan
    with pytest.raises(MeshMapError, match="no usable mesh"):
        fill_holes(broken, mesh.faces)


def test_each_new_face_knows_its_loop():
    mesh = zoo.jittered_plane(30, 3.0)
    faces = punched(mesh, [(0.8, 0.9), (2.1, 1.9)], 0.22)
    done = fill_holes(mesh.vertices, faces, max_perimeter=3.0)
    loops = border_loops(faces, len(mesh.vertices))
    new = done.derived.faces[done.new_faces]
    assert len(done.face_loops) == len(new) and (np.diff(done.face_loops.astype(int)) >= 0).all()
    for loop in np.flatnonzero(done.fates == LoopFate.FILLED):
        corners = np.unique(new[done.face_loops == loop])
        own = loops.vertices[loops.offsets[loop] : loops.offsets[loop + 1]]
        assert np.array_equal(np.sort(own), corners[corners < len(mesh.vertices)])
    assert fill_holes(mesh.vertices, faces, max_perimeter=0.1).face_loops.size == 0
