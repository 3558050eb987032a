"""What a planner returned, checked before anyone relies on it."""

from typing import Any

import numpy as np

from mesh_msgs.text import one_line

from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.execution.attempt import fault_of_answer
from mesh_navigation.execution.path_check import fault_of_poses
from mesh_navigation.plugins.planner import PlanResult


def checked_result(returned: Any) -> PlanResult:
    """The result with an outcome and a message that can be sent, and with poses if it is a success.

    Whatever is no such result becomes INTERNAL_ERROR, or EMPTY_PATH for a success without poses; a
    failure keeps its outcome, and has neither poses nor a cost.
    """
    fault = fault_of_answer(returned, PlanResult)
    if fault:
        return _fault(fault)
    returned.outcome, returned.message = int(returned.outcome), one_line(returned.message)
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
    return fault_of_poses(poses)
