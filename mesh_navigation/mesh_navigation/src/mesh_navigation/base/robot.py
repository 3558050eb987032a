"""The robot as controllers and recovery behaviors see it: poses come in, velocities go out."""

import abc
import math
import threading
from collections import deque
from typing import Callable, Deque, List, NamedTuple, Optional

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock, Stopwatch
from mesh_navigation.base.pose import Pose

SPACING = 0.05  # m, from one pose to the next
LENGTH = 20.0  # m, that are remembered
JUMP = 1.0  # m; a robot that was put elsewhere did not drive there
POLL = 0.05  # s between two looks for a pose that is lost


class Trail:
    """The robot's last poses, `SPACING` apart. From any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._poses: Deque[Pose] = deque(maxlen=int(LENGTH / SPACING))

    def add(self, pose: Pose) -> None:
        """Note where the robot is."""
        with self._lock:
            if self._poses:
                step = math.dist(pose.position, self._poses[-1].position)
                if step < SPACING:
                    return
                if step > JUMP:
                    self._poses.clear()
            self._poses.append(pose)

    def back(self) -> List[Pose]:
        """The poses, the last one first."""
        with self._lock:
            return list(reversed(self._poses))

    def forget_last(self, count: int) -> None:
        """The robot went back: its last poses are not behind it any more."""
        with self._lock:
            for _ in range(min(count, len(self._poses))):
                self._poses.pop()

    def clear(self) -> None:
        """Forget all: the robot was put elsewhere, or there is another map."""
        with self._lock:
            self._poses.clear()


class Velocity(NamedTuple):
    """Of the robot, in its own frame."""

    x: float = 0.0
    """Ahead (m/s)."""
    y: float = 0.0
    """To the left (m/s)."""
    yaw: float = 0.0
    """To the left (rad/s)."""

    @property
    def is_finite(self) -> bool:
        """Whether it may be sent."""
        return all(map(math.isfinite, self))


STOP = Velocity()


class RobotState(NamedTuple):
    """The robot at one moment."""

    time: float
    """Of the clock of the execution (s)."""
    pose: Pose
    """In the map's frame, with a unit quaternion; all numbers are finite."""
    velocity: Velocity
    """Measured where there is odometry, else what was commanded last."""


class RobotLost(Exception):
    """The robot's pose is not known; the message says why, with numbers."""


class NotLocalized(RobotLost):
    """A localizer that knew where the robot is does not any more; the message says why."""

    def __init__(self, message: str, patience: float) -> None:
        """
        Args:
            message: why, as a sentence.
            patience: how long those that drive the robot wait for it (s); inf: without end.
        """
        super().__init__(message)
        self.patience = patience


class MapGap(RobotLost):
    """What is around the robot is not known just now; the message says why."""


class Robot(abc.ABC):
    """One robot. Methods may be called from any thread and return at once."""

    trail: Trail
    """Where it has been; those that drive it add to it."""
    lost_timeout = 0.0
    """How long those that drive it wait where its pose is not known (s)."""

    @abc.abstractmethod
    def state(self) -> RobotState:
        """The newest pose.

        Raises:
            RobotLost: there is none, it is too old, or it is not finite.
            NotLocalized: a localizer does not know it any more.
        """

    def awaited_state(self, clock: Clock, cancellation: Cancellation) -> RobotState:
        """The newest pose; as long as there is none, the robot stands and the caller waits.

        Raises:
            RobotLost: there is none for ``lost_timeout``, or when it is canceled.
            NotLocalized: it is not localized for the patience of that.
        """
        not_localized, watch = Stopwatch(clock), Stopwatch(clock)
        while True:
            try:
                return self.state()
            except NotLocalized as lost:
                self.drive(STOP)
                if not_localized.seconds() >= lost.patience or cancellation.canceled:
                    raise
                watch = Stopwatch(clock)
            except RobotLost:
                self.drive(STOP)
                not_localized.seconds()
                if watch.seconds() >= self.lost_timeout or cancellation.canceled:
                    raise
            clock.wait_until(clock.now() + POLL, cancellation)

    def known_pose(self) -> Optional[Pose]:
        """The newest pose; None where there is none to go by."""
        try:
            return self.state().pose
        except RobotLost:
            return None

    @abc.abstractmethod
    def drive(self, velocity: Velocity) -> None:
        """Command a velocity; it holds until the next one, at most 0.2 s or three control cycles.

        What is not finite becomes `STOP`.
        """


class GuardedRobot(Robot):
    """Passes everything on to a robot until it is closed; commands that come later are dropped."""

    def __init__(
        self,
        robot: Robot,
        refuses: Callable[[], str] = lambda: "",
        gap: Callable[[], str] = lambda: "",
    ) -> None:
        """
        Args:
            robot: to be driven.
            refuses: why the robot must not move any more; empty if it may.
            gap: why it must not move just now: it stands, and has no state; empty if it may.
        """
        self._robot, self._refuses, self._gap = robot, refuses, gap
        self.lost_timeout = robot.lost_timeout
        self._moves = False
        self.refusal = ""
        """Why it does not move any more, whatever is commanded; empty if it does."""
        self._lock = threading.Lock()
        self._closed = False

    @property
    def trail(self) -> Trail:  # type: ignore[override]
        """That of the robot."""
        return self._robot.trail

    def state(self) -> RobotState:
        state = self._robot.state()  # without which sensors may say nothing, too
        gap = self._gap()
        if gap:
            raise MapGap(gap)
        return state

    def drive(self, velocity: Velocity) -> None:
        # Under the lock: no command can overtake the last stop.
        with self._lock:
            self._moves = velocity != STOP
            if not self._closed:
                self._refuse()
                self._robot.drive(STOP if self.refusal or self._gap() else velocity)

    def look(self) -> str:
        """Stop the robot if it must not move now; returns the refusal."""
        with self._lock:
            if not (self._closed or self.refusal):
                self._refuse()
                if self.refusal or (self._moves and self._gap()):
                    self._robot.drive(STOP)
        return self.refusal

    def _refuse(self) -> None:
        if self._moves and not self.refusal:
            self.refusal = self._refuses()

    def close(self) -> None:
        """Stop the robot; from now on it obeys others only."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._robot.drive(STOP)
