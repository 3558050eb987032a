"""Driving along a path: the cycle of a controller, with all that may end it."""

import math
import threading
import time
from typing import Any, Callable, Mapping, NamedTuple, Optional, Tuple

from mesh_map.base.parameter import Value
from mesh_msgs.text import one_line

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import ExePathOutcome, is_success
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.progress_watch import angle_between
from mesh_navigation.base.robot import (
    STOP,
    NotLocalized,
    Robot,
    RobotLost,
    RobotState,
    Velocity,
)
from mesh_navigation.execution.attempt import fault_of_answer
from mesh_navigation.execution.drive_watches import ObedienceWatch, OscillationWatch
from mesh_navigation.execution.server_parameters import PARAMETERS
from mesh_navigation.plugins.controller import (
    Command,
    ControlFailure,
    ControllerPlan,
    MeshController,
)

# Hz; a controller_frequency of 0 is no frequency, and none is slower than the least.
DEFAULT_FREQUENCY, LEAST_FREQUENCY = 20.0, 1.0


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


class _Step(NamedTuple):
    outcome: int
    message: str
    state: Optional[RobotState] = None
    velocity: Velocity = STOP
    ends: bool = True


def default_values() -> Mapping[str, Value]:
    """The server's parameters as they are if nobody sets them."""
    return {parameter.name: parameter.default for parameter in PARAMETERS}


def control_period(values: Mapping[str, Value]) -> float:
    """From one control cycle to the next (s), by the server's parameters."""
    frequency = float(values["controller_frequency"])  # type: ignore[arg-type]
    return 1.0 / (max(LEAST_FREQUENCY, frequency) if frequency > 0.0 else DEFAULT_FREQUENCY)


