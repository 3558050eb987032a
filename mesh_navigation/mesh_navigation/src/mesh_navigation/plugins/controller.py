"""What a controller is: the base class of all controllers, what one gets and what it returns."""

from typing import Any, NamedTuple, Optional

import numpy as np

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, RobotState, Velocity
from mesh_navigation.plugins.planner import PlanField
from mesh_navigation.plugins.plugin import MeshPlugin


class ControllerPlan(NamedTuple):
    """What is to be followed."""

    poses: np.ndarray
    """(N,7) float64 in the map's frame, N at least 1: position (m), unit quaternion x, y, z, w. The
    last one is the goal."""
    field: Optional[PlanField] = None
    """The potential that the path was made from; None if it came from elsewhere."""
    prepared: Any = None
    """What the controller's ``prepare_plan`` made of it; None if that was not called."""

    @property
    def goal(self) -> Pose:
        """Where to arrive, and with which heading."""
        return Pose(self.poses[-1, :3], self.poses[-1, 3:])


class Command(NamedTuple):
    """What a controller wants the robot to do until the next cycle."""

    outcome: int
    """A value of `ExePathOutcome`, or a controller's own: 1 to 9 (all is well) or 121 to 149."""
    message: str = ""
    """One sentence for people, with numbers; never empty where the outcome is a failure."""
    velocity: Velocity = STOP


class ControlFailure(Exception):
    """Raised within a controller: it cannot go on now. Carries outcome and message."""

    def __init__(self, outcome: int, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome
        self.message = message


class MeshController(MeshPlugin):
    """Base class of controllers.

    A controller of one's own derives from it and is described in an XML file as planners are (see
    `MeshPlanner`), with ``base_class_type="mesh_navigation::MeshController"``.

    The contract:

    * Construction takes no arguments and does nothing long. ``initialize`` is called once per map.
    * Each goal gets a shallow copy (``copy.copy``) of the controller that was initialized, so that
      goals of several slots can be followed at once: what ``initialize`` has prepared is shared by
      all goals and must not be changed later; ``set_plan`` makes what belongs to one goal.
    * For one goal, one method is called at a time: ``set_plan`` first and again when a newer plan
      replaces the one that is followed (the robot may be moving), then in every cycle
      ``is_goal_reached`` and, if it is not, ``compute_velocity``.
    * ``set_plan`` takes its time from a cycle. What takes long in it can be done in
      ``prepare_plan``, which other threads call before.
    * The robot may be found elsewhere after a time without localization: ``forget_place`` and
      ``set_plan`` with the same plan come before the next cycle then, while it stands.
    * ``compute_velocity`` is to return within a fraction of a cycle (1 / controller_frequency). It
      does not drive and does not wait. If it takes long, the server stops the robot meanwhile; look
      at ``cancellation`` then, after half a second the server answers without the controller.
    * A command that is a failure (or an exception: `ControlFailure`, or any other as
      INTERNAL_ERROR) stops the robot for this cycle. The server asks again in the next cycle until
      controller_max_retries or controller_patience is used up, but for INVALID_PATH,
      NOT_INITIALIZED, INTERNAL_ERROR and MAP_ERROR, which end the goal at once.
    * The server sends zero velocity when the goal ends, whatever the reason. A controller limits
      its own accelerations and decelerations otherwise.
    * Parameters may be changed meanwhile, which replaces ``self.values``, and the map may
      get new costs: take one ``self.map.planning_costs()`` per cycle.
    * What the robot's body must not touch, ``self.body.obstacles(...)`` says.
    * Units are m, rad and s, the frame is the map's (``self.map.frame_id``).
    """

    def prepare_plan(self, plan: ControllerPlan) -> Any:
        """What ``set_plan`` needs of a plan that comes while the robot drives; it finds it in the
        plan as ``prepared``.

        Called in other threads, while cycles go on: it changes nothing of the controller. It is
        not called for every plan. If it fails, ``set_plan`` gets the plan without it.
        """
        return None

    def set_plan(self, plan: ControllerPlan) -> None:
        """Follow this from now on.

        Raises:
            ControlFailure: INVALID_PATH, it cannot be followed.
        """
        raise NotImplementedError(f"{type(self).__name__} does not override set_plan()")

    def forget_place(self) -> None:
        """Forget where the robot was in the cycles before: that may have been wrong, or it was
        carried away meanwhile. Nothing to do for a controller that remembers nothing of it."""

    def compute_velocity(self, state: RobotState, cancellation: Cancellation) -> Command:
        """What to do next.

        Raises:
            ControlFailure: as a command with this outcome.
        """
        raise NotImplementedError(f"{type(self).__name__} does not override compute_velocity()")

    def is_goal_reached(
        self, state: RobotState, dist_tolerance: float, angle_tolerance: float
    ) -> bool:
        """Whether the robot has arrived.

        Args:
            state: of the robot, of this cycle.
            dist_tolerance: m.
            angle_tolerance: rad.
        """
        raise NotImplementedError(f"{type(self).__name__} does not override is_goal_reached()")
