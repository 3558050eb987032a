"""Which way to go from where the robot is: down the field of the plan, or along its path."""

from typing import List, NamedTuple, Optional

import numpy as np

from mesh_map.distance.surface_path import FieldTracer
from mesh_map.geometry.mesh_geometry import MeshGeometry

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import vector_text
from mesh_navigation.controllers.surface_pose import SurfacePose
from mesh_navigation.controllers.track import Track
from mesh_navigation.controllers.local_path import LocalPath
from mesh_navigation.plugins.controller import ControlFailure, ControllerPlan

_BACK = 0.5  # m before the point of the path that is nearest, to where it may have to go back


class Guidance(NamedTuple):
    """The way to go."""

    paths: List[LocalPath]
    """The next one is for where nothing of those before can be seen."""
    remark: str = ""
    """One sentence if it is not what was asked for."""


class Guide(Track):
    """Of one plan: its path, and its field."""

    def __init__(
        self,
        geometry: MeshGeometry,
        plan: ControllerPlan,
        costs: np.ndarray,
        distance: float,
        clearance: float,
    ) -> None:
        """As a `Track`, of the plan that is to be followed."""
        super().__init__(geometry, plan.poses[:, :3], costs, distance, clearance)
        self._field = plan.field
        self._tracer: Optional[FieldTracer] = (
            None if plan.field is None else FieldTracer.of(geometry)
        )

    def guidance(
        self, surface_pose: SurfacePose, follow_field: bool, length: float, max_distance: float
    ) -> Guidance:
        """The way to go from here.

        Args:
            surface_pose: where the robot is.
            follow_field: True: from here down the field where there is one; else along the path.
            length: at which the way may be cut off (m).
            max_distance: from the path that is allowed when it is followed (m).

        Raises:
            ControlFailure: MISSED_PATH, the path is too far away.
        """
        remark = ""
        if follow_field:
            way = self._down_the_field(surface_pose, length)
            if way is not None:
                return Guidance([way])
            remark = "the plan has no field"
            if self._field is not None:
                remark = (
                    f"the field of the plan does not reach {vector_text(surface_pose.position)}"
                )
            remark += ": its path is followed"
        nearest = self.nearest(surface_pose.position, max_distance)
        if nearest.distance > max_distance:
            raise ControlFailure(
                ExePathOutcome.MISSED_PATH,
                f"the robot at {vector_text(surface_pose.position)} is {nearest.distance:.2f} m "
                f"from the path, allowed are {max_distance:.2f} m (max_path_distance); the path is "
                f"nearest at {vector_text(nearest.position)}",
            )
        back = self.before(nearest, _BACK)
        paths = [self.ahead(nearest, length), self.ahead(back, length + _BACK)]
        return Guidance(paths, remark)

    def has_path_ahead(
        self, surface_pose: SurfacePose, follow_field: bool, radius: float, max_distance: float
    ) -> bool:
        """Whether the path leads away once more from the goal, beside which the robot is, farther
        than a radius (m): paths of other programs may be loops, those of fields are none."""
        if follow_field and self._field is not None:
            return False
        nearest = self.nearest(surface_pose.position, max_distance)
        return nearest.distance <= max_distance and self.comes_back(nearest, radius)

    def _down_the_field(self, surface_pose: SurfacePose, length: float) -> Optional[LocalPath]:
        if self._tracer is None:
            return None
        path = self._tracer.path(self._field, surface_pose, max_length=length)
        if path is None:
            return None
        arrives = bool((path.points[-1] == self._field.goal_position).all())
        return LocalPath.through(path.points, path.faces, arrives)
