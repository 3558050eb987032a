"""Costs in a map file that does not say how, and for which geometry, they were computed.

The released programs store layers so. Such costs are used on trust where they can be those of the
layer: they are found under the name that the release gives its type, and lie in its range.
"""
import logging
from typing import TYPE_CHECKING, Callable, Optional

import numpy as np

from mesh_map.costs.layer import ON_TRUST, Layer, LayerResult, checked

if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")

# (layer, the name that the release gives its type) -> costs (V,) in the file, or None
CostsOnTrust = Callable[[str, str], Optional[np.ndarray]]
_ROUNDING = 1.0001  # of what others have computed in another order


def trusted(
    mesh_map: "MeshMap", layer: Layer, found: Optional[CostsOnTrust]
) -> Optional[LayerResult]:
    """The result of a layer with costs of a file that does not say how they were made; None where
    there are none that can be its. The log says on what trust.
    """
    if found is None or not layer.RELEASED_NAME or layer.READS_LAYERS or not layer.STORABLE:
        return None
    costs = found(layer.name, layer.RELEASED_NAME)
    if costs is None:
        return None
    fault = _misfit(costs, layer.largest_cost(mesh_map.geometry))
    if fault:
        text = "layer %s is computed anew: the values of %s in the map file are none of a %s: %s"
        _LOG.warning(text, layer.name, layer.RELEASED_NAME, layer.type_name, fault)
        return None
    returned = layer.reuse(costs, mesh_map, {})
    if returned is None:
        return None
    result = checked(returned, len(mesh_map.vertices))
    layer.identity = {ON_TRUST: layer.RELEASED_NAME}
    _LOG.warning(
        "layer %s is taken on trust: the map file has costs of its type's name, %s, for as many "
        "vertices and in its range, but does not say with which parameters and for which geometry "
        "they were computed (require_provenance: true computes them)",
        layer.name,
        layer.RELEASED_NAME,
    )
    return result


def _misfit(costs, largest):
    """Why costs cannot be of a layer whose finite ones are at most this; "" if they can."""
    known = costs[~np.isnan(costs)]
    if not known.size:
        return "none is known"
    finite = known[np.isfinite(known)]
    if finite.size and finite.min() < 0:
        return "%g is negative" % finite.min()
    if finite.size and finite.max() > largest * _ROUNDING:
        return "%g is more than the %g that there can be" % (finite.max(), largest)
    return ""
