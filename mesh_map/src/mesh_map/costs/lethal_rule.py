"""Which costs of a layer are lethal."""

from typing import NamedTuple

import numpy as np


class LethalRule(NamedTuple):
    """Costs that are lethal beside +inf: those above a threshold, and itself where `inclusive`.

    threshold: in the unit of the layer, compared as float32, as costs are.
    """

    threshold: float
    inclusive: bool = False

    def of(self, costs: np.ndarray) -> np.ndarray:
        """(V,) bool: which of these costs (V,) are lethal; unknown ones are not."""
        threshold = np.float32(self.threshold)
        with np.errstate(invalid="ignore"):
            return costs >= threshold if self.inclusive else costs > threshold
