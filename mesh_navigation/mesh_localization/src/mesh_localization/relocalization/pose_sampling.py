"""Places all over a map where a robot may stand, with the plane that it stands on."""

from typing import NamedTuple, Optional, Tuple

import numpy as np
from mesh_map.base.cancel import CancelFlag
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.spatial.hits import NO_FACE

_APART = 0.05  # m below a surface, from where on the next one is another storey
_MOST_STOREYS = 50
_FOOTPRINT = 0.3  # m, radius of the circle that a plane is laid through
_STEP = 0.3  # m over or below the plane of the face, up to which the circle's ground counts
_CORNERS = 6  # of the circle
_ABOVE = 0.2  # m: what is lower over the ground than this is ground, too


class SearchRegion(NamedTuple):
    """A ball: center (3,) m, radius in m."""

    center: np.ndarray
    radius: float


class PoseLimits(NamedTuple):
    """Where a robot can stand.

    Attributes:
        max_slope: rad from the map's up direction, of the ground under a footprint.
        headroom: m over a place, in which there is nothing.
    """

    max_slope: float = 0.6
    headroom: float = 0.8


class SampledPlaces(NamedTuple):
    """P places.

    Attributes:
        positions: (P, 3) float64 m, on the surface.
        frames: (P, 3, 3) float64, rotations into the map's frame: z along the normal of the ground,
            x in the plane of the ground, at all places about the same way.
    """

    positions: np.ndarray
    frames: np.ndarray

    def part(self, which: np.ndarray) -> "SampledPlaces":
        """Those places."""
        return SampledPlaces(self.positions[which], self.frames[which])


def sampled_places(
    geometry: MeshGeometry,
    spacing: float,
    *,
    region: Optional[SearchRegion] = None,
    limits: PoseLimits = PoseLimits(),
    cancel: Optional[CancelFlag] = None,
) -> SampledPlaces:
    """Places on a grid, on all storeys: where vertical lines meet faces that look up.

    Args:
        geometry: the map.
        spacing: m of the grid, seen from above.
        region: only places in it.
        limits: where a robot can stand.
        cancel: ends it.

    Raises:
        Canceled: by `cancel`.
    """
    up = np.asarray(geometry.up, np.float64)
    across = _level_axes(up)
    starts = _grid(geometry, across, up, spacing, region)
    index = geometry.spatial_index
    found, looks = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for _ in range(_MOST_STOREYS):
        if not len(starts):
            break
        directions = np.broadcast_to(-up, starts.shape)
        hits = index.cast_batch(origins=starts, directions=directions, cancel=cancel)
        met = hits.faces != NO_FACE
        points = starts[met] - hits.distances[met, None] * up
        normals = geometry.face_normals[hits.faces[met]]
        upward = _looks_up(geometry, normals, limits)
        found.append(points[upward])
        looks.append(normals[upward])
        starts = points - _APART * up
    positions, normals = np.concatenate(found), np.concatenate(looks)
    if region is not None:
        inside = np.linalg.norm(positions - region.center, axis=1) <= region.radius
        positions, normals = positions[inside], normals[inside]
    return _open_places(geometry, positions, normals, limits, cancel)


def places_around(
    geometry: MeshGeometry,
    places: SampledPlaces,
    spacing: float,
    *,
    limits: PoseLimits = PoseLimits(),
    cancel: Optional[CancelFlag] = None,
) -> SampledPlaces:
    """Nine places for each, on a square grid in the plane of the ground, as far as there are.

    Args:
        places: P of them.
        spacing: m of the grid.
        Others: see sampled_places().

    Raises:
        Canceled: by `cancel`.
    """
    steps = np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)]) * spacing
    aside = np.einsum("pij,oj->poi", places.frames[:, :, :2], steps)
    reach = spacing + _STEP  # slopes of 45 degrees, and a step
    above = reach * places.frames[:, :, 2]
    starts = (places.positions[:, None] + aside + above[:, None]).reshape(-1, 3)
    directions = np.repeat(-places.frames[:, :, 2], len(steps), axis=0)
    hits = geometry.spatial_index.cast_batch(
        origins=starts, directions=directions, max_distance=2 * reach, cancel=cancel
    )
    normals = geometry.face_normals[np.where(hits.faces == NO_FACE, 0, hits.faces)]
    met = (hits.faces != NO_FACE) & _looks_up(geometry, normals, limits)
    positions = starts[met] + hits.distances[met, None] * directions[met]
    return _open_places(geometry, positions, normals[met], limits, cancel)


