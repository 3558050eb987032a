"""A straightest geodesic in NumPy: another way than the kernel's, for walks that meet no vertex.

The direction is kept in space, and turned about each edge that is crossed by the angle between the
two faces.
"""

from functools import lru_cache

import numpy as np


def turned(vector, axis, angle):
    """O. Rodrigues: a vector turned about a unit vector."""
    return (
        vector * np.cos(angle)
        + np.cross(axis, vector) * np.sin(angle)
        + axis * (axis @ vector) * (1 - np.cos(angle))
    )


def inward(corners, i, j, k):
    """Unit vector in a face from the edge i, j to corner k, at a right angle to the edge."""
    side = corners[j] - corners[i]
    to = corners[k] - corners[i]
    rise = to - side * (to @ side) / (side @ side)
    return rise / np.linalg.norm(rise)


def oracle_walk(vertices, faces, face, point, direction, length):
    """(face, point, direction, length walked, None or "border" or "vertex")."""
    vertices = vertices.astype(np.float64)
    at_edge = {}
    for index, corners in enumerate(faces):
        for k in range(3):
            at_edge.setdefault(frozenset((corners[k], corners[(k + 1) % 3])), []).append(index)
    corners = vertices[faces[face]]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    direction = direction - normal * (direction @ normal)
    direction /= np.linalg.norm(direction)
    walked, came_over = 0.0, None
    while True:
        corners = vertices[faces[face]]
        best = None
        for k in range(3):
            i, j = k, (k + 1) % 3
            edge = frozenset((faces[face][i], faces[face][j]))
            out = -inward(corners, i, j, (k + 2) % 3)
            if edge == came_over or direction @ out <= 0:
                continue
            distance = (corners[i] - point) @ out / (direction @ out)
            if best is None or distance < best[0]:
                best = distance, i, j, out, edge
        distance, i, j, out, edge = best
        if walked + distance >= length:
            return face, point + (length - walked) * direction, direction, length, None
        point, walked = point + distance * direction, walked + distance
        side = corners[j] - corners[i]
        share = (point - corners[i]) @ side / (side @ side)
        if not 1e-6 < share < 1 - 1e-6:
            return face, point, direction, walked, "vertex"
        others = [other for other in at_edge[edge] if other != face]
        if not others:
            return face, point, direction, walked, "border"
        (other,) = others
        (k,) = [k for k in range(3) if faces[other][k] not in edge]
        beyond = inward(vertices[faces[other]], (k + 1) % 3, (k + 2) % 3, k)
        axis = side / np.linalg.norm(side)
        angle = np.arctan2(np.cross(out, beyond) @ axis, out @ beyond)
        direction = turned(direction, axis, angle)
        face, came_over = other, edge


@lru_cache(maxsize=None)
def faces_at(mesh):
    """The faces that name each vertex, ascending."""
    rows = [[] for _ in mesh.vertices]
    for face, corners in enumerate(mesh.faces.tolist()):
        for vertex in set(corners):
            rows[vertex].append(face)
    return [np.array(row, np.int64) for row in rows]


