"""Some rays of many."""

import numpy as np


def chosen_rays(count: int, most: int) -> np.ndarray:
    """(min(count, most),) ascending indices below `count`, the same for the same numbers.

    One at random out of each of `most` equal parts: at equal distances they might all be of the
    same ring of a lidar.
    """
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most + 1)
    shares = np.random.default_rng(count).random(most)
    return np.floor(edges[:-1] + shares * np.diff(edges)).astype(np.int64)
