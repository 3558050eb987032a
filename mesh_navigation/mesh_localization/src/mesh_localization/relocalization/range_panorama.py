"""A scan, and views of the map, as ranges around an axis that is upright on the ground."""

from typing import NamedTuple, Optional

import numpy as np
from mesh_map.base.cancel import CancelFlag
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_localization.relocalization.pose_sampling import SampledPlaces

HEADINGS = 48
_ROWS = 5
_ALIKE = np.radians(1.5)  # elevations that are one
_NEAR = np.radians(4.0)  # of a direction, in which a point counts for it: all between columns
_SHARES = (0.02, 0.98)  # of the points, which are between the lowest and the highest row


class Panorama(NamedTuple):
    """What a scan sees in directions around an upright axis.

    Attributes:
        height: m of the middle above the ground, on the axis of the robot's base.
        elevations: (E,) rad of the rows.
        ranges: (E, A) float32 m from the middle; the columns turn left from ahead, evenly. NaN
            where no point is.
    """

    height: float
    elevations: np.ndarray
    ranges: np.ndarray

    @property
    def count(self) -> int:
        """Directions in which there are points."""
        return int(np.isfinite(self.ranges).sum())


def panorama_of(
    points: np.ndarray,
    origins: np.ndarray,
    base_height: float,
    *,
    headings: int = HEADINGS,
    rows: int = _ROWS,
) -> Panorama:
    """A scan as a panorama: of each direction the point that is nearest to it.

    Args:
        points: (N, 3) m in the base's frame, N >= 1.
        origins: (N, 3) or (3,) there, where the sensor was.
        base_height: m of the base's frame above the ground.
        headings: columns.
        rows: at most; of a scan in one plane there is one.
    """
    middle = float(np.mean(np.broadcast_to(origins, points.shape)[:, 2]))
    ways = points - np.array([0.0, 0.0, middle])
    ranges = np.linalg.norm(ways, axis=1)
    elevation = np.arctan2(ways[:, 2], np.hypot(ways[:, 0], ways[:, 1]))
    azimuth = np.arctan2(ways[:, 1], ways[:, 0])
    low, high = np.quantile(elevation, _SHARES)
    wanted = np.linspace(low, high, rows) if rows > 1 else np.array([(low + high) / 2])
    # Rows at elevations that the sensor has: between rings there is nothing to compare with.
    sorted_ones = np.sort(elevation)
    kept: list = []
    for each in sorted_ones[np.minimum(np.searchsorted(sorted_ones, wanted), len(ranges) - 1)]:
        if not kept or each - kept[-1] > _ALIKE:
            kept.append(float(each))
    elevations = np.array(kept)
    row = abs(elevation[:, None] - elevations).argmin(axis=1)
    step = 2 * np.pi / headings
    column = np.rint(azimuth / step).astype(int)
    off = np.hypot(elevation - elevations[row], (azimuth - column * step) * np.cos(elevation))
    near = np.flatnonzero((off < _NEAR) & (ranges > 0))
    near = near[np.argsort(-off[near], kind="stable")]  # of equal places, the last one stays
    table = np.full((len(elevations), headings), np.nan, np.float32)
    table[row[near], column[near] % headings] = ranges[near]
    return Panorama(middle + base_height, elevations, table)


def map_ranges(
    index: SpatialIndex,
    places: SampledPlaces,
    scan: Panorama,
    cancel: Optional[CancelFlag] = None,
) -> np.ndarray:
    """(P, E, A) float32: what a scan would be at each place, heading along x of its frame; inf
    where there is nothing.

    Raises:
        Canceled: by `cancel`.
    """
    rows, columns = scan.ranges.shape
    angles = np.arange(columns) * (2 * np.pi / columns)
    flat, up = np.cos(scan.elevations)[:, None], np.sin(scan.elevations)[:, None]
    ways = [flat * np.cos(angles), flat * np.sin(angles), np.broadcast_to(up, (rows, columns))]
    own = np.stack(ways, axis=2).reshape(-1, 3)
    directions = np.einsum("pij,rj->pri", places.frames, own)
    origins = places.positions + scan.height * places.frames[:, :, 2]
    hits = index.cast_batch(
        origins=np.repeat(origins, len(own), axis=0),
        directions=directions.reshape(-1, 3),
        cancel=cancel,
    )
    return np.float32(hits.distances).reshape(len(places.positions), rows, columns)
