"""Validation of what is said about cost layers."""

import math
from typing import Any, List, Optional

from mesh_msgs.checks.findings import Finding, check_header, check_uuid, each, shown

_ABOVE, _AT_LEAST, _OTHER = 1, 2, 3  # comparisons of LayerInfo; 0 is none


def layer_info(msg: Any, vertex_count: Optional[int] = None) -> List[Finding]:
    """layer_unnamed, layer_comparison, layer_threshold, layer_count."""
    findings = []
    if not msg.name:
        hint = "name it as its costs messages do"
        findings.append(Finding("layer_unnamed", "the layer has no name", None, 1, hint))
    if not 0 <= msg.comparison <= _OTHER:
        what = "the comparison is %d" % msg.comparison
        hint = "choose one of the constants of LayerInfo"
        findings.append(Finding("layer_comparison", what, None, 1, hint))
    if msg.comparison in (_ABOVE, _AT_LEAST) and not math.isfinite(msg.threshold):
        what = "the threshold is %g" % msg.threshold
        hint = "give a finite one, or say that there is no comparison"
        findings.append(Finding("layer_threshold", what, None, 1, hint))
    if vertex_count is not None and msg.lethal > vertex_count - msg.unknown:
        what = "%d vertices are lethal and %d unknown, of %d" % (
            msg.lethal,
            msg.unknown,
            vertex_count,
        )
        hint = "count those of the mesh that the UUID stands for"
        findings.append(Finding("layer_count", what, None, 1, hint))
    return findings


def layer_info_array(
    msg: Any, vertex_count: Optional[int] = None, uuid: Optional[str] = None
) -> List[Finding]:
    """See layer_info; layer_twice, frame_id_empty, uuid_mismatch."""
    findings = each("layer", msg.layers, lambda layer: layer_info(layer, vertex_count))
    names = [layer.name for layer in msg.layers]
    twice = [index for index, name in enumerate(names) if name in names[:index]]
    if twice:
        what = "layer %d is called %s, as one before it" % (twice[0], shown(names[twice[0]]))
        findings.append(
            Finding("layer_twice", what, twice[0], len(twice), "say once what each layer means")
        )
    return findings + check_header(msg) + check_uuid(msg.uuid, uuid)
