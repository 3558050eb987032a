"""Costs of the layers in plain NumPy and double precision, from their formulas alone.

Without the vertex itself, height differences and roughness are what the first mesh_navigation (with
lvr2 20.11) computes, whose numbers are published. Nothing here is taken from the package that is
tested.
"""

from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra


AT_ONCE = 100  # vertices whose neighborhoods grow together, in arrays that fit into a cache


def sides(faces):
    """(N, 2) sorted ends of all sides of faces, without those that end where they begin."""
    pairs = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1)


class OracleMesh:
    """Edges, normals and neighborhoods of a triangle soup."""

    def __init__(self, mesh, up=(0, 0, 1)):
        self.points = np.asarray(mesh.vertices, np.float64)
        self.faces = np.asarray(mesh.faces, np.int64)
        self.up = np.asarray(up, np.float64) / np.linalg.norm(up)
        self.count = len(self.points)
        self._pairs = {}

    @cached_property
    def edges(self):
        """(E, 2) without repetition."""
        return np.unique(sides(self.faces), axis=0)

    @cached_property
    def lengths(self):
        return np.linalg.norm(self.points[self.edges[:, 0]] - self.points[self.edges[:, 1]], axis=1)

    @cached_property
    def rows(self):
        """starts (V + 1,) and neighbors: those of v are neighbors[starts[v]:starts[v + 1]]."""
        both = np.concatenate([self.edges, self.edges[:, ::-1]])
        both = both[np.lexsort((both[:, 1], both[:, 0]))]
        return np.searchsorted(both[:, 0], np.arange(self.count + 1)), both[:, 1]

    def neighborhoods(self, radius):
        """Pairs (v, u), u != v: u is reached from v over edges through vertices nearer than r."""
        if radius not in self._pairs:
            self._pairs[radius] = self._grown(radius)
        return self._pairs[radius]

    def _grown(self, radius):
        pairs = [self._grown_from(first, radius) for first in range(0, self.count, AT_ONCE)]
        return tuple(map(np.concatenate, zip(*pairs)))

    def _grown_from(self, first, radius):
        """The same of AT_ONCE vertices: a pair (v, u) has a number, under which seen has it."""
        starts, neighbors = self.rows
        center = reached = np.arange(first, min(first + AT_ONCE, self.count))
        seen = np.zeros(len(center) * self.count, bool)
        writer = np.zeros(len(seen), np.int32)
        seen[(center - first) * self.count + center] = True
        pairs = []
        while len(center):
            counts = starts[reached + 1] - starts[reached]
            before = np.repeat(starts[reached] - np.cumsum(counts) + counts, counts)
            center, beyond = np.repeat(center, counts), neighbors[before + np.arange(len(before))]
            number = (center - first) * self.count + beyond
            new = np.flatnonzero(~seen[number])
            writer[number[new]] = np.arange(len(new))
            new = new[writer[number[new]] == np.arange(len(new))]  # each once
            seen[number[new]] = True
            center, reached = center[new], beyond[new]
            step = self.points[reached] - self.points[center]
            near = step[:, 0] ** 2 + step[:, 1] ** 2 + step[:, 2] ** 2 < radius * radius
            center, reached = center[near], reached[near]
            pairs.append((center, reached))
        return tuple(map(np.concatenate, zip(*pairs)))

    @cached_property
    def face_normals(self):
        """(F, 3), (0, 0, 1) where there is no area; and the areas."""
        a, b, c = (self.points[self.faces[:, k]] for k in range(3))
        twice = np.cross(b - a, c - a)
        size = np.linalg.norm(twice, axis=1)
        unit = twice / np.where(size > 0, size, 1)[:, None]
        return np.where(size[:, None] > 0, unit, (0.0, 0.0, 1.0)), size / 2

    @cached_property
    def normals(self):
        """(V, 3) unweighted mean of the normals of faces with area, (0, 0, 1) where it is nothing.

        And (V,) its length: near 0, its direction is one of rounding.
        """
        unit, area = self.face_normals
        total = np.zeros((self.count, 3))
        for corner in range(3):
            corners = self.faces[:, corner]
            first = (self.faces[:, :corner] != corners[:, None]).all(axis=1)
            counts = first & (area > 0)
            np.add.at(total, corners[counts], unit[counts])
        size = np.linalg.norm(total, axis=1)
        size[size < 1e-14] = 0
        mean = total / np.where(size > 0, size, 1)[:, None]
        return np.where(size[:, None] > 0, mean, (0.0, 0.0, 1.0)), size


def per_vertex(count, center, values):
    """Sums and numbers of values (N,) of pairs with a center."""
    return np.bincount(center, values, count), np.bincount(center, minlength=count)


