"""Shadows of scans closed: holes where no ray came, if what is around tells what is in them."""

from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from scipy.spatial import cKDTree

from mesh_map.geometry.border_loops import BorderLoops, border_loops
from mesh_map.geometry.hole_filling import HoleFilling, LoopFate, fill_holes
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex

MOST_STEP = 0.15  # m by which the ground on both sides of a shadow may be off
_AROUND = 40.0  # perimeter of a loop that is looked at, in widths
_FLATNESS = 0.3  # of fill_holes()
_AWAY, _TOWARDS = np.sin(np.radians(30.0)), np.sin(np.radians(20.0))
_LEAST_AWAY, _MOST_TOWARDS = 0.5, 0.1  # shares of the loop of a lid
_REACH = 8.0  # sides of loops, up to which faces around a place of one tell its plane
_GROUND = np.cos(np.radians(40.0))  # between the normals of these and the patch
_LEAST_VERTICES = 15  # that tell a plane
_MOST_PLACES = 150  # of a loop that are compared
_PLACES, _CONE = 16, np.radians(60.0)  # of a patch that rays begin at; how far they spread
_MOST_SEEN = 0.25  # of these rays, that may end on the front of a face


class Shadows(NamedTuple):
    """What fill_shadows() has closed.

    derived: the mesh, or None where nothing was closed.
    holes, faces: how many, by how many faces.
    folded: vertices of each loop that cannot be closed, for what would close it lies back on the
        surface or crosses it: without the faces beside, it may be.
    """

    derived: Optional[DerivedMesh]
    holes: int
    faces: int
    folded: List[np.ndarray]


def fill_shadows(vertices: Any, faces: Any, *, max_width: float, narrow: float) -> Shadows:
    """A surface that was scanned, without the shadows that can be told to have surface in them.

    A hole is closed where all of this holds for the patch that fill_holes() makes for it:

    * No circle wider than `max_width` has room in the hole, and its perimeter is at most 40 times
      that.
    * It is no opening, or not wider than half of `narrow`: of rays that go on behind the patch, at
      most a quarter first meet a face from its front. Behind the ground there are backs of faces
      or none; in a pit, below a bridge or behind a window, what the scans have seen there.
    * Wider than `narrow`, it is either a lid, from which the surface falls away all around (the
      top of a wall), or the ground goes on across it: planes fitted on both sides agree within
      0.15 m where they are to meet by the mean of their slopes, and nothing upright around begins
      that much below them. So curbs, ledges and ditches stay open.

    Args:
        vertices: (V, 3) m. faces: (F, 3), their front towards the sensors; no hole that is short
            and flat (see fill_holes()) should be left.
        max_width: m; 0 for none.
        narrow: m; narrower holes may lie anywhere.
    Raises:
        MeshMapError: no mesh: what is wrong.
    """
    filling = fill_holes(vertices, faces, max_perimeter=_AROUND * max_width, flatness=_FLATNESS)
    loops = border_loops(faces, len(vertices))
    folded = [
        loops.vertices[loops.offsets[i] : loops.offsets[i + 1]]
        for i in np.flatnonzero(np.isin(filling.fates, (LoopFate.FOLDED, LoopFate.CROSSING)))
    ]
    if filling.derived is None:
        return Shadows(None, 0, 0, folded)
    judge = _ShadowJudge(np.asarray(vertices, np.float64), np.asarray(faces), loops, filling)
    closed = [
        patch
        for patch in judge.patches()
        if patch.width <= max_width
        and (patch.width <= narrow or judge.is_lid(patch) or judge.ground_goes_on(patch))
    ]
    seen = judge.seen_shares(closed)
    closed = [
        patch
        for patch, share in zip(closed, seen)
        if share <= _MOST_SEEN or patch.width <= 0.5 * narrow
    ]
    if not closed:
        return Shadows(None, 0, 0, folded)
    derived = judge.with_patches(closed)
    return Shadows(derived, len(closed), len(derived.faces) - len(faces), folded)


class _Patch(NamedTuple):
    """What closes a loop.

    faces: (K,) of those of the mesh with all patches.
    loop: (N,) vertices, in the order of the faces beside.
    sides: (N, 3) m, from each of them to the next.
    width: m, of the largest circle that it has room for.
    normal: (3,), of length 1.
    """

    faces: np.ndarray
    loop: np.ndarray
    sides: np.ndarray
    width: float
    normal: np.ndarray


