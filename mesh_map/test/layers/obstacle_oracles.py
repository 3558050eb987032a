"""Obstacles in plain Python, one point after the other, for the tests."""

import math

import numpy as np
from mesh_map.spatial.hits import NO_FACE


def face_below(vertices, faces, point, down, reach):
    """The first face that a ray meets and how far it is; and whether rounding decides that."""
    a, b, c = (vertices[faces[:, k]].astype(np.float64) for k in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        p = np.cross(down, c - a)
        det = np.einsum("ij,ij->i", b - a, p)
        s = point - a
        u = np.einsum("ij,ij->i", s, p) / det
        q = np.cross(s, b - a)
        w = q @ down / det
        t = np.einsum("ij,ij->i", c - a, q) / det
        hit = (u >= 0) & (w >= 0) & (u + w <= 1) & (t >= 0) & (t <= reach)
        margins = np.minimum(np.minimum(u, w), np.minimum(1 - u - w, t))
        close = (np.abs(margins) < 1e-9).any() or (np.abs(det) < 1e-12).any()
        close = close or (np.abs(t - reach) < 1e-9).any()
    if not hit.any():
        return NO_FACE, math.inf, close
    distances = np.where(hit, t, np.inf)
    first = int(np.argmin(distances))
    return first, distances[first], close or np.sum(distances < distances[first] + 1e-9) > 1


def view_cell(offset, angle):
    """Row and column of the cell in which a direction lies; None for none."""
    distance = math.sqrt(sum(x * x for x in offset))
    if not distance:
        return None
    rows = max(math.ceil(math.pi / angle), 1)
    height = math.asin(max(-1.0, min(1.0, offset[2] / distance))) / math.pi + 0.5
    row = min(int(height * rows), rows - 1)
    middle = (row + 0.5) / rows * math.pi - math.pi / 2
    columns = max(math.ceil(2 * math.pi / angle * math.cos(middle)), 1)
    turn = math.atan2(offset[1], offset[0]) / (2 * math.pi) + 0.5
    return row, min(int(turn * columns), columns - 1)


def seen_past(mark, offsets, ground, angle, margin):
    """Whether a view has something beyond a point in its cell, and nothing at or before it."""
    cell = view_cell(mark, angle)
    if cell is None:
        return False
    beyond = math.sqrt(sum(x * x for x in mark)) + margin
    far = False
    for offset, is_ground in zip(offsets, ground):
        if view_cell(offset, angle) != cell:
            continue
        distance = math.sqrt(sum(x * x for x in offset))
        if distance > beyond:
            far = True
        elif not is_ground:
            return False
    return far


class SlowObstacles:
    """What ObstacleLayer does, as its README says it."""

    def __init__(self, vertices, faces, params):
        self.vertices, self.faces, self.params = vertices, faces, params
        self.marks = {}  # (face, cube) -> (point, time)
        self.undecided = 0

    @property
    def marked_faces(self):
        return sorted({face for face, _ in self.marks})

    def insert_cloud(self, points, origin, stamp, down=(0, 0, -1)):
        params, down = self.params, np.asarray(down, float) / np.linalg.norm(down)
        lowest, found, offsets, ground = params["min_obstacle_height"], [], [], []
        for point in points:
            if not all(math.isfinite(x) for x in point):
                continue
            offsets.append(tuple(point - origin))
            distance, is_ground = math.dist(point, origin), False
            if params["min_obstacle_dist"] <= distance <= params["max_obstacle_dist"]:
                start, reach = point - lowest * down, params["robot_height"] + lowest
                face, way, close = face_below(self.vertices, self.faces, start, down, reach)
                self.undecided += bool(close)
                is_ground = face != NO_FACE and way - lowest < lowest
                if face != NO_FACE and not is_ground:
                    found.append((face, point))
            ground.append(is_ground)
        for key, (point, time) in list(self.marks.items()):
            self.marks[key] = (point, min(time, stamp))
        if params["decay"] < 0:
            self.marks = {}
        elif params["clearing"]:
            angle, margin = math.radians(params["clearing_angle"]), params["clearing_margin"]
            self.marks = {
                key: (point, time)
                for key, (point, time) in self.marks.items()
                if not seen_past(tuple(point - origin), offsets, ground, angle, margin)
            }
        self.decay(stamp)
        cloud = {}
        for face, point in found:
            cube = tuple(int(math.floor(x / 0.1)) for x in point)
            cloud.setdefault((face, cube), (point, stamp))
        self.marks.update(cloud)

    def decay(self, now):
        for key, (point, time) in list(self.marks.items()):
            self.marks[key] = (point, min(time, now))
            if self.params["decay"] > 0 and min(time, now) < now - self.params["decay"]:
                del self.marks[key]