@lru_cache(maxsize=None)
def height_difference(mesh, radius, include_vertex=True, nothing=np.nan):
    """max z - min z over N_r(v), and v or not; `nothing` where none are (released: -inf)."""
    center, reached = mesh.neighborhoods(radius)
    z = mesh.points @ mesh.up
    start = (z, z) if include_vertex else (-np.inf, np.inf)
    high, low = (np.full(mesh.count, value, np.float64) for value in start)
    np.maximum.at(high, center, z[reached])
    np.minimum.at(low, center, z[reached])
    return np.where(high < low, nothing, high - low)


@lru_cache(maxsize=None)
def mean_angle(mesh):
    """(V,) A(u): the mean angle between the normal of u and those at the other ends of its edges;
    0 without edges."""
    normals, _ = mesh.normals
    a, b = np.concatenate([mesh.edges, mesh.edges[:, ::-1]]).T
    # of the chord, not of the cosine, which says little about small angles
    chord = np.linalg.norm(normals[a] - normals[b], axis=1)
    angles = 2 * np.arcsin(np.minimum(chord / 2, 1))
    total, number = per_vertex(mesh.count, a, angles)
    return total / np.maximum(number, 1)


def roughness(mesh, radius, include_vertex=False):
    """Mean of A(u) over N_r(v), as released, or over v, too; 0 for nothing."""
    angle = mean_angle(mesh)
    center, reached = mesh.neighborhoods(radius)
    total, number = per_vertex(mesh.count, center, angle[reached])
    if include_vertex:
        total, number = total + angle, number + 1
    return total / np.maximum(number, 1)


def ridge(mesh, radius, lonely=0.0):
    """Mean of |(p_u + n_u) - (p_v + n_v)| over N_r(v); `lonely` for nothing."""
    tips = mesh.points + mesh.normals[0]
    center, reached = mesh.neighborhoods(radius)
    gaps = np.linalg.norm(tips[reached] - tips[center], axis=1)
    total, number = per_vertex(mesh.count, center, gaps)
    return np.where(number > 0, total / np.maximum(number, 1), lonely)


def steepness(mesh):
    """Angle between normal and up, 0 to pi."""
    normals, _ = mesh.normals
    across = np.linalg.norm(np.cross(normals, mesh.up), axis=1)
    return np.arctan2(across, normals @ mesh.up)


def border(mesh, cost):
    """The cost at the ends of sides that one face alone has, else 0.

    Faces that name a vertex twice are no surface and do not count.
    """
    ends = np.sort(mesh.faces, axis=1)
    proper = mesh.faces[(np.diff(ends, axis=1) > 0).all(axis=1)]
    edges, number = np.unique(sides(proper), axis=0, return_counts=True)
    result = np.zeros(mesh.count)
    result[edges[number == 1]] = cost
    return result


