"""What users choose for a whole map: how costs are combined, and what they mean to planners."""

import dataclasses
from typing import Any, List, Mapping, Tuple

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, checked_values

SETTINGS = (
    Parameter(
        "combination",
        "sum",
        description="how the costs of all layers become one: the sum of factor times cost, the "
        "same of costs normalized to 0..1, or the largest factor times cost",
        choices=("sum", "normalized", "max"),
    ),
    Parameter(
        "default_layer",
        "",
        description="the layer whose costs are those of the map, instead of a combination; "
        "empty for the combination",
    ),
    Parameter(
        "edge_weight",
        "mean",
        description="weights of edges from their length and the costs at both ends: their mean "
        "(with edge_cost_factor), or their difference (with layer_factor)",
        choices=("mean", "difference"),
    ),
    Parameter("layer_factor", 1.0, 0.0, 10.0, "of edge_weight difference; 0 is pure length"),
    Parameter("edge_cost_factor", 0.0, 0.0, 10.0, "of edge_weight mean; 0 is pure length"),
)


@dataclasses.dataclass(frozen=True)
class MapSettings:
    """Values of SETTINGS, all of them checked."""

    combination: str = "sum"
    default_layer: str = ""
    edge_weight: str = "mean"
    layer_factor: float = 1.0
    edge_cost_factor: float = 0.0

    def changed(self, values: Mapping[str, Any]) -> Tuple["MapSettings", List[str]]:
        """With other values, and warnings: numbers out of range are moved to the limit.

        Raises:
            MeshMapError: a name that does not exist, or a value of a wrong type.
        """
        known = {parameter.name: parameter for parameter in SETTINGS}
        unknown = sorted(str(name) for name in values if name not in known)
        if unknown:
            raise MeshMapError(
                "unknown settings: " + ", ".join(unknown), "known: " + ", ".join(sorted(known))
            )
        accepted, warnings = checked_values([known[name] for name in values], values)
        return dataclasses.replace(self, **accepted), warnings
