"""What a planner is: the base class of all planners, and what one returns."""

from dataclasses import dataclass, field
from typing import NamedTuple, Optional

import numpy as np

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome, is_success
from mesh_navigation.base.pose import Pose
from mesh_navigation.plugins.plugin import MeshPlugin


class PlanField(NamedTuple):
    """Costs to the goal of one plan, which never change; what `mesh_map.surface_path.FieldTracer`
    takes as a field."""

    labels: np.ndarray
    """(V,) float64, read-only: the cost from each vertex to the goal; above ``limit`` not final."""
    limit: float
    slowness: Optional[np.ndarray]
    """(V,) float32, what a meter costs there, not finite where it is closed; None: 1 everywhere."""
    goal_face: int
    goal_position: np.ndarray
    """(3,) m."""
    lead: float = 0.0
    """How much of the path, from its start on, leads out of closed ground (m), where the field is
    not known: a controller follows the path there."""


def _no_poses() -> np.ndarray:
    return np.zeros((0, 7))


@dataclass
class PlanResult:
    """How a plan ended."""

    outcome: int
    """A value of `GetPathOutcome`, or a planner's own: 1 to 9 (success) or 71 to 99 (failure)."""
    message: str
    """One sentence for people, with numbers."""
    poses: np.ndarray = field(default_factory=_no_poses)
    """(N,7) float64 in the map's frame: position (m), unit quaternion x, y, z, w. At least two
    poses on success, none otherwise."""
    cost: float = 0.0
    """What the planner minimized; for a planner that knows only distance, the path's length (m)."""
    potential: Optional[np.ndarray] = None
    """(V,) float32: the cost from each vertex to the goal, inf where the planner did not come."""
    vector_field: Optional[np.ndarray] = None
    """(V,3) float32: unit vectors along the surface to the goal, zero where there is none."""
    face_vectors: Optional[np.ndarray] = None
    """(F,3) float32: the same in the middle of each face, in its plane."""
    plan_field: Optional[PlanField] = None
    """What the path was made from, for controllers that follow it; None where there is none."""

    lasting: bool = False
    """Of a failure: whether it stays so whatever sensors see, because layers that cannot be cleared
    block the goal. Nobody tries again then, and move_base moves no robot."""

    @property
    def succeeded(self) -> bool:
        """Whether there is a path."""
        return is_success(self.outcome)


class PlanFailure(Exception):
    """Raised within a planner: there is no plan. Carries outcome and message of the result."""

    def __init__(
        self,
        outcome: int,
        message: str,
        potential: Optional[np.ndarray] = None,
        lasting: bool = False,
    ) -> None:
        super().__init__(message)
        self.outcome = outcome
        self.message = message
        self.potential = potential
        self.lasting = lasting

    def as_result(self) -> PlanResult:
        """The result that says so."""
        return PlanResult(
            self.outcome, self.message, potential=self.potential, lasting=self.lasting
        )


class MeshPlanner(MeshPlugin):
    """Base class of planners.

    A planner of one's own derives from it and is described in an XML file::

        <class name="my_planners/Straight" type="my_planners.straight.StraightPlanner"
               base_class_type="mesh_navigation::MeshPlanner"/>

    which package.xml exports as ``<mesh_navigation plugin="${prefix}/planners.xml"/>``.

    The contract:

    * Construction takes no arguments and does nothing long. ``initialize`` is called once per map.
    * ``plan`` is the one method to override. **It may run several times at once**, in different
      threads (one per concurrency slot), so what belongs to one plan stays in local variables.
    * Parameters may be changed while plans run, which replaces ``self.values`` as a whole: take it
      once per plan.
    * The map may get new costs while plans run: take one ``self.map.planning_costs()`` per plan,
      whose costs and edge weights are of the same moment. ``self.body.costs(...)`` makes of these
      costs those for the robot's middle: closed (over every limit) where its body would touch
      lethal or unknown ground.
    * Cancel: every plan has its own `Cancellation`, which any thread may trigger at any time, also
      before the plan starts. Look at it at least every 0.1 s, or hand a function that stops the
      work to ``cancellation.calling``; then raise `PlanFailure` with outcome CANCELED. The server
      waits half a second, then answers its client without the planner and drops its late result.
    * Outcomes are those of `GetPathOutcome`; 1 to 9 and 71 to 99 are free for a planner's own
      meanings. FAILURE, TF_ERROR, NOT_INITIALIZED and 71 to 99 are retried by the server
      (parameters planner_max_retries and planner_patience), and NO_PATH_FOUND where the map has a
      layer that can be cleared and whose data are current, unless the failure is ``lasting``; all
      others are final. Any other exception is reported as INTERNAL_ERROR.
    * ``self.map.cleared_costs()`` are those without what sensors see: a goal that cannot be reached
      by these either is ``lasting``, see `PlanResult`.
    * Units are m and rad, the frame is the map's (``self.map.frame_id``). The roll and pitch of
      start and goal mean nothing: in real maps poses are picked on surfaces wound upside down.
    """

    def make_plan(
        self,
        start: Pose,
        goal: Pose,
        tolerance: float = 0.0,
        cancellation: Optional[Cancellation] = None,
    ) -> PlanResult:
        """Plan a path; what users of a planner call, from any thread.

        Args:
            start: in the map's frame.
            goal: in the map's frame; the path ends there, with its heading.
            tolerance: where the goal cannot be reached, the path may end this far from it (m).
            cancellation: to stop the plan from another thread.

        Returns:
            The result; a plan that fails is a result too, never an exception. MAP_ERROR while a
            required layer of the map does not stand.
        """
        for outcome, what, pose in (
            (GetPathOutcome.INVALID_START, "start", start),
            (GetPathOutcome.INVALID_GOAL, "goal", goal),
        ):
            fault = pose.fault()
            if fault:
                return PlanResult(outcome, f"{what}: {fault}")
        if not tolerance >= 0.0:
            return PlanResult(GetPathOutcome.INVALID_GOAL, f"tolerance {tolerance} m is not >= 0")
        cancellation = cancellation or Cancellation()
        try:
            stop_if_canceled(cancellation)
            self._stop_for(self.map.fault)
            result = self.plan(start.normalized(), goal.normalized(), tolerance, cancellation)
            self._stop_for(self.map.lasting_fault)  # its costs are those of the begin
            return result
        except PlanFailure as failure:
            return failure.as_result()

    def _stop_for(self, fault: str) -> None:
        """Raise the `PlanFailure` of a map of which a required layer does not stand."""
        if fault:
            raise PlanFailure(GetPathOutcome.MAP_ERROR, fault)

    def plan(
        self, start: Pose, goal: Pose, tolerance: float, cancellation: Cancellation
    ) -> PlanResult:
        """Plan a path: what a planner overrides. Arguments of `make_plan`, checked and normalized.

        Raises:
            PlanFailure: there is no path, or the plan was canceled.
        """
        raise NotImplementedError(f"{type(self).__name__} does not override plan()")


def stop_if_canceled(cancellation: Cancellation) -> None:
    """Raise the `PlanFailure` of a canceled plan if a cancel was requested."""
    if cancellation.canceled:
        raise PlanFailure(GetPathOutcome.CANCELED, f"planning stopped: {cancellation.reason}")
