"""How driving goes, and how it ended."""

import math
from typing import NamedTuple, Optional, Tuple

from mesh_navigation.base.pose import Pose
from mesh_navigation.base.progress_watch import angle_between
from mesh_navigation.base.robot import RobotState, Velocity
from mesh_navigation.plugins.controller import ControllerPlan


class Tolerances(NamedTuple):
    """What counts as arrived."""

    distance: float
    """m."""
    angle: float
    """rad."""


class Cycle(NamedTuple):
    """One cycle, for feedback and statistics."""

    outcome: int
    message: str
    state: Optional[RobotState]
    """None where the robot's pose is not known."""
    velocity: Velocity
    """What was commanded."""
    dist_to_goal: float
    """m in a straight line; NaN where the pose is not known, as the next one."""
    angle_to_goal: float
    """rad."""
    seconds: float
    """What the cycle took, of the computer's time."""
    late: bool
    """Whether it ended after the next one should have begun."""


class ExecutionResult(NamedTuple):
    """How it ended."""

    outcome: int
    message: str
    final_pose: Optional[Pose]
    """None if the robot's pose was never known."""
    dist_to_goal: float
    """m; NaN without a pose, as the next one."""
    angle_to_goal: float
    """rad."""


def to_goal(plan: ControllerPlan, pose: Optional[Pose]) -> Tuple[float, float]:
    """(m, rad) from a pose to the goal, in a straight line; NaN without a pose."""
    if pose is None:
        return math.nan, math.nan
    distance = math.dist(plan.goal.position, pose.position)
    return distance, angle_between(plan.goal, pose)