class Around:
    """A vertex with the faces around it, seen along the normal of one of them.

    It tells which headings in the plane of that face they contain, and knows no angles of faces.

    A face that edges connect with the one of the view is on the same side of the surface; if it may
    be seen from behind there, it counts for nothing: it is folded away.
    """

    MARGIN = 1e-6  # rad beside the side of a face, where rounding may say either

    def __init__(self, mesh, vertex, face, up=None):
        self.origin = mesh.vertices[vertex].astype(np.float64)
        corners = {face: mesh.faces[face].tolist()}
        for other in faces_at(mesh)[vertex].tolist():
            if len(set(mesh.faces[other].tolist())) == 3 and not any(
                set(mesh.faces[other].tolist()) == set(known) for known in corners.values()
            ):
                corners[other] = mesh.faces[other].tolist()
        # right and left as wound, for each
        ends = {f: (c * 2)[c.index(vertex) + 1 :][:2] for f, c in corners.items()}
        self.faces = np.array(list(corners))
        sides = [
            mesh.vertices[[end[k] for end in ends.values()]].astype(np.float64) - self.origin
            for k in (0, 1)
        ]
        normals = np.cross(*sides)
        sizes = np.linalg.norm(normals, axis=1)
        size2 = np.maximum(*(np.square(side).sum(1) for side in sides))
        self.has_area = sizes > 1e-9 * size2
        normals /= np.where(self.has_area, sizes, 1)[:, None]
        self.normal = normals[0] if up is None else np.asarray(up, np.float64)
        self.x = sides[0][0] - self.normal * (sides[0][0] @ self.normal)
        self.x /= np.linalg.norm(self.x)
        self.y = np.cross(self.normal, self.x)
        seen = [np.stack([side @ self.x, side @ self.y], 1) for side in sides]
        angles = [np.arctan2(side[:, 1], side[:, 0]) for side in seen]
        spread = (angles[1] - angles[0] + np.pi) % (2 * np.pi) - np.pi
        self._sides, self._seen = sides, seen
        self.begin = np.where(spread > 0, angles[0], angles[1])
        self.spread = np.abs(spread)
        facing = normals @ self.normal
        upright = (np.abs(facing) < 1e-6) | (self.spread > np.pi - 1e-6)
        signs, self.is_surrounded, self.is_plain = _connected(
            ends, face, 1 if facing[0] >= 0 else -1
        )
        self.is_surrounded &= bool(self.has_area.all())
        self.in_front = self.has_area & ~upright
        for i, other in enumerate(self.faces.tolist()):
            self.in_front[i] &= all(sign * facing[i] > 0 for sign in signs.get(other, ()))
        self.connected = np.array([other in signs for other in self.faces.tolist()])
        self.shows_all = bool((self.in_front & (np.abs(facing) > 1e-3))[self.connected].all())

    def heading(self, angle):
        """(3,) in the plane that is seen."""
        return np.cos(angle) * self.x + np.sin(angle) * self.y

    def way_in(self, face, angle):
        """(3,) from the vertex into a face that contains a heading, of length 1 as seen."""
        i = int(np.flatnonzero(self.faces == face)[0])
        both = np.stack([seen[i] for seen in self._seen], 1)
        right, left = np.linalg.solve(both, (np.cos(angle), np.sin(angle)))
        return right * self._sides[0][i] + left * self._sides[1][i]

    def angle_of(self, way):
        """Of the heading of a way (3,)."""
        return np.arctan2(way @ self.y, way @ self.x)

    def containing(self, angle):
        """Indices of the faces that surely contain a heading, and whether others may."""
        past = (angle - self.begin) % (2 * np.pi)
        surely = (past > self.MARGIN) & (past < self.spread - self.MARGIN) & self.in_front
        near = (past < self.spread + self.MARGIN) | (past > 2 * np.pi - self.MARGIN)
        return self.faces[surely], bool((near & ~surely).any())


def _connected(ends, first, sign):
    """Which faces edges at a vertex connect with the first one, each with the sides on which a walk
    may come to it from a side of the first (1: as it is wound; where more than two faces meet, both
    may be); whether they go all the way round; and whether never more than two meet.
    """
    spokes = {}
    for face, (right, left) in ends.items():
        spokes.setdefault(right, []).append((face, 1))
        spokes.setdefault(left, []).append((face, -1))
    signs, waiting = {first: {sign}}, [(first, sign)]
    while waiting:
        face, sign = waiting.pop()
        for spoke in ends[face]:
            own = next(way for other, way in spokes[spoke] if other == face)
            for other, way in spokes[spoke]:
                theirs = -sign * own * way
                if other != face and theirs not in signs.setdefault(other, set()):
                    signs[other].add(theirs)
                    waiting.append((other, theirs))
    meeting = [len(spokes[spoke]) for face in signs for spoke in ends[face]]
    return signs, min(meeting) == max(meeting) == 2, max(meeting) <= 2
