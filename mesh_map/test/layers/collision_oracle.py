"""CollisionLayer written down again, every face against every other one, in double precision.

What rounding may decide is told from what it may not: each function gives a lower and an upper
bound, from bodies that are a little smaller, or larger.
"""

import math
from collections import defaultdict

import numpy as np

LEAST_LEVEL = 0.02  # |z| of the normal of faces that have cells
FINE = 2e-4  # meters that are left open, twice what the layer takes for rounding


def clip(polygon, value):
    """What is left of a convex polygon [(x, y, z), ...] where value(x, y, z) >= 0, which is linear
    in the point."""
    left = []
    values = [value(*point) for point in polygon]
    ends = zip(polygon[1:] + polygon[:1], values[1:] + values[:1])
    for here, a, (there, b) in zip(polygon, values, ends):
        if a >= 0:
            left.append(here)
        if a * b < 0:
            share = a / (a - b)
            left.append([own + share * (other - own) for own, other in zip(here, there)])
    return left


def gap_in_plan(polygon, point):
    """How far in plan a point is from a convex polygon."""
    around = [(x - point[0], y - point[1]) for x, y, _ in polygon]
    ends = list(zip(around, around[-1:] + around))
    turns = [a[0] * b[1] - a[1] * b[0] for a, b in ends]
    if len(polygon) > 2 and (min(turns) > 0 or max(turns) < 0):
        return 0.0
    gaps = []
    for (ax, ay), (bx, by) in ends:
        x, y = bx - ax, by - ay
        share = min(max(-(ax * x + ay * y) / max(x * x + y * y, 1e-300), 0.0), 1.0)
        gaps.append(math.hypot(ax + share * x, ay + share * y))
    return min(gaps, default=math.inf)


