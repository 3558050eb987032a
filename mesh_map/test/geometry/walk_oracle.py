"""A straightest geodesic in NumPy: another way than the kernel's, for walks that meet no vertex.

The direction is kept in space, and turned about each edge that is crossed by the angle between the
two faces.
"""

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
