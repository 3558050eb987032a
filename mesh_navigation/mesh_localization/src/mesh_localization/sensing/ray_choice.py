"""Some rays of many."""

import numpy as np


def chosen_rays(count: int, most: int) -> np.ndarray:
    """(min(count, most),) ascending indices below `count`, the same for the same numbers.

    One at random out of each of `most` equal parts: at equal distances they might all be of the
    same ring of a lidar.
    """
    if count <= most:
        return np.arange(count)
    edges = np.arange(most + 1) * count // most
    shares = np.random.default_rng(count).random(most)
    return edges[:-1] + np.floor(shares * np.diff(edges)).astype(np.int64)
