"""Components dropped, and meshes made manifold: at the same places, with all faces."""

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.components import components, drop_components, face_areas
from mesh_map.geometry.manifold import make_manifold
from mesh_map.geometry.orientation import orient_towards
from mesh_map.geometry.topology import Topology
from mesh_msgs import zoo
from meshes import SMALL, small, soup, terrain

FAULTS = ("non_manifold_edges", "non_manifold_vertices", "degenerate_faces", "duplicate_faces")


def topology(mesh):
    return Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))


def cubes_at_an_edge():
    """Two cubes of one solid that touch along an edge, and both a third one below: the way around
    both ends of that edge leads from one cube to the other."""
    cells = [(0, 0, 1), (1, 1, 1), (0, 0, 0), (1, 1, 0), (0, 1, 0), (1, 0, 0)]
    cells += [(0, 0, 2), (1, 1, 2), (0, 1, 2), (1, 0, 2)]
    taken = set(cells)
    quads = []
    for cell in cells:
        for axis in range(3):
            for side in (0, 1):
                beside = list(cell)
                beside[axis] += 2 * side - 1
                if tuple(beside) in taken:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                corners = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[u] += du
                    corner[v] += dv
                    corners.append(tuple(corner))
                quads.append(corners if side else corners[::-1])
    points = sorted({corner for quad in quads for corner in quad})
    number = {point: i for i, point in enumerate(points)}
    faces = []
    for quad in quads:
        a, b, c, d = (number[corner] for corner in quad)
        faces += [(a, b, c), (a, c, d)]
    return np.float32(points), np.uint32(faces)


@small
@pytest.mark.parametrize("orient", [True, False])
def test_no_fault_is_left_and_no_surface_is_lost(mesh, orient):
    made = make_manifold(mesh.vertices, mesh.faces, orient=orient)
    before = topology(mesh)
    if made.derived is None:
        assert not any(before.counts()[name] for name in FAULTS)
        return
    derived, after = made.derived, topology(made.derived)
    assert not any(after.counts()[name] for name in FAULTS)
    kept = ~(before.degenerate_faces | before.duplicate_faces)
    assert np.isclose(
        face_areas(derived.vertices, derived.faces).sum(),
        face_areas(mesh.vertices, mesh.faces[kept]).sum(),
        rtol=1e-4,
    )
    assert set(derived.face_parents.tolist()) == set(np.flatnonzero(kept).tolist())
    assert made.degenerate_faces == before.degenerate_faces.sum()
    places = derived.vertex_values(mesh.vertices.astype(np.float64))
    assert np.abs(places - derived.vertices).max() <= 1e-6 * np.abs(mesh.vertices).max()
    again = make_manifold(derived.vertices, derived.faces, orient=orient)
    if mesh.name != "moebius_strip":
        assert again.derived is None and again.report() == "nothing to be done"


def test_hostile_soups():
    for seed in range(60):
        mesh = soup(100 + seed, 7, 40)
        derived = make_manifold(mesh.vertices, mesh.faces).derived
        assert not any(topology(derived).counts()[name] for name in FAULTS), seed


def test_an_edge_whose_ends_hang_together_is_split_in_the_middle():
    vertices, faces = cubes_at_an_edge()
    before = Topology(faces=faces, vertex_count=len(vertices))
    assert before.non_manifold_edges.sum() == 1
    made = make_manifold(vertices, faces)
    after = topology(made.derived)
    assert (made.split_edges, made.split_vertices, made.turned_faces) == (1, 0, 0)
    assert len(made.derived.faces) == len(faces) + 2
    assert not after.border_edges.any() and not after.inconsistent_edges.any()
    assert np.allclose(made.derived.vertices[-1], (1.0, 1.0, 1.5))
    assert made.report() == "1 edge split"


