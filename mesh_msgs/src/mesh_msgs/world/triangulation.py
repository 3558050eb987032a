"""Irregular triangles over a square with holes, for the ground of the generated outdoor world."""

from typing import List, NamedTuple, Tuple

import numpy as np
from scipy.spatial import Delaunay, cKDTree

# Up to so many faces Delaunay's triangulation is used for the whole square (about 4 us per face).
WHOLE_LIMIT = 400_000


class Triangulation(NamedTuple):
    """Free points first, then those of the rings, in their order."""

    # (N, 2)
    free: np.ndarray
    # (F, 3), counter-clockwise
    faces: np.ndarray


def triangulate(
    size: float, faces: int, rings: List[np.ndarray], cover: np.ndarray, seed: int
) -> Triangulation:
    """Fill a square, except for the inside of rings, with about `faces` triangles.

    The square has the side `size` and its middle at the origin. Free points are those of a grid,
    moved at random. Near the rings (everywhere, if `faces` are few) the triangles are Delaunay's,
    which contain every edge of a ring because no other point lies in the circle around it;
    elsewhere each cell of the grid is cut along its shorter diagonal.

    :param rings: simple polygons (R, 2), counter-clockwise, well apart from each other and from the
      border.
    :param cover: (K, 3) discs x, y, radius; they and discs around the rings' edges cover all holes.
    :raises RuntimeError: where an edge of a ring is missing, because two rings are too close.
    """
    discs = np.concatenate([cover] + [_guards(ring) for ring in rings])
    whole = faces <= WHOLE_LIMIT
    wanted = faces / 2.0
    for _ in range(6):
        nx = max(4, int(round(np.sqrt(wanted))) - 1)
        ny = max(4, int(np.ceil(wanted / (nx + 1))) - 1)
        grid, zone, dropped = _grid(size, nx, ny, discs, whole, seed)
        # Euler's formula for a square with holes: F = 2 V - 2 - border - sum(ring - 2). V counts
        # the rings as well.
        free = len(grid) - np.count_nonzero(dropped)
        surplus = (2 * free - 2 - 2 * (nx + ny) + sum(len(ring) + 2 for ring in rings) - faces) // 2
        if 0 <= surplus <= nx + 1:
            break
        wanted = max(25.0, wanted - surplus + (nx + 1) / 2)
    if whole:
        # A few points less, so that the number is exact even for a coarse mesh.
        inner = np.flatnonzero(~dropped & (np.abs(grid).max(axis=1) < size / 2 * (1.0 - 1.5 / nx)))
        fewer = min(max(0, surplus), len(inner) // 4)
        dropped[np.random.default_rng([seed, 4]).permutation(inner)[:fewer]] = True

    number = np.cumsum(~dropped) - 1
    free = grid[~dropped]
    index = np.arange(len(grid)).reshape(nx + 1, ny + 1)
    regular = number[_shorter_diagonals(grid, index, ~zone)]
    near = np.zeros(index.shape, dtype=bool)
    for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1)):
        near[di : di + nx, dj : dj + ny] |= zone
    near = number[np.flatnonzero(near.ravel() & ~dropped)]
    irregular = _delaunay(free, near, rings, zone, size)
    return Triangulation(free, np.concatenate([regular, irregular]))


def _guards(ring: np.ndarray) -> np.ndarray:
    """Discs (N, 3) that keep other points away from a ring's vertices and edges."""
    ahead = np.roll(ring, -1, axis=0)
    length = np.linalg.norm(ahead - ring, axis=1, keepdims=True)
    edges = np.concatenate([(ring + ahead) / 2, 0.6 * length], axis=1)
    ends = np.concatenate([ring, 0.45 * np.maximum(length, np.roll(length, 1, axis=0))], axis=1)
    return np.concatenate([edges, ends])