class PathExecution:
    """One robot that follows one path, which may be replaced while it drives.

    ``run`` does all in the thread that calls it, by any clock; `prepared` and `replace` may be
    called from others.
    """

    def __init__(
        self,
        robot: Robot,
        clock: Clock,
        values: Callable[[], Mapping[str, Value]] = default_values,
        on_cycle: Callable[[Cycle], None] = lambda cycle: None,
        map_fault: Callable[[], str] = lambda: "",
        map_gap: Callable[[], str] = lambda: "",
    ) -> None:
        """
        Args:
            robot: that is driven.
            clock: by which cycles and patience are measured.
            values: of the server's parameters, asked in each cycle.
            on_cycle: called at the end of each cycle.
            map_fault: why the controller's map must not be driven on any longer; empty if it may.
            map_gap: why it must not be driven on just now: the robot stands, and waits; or empty.
        """
        self._robot, self._clock, self._values = robot, clock, values
        self._on_cycle, self._map_fault, self._map_gap = on_cycle, map_fault, map_gap
        self._lock = threading.Lock()
        self._pending: Optional[Tuple[ControllerPlan, Tolerances]] = None
        self._ended = False
        self._controller: Optional[MeshController] = None
        self._pose: Optional[Pose] = None
        self._oscillation, self._obedience = OscillationWatch(), ObedienceWatch()
        # Times (s): the last command that was valid, the last pose, the last map without a gap, the
        # last moment at which the robot was localized.
        self._valid = self._seen = self._whole = self._localized = 0.0
        self._is_elsewhere = False  # whether it may be, since it was not localized
        self._retries = 0  # since the last command that was valid

    def prepared(self, plan: ControllerPlan) -> ControllerPlan:
        """A plan for `replace`, with all done to it that need not take the time of a cycle."""
        controller = self._controller
        if controller is None:
            return plan
        try:
            return plan._replace(prepared=controller.prepare_plan(plan))
        except (Exception, SystemExit):  # It is the cycle's to fail with it, or do without.
            return plan

    def replace(self, plan: ControllerPlan, tolerances: Tolerances) -> bool:
        """Follow another plan from the next cycle on; the robot does not stop in between.

        Returns:
            Whether it will be followed; False once the execution has ended.
        """
        with self._lock:
            if not self._ended:
                self._pending = plan, tolerances
            return not self._ended

    def close(self) -> None:
        """Accept no more plans: nobody waits for the result any longer."""
        with self._lock:
            self._ended = True

    def run(
        self,
        controller: MeshController,
        plan: ControllerPlan,
        tolerances: Tolerances,
        cancellation: Cancellation,
    ) -> ExecutionResult:
        """Drive until the goal is reached, driving fails or is canceled. Called once.

        When it returns or raises, the robot was told to stop.
        """
        self._controller = controller
        with self._lock:
            # A plan that came before the start is newer.
            self._pending = self._pending or (plan, tolerances)
        self._plan, self._tolerances = plan, tolerances
        try:
            step = self._drive(controller, cancellation)
        finally:
            self.close()
            self._robot.drive(STOP)
        self._pose = self._robot.known_pose() or self._pose  # the last one that was known
        to_go = self._to_goal(self._pose)
        return ExecutionResult(int(step.outcome), step.message, self._pose, *to_go)

    def _drive(self, controller: MeshController, cancellation: Cancellation) -> _Step:
        clock = self._clock
        now = due = clock.now()
        self._restart(now)
        while True:
            begin = time.perf_counter()
            step = self._step(controller, now, cancellation)
            after = clock.now()
            due += control_period(self._values())
            late = after > due
            if late:
                due = after
            elif after < now:  # Time has jumped back.
                due = after
                self._restart(after)
            to_go = self._to_goal(step.state and step.state.pose)
            self._tell(Cycle(*step[:4], *to_go, time.perf_counter() - begin, late))
            if step.ends:
                if self._end(step.outcome):
                    return step
                self._restart(after)  # The newer plan gets its own time.
            clock.wait_until(due, cancellation)
            now = clock.now()
            if now < after:
                due = now
                self._restart(now)

    def _tell(self, cycle: Cycle) -> None:
        self._on_cycle(cycle)

    def _end(self, outcome: int) -> bool:
        """Whether this is the end; a plan that has just come is still followed."""
        with self._lock:
            dead = (ExePathOutcome.CANCELED, ExePathOutcome.MAP_ERROR)
            self._ended = self._pending is None or outcome in dead
            return self._ended

    def _restart(self, now: float) -> None:
        """Measure all times from now: for another plan, and when time has jumped back."""
        self._valid = self._seen = self._whole = self._localized = now
        self._retries = 0
        self._oscillation.restart()
        self._obedience.restart()

    def _step(self, controller: MeshController, now: float, cancellation: Cancellation) -> _Step:
        if cancellation.canceled:
            return _canceled(cancellation)
        fault = self._map_fault()
        if fault:
            self._robot.drive(STOP)
            return _Step(ExePathOutcome.MAP_ERROR, fault)
        refusal = self._take_plan(controller)
        if refusal:
            self._robot.drive(STOP)
            return _Step(refusal.outcome, refusal.message)
        values = self._values()
        gap = self._map_gap()
        if not gap:
            self._whole = now
        try:
            state = self._robot.state()
        except NotLocalized as lost:
            return self._not_localized(str(lost), now, lost.patience)
        except RobotLost as lost:  # which is why sensors may say nothing, too
            return self._lost(str(lost), now, values["tf_timeout"])
        self._localized = now
        if gap:
            return self._without_map(gap, now, values["controller_patience"])
        refusal = self._begin_elsewhere(controller)
        if refusal:
            return self._failed(refusal, state, now, values)
        self._seen, self._pose = max(self._seen, min(now, state.time)), state.pose
        self._robot.trail.add(state.pose)
        command = self._ask(controller, state, values, cancellation)
        if cancellation.canceled:
            return _canceled(cancellation)._replace(state=state)
        if command is None:
            return _Step(ExePathOutcome.SUCCESS, self._arrival(state.pose), state)
        if not is_success(command.outcome):
            return self._failed(command, state, now, values)
        return self._obeyed(command, state, now, values)

    def _not_localized(self, why: str, now: float, patience: float) -> _Step:
        """A cycle in which nobody knows where the robot is: as without a pose."""
        self._stand(now)
        self._seen = self._whole = now
        if not self._is_elsewhere:
            self._is_elsewhere = True
            self._robot.trail.clear()  # what it has of now may be wrong
        if now - self._localized < patience:
            return _Step(ExePathOutcome.TF_ERROR, why, ends=False)
        text = f"{why}; waited for {patience:.1f} s (localization_patience)"
        return _Step(ExePathOutcome.TF_ERROR, text)

    def _begin_elsewhere(self, controller: MeshController) -> Optional[Command]:
        """Where the robot was not localized meanwhile, follow the plan as one that begins here; the
        controller's failure if it refuses that."""
        if not self._is_elsewhere:
            return None
        self._is_elsewhere = False

        def begin() -> Command:
            controller.forget_place()
            controller.set_plan(self._plan._replace(prepared=None))  # it knows a place, too
            return Command(ExePathOutcome.SUCCESS)

        command = checked_command(begin)
        return None if is_success(command.outcome) else command

    def _take_plan(self, controller: MeshController) -> Optional[Command]:
        """Give the controller the newest plan; its failure if it refuses that."""
        with self._lock:
            newest, self._pending = self._pending, None
            if newest is None:
                return None
            self._plan, self._tolerances = newest

        def set_plan() -> Command:
            controller.set_plan(self._plan)
            return Command(ExePathOutcome.SUCCESS)

        command = checked_command(set_plan)
        return None if is_success(command.outcome) else command

    def _without_map(self, why: str, now: float, patience: float) -> _Step:
        """A cycle in which the map does not have what sensors see: as without a pose."""
        self._stand(now)
        self._seen = now
        if not 0.0 < patience <= now - self._whole:
            return _Step(ExePathOutcome.MAP_ERROR, why, ends=False)
        text = f"{why}; waited for {patience:.1f} s (controller_patience)"
        return _Step(ExePathOutcome.MAP_ERROR, text)

    def _stand(self, now: float) -> None:
        """Stop the robot in a cycle that is not the controller's fault."""
        self._robot.drive(STOP)
        self._valid = now
        self._obedience.restart()
        self._oscillation.restart()

    def _lost(self, why: str, now: float, timeout: float) -> _Step:
        """A cycle without a pose: the robot stops, and waits for one."""
        self._stand(now)
        if now - self._seen < timeout:
            return _Step(ExePathOutcome.TF_ERROR, why, ends=False)
        text = f"{why}; waited for {timeout:.1f} s (tf_timeout)"
        return _Step(ExePathOutcome.TF_ERROR, text)

    def _ask(
        self,
        controller: MeshController,
        state: RobotState,
        values: Mapping[str, Value],
        cancellation: Cancellation,
    ) -> Optional[Command]:
        """The controller's command; None if the goal is reached."""
        arrived = values["mbf_tolerance_check"] and self._is_near(state.pose)
        if arrived:
            return None

        def ask() -> Optional[Command]:
            nonlocal arrived
            arrived = bool(controller.is_goal_reached(state, *self._tolerances))
            if arrived:
                return Command(ExePathOutcome.SUCCESS)
            return controller.compute_velocity(state, cancellation)

        command = checked_command(ask)
        return None if arrived else command

    def _failed(
        self, command: Command, state: RobotState, now: float, values: Mapping[str, Value]
    ) -> _Step:
        """A cycle without a velocity: the robot stops, and the controller may be asked again."""
        self._robot.drive(STOP)
        self._obedience.restart()
        outcome, message = command.outcome, command.message
        retries, patience = values["controller_max_retries"], values["controller_patience"]
        if outcome in FINAL or retries == 0:
            return _Step(outcome, message, state)
        self._retries += 1
        if 0 < retries < self._retries:
            message = f"{message} (after {retries} retries, controller_max_retries)"
            return _Step(outcome, message, state)
        if 0.0 < patience < now - self._valid:
            message = (
                f"no velocity for {now - self._valid:.2f} s (controller_patience {patience:.2f} s)"
                f"; the last failure: {outcome_text(outcome)}, {message}"
            )
            return _Step(ExePathOutcome.PAT_EXCEEDED, message, state)
        return self._or_oscillation(_Step(outcome, message, state, ends=False), now, values)

    def _obeyed(
        self, command: Command, state: RobotState, now: float, values: Mapping[str, Value]
    ) -> _Step:
        """A cycle as it should be."""
        tolerance = values["cmd_vel_ignored_tolerance"]
        stuck = self._obedience.fault(state, command.velocity, now, tolerance)
        if stuck:
            self._robot.drive(STOP)
            return _Step(ExePathOutcome.ROBOT_STUCK, stuck, state)
        self._valid, self._retries = now, 0
        step = _Step(command.outcome, command.message, state, command.velocity, ends=False)
        step = self._or_oscillation(step, now, values)
        self._robot.drive(step.velocity)
        return step

    def _or_oscillation(self, step: _Step, now: float, values: Mapping[str, Value]) -> _Step:
        assert step.state is not None
        fault = self._oscillation.fault(step.state.pose, now, values)
        return _Step(ExePathOutcome.OSCILLATION, fault, step.state) if fault else step

    def _to_goal(self, pose: Optional[Pose]) -> Tuple[float, float]:
        return to_goal(self._plan, pose)

    def _is_near(self, pose: Pose) -> bool:
        distance, angle = self._to_goal(pose)
        return distance < self._tolerances.distance and angle < self._tolerances.angle

    def _arrival(self, pose: Pose) -> str:
        distance, angle = self._to_goal(pose)
        return f"arrived, {distance:.3f} m and {angle:.3f} rad from the goal"