def test_what_goes_straight_on_stays_together():
    ground = zoo.grid(4, 4.0)
    count = len(ground.vertices)
    # a wall on the middle row of edges
    row = np.flatnonzero(np.isclose(ground.vertices[:, 1], 2.0))
    top = ground.vertices[row] + np.float32([0, 0, 1])
    vertices = np.concatenate([ground.vertices, top])
    above = count + np.arange(len(row))
    a, b, c, d = row[:-1], row[1:], above[1:], above[:-1]
    wall = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.uint32)
    made = make_manifold(vertices, np.concatenate([ground.faces, wall]))
    derived = made.derived
    assert np.array_equal(derived.faces[: len(ground.faces)], ground.faces)
    assert components(derived.vertices, derived.faces).face_counts.tolist() == [32, 8]
    assert made.split_vertices == len(row) and not made.split_edges


def test_faces_are_turned_as_most_are_or_to_the_sensors():
    sphere = zoo.sphere(2)
    mixed = sphere.faces.copy()
    mixed[::3] = mixed[::3][:, [0, 2, 1]]
    outside = make_manifold(sphere.vertices, mixed)
    assert np.array_equal(outside.derived.faces, sphere.faces)
    assert outside.turned_faces == len(mixed[::3])
    inside = make_manifold(sphere.vertices, mixed, sensors=[(0, 0, 0), (0.1, 0, 0)])
    assert np.array_equal(inside.derived.faces, sphere.faces[:, [0, 2, 1]])
    around = [(5, 0, 0), (-5, 0, 0), (0, 5, 0), (0, -5, 0), (0, 0, 5), (0, 0, -5)]
    assert np.array_equal(
        make_manifold(sphere.vertices, mixed, sensors=around).derived.faces, sphere.faces
    )
    ground = terrain()
    down = ground.faces[:, [0, 2, 1]]
    assert make_manifold(ground.vertices, down).derived is None
    for options in ({"up": (0, 0, 2)}, {"sensors": [(1, 1, 3)]}):
        assert np.array_equal(
            make_manifold(ground.vertices, down, **options).derived.faces, ground.faces
        )


def test_sensors_that_are_none_are_refused():
    mesh = terrain()
    for sensors, text in (([(0, 0)], "shape"), ([(0, 0, np.nan)], "position 0"), ([], "shape")):
        with pytest.raises(ValueError, match=text):
            orient_towards(
                mesh.vertices,
                mesh.faces,
                topology(mesh),
                np.reshape(sensors, (-1, 2 if text == "shape" else 3)),
            )


def test_nothing_but_degenerate_faces():
    with pytest.raises(MeshMapError, match="nothing of the mesh is left"):
        make_manifold(np.zeros((3, 3), np.float32), np.uint32([[0, 0, 1], [2, 1, 1]]))


@small
def test_components_are_what_edges_connect(mesh):
    found = components(mesh.vertices, mesh.faces)
    sets = {v: {v} for v in range(len(mesh.vertices))}
    for face in mesh.faces.tolist():
        joined = set().union(*(sets[v] for v in face))
        for v in joined:
            sets[v] = joined
    expected = {frozenset(sets[face[0]]) for face in mesh.faces.tolist()}
    assert found.count == len(expected)
    for number in range(found.count):
        own = mesh.faces[found.of_faces == number]
        assert frozenset(own.ravel().tolist()) in {
            e & frozenset(own.ravel().tolist()) for e in expected
        }
        assert len(own) == found.face_counts[number]
        assert np.isclose(found.areas[number], face_areas(mesh.vertices, own).sum())
    assert (np.diff(found.areas) <= 1e-9).all()


def test_small_components_are_dropped():
    big, little = zoo.grid(5, 5.0), zoo.tetrahedron(0.2)
    vertices = np.concatenate([big.vertices, little.vertices + 9.0]).astype(np.float32)
    faces = np.concatenate([little.faces + len(big.vertices), big.faces])
    for options in ({"min_faces": 5}, {"min_share": 0.02}):
        derived = drop_components(vertices, faces, **options)
        assert np.array_equal(derived.vertices, big.vertices)
        assert np.array_equal(derived.faces, big.faces)
        assert np.array_equal(derived.face_parents, np.arange(4, len(faces)))
    assert drop_components(vertices, faces, min_faces=4) is None
    assert len(drop_components(vertices, faces, min_faces=10**9).faces) == len(big.faces)
    with pytest.raises(MeshMapError, match="from 0 to 1"):
        drop_components(vertices, faces, min_share=1.5)
    assert any(mesh.name == "two_components" for mesh in SMALL)
