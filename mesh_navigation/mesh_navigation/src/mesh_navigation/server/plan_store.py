"""The fields of the last plans, found again by their paths."""

from typing import Optional

import numpy as np

from mesh_map.base.digest import digest

from mesh_navigation.base.recent import Recent
from mesh_navigation.plugins.planner import PlanField


class PlanStore(Recent[PlanField]):
    """Remembers which field a path was made from.

    A client gets a path from the action get_path and passes it on to exe_path, in a message that
    has no place for a field. Numbers of messages are the same bits on both ways, so the path itself
    is the key. From any thread.
    """

    def __init__(self, size: int = 8) -> None:
        """
        Args:
            size: how many plans are remembered, those that were used last; each keeps its field.
        """
        super().__init__(size)

    def put(self, poses: np.ndarray, field: Optional[PlanField]) -> None:
        """Remember the field of (N,7) poses; None forgets one of the same poses."""
        super().put(digest(poses), field)

    def find(self, poses: np.ndarray) -> Optional[PlanField]:
        """The field of exactly these (N,7) poses, None if it is not known."""
        return super().find(digest(poses))