def _grid(
    size: float, nx: int, ny: int, discs: np.ndarray, whole: bool, seed: int
) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the points of a grid, the cells for Delaunay, and which points the discs cover.

    The points ((nx + 1) (ny + 1), 2) are moved at random; `whole` takes all cells for Delaunay.
    """
    cell = np.array([size / nx, size / ny])
    zone = np.full((nx, ny), whole)
    if not whole:
        low = np.floor((discs[:, :2] - discs[:, 2:] + size / 2) / cell).astype(int) - 2
        high = np.floor((discs[:, :2] + discs[:, 2:] + size / 2) / cell).astype(int) + 3
        for (i, j), (k, m) in zip(np.maximum(low, 0), high):
            zone[i:k, j:m] = True
    x, y = np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0), indexing="ij")
    # Up to a quarter of a cell all quadrilaterals stay convex; Delaunay needs no such care.
    reach = 0.76 if whole else 0.49
    jitter = (np.random.default_rng([seed, 3]).random((2, nx + 1, ny + 1)) - 0.5) * reach
    # The border of the square stays straight, and so does that between the two kinds of triangles:
    # no point is then within the circle around one of its edges, so both sides agree on it.
    jitter[0, [0, -1]] = 0.0
    jitter[1, :, [0, -1]] = 0.0
    jitter[:, [0, 0, -1, -1], [0, -1, 0, -1]] = 0.0
    if not whole:
        count = np.zeros((nx + 1, ny + 1), dtype=np.int8)
        for di, dj in ((0, 0), (0, 1), (1, 0), (1, 1)):
            count[di : di + nx, dj : dj + ny] += np.where(zone, np.int8(1), np.int8(-1))
        # Cells of both kinds meet at a point, except where all of its four, two or one agree.
        cells = np.full((nx + 1, ny + 1), 4, dtype=np.int8)
        cells[[0, -1]] = 2
        cells[:, [0, -1]] = 2
        jitter[:, np.abs(count) < cells] = 0.0
        jitter[:, [0, 0, -1, -1], [0, -1, 0, -1]] = 0.0
    grid = (np.stack([x + jitter[0], y + jitter[1]], axis=2) * cell - size / 2).reshape(-1, 2)
    # Exactly straight borders, whatever the rounding.
    rim = np.stack([x % nx == 0, y % ny == 0], axis=2).reshape(-1, 2)
    grid[rim] = np.sign(grid[rim]) * (size / 2)
    dropped = np.zeros(len(grid), dtype=bool)
    candidates = np.flatnonzero(np.pad(zone, ((0, 1), (0, 1)), mode="edge").ravel())
    if len(candidates) and len(discs):
        hits = cKDTree(grid[candidates]).query_ball_point(discs[:, :2], discs[:, 2])
        hits = np.unique(np.concatenate([np.asarray(hit, dtype=np.int64) for hit in hits]))
        dropped[candidates[hits]] = True
    return grid, zone, dropped & ~rim.any(axis=1)


def _shorter_diagonals(grid: np.ndarray, index: np.ndarray, cells: np.ndarray) -> np.ndarray:
    a, b = index[:-1, :-1][cells], index[1:, :-1][cells]
    c, d = index[1:, 1:][cells], index[:-1, 1:][cells]
    first = np.square(grid[a] - grid[c]).sum(axis=1) <= np.square(grid[b] - grid[d]).sum(axis=1)
    lower = np.stack([a, b, np.where(first, c, d)], axis=1)
    upper = np.stack([np.where(first, a, b), c, d], axis=1)
    return np.stack([lower, upper], axis=1).reshape(-1, 3)


def _delaunay(
    free: np.ndarray, near: np.ndarray, rings: List[np.ndarray], zone: np.ndarray, size: float
) -> np.ndarray:
    """Delaunay's triangles of the cells in `zone` over free points and rings, without the holes.

    `near` are the indices of the free points that belong to cells of the zone.
    """
    lengths = [len(ring) for ring in rings]
    points = np.concatenate([free[near]] + rings)
    number = np.concatenate([near, len(free) + np.arange(sum(lengths))])
    hole = np.concatenate([np.full(len(near), -1), np.repeat(np.arange(len(rings)), lengths)])
    faces = Delaunay(points).simplices.astype(np.int64)
    (ax, ay), (bx, by), (cx, cy) = points[faces].transpose(1, 2, 0)
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    clockwise = area < 0.0
    faces[clockwise] = faces[clockwise][:, ::-1]
    # Three points of a straight border can come out as a triangle without area.
    keep = np.abs(area) > 1e-9 * (size / max(zone.shape)) ** 2
    centers = points[faces].mean(axis=1)
    cells = np.floor((centers + size / 2) * zone.shape / size).astype(int)
    i, j = np.clip(cells, 0, np.array(zone.shape) - 1).T
    keep &= zone[i, j]
    inside = keep & (hole[faces[:, 0]] >= 0) & (np.ptp(hole[faces], axis=1) == 0)
    for candidate in range(len(rings)):
        mine = np.flatnonzero(inside & (hole[faces[:, 0]] == candidate))
        inside[mine] = _in_polygon(centers[mine], rings[candidate])
    if np.count_nonzero(inside) != sum(lengths) - 2 * len(rings):
        raise RuntimeError(
            "two structures of the generated world are too close to each other; try another seed"
        )
    return number[faces[keep & ~inside]]


def _in_polygon(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Tell which points lie in a simple polygon."""
    result = np.zeros(len(points), dtype=bool)
    x, y = points.T
    # A ray along x from a point inside crosses the edges an odd number of times.
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0)):
        if ay != by:
            crosses = (y < ay) != (y < by)
            result ^= crosses & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return result