def free_distances(mesh, start, direction, shrinks):
    """(S, V) how far from start (V, 3) along direction (V, 3) faces are, of both sides; inf: none.

    shrinks: faces are that much (of their size) smaller, or larger if negative; for each.
    """
    a, b, c = (mesh.points[mesh.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    size2 = np.sum(normal * normal, axis=1)
    above = np.sum(a * normal, axis=1)
    # how far a point is from the side p q, in shares of the height: linear in the point
    inwards = [np.cross(normal, q - p) for p, q in ((a, b), (b, c), (c, a))]
    begins = [np.sum(p * inward, axis=1) for p, inward in zip((a, b, c), inwards)]
    found = np.full((len(shrinks), len(start)), np.inf)
    for row, (origin, way) in enumerate(zip(start, direction)):
        slope = normal @ way
        good = (size2 > 0) & (np.abs(slope) > 1e-9 * np.sqrt(size2))
        with np.errstate(all="ignore"):
            distance = (above - normal @ origin) / slope
            parts = [
                (inward @ origin + distance * (inward @ way) - begin) / size2
                for inward, begin in zip(inwards, begins)
            ]
        least = np.min(parts, axis=0)
        for k, shrink in enumerate(shrinks):
            inside = good & (least >= shrink) & (distance > 0)
            found[k, row] = distance[inside].min(initial=np.inf)
    return found


def clearance_cost(free, height, margin):
    """1 below the height of the robot, 0 from margin above it on, half a cosine between."""
    between = (np.cos(np.pi * (np.clip(free, height, height + margin) - height) / margin) + 1) / 2
    return np.where(free < height, 1.0, np.where(free <= height + margin, between, 0.0))


def fading(distance, inscribed_radius, inflation_radius, inscribed_value, lethal_value, scale=None):
    """Cost at a distance from lethal vertices; scale: of the exponential variant, None: cosine."""
    r, big = inscribed_radius, inflation_radius
    result = np.zeros(len(distance))
    ring = (distance > r) & (distance <= big)
    if scale is None:
        alpha = np.pi * (distance[ring] - r) / (big - r)
        result[ring] = inscribed_value * (np.cos(alpha) + 1) / 2
    else:
        result[ring] = inscribed_value * np.exp(-scale * (distance[ring] - r))
    result[(distance > 0) & (distance <= r)] = inscribed_value
    result[distance == 0] = np.inf if lethal_value == -1 else lethal_value
    return result


@lru_cache(maxsize=None)
def surface_graph(mesh, pieces):
    """A graph with `pieces` parts to each edge, all points of a face joined."""
    inner = np.arange(1, pieces) / pieces
    p, q = mesh.points[mesh.edges[:, 0]], mesh.points[mesh.edges[:, 1]]
    between = p[:, None] + inner[None, :, None] * (q - p)[:, None]
    points = np.concatenate([mesh.points, between.reshape(-1, 3)])
    corners = np.sort(mesh.faces, axis=1)
    keys = mesh.edges @ (mesh.count, 1)
    own = [corners]  # the points of each face; of a corner that is named twice, one is left out
    for a, b in ((0, 1), (1, 2), (0, 2)):
        edge = np.searchsorted(keys, corners[:, [a, b]] @ (mesh.count, 1)) % max(len(keys), 1)
        inside = mesh.count + edge[:, None] * (pieces - 1) + np.arange(pieces - 1)
        own.append(np.where((corners[:, a] == corners[:, b])[:, None], corners[:, [a]], inside))
    own = np.concatenate(own, axis=1)
    ends = own[:, np.triu_indices(own.shape[1], 1)]
    start, end = np.sort(ends, axis=1).transpose(1, 0, 2).reshape(2, -1)
    keys = np.unique((start * len(points) + end)[start < end])
    start, end = np.divmod(keys, len(points))
    # a length of 0 would be no edge
    length = np.maximum(np.linalg.norm(points[start] - points[end], axis=1), 1e-12)
    return coo_matrix((length, (start, end)), (len(points), len(points))).tocsr()


def surface_distance(mesh, sources, pieces=8):
    """(V,) shortest way over the surface to source vertices and to the edges between two of them.

    In surface_graph(): never too short, and too long by a share that falls with the square of
    `pieces`.
    """
    graph = surface_graph(mesh, pieces)
    chosen = np.zeros(graph.shape[0], bool)
    chosen[sources] = True
    joined = chosen[mesh.edges].all(axis=1)
    chosen[mesh.count :] = np.repeat(joined, pieces - 1)
    if not chosen.any():
        return np.full(mesh.count, np.inf)
    found = dijkstra(graph, directed=False, indices=np.flatnonzero(chosen), min_only=True)
    return np.where(found[: mesh.count] < 1e-9, 0.0, found[: mesh.count])


def distance_on_plane(mesh, sources):
    """(V,) Euclidean distance to lethal vertices, edges and faces (all of whose corners are)."""
    lethal = np.zeros(mesh.count, bool)
    lethal[sources] = True
    best = np.full(mesh.count, np.inf)
    if not lethal.any():
        return best
    for vertex in sources:
        best = np.minimum(best, np.linalg.norm(mesh.points - mesh.points[vertex], axis=1))
    for a, b in mesh.points[mesh.edges[lethal[mesh.edges].all(axis=1)]]:
        side = b - a
        share = np.clip((mesh.points - a) @ side / (side @ side), 0, 1)
        foot = a + share[:, None] * side
        best = np.minimum(best, np.linalg.norm(mesh.points - foot, axis=1))
    return best


def combined(layers, mode="sum"):
    """Costs of a map of (costs, lethal, factor) of each layer."""
    count = len(layers[0][0])
    total, dead, unknown = np.zeros(count), np.zeros(count, bool), np.zeros(count, bool)
    for costs, lethal, factor in layers:
        dead |= lethal | np.isposinf(costs)
        unknown |= np.isnan(costs)
        finite = np.isfinite(costs)
        part = np.where(finite, costs, 0).astype(np.float64)
        if mode == "normalized" and finite.any():
            low, high = part[finite].min(), part[finite].max()
            part = (part - low) / (high - low) if high > low else np.zeros(count)
        total = np.maximum(total, factor * part) if mode == "max" else total + factor * part
    return np.where(dead, np.inf, np.where(unknown, np.nan, total))


def edge_weights(mesh, costs, kind, factor):
    """Weights of mesh.edges as the first ("difference") and second ("mean") release has them."""
    one, other = costs[mesh.edges].T
    good = np.isfinite(one) & np.isfinite(other)
    one, other = np.where(good, one, 0), np.where(good, other, 0)
    if kind == "difference":
        return mesh.lengths * (1 + factor * np.abs(one - other))
    return np.where(good, mesh.lengths * (1 + factor * (one + other) / 2), np.inf)
