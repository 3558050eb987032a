"""Combination of the costs of several layers into one."""

from typing import Iterable, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.costs.layer import LayerResult

COMBINED_COSTS = "Combined Costs"  # type of the messages, beside the names of the layers

_BLOCK = 1 << 16  # vertices at a time, so that intermediate results stay in the cache


class Term(NamedTuple):
    """A layer in a combination; `low` and `high` are the limits of its finite costs."""

    result: LayerResult
    factor: float
    low: float
    high: float


class Combination:
    """Costs of a map from those of its layers: Pütz et al., 4.2. Immutable.

    Modes, each for one vertex:
        sum: factor_1 cost_1 + factor_2 cost_2 + ..., as released.
        normalized: the same of (cost - low) / (high - low), where low and high are the limits of
            the finite costs of the layer over the whole map; 0 where they are equal.
        max: the largest factor times cost, at least 0.
    A vertex that is lethal in any layer, whatever its factor, has +inf. One that is unknown (NaN)
    in any layer, and lethal in none, has NaN.

    Attributes:
        mode: "sum", "normalized" or "max".
        terms: in the order of the layers.
        costs: (V,) float32, read-only.
    """

    def __init__(
        self,
        results: Iterable[Tuple[LayerResult, float]],
        vertex_count: int,
        mode: str = "sum",
        before: Optional["Combination"] = None,
        changed: Optional[np.ndarray] = None,
    ) -> None:
        """Combines layers.

        Args:
            results: pairs of result and factor >= 0, in the order of the layers.
            vertex_count: V.
            mode: see above.
            before: an earlier combination; the result is the same as without, bit for bit.
            changed: with `before` of the same layers: the vertices ((K,) indices) at which alone
                they may differ now; None for all.
        """
        self.mode = mode
        same_mode = before is not None and before.mode == mode
        known = {id(term.result): term for term in before.terms} if same_mode else {}
        self.terms = tuple(
            Term(result, factor, *self._limits(result, known.get(id(result))))
            for result, factor in results
        )
        if before is not None and changed is not None and self._like(before):
            if len(changed) == 0:
                self.costs = before.costs
                return
            if len(changed) < vertex_count // 4:
                costs = before.costs.copy()
                costs[changed] = self._at(changed)
                self.costs = read_only(costs)
                return
        costs = np.zeros(vertex_count, np.float32)
        for start in range(0, vertex_count, _BLOCK):
            block = slice(start, start + _BLOCK)
            costs[block] = self._at(block)
        self.costs = read_only(costs)

    def _limits(self, result: LayerResult, known: Optional[Term]) -> Tuple[float, float]:
        if self.mode != "normalized":
            return 0.0, 0.0
        if known is not None:
            return known.low, known.high
        finite = result.costs[np.isfinite(result.costs)]
        return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)

    def _like(self, before: "Combination") -> bool:
        return self.mode == before.mode and [term[1:] for term in self.terms] == [
            term[1:] for term in before.terms
        ]

    def _at(self, vertices: "np.ndarray | slice") -> np.ndarray:
        """Costs of some vertices; of each one the same, whichever others there are."""
        lethal = np.zeros(0, np.bool_)
        total = np.zeros(0)
        for number, (result, factor, low, high) in enumerate(self.terms):
            term = result.costs[vertices].astype(np.float64)
            if not number:
                total = np.zeros(len(term))
                lethal = np.zeros(len(term), np.bool_)
            with np.errstate(invalid="ignore"):  # 0 * inf and inf / inf, which are lethal anyway
                if self.mode == "normalized":
                    term -= low
                    term *= factor
                    term /= (high - low) or 1.0
                else:
                    term *= factor
                if self.mode == "max":
                    np.maximum(total, term, out=total)
                else:
                    total += term
            lethal |= result.lethal[vertices]
        if not self.terms:
            return np.float32(0)
        total[lethal] = np.inf
        with np.errstate(over="ignore"):
            return total.astype(np.float32)
