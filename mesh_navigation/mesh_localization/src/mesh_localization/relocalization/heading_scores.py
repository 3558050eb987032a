"""How well a scan fits at places, in each heading: panoramas compared by circular shifts."""

import numpy as np

_MOST_BEFORE, _MOST_THROUGH = -0.3, -1.0
_BLOCK = 1 << 16  # numbers that fit into a core's cache


def heading_scores(scan: np.ndarray, views: np.ndarray, tolerances: np.ndarray) -> np.ndarray:
    """(P, A) float32: means over the scan's directions, 1 where all agree.

    A direction counts 1 where the ranges are equal, 0 where they are a tolerance apart, and less
    beyond: little less where the scan ends before the map, as obstacles do; -1 where it goes
    through the map.

    Args:
        scan: (E, A) float32 m, NaN where nothing was measured; not all of them.
        views: (P, E, A) float32 m of the map at P places, inf where there is nothing.
        tolerances: (E, A) float32 m, for each of the scan's ranges.
    """
    rows, columns = np.nonzero(np.isfinite(scan))
    ranges, scales = scan[rows, columns], 1 / tolerances[rows, columns]
    headings = scan.shape[1]
    scores = np.zeros((len(views), headings), np.float32)
    # Far beyond what any tolerance is, and still a number.
    limit = np.float32(10 * np.nanmax(scan) + 1e3)
    step = max(1, _BLOCK // len(rows))
    for begin in range(0, len(views), step):
        some = np.minimum(views[begin : begin + step], limit)
        for heading in range(headings):
            # A robot that is turned left by it sees ahead what is in that column of the map.
            seen = some[:, rows, (columns + heading) % headings]
            off = (ranges - seen) * scales
            behind = np.maximum(1 - off, _MOST_THROUGH)
            off += 1
            np.maximum(off, _MOST_BEFORE, out=off)
            scores[begin : begin + step, heading] = np.minimum(off, behind).mean(axis=1)
    return scores
