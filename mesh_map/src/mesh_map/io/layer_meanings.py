"""What the costs of layers mean, for those who have the costs alone."""

import logging
import math

import numpy as np
from mesh_msgs_hdf5.model.layer_meaning import ABOVE, AT_LEAST, NONE, OTHER, LayerMeaning

from mesh_map.base.errors import PLUGIN_FAILURES, error_line
from mesh_map.costs.layer import Layer

_LOG = logging.getLogger("mesh_map")


def layer_meaning(layer: Layer) -> LayerMeaning:
    """Of a layer that has been computed, with the numbers of its vertices.

    A rule by which other vertices would be lethal than are is none: OTHER.
    """
    costs, lethal, _ = layer.result
    comparison, threshold, rule = NONE, math.nan, None
    try:
        rule = layer.lethal_rule()
    except PLUGIN_FAILURES as error:
        _LOG.warning("layer %s does not say what is lethal: %s", layer.name, error_line(error))
    if rule is not None and math.isfinite(rule.threshold):
        comparison, threshold = AT_LEAST if rule.inclusive else ABOVE, float(rule.threshold)
    counts = int(np.count_nonzero(lethal)), int(np.count_nonzero(np.isnan(costs)))
    meaning = LayerMeaning(layer.type_name, layer.UNIT, comparison, threshold, *counts)
    if not np.array_equal(meaning.lethal_in(costs), lethal):
        return meaning._replace(comparison=OTHER, threshold=math.nan)
    return meaning
