"""Goals as users give them, as messages. No rospy: messages are plain data."""

import math
from typing import Any, Optional

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path

from mesh_navigation.base.messages import pose_message
from mesh_navigation.base.pose import Pose


def goal_pose(*goal: Any, yaw: Optional[float] = None, frame_id: str = "map") -> PoseStamped:
    """A PoseStamped of x, y, z and yaw, of a sequence of these, or of a pose.

    Args:
        goal: x, y, z in meters, and yaw in rad if it is not given by name; or one tuple of these;
            or one PoseStamped, which is returned as it is, or Pose.
        yaw: the heading (rad), 0 if there is none.
        frame_id: of positions and of a Pose.

    Raises:
        ValueError: it is none of these.
    """
    if len(goal) == 1:
        (given,) = goal
        if hasattr(given, "header"):
            return given
        if hasattr(given, "orientation"):
            stamped = PoseStamped(pose=given)
            stamped.header.frame_id = frame_id
            return stamped
        goal = tuple(given)
    numbers = [float(value) for value in goal]
    if len(numbers) == 4 and yaw is None:
        yaw = numbers.pop()
    if len(numbers) != 3 or not all(map(math.isfinite, [*numbers, yaw or 0.0])):
        raise ValueError(
            f"a goal is x, y, z (m, finite) and possibly yaw (rad), or a pose, not {goal}"
        )
    return pose_message(Pose.at(numbers, yaw or 0.0), frame_id)


def has_heading(*goal: Any, yaw: Optional[float] = None) -> bool:
    """Whether a goal, given as for `goal_pose`, says which heading it wants."""
    if yaw is not None or len(goal) == 4:
        return True
    return len(goal) == 1 and (hasattr(goal[0], "orientation") or not _is_position(goal[0]))


def _is_position(given: Any) -> bool:
    return not hasattr(given, "header") and len(given) == 3


def heading_of_arrival(path: Path) -> Optional[float]:
    """The yaw (rad) with which a path comes to its end; None if it does not move in x and y."""
    positions = [(p.pose.position.x, p.pose.position.y) for p in reversed(path.poses)]
    for x, y in positions[1:]:
        dx, dy = positions[0][0] - x, positions[0][1] - y
        if math.hypot(dx, dy) > 1e-3:
            return math.atan2(dy, dx)
    return None
