"""What the values of a stored layer mean, as mesh_map knows it of its layers.

It is stored with the parameters that a layer was computed with, below `KEY`: readers that do not
know it take it for one more of them, and whoever replaces a layer's values replaces it, too.
"""
import math
from typing import Any, Dict, Mapping, NamedTuple, Optional

import numpy as np

KEY = "layer_info"
NONE, ABOVE, AT_LEAST, OTHER = COMPARISONS = ("none", "above", "at_least", "other")
MOST_TEXT = 100  # characters of a unit or type


class LayerMeaning(NamedTuple):
    """As mesh_msgs/LayerInfo has it.

    layer_type: the plugin that computed it; "" if that is not known.
    unit: of the values; "" if they have none.
    comparison: which values are lethal beside +inf: NONE, those ABOVE the threshold, or AT_LEAST
        that; OTHER: that does not follow from the values.
    threshold: in that unit; NaN for NONE and OTHER.
    lethal, unknown: numbers of vertices when the layer was stored, or None.
    """

    layer_type: str = ""
    unit: str = ""
    comparison: str = NONE
    threshold: float = math.nan
    lethal: Optional[int] = None
    unknown: Optional[int] = None

    def stored(self) -> Dict[str, Any]:
        """What json can write, for the parameters' `KEY`; the type is one of the parameters."""
        value: Dict[str, Any] = {"unit": self.unit, "comparison": self.comparison}
        if self.comparison in (ABOVE, AT_LEAST):
            value["threshold"] = float(self.threshold)
        for key in ("lethal", "unknown"):
            if getattr(self, key) is not None:
                value[key] = int(getattr(self, key))
        return value

    def counted(self, costs: np.ndarray) -> "LayerMeaning":
        """The same with the numbers of these costs (V,)."""
        unknown = int(np.count_nonzero(np.isnan(costs)))
        return self._replace(lethal=self.count_lethal(costs), unknown=unknown)

    def lethal_in(self, costs: np.ndarray) -> np.ndarray:
        """(N,) bool of float32 costs (N,): which are lethal, as far as that follows from them."""
        lethal = np.isposinf(costs)
        with np.errstate(invalid="ignore"):
            if self.comparison == ABOVE:
                lethal |= costs > np.float32(self.threshold)
            elif self.comparison == AT_LEAST:
                lethal |= costs >= np.float32(self.threshold)
        return lethal

    def count_lethal(self, costs: np.ndarray) -> int:
        """How many are lethal; of OTHER as many as there were when the layer was stored."""
        if self.comparison == OTHER and self.lethal is not None:
            return self.lethal
        return int(np.count_nonzero(self.lethal_in(costs)))

    def rule_text(self) -> str:
        """Which values are lethal, as "above 0.3 rad"; "" where +inf alone is."""
        if self.comparison == OTHER:
            return "not by their values alone"
        if self.comparison == NONE:
            return ""
        value = "%g%s" % (self.threshold, " " + self.unit if self.unit else "")
        return ("above " if self.comparison == ABOVE else "from ") + value


def meaning_of(parameters: Mapping[str, Any]) -> Optional[LayerMeaning]:
    """What is stored with the parameters of a layer; None where nothing usable is: files may hold
    anything."""
    value = parameters.get(KEY)
    if not isinstance(value, dict):
        return None
    comparison, threshold = value.get("comparison"), value.get("threshold")
    if not isinstance(comparison, str) or comparison not in COMPARISONS:
        return None
    if comparison in (ABOVE, AT_LEAST):
        number = isinstance(threshold, (int, float)) and not isinstance(threshold, bool)
        if not number or not abs(threshold) <= np.finfo(np.float32).max:
            return None
    else:
        threshold = math.nan
    return LayerMeaning(
        _text(parameters.get("type")),
        _text(value.get("unit")),
        comparison,
        float(threshold),
        _count(value.get("lethal")),
        _count(value.get("unknown")),
    )


def computed_with(parameters: Mapping[str, Any]) -> Dict[str, Any]:
    """The parameters without what the values mean."""
    return {key: value for key, value in parameters.items() if key != KEY}


def _count(value: Any) -> Optional[int]:
    is_count = isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 32
    return value if is_count else None


def _text(value: Any) -> str:
    return value[:MOST_TEXT] if isinstance(value, str) and value.isprintable() else ""