class CollisionOracle:
    def __init__(self, mesh, step_height, robot_height):
        self.points = mesh.vertices.astype(np.float64)
        self.faces = mesh.faces.astype(np.int64)
        self.corners = self.points[self.faces]
        self.lower, self.upper = self.corners.min(axis=1), self.corners.max(axis=1)
        a, b, c = self.corners.transpose(1, 0, 2)
        self.normals = np.cross(b - a, c - a)
        size = np.linalg.norm(self.normals, axis=1)
        self.level = (size > 0) & (np.abs(self.normals[:, 2]) >= LEAST_LEVEL * size)
        self.step, self.height = step_height, robot_height

    def near(self, lower, upper):
        """Faces whose boxes touch a box."""
        return np.flatnonzero(((self.lower <= upper) & (self.upper >= lower)).all(axis=1))

    def point_bounds(self):
        """(V,) bool twice: what meets something without a radius, at least and at most."""
        bounds = []
        for slack, low, high in (
            (0.0, self.step + FINE, self.height - FINE),
            (FINE, self.step, self.height),
        ):
            met = self.inside((low + high) / 2) | self.lines(slack, low, high)
            for face in np.flatnonzero(self.level):
                met[self.faces[face][self.cells(face, slack, low, high)]] = True
            bounds.append(met)
        return bounds

    def cells(self, face, slack, low, high):
        """(3,) bool: over the cells of which corners of a face something is."""
        corners, normal = self.corners[face].tolist(), self.normals[face]
        slope = -normal[:2] / normal[2]
        reach = slack * (1 + np.linalg.norm(slope))
        (cx, cy, cz), (sx, sy) = corners[0], slope.tolist()

        def foot(x, y):  # z of the plane of the face
            return cz + sx * (x - cx) + sy * (y - cy)

        def above(x, y, z):
            return z - foot(x, y)

        def side_of(k):
            a, b, inner = corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]
            length = math.hypot(b[0] - a[0], b[1] - a[1])
            nx, ny = (a[1] - b[1]) / length, (b[0] - a[0]) / length
            turn = math.copysign(1.0, nx * (inner[0] - a[0]) + ny * (inner[1] - a[1]))
            nx, ny = turn * nx, turn * ny
            return lambda x, y, z: nx * (x - a[0]) + ny * (y - a[1]) + slack

        def nearer_to(own, other):  # how far on its side of the plane in the middle of both
            mx, my, mz = ((a + b) / 2 for a, b in zip(own, other))
            length = math.dist(own, other)
            nx, ny, nz = ((a - b) / length for a, b in zip(own, other))

            def value(x, y, z):
                return (x - mx) * nx + (y - my) * ny + (foot(x, y) - mz) * nz + reach

            return value

        sides = [side_of(k) for k in range(3)]
        cells = [[nearer_to(corners[k], corners[(k + j) % 3]) for j in (1, 2)] for k in range(3)]
        found = np.zeros(3, bool)
        box = self.lower[face] + [-slack, -slack, low - reach], self.upper[face]
        some = self.near(box[0], box[1] + [slack, slack, high + reach])
        gaps = above(*np.moveaxis(self.corners[some], 2, 0))
        for other in some[(gaps.max(axis=1) > low) & (gaps.min(axis=1) < high)]:
            polygon = self.corners[other].tolist()
            for side in sides:
                polygon = clip(polygon, side)
            for k in np.flatnonzero(~found):
                part = polygon
                for nearer in cells[k]:
                    part = clip(part, nearer)
                heights = [above(*point) for point in part]
                found[k] = bool(heights) and max(heights) > low and min(heights) < high
        return found

    def lines(self, slack, low, high):
        """(V,) bool: faces above vertices that have no cell."""
        met = np.zeros(len(self.points), bool)
        lonely = np.ones(len(self.points), bool)
        lonely[self.faces[self.level]] = False
        for vertex in np.flatnonzero(lonely):
            met[vertex] = any(True for _ in self.met(vertex, slack or 1e-7, low, high))
        return met

    def met(self, vertex, radius, low, high):
        """The faces that are in a body with a radius at a vertex."""
        foot = self.points[vertex].tolist()
        lower, upper = foot[2] + low, foot[2] + high
        x, y, _ = foot
        box = [x - radius, y - radius, lower], [x + radius, y + radius, upper]
        for face in self.near(*box):
            polygon = clip(self.corners[face].tolist(), lambda x, y, z: z - lower)
            polygon = clip(polygon, lambda x, y, z: upper - z)
            if gap_in_plan(polygon, foot) <= radius:
                yield face

    def inside(self, height):
        """(V,) bool: inside of a closed patch that far above the vertices: a ray in a direction
        that is that of nothing crosses its faces an odd number of times."""
        found = np.zeros(len(self.points), bool)
        ray = np.array([0.3, 0.5, 0.81]) / np.linalg.norm([0.3, 0.5, 0.81])
        for patch in self.closed_patches():
            for vertex, point in enumerate(self.points + [0, 0, height]):
                a, b, c = (self.corners[patch] - point).transpose(1, 0, 2)
                sides = np.stack([np.cross(a, b) @ ray, np.cross(b, c) @ ray, np.cross(c, a) @ ray])
                within = (sides > 0).all(axis=0) | (sides < 0).all(axis=0)
                normals = np.cross(b - a, c - a)
                ahead = np.einsum("ij,ij->i", a, normals) * (normals @ ray) > 0
                found[vertex] |= bool((within & ahead).sum() % 2)
        return found

    def closed_patches(self):
        """Faces joined at edges of an even number, where all edges of the patch have one. Of faces
        with the same corners one counts, else where their number is odd."""
        proper = (np.diff(np.sort(self.faces, axis=1), axis=1) > 0).all(axis=1)
        sets = defaultdict(list)
        for face in np.flatnonzero(proper):
            sets[tuple(sorted(self.faces[face]))].append(face)
        patches = self._patches([faces[0] for faces in sets.values()])
        found = {face for patch in patches for face in patch}
        left = [f[0] for f in sets.values() if len(f) % 2 == 1 and f[0] not in found]
        return patches + (self._patches(left) if len(sets) < proper.sum() else [])

    def _patches(self, some):
        at_edge = defaultdict(list)
        for face in some:
            for k in range(3):
                at_edge[tuple(sorted(self.faces[face][[k, (k + 1) % 3]]))].append(face)
        parent = list(range(len(self.faces)))

        def root(i):
            while parent[i] != i:
                i = parent[i]
            return i

        for faces in at_edge.values():
            for face in faces[1:] if len(faces) % 2 == 0 else []:
                parent[root(faces[0])] = root(face)
        patches = defaultdict(list)
        for face in some:
            patches[root(face)].append(face)
        opened = {root(face) for faces in at_edge.values() if len(faces) % 2 for face in faces}
        return [faces for first, faces in patches.items() if first not in opened]

    def body_bounds(self, radius, closed):
        """(V,) bool twice: what meets something with a radius, where `closed` does without."""
        least, most = closed.copy(), closed.copy()
        around = defaultdict(set)
        for face, corners in enumerate(self.faces.tolist()):
            for corner in corners:
                around[corner].add(face)
        for vertex in np.flatnonzero(~closed):
            for bound, sign in ((least, -1), (most, 1)):
                low = self.step + (FINE if sign < 0 else 0)
                high = self.height - (FINE if sign < 0 else 0)
                met = set(self.met(vertex, radius + sign * FINE, low, high))
                if met:
                    reached = self.ground(vertex, radius - sign * FINE, -sign, closed, around)
                    bound[vertex] = not met <= reached
        return least, most

    def ground(self, vertex, radius, sign, closed, around):
        """The faces that are ground of a vertex."""
        foot = self.points[vertex]
        away = self.points - foot
        low = away[:, 2] <= self.step + 5e-5 + sign * FINE + np.hypot(away[:, 0], away[:, 1])
        reached, queue, faces = {vertex}, [vertex], set()
        for start in queue:
            for face in around[start] - faces:
                corners = self.faces[face]
                if closed[start] and not self.level[face]:
                    continue
                if low[corners].all() and gap_in_plan(self.corners[face].tolist(), foot) <= radius:
                    faces.add(face)
                    more = {int(c) for c in corners} - reached
                    reached |= more
                    queue += more
        return faces
