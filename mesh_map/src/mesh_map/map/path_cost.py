"""The cost along a path."""

import math
from typing import Callable, Iterator, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.surface import barycentric_coordinates, interpolate, is_inside
from mesh_map.geometry.walk import WalkEnd, WalkPath
from mesh_map.spatial.hits import NO_FACE, SurfacePoints

_CLOSE = 1e-6  # of a path that stays within a face, of the size of the piece
_SAME = 1e-3  # of a line that came to its target, of its length
_FLAT = 1e-3  # weights that are off by more are of a face without area, such as between two others
_SAMPLE = 0.05  # meters; where the surface cannot be followed
_MOST_SAMPLES = 10_000  # of one piece of a path
_TOGETHER = 1 << 14  # samples, about: each takes some hundred bytes on its way

Carry = Callable[[np.ndarray], SurfacePoints]


class PathCost(NamedTuple):
    """What a path costs.

    length: meters, along the surface where the path is on it.
    integral: cost x meters over the part where costs are known and not lethal.
    mean, maximum: over that part; 0 where there is none.
    lethal_length, unknown_length, off_map_length: meters.
    point_costs: (N,) float64 at the points of the path: +inf lethal, NaN unknown or off the map.
    point_faces: (N,) uint32; NO_FACE off the map.
    """

    length: float
    integral: float
    mean: float
    maximum: float
    lethal_length: float
    unknown_length: float
    off_map_length: float
    point_costs: np.ndarray
    point_faces: np.ndarray

    @property
    def lethal(self) -> bool:
        return self.lethal_length > 0.0 or bool(np.isposinf(self.point_costs).any())

    @property
    def off_map(self) -> bool:
        return self.off_map_length > 0.0 or bool((self.point_faces == NO_FACE).any())

    @property
    def unknown(self) -> bool:
        """Also where it is off the map."""
        return self.unknown_length > 0.0 or bool(np.isnan(self.point_costs).any()) or self.off_map

    @property
    def cost(self) -> float:
        """One number: +inf if any of it is lethal, else NaN if unknown, else the integral."""
        return math.inf if self.lethal else math.nan if self.unknown else self.integral


class _Pieces(NamedTuple):
    """Straight pieces of a path.

    faces: (K,); NO_FACE off the map.
    begins, ends: (K, 3), in the face (but for pieces that are sampled, a point of it).
    lengths: (K,) meters.
    """

    faces: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    lengths: np.ndarray


def path_cost(
    geometry: MeshGeometry,
    costs: np.ndarray,
    points: np.ndarray,
    carry: Carry,
    step: Optional[float],
) -> PathCost:
    """The cost along the straight pieces between points; see SurfaceQueries.path_cost().

    By the trapezoidal rule, which is exact where costs are linear (Pütz et al., eq. (4)).

    Args:
        geometry: the mesh.
        costs: (V,).
        points: (N, 3), N >= 1.
        carry: finds the points of the surface that carry points.
        step: meters between samples; None to be exact.
    """
    carried = carry(points)
    if step is None:
        parts = _exact_pieces(geometry, carried, points, carry)
    else:
        parts = _sampled(points[:-1], points[1:], carry, step)
    at_points = interpolate(costs, geometry.faces, carried)
    finite = at_points[np.isfinite(at_points)]
    sums, maximum = np.zeros(len(_Sums._fields)), finite.max(initial=0.0)
    for pieces in parts:
        found, most = _summed(costs, geometry, pieces)
        sums, maximum = sums + found, max(maximum, most)
    total = _Sums(*sums.tolist())
    if total.known > 0.0:
        mean = total.integral / total.known
    else:
        mean = float(finite.mean()) if len(finite) else 0.0
    return PathCost(
        length=total.length,
        integral=total.integral,
        mean=mean,
        maximum=float(maximum),
        lethal_length=total.lethal,
        unknown_length=total.unknown,
        off_map_length=total.off_map,
        point_costs=at_points,
        point_faces=carried.faces,
    )


class _Sums(NamedTuple):
    """Of pieces: the integral of the cost, and lengths in meters: of all, and by what is there."""

    integral: float
    length: float
    known: float
    lethal: float
    unknown: float
    off_map: float


def _summed(costs: np.ndarray, geometry: MeshGeometry, pieces: _Pieces) -> Tuple[_Sums, float]:
    """The sums, and the largest cost."""
    middle = _values(costs, geometry, pieces.faces, (pieces.begins + pieces.ends) / 2.0)
    known, lethal = np.isfinite(middle), np.isposinf(middle)
    off_map = pieces.faces == NO_FACE
    both_ends = [
        _values(costs, geometry, pieces.faces[known], places[known])
        for places in (pieces.begins, pieces.ends)
    ]
    # an end just at a lethal corner, of which the middle has too little to count
    begin, end = (np.where(np.isfinite(value), value, middle[known]) for value in both_ends)
    lengths = pieces.lengths
    integral = ((begin + end) / 2.0 * lengths[known]).sum()
    kinds = (known, lethal, ~known & ~lethal & ~off_map, off_map)
    sums = _Sums(integral, lengths.sum(), *(lengths[kind].sum() for kind in kinds))
    return sums, np.concatenate([begin, end]).max(initial=0.0)


