"""The topology kernel against plain Python and SciPy, on the zoo, random soups and real meshes."""

from collections import Counter, defaultdict

import numpy as np
import pytest
from mesh_map.geometry.topology import NO_EDGE, Topology, edge_lengths
from mesh_msgs import zoo
from meshes import BOTANICAL, SMALL, TRAY, TestMesh, data_mesh, real, renumbered, small, soup
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def topology_of(mesh, **kwargs):
    return Topology(faces=mesh.faces, vertex_count=len(mesh.vertices), **kwargs)


def sides(face):
    return [(face[k], face[(k + 1) % 3]) for k in range(3)]


def fan_count(vertex, faces):
    """Groups of faces around a vertex that share edges at it."""
    groups = []
    for face in faces:
        others = set(face) - {vertex}
        touching = [group for group in groups if group & others]
        groups = [group for group in groups if not group & others] + [others.union(*touching)]
    return len(groups)


def check(mesh):
    """Every array of the topology equals what plain Python finds."""
    t = topology_of(mesh)
    faces = [tuple(face) for face in mesh.faces.tolist()]
    proper = [len(set(face)) == 3 for face in faces]
    edges = sorted({(min(s), max(s)) for face in faces for s in sides(face) if s[0] != s[1]})
    assert t.edges.tolist() == [list(edge) for edge in edges]
    number = {edge: e for e, edge in enumerate(edges)}

    expected = [[number.get((min(s), max(s)), NO_EDGE) for s in sides(face)] for face in faces]
    assert t.face_edges.tolist() == expected

    along = defaultdict(list)
    for face, counted in zip(faces, proper):
        for a, b in sides(face) if counted else ():
            along[number[min(a, b), max(a, b)]].append(a < b)
    counts = [len(along[e]) for e in range(len(edges))]
    assert t.edge_face_counts.tolist() == counts
    assert t.border_edges.tolist() == [count == 1 for count in counts]
    assert t.non_manifold_edges.tolist() == [count > 2 for count in counts]
    flipped = [counts[e] == 2 and along[e][0] == along[e][1] for e in range(len(edges))]
    assert t.inconsistent_edges.tolist() == flipped

    assert t.degenerate_faces.tolist() == [not p for p in proper]
    seen = Counter()
    for face, counted, duplicate in zip(faces, proper, t.duplicate_faces):
        key = tuple(sorted(face))
        assert duplicate == (counted and seen[key] > 0)
        seen[key] += 1

    next_to = defaultdict(list)
    for e, (a, b) in enumerate(edges):
        next_to[a].append((b, e))
        next_to[b].append((a, e))
    around = defaultdict(list)
    for f, face in enumerate(faces):
        for vertex in set(face):
            around[vertex].append(f)
    vertices = range(len(mesh.vertices))
    rows = zip(t.neighbor_offsets[:-1].tolist(), t.neighbor_offsets[1:].tolist())
    neighbors = list(zip(t.neighbors.tolist(), t.neighbor_edges.tolist()))
    assert [neighbors[begin:end] for begin, end in rows] == [sorted(next_to[v]) for v in vertices]
    assert [t.neighbors_of(v).tolist() for v in vertices] == [
        [to for to, _ in sorted(next_to[v])] for v in vertices
    ]
    assert [t.faces_of(v).tolist() for v in vertices] == [around[v] for v in vertices]
    assert t.isolated_vertices.tolist() == [not next_to[v] for v in vertices]

    on_bad_edge = {v for e, count in enumerate(counts) if count > 2 for v in edges[e]}
    bad = [
        v in on_bad_edge or fan_count(v, [faces[f] for f in around[v] if proper[f]]) > 1
        for v in vertices
    ]
    assert t.non_manifold_vertices.tolist() == bad
    check_components(t)
    return t


def check_components(t):
    """Components equal SciPy's, numbered by their lowest vertices."""
    graph = coo_matrix((np.ones(t.edge_count), t.edges.T), (t.vertex_count, t.vertex_count))
    count, labels = connected_components(graph, directed=False)
    assert t.component_count == count
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))
    assert np.array_equal(t.components, rank[inverse])
    assert t.components.dtype == np.int32


@small
def test_everything_equals_plain_python(mesh):
    check(mesh)


@pytest.mark.parametrize("seed", range(100))
def test_random_soups_equal_plain_python(seed):
    check(soup(1000 + seed, 4 + seed % 12, 1 + seed % 40))


@real
def test_real_meshes_equal_plain_python(name):
    check(data_mesh(name))


def test_oracle_numbers_of_the_real_meshes():
    tray = topology_of(data_mesh(TRAY)).counts()
    assert tray == {
        "vertices": 1257,
        "faces": 2416,
        "edges": 3672,
        "components": 1,
        "border_edges": 96,
        "non_manifold_edges": 0,
        "non_manifold_vertices": 0,
        "inconsistent_edges": 0,
        "duplicate_faces": 0,
        "degenerate_faces": 0,
        "isolated_vertices": 0,
    }
    botanical = topology_of(data_mesh(BOTANICAL))
    assert botanical.component_count == 382
    assert botanical.counts()["non_manifold_vertices"] == 1139
    assert "382 components" in botanical.report()
    assert "1,139 non-manifold vertices" in botanical.report()
    assert "duplicate" not in botanical.report()


