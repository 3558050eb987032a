"""The links of TF from the robot up to the map: which there are, and how old each may be."""

import re
from typing import Dict, List, NamedTuple, Sequence

from mesh_navigation.base.robot import RobotLost

# One frame of tf2's all_frames_as_yaml().
_FRAME = re.compile(r"^(.+): \n  parent: '(.*)'$", re.MULTILINE)


class AgeLimits(NamedTuple):
    """How old the newest transform of a link may be, or how far ahead of time."""

    odom_frame: str
    """Links from the robot to this frame are odometry's, those beyond it the localizer's."""
    odom_timeout: float
    """s, of odometry."""
    map_timeout: float
    """s, of the localizer, which may be slow, and stamps ahead."""


def robot_chain(all_frames: str, robot_frame: str, map_frame: str) -> List[str]:
    """The frames from the robot's to the map's, neighbors of which are linked in TF.

    Args:
        all_frames: as tf2's all_frames_as_yaml() gives them.
        robot_frame, map_frame: their names.

    Raises:
        RobotLost: they are not linked.
    """
    parents = dict(_FRAME.findall(all_frames))
    up, down = _ancestry(parents, robot_frame), _ancestry(parents, map_frame)
    for index, frame in enumerate(up):
        if frame in down:
            return up[:index] + down[down.index(frame) :: -1]
    known = {*parents, *parents.values()}
    missing = [name for name in (robot_frame, map_frame) if name not in known]
    reason = "; ".join(f"TF has no frame '{name}'" for name in missing)
    reason = reason or f"TF has two trees, from '{up[-1]}' and from '{down[-1]}'"
    raise RobotLost(f"no transform from '{robot_frame}' to '{map_frame}': {reason}")


def _ancestry(parents: Dict[str, str], frame: str) -> List[str]:
    """A frame, its parent, and so on."""
    found = [frame]
    while found[-1] in parents and parents[found[-1]] not in found:
        found.append(parents[found[-1]])
    return found


def robot_time(
    frames: Sequence[str], stamps: Sequence[float], now: float, limits: AgeLimits
) -> float:
    """The time of the robot's pose (s): that of the oldest link of odometry.

    Where odometry has no link that moves, the others are what tells that the robot moves, and count
    as odometry.

    Args:
        frames: from the robot's to the map's.
        stamps: of the newest transform from each frame to the next (s), 0: static, never too old.
        now: s.
        limits: how old they may be.

    Raises:
        RobotLost: a link is too old, or too far ahead of time.
    """
    own = frames.index(limits.odom_frame) if limits.odom_frame in frames else len(stamps)
    if not any(stamps[:own]):
        own = len(stamps)
    for index, stamp in enumerate(stamps):
        name = "odom_timeout" if index < own else "map_timeout"
        age, allowed = now - stamp, getattr(limits, name)
        if stamp and abs(age) > allowed:
            raise RobotLost(
                f"the robot's pose is not known: '{frames[index]}' in '{frames[index + 1]}' is "
                f"{abs(age):.2f} s {'old' if age > 0 else 'ahead of time'}, allowed are "
                f"{allowed:.2f} s ({name})"
            )
    return min(filter(None, stamps[:own]), default=now)
