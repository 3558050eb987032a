"""Many vectors rotated at once."""

from typing import Any

import numpy as np


def rotated(vectors: Any, rotation: np.ndarray) -> np.ndarray:
    """(..., 3) float64: each vector of (..., 3) by a matrix (3, 3).

    Not by BLAS, whose threads spin on the other cores for a while after each product.
    """
    return np.einsum("...j,kj->...k", np.asarray(vectors, np.float64), rotation)