def test_report_of_few():
    report = Topology(faces=[[0, 1, 2], [2, 2, 2]], vertex_count=4).report()
    assert report == (
        "4 vertices, 2 faces, 3 edges, 2 components, 3 border edges, 1 degenerate face, "
        "1 isolated vertex"
    )
    assert Topology(faces=[[0, 0, 0]], vertex_count=1).report() == (
        "1 vertex, 1 face, 0 edges, 1 component, 1 degenerate face, 1 isolated vertex"
    )


@pytest.mark.parametrize("mesh", zoo.all_meshes(), ids=[m.name for m in zoo.all_meshes()])
def test_traits_of_the_zoo(mesh):
    counts = topology_of(mesh).counts()
    traits = mesh.traits
    assert ("boundary" in traits) == (counts["border_edges"] > 0)
    assert ("isolated_vertices" in traits) == (counts["isolated_vertices"] > 0)
    assert ("duplicate_faces" in traits) == (counts["duplicate_faces"] > 0)
    if len(mesh.faces) and not counts["non_manifold_edges"]:
        assert ("oriented" in traits) == (counts["inconsistent_edges"] == 0)
    if len(mesh.faces):
        assert ("manifold" in traits) == (counts["non_manifold_vertices"] == 0)
        assert ("connected" in traits) == (counts["components"] == 1)


def test_euler_characteristic():
    for name, expected in (("tetrahedron", 2), ("sphere", 2), ("torus", 0)):
        t = topology_of(getattr(zoo, name)())
        assert t.vertex_count - t.edge_count + t.face_count == expected


@small
def test_the_order_of_vertices_does_not_matter(mesh):
    other, new = renumbered(mesh)
    t, u = topology_of(mesh), topology_of(other)
    assert t.counts() == u.counts()
    moved = np.sort(new[t.edges], axis=1)
    assert np.array_equal(moved[np.lexsort(moved.T[::-1])], u.edges)
    assert np.array_equal(t.non_manifold_vertices, u.non_manifold_vertices[new])
    assert np.array_equal(t.duplicate_faces, u.duplicate_faces)


def test_the_number_of_threads_does_not_matter():
    mesh = soup(9, 50_000, 90_000)
    one, four = topology_of(mesh, threads=1), topology_of(mesh, threads=4)
    assert one.edge_count > 200_000
    for name in vars(one):
        assert np.array_equal(getattr(one, name), getattr(four, name)), name
    check_components(one)


def test_a_hub_and_identical_triangles():
    count = 30_000
    rim = np.arange(1, count + 1)
    faces = np.stack([np.zeros(count, int), rim, np.roll(rim, -1)], 1)
    hub = Topology(faces=faces, vertex_count=count + 1)
    assert len(hub.neighbors_of(0)) == count and not hub.non_manifold_vertices.any()
    assert hub.border_edges.sum() == count

    same = Topology(faces=np.tile([[2, 0, 1]], (count, 1)), vertex_count=3)
    assert same.edge_count == 3 and same.edge_face_counts.tolist() == [count] * 3
    assert same.duplicate_faces.sum() == count - 1 and not same.duplicate_faces[0]


def test_empty_meshes():
    nothing = Topology(faces=np.zeros((0, 3), np.uint32), vertex_count=0)
    assert nothing.counts() == dict.fromkeys(nothing.counts(), 0)
    points = Topology(faces=[], vertex_count=3)
    assert points.component_count == 3 and points.isolated_vertices.all()


@pytest.mark.parametrize(
    "faces, message",
    [
        ([[0, 1, 2], [0, 3, 1]], "face 1 refers to vertex 3, but there are only 3 vertices"),
        (np.array([[0, 1, 0xFFFFFFFF]], np.uint32), "face 0 refers to vertex 4294967295"),
        ([[0, 1, 2], [0, -1, 2]], r"face 1 refers to vertex -1.*\(1 such in all\)"),
        ([[0.0, 1.0, 2.0]], "whole numbers"),
        ([[0, 1], [1, 2]], r"shape \(N, 3\)"),
        ([0, 1, 2], r"shape \(N, 3\)"),
    ],
)
def test_bad_faces_are_refused(faces, message):
    with pytest.raises(ValueError, match=message):
        Topology(faces=faces, vertex_count=3)


def test_arrays_cannot_be_changed():
    t = topology_of(SMALL[0])
    with pytest.raises(ValueError):
        t.neighbors[0] = 1


@small
def test_edge_lengths(mesh: TestMesh):
    edges = topology_of(mesh).edges
    ends = mesh.vertices.astype(np.float64)[edges]
    gap = ends[:, 0] - ends[:, 1]
    expected = np.sqrt(gap[:, 0] ** 2 + gap[:, 1] ** 2 + gap[:, 2] ** 2).astype(np.float32)
    assert np.array_equal(edge_lengths(mesh.vertices, edges), expected)
    with pytest.raises(ValueError, match="edges has the index"):
        edge_lengths(mesh.vertices, [[0, len(mesh.vertices)]])