class _ShadowJudge:
    """What is around patches, and behind them.

    Args:
        vertices: (V, 3) float64. faces: (F, 3).
        loops: of this mesh.
        filling: of this mesh, with a derived mesh.
    """

    def __init__(
        self, vertices: np.ndarray, faces: np.ndarray, loops: BorderLoops, filling: HoleFilling
    ) -> None:
        assert filling.derived is not None
        self._vertices, self._faces, self._filling = vertices, faces, filling
        self._all_vertices = filling.derived.vertices.astype(np.float64)
        self._all_faces = filling.derived.faces
        self._loops = loops
        side = float(loops.perimeters(vertices).sum()) / len(loops.vertices)
        self._reach = _REACH * side

        at_border = np.zeros(len(vertices), bool)
        at_border[loops.vertices] = True
        rows = [at_border]
        for _ in range(int(_REACH) + 2):
            rows.append(rows[-1].copy())
            rows[-1][faces[rows[-1][faces].any(axis=1)]] = True
        near = faces[rows[-1][faces].any(axis=1)]
        of_vertices = _sums(near, _crosses(vertices[near]), len(vertices))
        self._smooth = _unit(_around(near, _around(near, of_vertices)))
        inner = np.flatnonzero(rows[-1] & ~rows[1])
        self._inner_points, self._inner_normals = vertices[inner], _unit(of_vertices[inner])
        self._inner = cKDTree(self._inner_points)

    def patches(self) -> List[_Patch]:
        """One for each loop that was closed."""
        loops, starts = np.unique(self._filling.face_loops, return_index=True)
        starts = np.append(starts, len(self._filling.face_loops)) + len(self._faces)
        return [
            self._patch(int(loop), np.arange(begin, end))
            for loop, begin, end in zip(loops, starts[:-1], starts[1:])
        ]

    def _patch(self, number: int, faces: np.ndarray) -> _Patch:
        offsets = self._loops.offsets
        loop = self._loops.vertices[offsets[number] : offsets[number + 1]]
        around = self._vertices[loop]
        sides = np.roll(around, -1, axis=0) - around
        corners = self._all_faces[faces]
        inside = [self._all_vertices[corners].mean(axis=1)]
        inside.append(self._all_vertices[np.unique(corners[corners >= len(self._vertices)])])
        rim = cKDTree(np.concatenate([around, around + 0.5 * sides]))
        width = 2.0 * float(rim.query(np.concatenate(inside))[0].max())
        return _Patch(
            faces, loop, sides, width, _unit(_crosses(self._all_vertices[corners]).sum(axis=0))
        )

    def is_lid(self, patch: _Patch) -> bool:
        """Whether the surface falls away from it on most of its loop, and nowhere rises."""
        outwards = _unit(np.cross(patch.normal, patch.sides))
        rises = -np.einsum("ij,ij->i", self._smooth[patch.loop], outwards)
        lengths = np.linalg.norm(patch.sides, axis=1)
        away = lengths[rises < -_AWAY].sum() / lengths.sum()
        towards = lengths[rises > _TOWARDS].sum() / lengths.sum()
        return bool(away >= _LEAST_AWAY and towards <= _MOST_TOWARDS)

    def ground_goes_on(self, patch: _Patch) -> bool:
        """Whether what is on both sides of it would meet in it.

        Between two places of smooth ground, the height changes by the mean of their slopes; at a
        ledge, the ground is level on both sides, and the heights differ all the same.
        """
        places = self._vertices[patch.loop]
        places = places[np.linspace(0, len(places) - 1, min(len(places), _MOST_PLACES)).astype(int)]
        up = patch.normal
        middles, normals = self._planes(places, up)
        steep = np.where(np.isfinite(middles[:, 0]), normals @ up, 1.0)
        heights = places @ up + np.einsum("ij,ij->i", middles - places, normals) / steep
        is_ground = np.abs(places @ up - heights) <= MOST_STEP  # not far below or above its plane
        if not is_ground.any():
            return False
        points, others = places[is_ground], places[~is_ground]
        normals, steep, heights = normals[is_ground], steep[is_ground], heights[is_ground]
        slopes = -(normals - np.outer(steep, up)) / steep[:, None]

        ways = _level(points[None] - points[:, None], up)
        steps = heights[None] - heights[:, None]
        steps -= 0.5 * np.einsum("ijk,ijk->ij", ways, slopes[None] + slopes[:, None])
        far = np.linalg.norm(ways, axis=2)
        opposite = (far > 0.7 * patch.width) & (far < 1.4 * patch.width)
        if np.percentile(np.abs(_medians(steps, opposite)), 90) > MOST_STEP:
            return False
        ways = _level(others[:, None] - points[None], up)
        rises = (others @ up)[:, None] - heights - np.einsum("ijk,jk->ij", ways, slopes)
        near = np.linalg.norm(ways, axis=2) < 1.2 * patch.width
        return bool(np.percentile(_medians(rises, near), 10) >= -MOST_STEP)

    def _planes(self, places: np.ndarray, up: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """(N, 3) middles and (N, 3) normals of the ground near places; NaN where there is none."""
        found = self._inner.query_ball_point(places, self._reach)
        counts = np.array([len(each) for each in found])
        near = np.concatenate([np.asarray(each, np.int64) for each in found])
        of = np.repeat(np.arange(len(places)), counts)
        is_ground = self._inner_normals[near] @ up > _GROUND
        near, of = near[is_ground], of[is_ground]
        sums = [
            np.bincount(of, values[near, k], len(places))
            for values in (self._inner_points, self._inner_normals)
            for k in range(3)
        ]
        counts = np.bincount(of, minlength=len(places)).astype(np.float64)
        counts[counts < _LEAST_VERTICES] = np.nan
        return np.stack(sums[:3], axis=1) / counts[:, None], _unit(np.stack(sums[3:], axis=1))

    def seen_shares(self, patches: List[_Patch]) -> np.ndarray:
        """(P,) of rays that begin behind each patch and go on, those that first meet a face from
        its front."""
        if not patches:
            return np.zeros(0)
        with_patches = self.with_patches(patches)
        index = SpatialIndex(with_patches.vertices, with_patches.faces)
        origins, directions = [], []
        for patch in patches:
            some = patch.faces[np.linspace(0, len(patch.faces) - 1, _PLACES).astype(int)]
            corners = self._all_vertices[self._all_faces[some]]
            fronts = _crosses(corners)
            sizes = np.sqrt(np.linalg.norm(fronts, axis=1))
            starts = corners.mean(axis=1) - 0.3 * sizes[:, None] * _unit(fronts)
            cone = _cone(-patch.normal)
            origins.append(np.repeat(starts, len(cone), axis=0))
            directions.append(np.tile(cone, (len(starts), 1)))
        ways = np.concatenate(directions)
        hits = index.cast_batch(
            origins=np.concatenate(origins), directions=ways, back_end="native"
        ).faces
        met = hits != NO_FACE
        met_faces = with_patches.faces[hits[met]]
        seen = np.zeros(len(hits))
        fronts = _crosses(with_patches.vertices[met_faces].astype(np.float64))
        seen[met] = np.einsum("ij,ij->i", fronts, ways[met]) < 0.0
        shares: np.ndarray = seen.reshape(len(patches), -1).mean(axis=1)
        return shares

    def with_patches(self, patches: List[_Patch]) -> DerivedMesh:
        """The mesh with these."""
        whole = self._filling.derived
        assert whole is not None
        kept = np.concatenate([np.arange(len(self._faces))] + [each.faces for each in patches])
        is_used = np.arange(len(whole.vertices)) < len(self._vertices)
        is_used[self._all_faces[kept]] = True
        numbers = np.cumsum(is_used, dtype=np.int64) - 1
        return DerivedMesh(
            "",
            "",
            whole.vertices[is_used],
            numbers[self._all_faces[kept]].astype(np.uint32),
            face_parents=whole.face_parents[kept],
            vertex_parents=whole.vertex_parents[is_used],
            vertex_weights=whole.vertex_weights[is_used],
            parent_vertex_count=len(self._vertices),
            parent_face_count=len(self._faces),
        )


def _unit(vectors: np.ndarray) -> np.ndarray:
    """Of length 1; 0 stays 0."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    scaled: np.ndarray = vectors / np.where(lengths > 0.0, lengths, 1.0)
    return scaled


def _level(ways: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Without what of them is along `up`."""
    flat: np.ndarray = ways - (ways @ up)[..., None] * up
    return flat


def _medians(values: np.ndarray, counted: np.ndarray) -> np.ndarray:
    """(N,) of those of each row (N, M) that are counted; of no row: [0]."""
    some = counted.any(axis=1)
    if not some.any():
        return np.zeros(1)
    found: np.ndarray = np.nanmedian(np.where(counted, values, np.nan)[some], axis=1)
    return found


def _crosses(corners: np.ndarray) -> np.ndarray:
    """(F, 3) normals of faces by their corners (F, 3, 3), as long as twice the area."""
    crosses: np.ndarray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return crosses


def _sums(faces: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """(count, 3): for each vertex the sum of the values (F, 3) of its faces."""
    numbers = faces.ravel()
    return np.stack(
        [np.bincount(numbers, np.repeat(values[:, k], 3), count) for k in range(3)], axis=1
    )


def _around(faces: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(V, 3): for each vertex the sum of the values (V, 3) of the corners of its faces."""
    return _sums(faces, values[faces].sum(axis=1), len(values))


def _cone(axis: np.ndarray) -> np.ndarray:
    """(16, 3) directions of length 1, evenly around an axis."""
    count = 16
    cosines = 1.0 - (1.0 - np.cos(_CONE)) * (np.arange(count) + 0.5) / count
    turns = np.pi * (1.0 + 5.0**0.5) * np.arange(count)
    side = _unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    other = np.cross(axis, side)
    sines = np.sqrt(1.0 - cosines**2)
    return (
        cosines[:, None] * axis
        + (sines * np.cos(turns))[:, None] * side
        + (sines * np.sin(turns))[:, None] * other
    )
