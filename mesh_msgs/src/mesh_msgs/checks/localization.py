"""Validation of what a localizer says of itself."""

import math
from typing import Any, List

from mesh_msgs.checks.findings import Finding, check_header

_LOST, _OK = 0, 2  # the first and the last state of LocalizationState


def localization_state(msg: Any) -> List[Finding]:
    """localization_state_unknown, localization_reason, localization_figure, frame_id_empty."""
    findings = []
    if not _LOST <= msg.state <= _OK:
        what = "the state is %d" % msg.state
        hint = "choose one of the constants of LocalizationState"
        findings.append(Finding("localization_state_unknown", what, None, 1, hint))
    if msg.state != _OK and not msg.reason:
        what = "the localization is not OK, and nothing says why"
        findings.append(Finding("localization_reason", what, None, 1, "say it in its reason"))
    limits = {"explained": 1.0, "residual": math.inf}
    limits.update(position_deviation=math.inf, rotation_deviation=math.inf)
    bad = [name for name, most in limits.items() if not _is_figure(getattr(msg, name), most)]
    if bad:
        what = "%s is %g (%d such figures in all)" % (bad[0], getattr(msg, bad[0]), len(bad))
        hint = "give shares from 0 to 1, other figures of at least 0, and NaN where none is known"
        findings.append(Finding("localization_figure", what, None, len(bad), hint))
    return findings + check_header(msg)


def _is_figure(value: float, most: float) -> bool:
    """Within 0 and the limit, or not known."""
    return math.isnan(value) or 0.0 <= value <= most
