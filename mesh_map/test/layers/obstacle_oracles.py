"""Obstacles in plain Python, for the tests; but for rays, which are many."""

import math

import numpy as np
from mesh_map.spatial.hits import NO_FACE


def faces_below(vertices, faces, points, down, reach):
    """(N,) the first face that a ray from each point meets, how far it is, and whether rounding
    decides that.
    """
    a, b, c = (vertices.astype(np.float64)[faces[:, k]] for k in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        p = np.cross(down, c - a)
        det = np.einsum("fj,fj->f", b - a, p)
        s = np.asarray(points, np.float64).reshape(-1, 1, 3) - a
        u = np.einsum("nfj,fj->nf", s, p) / det
        # of q = s x (b - a), what is q . d and q . (c - a)
        w = np.einsum("nfj,fj->nf", s, np.cross(b - a, down)) / det
        t = np.einsum("nfj,fj->nf", s, np.cross(b - a, c - a)) / det
        hit = (u >= 0) & (w >= 0) & (u + w <= 1) & (t >= 0) & (t <= reach)
        margins = np.minimum(np.minimum(u, w), np.minimum(1 - u - w, t))
        close = (np.abs(margins) < 1e-9).any(1) | (np.abs(det) < 1e-12).any()
        close |= (np.abs(t - reach) < 1e-9).any(1)
    distances = np.where(hit, t, np.inf)
    first = np.argmin(distances, 1)
    nearest = distances[np.arange(len(first)), first]
    alike = (distances < nearest[:, None] + 1e-9).sum(1) > 1
    found = hit.any(1)
    return np.where(found, first, NO_FACE), nearest, close | (found & alike)


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


def view_of(offsets, ground, angle):
    """What lies in each cell of a view: [(distance, whether it is ground)]."""
    view = {}
    for offset, is_ground in zip(offsets, ground):
        distance = math.sqrt(sum(x * x for x in offset))
        view.setdefault(view_cell(offset, angle), []).append((distance, is_ground))
    return view


def seen_past(mark, view, angle, margin):
    """Whether a view has something beyond a point in its cell, and nothing at or before it."""
    cell = view_cell(mark, angle)
    if cell is None:
        return False
    beyond = math.sqrt(sum(x * x for x in mark)) + margin
    far = False
    for distance, is_ground in view.get(cell, ()):
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
        points = [point for point in points if all(math.isfinite(x) for x in point)]
        reach = params["robot_height"] + lowest
        starts = [point - lowest * down for point in points]
        below = zip(*faces_below(self.vertices, self.faces, starts, down, reach))
        for point, (face, way, close) in zip(points, below):
            offsets.append(tuple(point - origin))
            distance, is_ground = math.dist(point, origin), False
            if params["min_obstacle_dist"] <= distance <= params["max_obstacle_dist"]:
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
            view = view_of(offsets, ground, angle)
            self.marks = {
                key: (point, time)
                for key, (point, time) in self.marks.items()
                if not seen_past(tuple(point - origin), view, angle, margin)
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
