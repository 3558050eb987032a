"""What a planner returned, checked before anyone relies on it."""

from typing import Any

import numpy as np

from mesh_msgs.text import one_line

from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.plugins.planner import PlanResult

# Quaternions whose length differs more from 1 are no rotations but a fault.
UNIT_TOLERANCE = 0.01


def checked_result(returned: Any) -> PlanResult:
    """The result with an outcome and a message that can be sent, and with poses if it is a success.

    Whatever is no such result becomes INTERNAL_ERROR, or EMPTY_PATH for a success without poses; a
    failure keeps its outcome, and has neither poses nor a cost.
    """
    if not isinstance(returned, PlanResult):
        return _fault(f"it returned a {type(returned).__name__} instead of a PlanResult")
    outcome = returned.outcome
    if not isinstance(outcome, (int, np.integer)) or not 0 <= outcome < 256:
        return _fault(f"its outcome is {outcome!r}, not a number from 0 to 255")
    returned.outcome, returned.message = int(outcome), one_line(returned.message)
    if not returned.succeeded:
        returned.poses, returned.cost = np.zeros((0, 7)), 0.0
        return returned
    fault = _fault_of_path(returned)
    if fault:
        return _fault(fault)
    if returned.poses.size == 0:
        message = f"the planner reported success without a pose: {returned.message}"
        return PlanResult(GetPathOutcome.EMPTY_PATH, message)
    return returned


def _fault(what: str) -> PlanResult:
    return PlanResult(GetPathOutcome.INTERNAL_ERROR, f"the planner is at fault: {what}")


def _fault_of_path(result: PlanResult) -> str:
    """What is wrong with the poses or the cost, empty if nothing is."""
    try:
        result.poses = np.asarray(result.poses, dtype=np.float64)
        result.cost = float(result.cost)
    except (TypeError, ValueError) as error:
        return f"its poses or cost are no numbers: {error}"
    poses = result.poses
    if poses.size == 0:
        return ""
    if poses.ndim != 2 or poses.shape[1] != 7:
        return f"its poses have shape {poses.shape}, not (N, 7)"
    if not np.isfinite(result.cost):
        return f"its cost is {result.cost}"
    bad = np.flatnonzero(~np.isfinite(poses).all(axis=1))
    if len(bad):
        return f"{len(bad)} of {len(poses)} poses are not finite, first {bad[0]}"
    bad = np.flatnonzero(np.abs(np.linalg.norm(poses[:, 3:], axis=1) - 1) > UNIT_TOLERANCE)
    if len(bad):
        return f"{len(bad)} of {len(poses)} poses have no unit quaternion, first {bad[0]}"
    return ""