def _exact_pieces(
    geometry: MeshGeometry, carried: SurfacePoints, points: np.ndarray, carry: Carry
) -> Iterator[_Pieces]:
    """Pieces within one face are as they are; others follow the surface; what does not arrive, such
    as off the map, is sampled.
    """
    begins, ends = carried.positions[:-1], carried.positions[1:]
    on_map = (carried.faces[:-1] != NO_FACE) & (carried.faces[1:] != NO_FACE)
    # the face of the middle is that of the whole where a piece runs along an edge, too
    middle = np.where(on_map, carry((begins + ends) / 2.0).faces, NO_FACE)
    within = middle != NO_FACE
    for places in (begins, ends):
        within[within] &= _are_in(geometry, middle[within], places[within])
    lengths = np.linalg.norm(ends - begins, axis=1)
    yield _Pieces(middle[within], begins[within], ends[within], lengths[within])

    followed = np.flatnonzero(on_map & ~within)
    if len(followed):
        starts = SurfacePoints(*(array[:-1][followed] for array in carried))
        walks = geometry.walker.line_batch(starts=starts, targets=ends[followed], paths=True)
        gaps = np.linalg.norm(walks.positions - ends[followed], axis=1)
        arrived = (walks.ends == WalkEnd.ARRIVED) & (gaps <= _SAME * lengths[followed])
        assert walks.paths is not None
        paths = [_of_path(walks.paths[number]) for number in np.flatnonzero(arrived)]
        if paths:
            yield _Pieces(*(np.concatenate(arrays) for arrays in zip(*paths)))
        within[followed[arrived]] = True
    rest = ~within
    yield from _sampled(points[:-1][rest], points[1:][rest], carry, _SAMPLE)


def _of_path(path: WalkPath) -> _Pieces:
    begins, ends = path.points[:-1], path.points[1:]
    return _Pieces(path.faces, begins, ends, np.linalg.norm(ends - begins, axis=1))


def _sampled(begins: np.ndarray, ends: np.ndarray, carry: Carry, step: float) -> Iterator[_Pieces]:
    """The middle of each of short pieces, for all of it."""
    lengths = np.linalg.norm(ends - begins, axis=1)
    counts = np.clip(np.ceil(lengths / step), 1, _MOST_SAMPLES).astype(np.int64)
    groups = np.cumsum(counts) // _TOGETHER
    for group in np.split(np.arange(len(counts)), np.flatnonzero(np.diff(groups)) + 1):
        which = np.repeat(group, counts[group])
        firsts = np.cumsum(counts[group]) - counts[group]
        numbers = np.arange(len(which)) - np.repeat(firsts, counts[group])
        shares = (numbers + 0.5) / counts[which]
        found = carry(begins[which] + shares[:, None] * (ends - begins)[which])
        lengths_of = (lengths / counts)[which]
        yield _Pieces(found.faces, found.positions, found.positions, lengths_of)


def _corners(geometry: MeshGeometry, which: np.ndarray) -> np.ndarray:
    """(N, 3, 3) float64, those of faces."""
    return geometry.vertices[geometry.faces[which]].astype(np.float64)


def _weights(corners: np.ndarray, places: np.ndarray) -> np.ndarray:
    return barycentric_coordinates(places, *corners.transpose(1, 0, 2))


def _weights_of_segments(corners: np.ndarray, places: np.ndarray) -> np.ndarray:
    """As _weights(), of faces that are nothing but their longest side."""
    sides = np.roll(corners, -1, 1) - corners
    squares = np.einsum("nkd,nkd->nk", sides, sides)
    rows, longest = np.arange(len(corners)), squares.argmax(1)
    along = np.einsum("nd,nd->n", places - corners[rows, longest], sides[rows, longest])
    length = squares[rows, longest]
    share = np.clip(along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    weights = np.zeros((len(corners), 3))
    weights[rows, longest] = 1.0 - share
    weights[rows, (longest + 1) % 3] = share
    return weights


def _are_in(geometry: MeshGeometry, which: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(N,) bool: whether places are in a face each."""
    corners = _corners(geometry, which)
    weights = _weights(corners, places)
    feet = np.einsum("nk,nkd->nd", weights, corners)
    size = np.ptp(corners, axis=1).max(1, initial=0.0)
    return is_inside(weights, _CLOSE) & (np.linalg.norm(feet - places, axis=1) <= _CLOSE * size)


def _values(
    costs: np.ndarray, geometry: MeshGeometry, which: np.ndarray, places: np.ndarray
) -> np.ndarray:
    """(N,) float64: costs at places in a face each."""
    weights = np.zeros((len(which), 3))
    on_map = which != NO_FACE
    weights[on_map] = _weights(_corners(geometry, which[on_map]), places[on_map])
    flat = on_map & ~is_inside(weights, _FLAT)
    weights[flat] = _weights_of_segments(_corners(geometry, which[flat]), places[flat])
    return interpolate(costs, geometry.faces, SurfacePoints(which, places, weights, weights[:, 0]))