def _canceled(cancellation: Cancellation) -> _Step:
    message = f"driving stopped: {cancellation.reason}"
    return _Step(ExePathOutcome.CANCELED, message)


FINAL = frozenset(
    (
        ExePathOutcome.CANCELED,
        ExePathOutcome.INVALID_PATH,
        ExePathOutcome.NOT_INITIALIZED,
        ExePathOutcome.INTERNAL_ERROR,
        ExePathOutcome.MAP_ERROR,
    )
)
"""Failures that another cycle does not change."""


def checked_command(ask: Callable[[], Any]) -> Command:
    """The command that a controller returns, or what is wrong with it; never raises.

    The velocity of a failure is zero, its message says something. A velocity that is not finite is
    NO_VALID_CMD; an exception, or anything that is no command, is INTERNAL_ERROR.
    """
    try:
        command = ask()
        fault = fault_of_answer(command, Command)
        if fault:
            return _fault(fault)
        outcome, message = int(command.outcome), one_line(command.message)
        if not is_success(outcome):
            return Command(outcome, message or f"the controller reported {outcome_text(outcome)}")
        x, y, yaw = map(float, command.velocity)
    except ControlFailure as failure:
        refused = Command(failure.outcome, failure.message)
        return checked_command(lambda: refused)
    except (Exception, SystemExit) as error:  # A plugin may raise anything; its goal is answered.
        return _fault(f"{type(error).__name__}: {error}")
    velocity = Velocity(x, y, yaw)
    if not velocity.is_finite:
        numbers = ", ".join(f"{number:g}" for number in velocity)
        return Command(
            ExePathOutcome.NO_VALID_CMD,
            f"the controller's velocity (x, y, yaw) = ({numbers}) is not finite",
        )
    return Command(outcome, message, velocity)


def outcome_text(outcome: int) -> str:
    """``MISSED_PATH (108)``, or the number alone of an outcome without a name."""
    try:
        return f"{ExePathOutcome(outcome).name} ({outcome})"
    except ValueError:
        return str(outcome)


def _fault(what: str) -> Command:
    text = one_line(f"the controller is at fault: {what}")
    return Command(ExePathOutcome.INTERNAL_ERROR, text, STOP)
