"""Driving along a path with a controller that may block: nobody waits for it, the robot stands."""

import threading
import time
from contextlib import contextmanager
from typing import Any, Iterator, Optional, Tuple

from mesh_msgs.text import one_line

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.robot import STOP, GuardedRobot, RobotState
from mesh_navigation.execution.attempt import Attempt
from mesh_navigation.execution.path_execution import (
    Cycle,
    ExecutionResult,
    PathExecution,
    Tolerances,
    to_goal,
)
from mesh_navigation.plugins.controller import Command, ControllerPlan, MeshController

# Between two looks at the controller (s, of the computer's time).
LOOK = 0.05
# A controller that takes longer (s), by both the computer's time and the clock, does not drive.
LONGEST_CALL = 0.2


class _Watched(MeshController):
    """Passes everything on to a controller, and knows for how long that has been at it."""

    def __init__(self, controller: MeshController, clock: Clock) -> None:
        self._controller, self._clock = controller, clock
        self._called: Optional[Tuple[float, float]] = None

    @contextmanager
    def _call(self) -> Iterator[None]:
        self._called = time.monotonic(), self._clock.now()
        try:
            yield
        finally:
            self._called = None

    def busy(self) -> Tuple[float, float]:
        """Since when the controller has been at it: seconds of the computer and of the clock."""
        called = self._called
        if called is None:
            return 0.0, 0.0
        return time.monotonic() - called[0], self._clock.now() - called[1]

    def prepare_plan(self, plan: ControllerPlan) -> Any:
        return self._controller.prepare_plan(plan)  # No cycle waits for it.

    def set_plan(self, plan: ControllerPlan) -> None:
        with self._call():
            self._controller.set_plan(plan)

    def forget_place(self) -> None:
        with self._call():
            self._controller.forget_place()

    def compute_velocity(self, state: RobotState, cancellation: Cancellation) -> Command:
        with self._call():
            return self._controller.compute_velocity(state, cancellation)

    def is_goal_reached(
        self, state: RobotState, dist_tolerance: float, angle_tolerance: float
    ) -> bool:
        with self._call():
            return self._controller.is_goal_reached(state, dist_tolerance, angle_tolerance)


class SupervisedExecution(PathExecution):
    """The same in a thread of its own, under a watch.

    While the controller takes long, the robot stands. A cancel is answered half a second later at
    the latest, and the patience ends a controller that blocks too; what such a controller still
    commands does not reach the robot. The clock may be any whose time goes on by itself.
    """

    def run(
        self,
        controller: MeshController,
        plan: ControllerPlan,
        tolerances: Tolerances,
        cancellation: Cancellation,
    ) -> ExecutionResult:
        """As `PathExecution.run`."""
        self._plan = plan
        self._robot = guard = GuardedRobot(self._robot)
        self._answering, self._answered = threading.Lock(), False
        watched = _Watched(controller, self._clock)
        attempt = Attempt("drive", lambda stop: self._driven(watched, plan, tolerances, stop))
        attempt.start()
        with cancellation.calling(attempt.wake.set):
            impatient = self._watch(watched, attempt.wake)
        finished, late = bool(attempt.results), ""
        if not finished:
            self.close()
            reason = impatient or cancellation.reason
            attempt.cancellation.cancel(reason)
            self._robot.drive(STOP)
            late = attempt.stop(reason, "controller")
        with self._answering:
            self._answered = True
        guard.close()
        if finished or (attempt.results and not impatient):
            return attempt.results[0]
        if impatient:
            return self._result(ExePathOutcome.PAT_EXCEEDED, impatient + late)
        message = f"driving stopped: {cancellation.reason}{late}"
        return self._result(ExePathOutcome.CANCELED, message)

    def _driven(self, *arguments: Any) -> ExecutionResult:
        try:
            return super().run(*arguments)
        except (Exception, SystemExit) as error:  # The goal gets its answer, whatever it is.
            text = one_line(f"driving failed with {type(error).__name__}: {error}")
            return self._result(ExePathOutcome.INTERNAL_ERROR, text)

    def _watch(self, watched: _Watched, wake: threading.Event) -> str:
        """Look after the controller until something else ends it; or why the patience is gone."""
        while not wake.wait(LOOK):
            system, clock = watched.busy()
            if min(system, clock) > LONGEST_CALL:
                self._robot.drive(STOP)
            patience = self._values()["controller_patience"]
            if 0.0 < patience < clock:
                return (
                    f"the controller did not answer for {clock:.2f} s "
                    f"(controller_patience {patience:.2f} s)"
                )
        return ""

    def _tell(self, cycle: Cycle) -> None:
        # Under the lock: nothing is heard of a drive after its answer.
        with self._answering:
            if not self._answered:
                super()._tell(cycle)

    def _result(self, outcome: int, message: str) -> ExecutionResult:
        pose = self._robot.known_pose()
        with self._lock:  # a drive may be taken over at this moment
            newest = self._pending[0] if self._pending else self._plan
        return ExecutionResult(outcome, message, pose, *to_goal(newest, pose))
