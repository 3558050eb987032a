"""Combination of the costs of several layers into one."""

from typing import Iterable, Tuple

import numpy as np

from mesh_map.layer import LayerResult


def combine(results: Iterable[Tuple[LayerResult, float]], vertex_count: int) -> np.ndarray:
    """The released sum: factor_1 cost_1 + factor_2 cost_2 + ... for each vertex.

    A vertex that is lethal in any layer, whatever its factor, has +inf. One that is unknown (NaN)
    in any layer, and lethal in none, has NaN.

    Args:
        results: pairs of result and factor >= 0, in the order of the layers.
        vertex_count: V.
    Returns:
        (V,) float32.
    """
    total = np.zeros(vertex_count, np.float64)
    lethal = np.zeros(vertex_count, np.bool_)
    for result, factor in results:
        lethal |= result.lethal
        with np.errstate(invalid="ignore"):  # 0 * inf, which is lethal anyway
            total += factor * result.costs.astype(np.float64)
    total[lethal] = np.inf
    with np.errstate(over="ignore"):
        return total.astype(np.float32)
