"""Paths over meshes to shorten, and what is true of the shortest."""

from itertools import combinations

import numpy as np
from mesh_map.distance.surface_path import SurfacePath
from oracles import cross, dot, length
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra


def path_of(points, faces):
    points = np.asarray(points, np.float64).reshape(-1, 3)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    remaining = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
    return SurfacePath(points=points, faces=np.array(faces, np.uint32), potentials=remaining)


def faces_around(geometry, vertex):
    """Those that are not degenerate."""
    topology = geometry.topology
    begin, end = topology.vertex_face_offsets[vertex : vertex + 2]
    around = topology.vertex_faces[begin:end]
    return around[~topology.degenerate_faces[around]]


def edge_way(geometry, *stops, weights=None):
    """Along the edges from vertex to vertex, the shortest way between each two."""
    edges, count = geometry.topology.edges, len(geometry.vertices)
    lengths = geometry.edge_lengths.astype(np.float64) if weights is None else weights
    graph = csr_matrix((lengths, tuple(edges.T)), (count, count))
    way = [stops[0]]
    for stop in stops[1:]:
        _, before = dijkstra(graph, directed=False, indices=stop, return_predecessors=True)
        while way[-1] != stop:
            assert before[way[-1]] >= 0, "the stops are not connected"
            way.append(int(before[way[-1]]))
    faces = [
        next(f for f in faces_around(geometry, a) if b in geometry.faces[f])
        for a, b in zip(way, way[1:])
    ]
    return path_of(geometry.vertices[way], faces)


def random_way(geometry, random, steps, mask=None):
    """From face to face, across random edges at random places, sometimes through a vertex."""
    allowed = ~geometry.topology.degenerate_faces if mask is None else mask
    allowed = allowed & ~geometry.topology.degenerate_faces
    corners = geometry.vertices.astype(np.float64)[geometry.faces]
    face = int(random.choice(np.flatnonzero(allowed)))
    points, faces = [random.dirichlet((1, 1, 1)) @ corners[face]], []
    for _ in range(steps):
        k = random.integers(3)
        if random.random() < 0.3:  # through a corner, into any face around it
            next_faces = faces_around(geometry, geometry.faces[face, k])
            point = corners[face, k]
        else:
            edge = geometry.topology.face_edges[face, k]
            begin, end = geometry.topology.edge_face_offsets[edge : edge + 2]
            next_faces = geometry.topology.edge_faces[begin:end]
            share = random.choice([0.0, 0.25, random.random(), 1.0])
            point = (1 - share) * corners[face, k] + share * corners[face, (k + 1) % 3]
        points.append(point)
        faces.append(face)
        face = int(random.choice(next_faces[allowed[next_faces]]))
    points.append(random.dirichlet((1, 1, 1)) @ corners[face])
    return path_of(points, faces + [face])


def to_segment(point, a, b):
    side = b - a
    share = np.clip((point - a) @ side / max(side @ side, 1e-300), 0.0, 1.0)
    return np.linalg.norm(point - a - share * side)


def to_faces(points, corners):
    """How far points (N, 3) are from triangles (N, 3 corners, 3), each from its own."""
    point, (a, b, c) = points.T, np.moveaxis(corners, (1, 2), (0, 1))
    normal = cross(b - a, c - a)
    square = dot(normal, normal)
    nearest, inside = np.inf, square > 0
    foot = point - dot(point - a, normal) / np.where(inside, square, 1) * normal
    for p, q in ((a, b), (b, c), (c, a)):
        side = q - p
        share = np.clip(dot(point - p, side) / np.maximum(dot(side, side), 1e-300), 0.0, 1.0)
        nearest = np.minimum(nearest, length(point - p - share * side))
        inside = inside & (dot(cross(side, foot - p), normal) >= 0)
    return np.where(inside, np.minimum(nearest, length(point - foot)), nearest)


def check_path(geometry, given, path, mask=None):
    """It is on the surface, where it may be, with the ends of what was given, and not longer."""
    assert len(path.points) == len(path.faces) + 1 == len(path.potentials)
    assert path.points.dtype == np.float64 and path.faces.dtype == np.uint32
    np.testing.assert_array_equal(path.points[0], given.points[0])
    np.testing.assert_array_equal(path.points[-1], given.points[-1])
    assert path.length <= given.length
    assert path.potentials[-1] == 0.0 and (np.diff(path.potentials) < 0).all()
    np.testing.assert_allclose(path.potentials[0], path.length, rtol=1e-12)
    corners = geometry.vertices.astype(np.float64)[geometry.faces]
    scale = 1e-9 * np.ptp(geometry.vertices, axis=0).max() + 1e-14 * np.abs(corners).max()
    assert mask is None or mask[path.faces].all()
    for ends in (path.points[:-1], path.points[1:]):
        assert (to_faces(ends, corners[path.faces]) < scale).all()


def angle(a, b):
    return np.arctan2(length(cross(a, b)), a @ b)


def least_angle_around(geometry, vertex, before, after, mask=None):
    """Between two rays from a vertex, each (face, point), over the faces that count."""
    center = geometry.vertices[vertex].astype(np.float64)
    around = [f for f in faces_around(geometry, vertex) if mask is None or mask[f]]
    names, arcs = {"before": 0, "after": 1}, []
    rays = {"before": before, "after": after}
    for f in around:
        ends = [int(v) for v in geometry.faces[f] if v != vertex]
        sides = [geometry.vertices[v].astype(np.float64) - center for v in ends]
        if any(np.linalg.norm(side) == 0 for side in sides):
            continue
        for v in ends:
            names.setdefault(v, len(names))
        arcs.append((names[ends[0]], names[ends[1]], angle(*sides)))
        here = [(name, point - center) for name, (face, point) in rays.items() if face == f]
        for name, way in here:
            for v, side in zip(ends, sides):
                arcs.append((names[name], names[v], angle(way, side)))
        if len(here) == 2:
            arcs.append((0, 1, angle(here[0][1], here[1][1])))
    least = np.full((len(names), len(names)), np.inf)
    for a, b, turn in arcs:
        least[a, b] = least[b, a] = min(least[a, b], turn)
    return dijkstra(np.where(least == 0, 1e-300, least), indices=0)[1]


def check_taut(geometry, path, mask=None, tolerance=1e-7):
    """Straight across every edge; 180 degrees or more on all sides where it bends."""
    vertices = geometry.vertices.astype(np.float64)
    near = 1e-9 * np.ptp(vertices, axis=0).max()
    bends = 0
    for i in range(1, len(path.points) - 1):
        point = path.points[i]
        f, g = (int(face) for face in path.faces[i - 1 : i + 1])
        ways = [path.points[k] - point for k in (i - 1, i + 1)]
        if min(np.linalg.norm(way) for way in ways) < 100 * near:
            continue  # rounding alone decides on its direction
        common = [int(v) for v in geometry.faces[f] if v in geometry.faces[g]]
        at = [v for v in common if np.linalg.norm(vertices[v] - point) < near]
        if at:
            bends += 1
            rays = ((f, path.points[i - 1]), (g, path.points[i + 1]))
            assert least_angle_around(geometry, at[0], *rays, mask) >= np.pi - tolerance
        elif len(common) >= 2:
            pairs = ((vertices[a], vertices[b]) for a, b in combinations(common, 2))
            a, b = min(pairs, key=lambda pair: to_segment(point, *pair))
            side = b - a
            assert abs(sum(angle(way, side) for way in ways) - np.pi) < tolerance
        else:
            assert abs(angle(*ways) - np.pi) < tolerance
    return bends
