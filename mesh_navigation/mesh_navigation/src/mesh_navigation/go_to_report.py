"""What the command go_to says, as text."""

import json
import math
from typing import Any, Dict, Optional, Tuple

import numpy as np

from mesh_map.errors import one_line

from mesh_navigation.navigation_result import NavigationResult
from mesh_navigation.path import path_length


class Remaining:
    """How far the robot has come, from the feedback of move_base."""

    def __init__(self) -> None:
        self._first: Optional[float] = None

    def update(self, feedback: Any) -> Tuple[str, Optional[float]]:
        """A few words, and the share of the way (0 to 1) that lies behind, None if not known."""
        distance = float(feedback.dist_to_goal)
        if not math.isfinite(distance):
            return "driving", None
        if self._first is None:
            self._first = distance
        share = 1.0 - distance / self._first if self._first > 0.0 else None
        speed = feedback.last_cmd_vel.twist.linear.x
        degrees = math.degrees(abs(feedback.angle_to_goal))
        text = f"{distance:.2f} m to the goal, {degrees:.0f} degrees to turn, {speed:.2f} m/s"
        return text, None if share is None else max(0.0, share)


def arrival_text(result: NavigationResult, seconds: float, as_json: bool) -> str:
    """How going there ended, as lines."""
    values = {
        "dist_to_goal": _finite(result.details.dist_to_goal),
        "angle_to_goal": _finite(result.details.angle_to_goal),
        "seconds": seconds,
    }
    if as_json:
        return _json(result, values)
    pose = result.details.final_pose
    where = ""
    if pose.header.frame_id:  # no such pose where nothing was driven
        p = pose.pose.position
        where = f"; now at ({p.x:.2f}, {p.y:.2f}, {p.z:.2f}) in '{pose.header.frame_id}'"
        where += f", {values['dist_to_goal'] or 0.0:.2f} m from the goal"
        where += f", {math.degrees(values['angle_to_goal'] or 0.0):.1f} degrees from its heading"
    return f"{one_line(str(result))}\n{seconds:.1f} s{where}\n"


def plan_text(result: NavigationResult, seconds: float, as_json: bool) -> str:
    """How planning ended, as lines."""
    path, positions = result.details.path, None
    if path.poses:
        positions = np.array(
            [[p.pose.position.x, p.pose.position.y, p.pose.position.z] for p in path.poses]
        )
    length = None if positions is None else path_length(positions)
    if as_json:
        return _json(
            result,
            {
                "length": length,
                "cost": _finite(result.details.cost),
                "seconds": seconds,
                "frame_id": path.header.frame_id,
                "positions": [] if positions is None else positions.tolist(),
            },
        )
    text = one_line(str(result)) + "\n"
    return text if length is None else f"{text}length {length:.3f} m, {1e3 * seconds:.0f} ms\n"


def _json(result: NavigationResult, values: Dict[str, Any]) -> str:
    first = {"outcome": result.outcome, "outcome_name": result.name, "message": result.message}
    return json.dumps({**first, **values}, allow_nan=False) + "\n"


def _finite(value: float) -> Optional[float]:
    return float(value) if math.isfinite(value) else None