def _looks_up(geometry: MeshGeometry, normals: np.ndarray, limits: PoseLimits) -> np.ndarray:
    # Steps and stones are steep, while the ground that they belong to is not.
    return normals @ np.asarray(geometry.up, np.float64) > 0.5 * np.cos(limits.max_slope)


def _open_places(
    geometry: MeshGeometry,
    positions: np.ndarray,
    normals: np.ndarray,
    limits: PoseLimits,
    cancel: Optional[CancelFlag],
) -> SampledPlaces:
    """Those of the positions (P, 3) on faces with normals (P, 3) at which a robot can stand."""
    up = np.asarray(geometry.up, np.float64)
    blocked = geometry.spatial_index.any_hit_batch(
        origins=positions + _ABOVE * up,
        directions=np.broadcast_to(up, positions.shape),
        max_distance=max(limits.headroom - _ABOVE, 0.0),
        cancel=cancel,
    )
    positions, normals = positions[~blocked], normals[~blocked]
    frames = _frames(geometry, positions, normals, _level_axes(up)[0], cancel)
    level = frames[:, :, 2] @ up >= np.cos(limits.max_slope)
    return SampledPlaces(positions[level], frames[level])


def _level_axes(up: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Two directions at right angles to `up`: x and y where that is z."""
    first = np.eye(3)[0 if abs(up[0]) < 0.9 else 1]
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    return first, np.cross(up, first)


def _grid(
    geometry: MeshGeometry,
    across: Tuple[np.ndarray, np.ndarray],
    up: np.ndarray,
    spacing: float,
    region: Optional[SearchRegion],
) -> np.ndarray:
    """(N, 3): the upper ends of vertical lines through all of the map, or of the region."""
    used = geometry.vertices[np.unique(geometry.faces)].astype(np.float64)
    spans = []
    for axis in across:
        along = used @ axis
        low, high = float(along.min()), float(along.max())
        if region is not None:
            middle = float(region.center @ axis)
            low, high = max(low, middle - region.radius), min(high, middle + region.radius)
        count = max(int(np.ceil((high - low) / spacing)), 1 if high >= low else 0)
        # Cells of the same size, the lines in their middles.
        spans.append(low + (np.arange(count) + 0.5) * (high - low) / max(count, 1))
    first, second = np.meshgrid(*spans, indexing="ij")
    top = float((used @ up).max()) + 1.0
    return first.reshape(-1, 1) * across[0] + second.reshape(-1, 1) * across[1] + top * up[None]


def _frames(
    geometry: MeshGeometry,
    positions: np.ndarray,
    normals: np.ndarray,
    ahead: np.ndarray,
    cancel: Optional[CancelFlag],
) -> np.ndarray:
    """(P, 3, 3): on the planes through circles around the places, which single faces of rough
    ground are tilted against."""
    frames = _upright(normals, ahead)
    angles = np.arange(_CORNERS) * (2 * np.pi / _CORNERS)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    slopes = np.zeros((len(positions), 2))
    for x, y in circle:
        aside = _FOOTPRINT * (x * frames[:, :, 0] + y * frames[:, :, 1])
        hits = geometry.spatial_index.cast_batch(
            origins=positions + aside + 2 * _STEP * frames[:, :, 2],
            directions=-frames[:, :, 2],
            max_distance=4 * _STEP,
            cancel=cancel,
        )
        rise = np.where(hits.faces == NO_FACE, 0.0, 2 * _STEP - hits.distances)
        rise[abs(rise) > _STEP] = 0.0
        # Least squares on a regular polygon: the sum of x^2 is half the number of its corners.
        slopes += rise[:, None] * [x, y] / (_FOOTPRINT * _CORNERS / 2)
    tilted = frames[:, :, 2] - np.einsum("nij,nj->ni", frames[:, :, :2], slopes)
    return _upright(tilted / np.linalg.norm(tilted, axis=1, keepdims=True), ahead)


def _upright(normals: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """(P, 3, 3): z along normals (P, 3), x as far along `ahead` as that allows."""
    left = np.cross(normals, ahead)
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    return np.stack([np.cross(left, normals), left, normals], axis=2)
