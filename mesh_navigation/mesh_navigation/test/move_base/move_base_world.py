"""Sub-goals of move_base that end as a script says, in simulated time, all in one thread."""

import math
from typing import NamedTuple, Optional

from actionlib_msgs.msg import GoalStatus

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import (
    TAKEN_OVER,
    ExePathOutcome,
    GetPathOutcome,
    RecoveryOutcome,
)
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.server_parameters import PARAMETERS
from mesh_navigation.move_base.move_base_execution import MoveBaseExecution
from mesh_navigation.move_base.sub_goals import GoalEnd, DriveProgress, SubActions, SubGoal

STEP = 0.01
CANCELED = {
    "plan": GetPathOutcome.CANCELED,
    "drive": ExePathOutcome.CANCELED,
    "recover": RecoveryOutcome.CANCELED,
}


class Scripted(NamedTuple):
    """What a sub-goal will do."""

    outcome: int = 0
    seconds: float = 0.1  # of a drive that takes new plans: from its beginning
    speed: float = 0.0  # of a drive (m/s)
    turn: float = 0.0  # of a drive (rad/s)
    reported: int = 0  # outcome of each cycle
    state: Optional[int] = None  # None: as the outcome says
    after_cancel: float = 0.05  # s to the end
    lasting: bool = False  # of a plan


class FakeGoal(SubGoal):
    def __init__(self, world, kind, name, scripted, on_progress=None):
        self.world, self.kind, self.name, self.scripted = world, kind, name, scripted
        self.on_progress = on_progress
        self.begun, self.due, self.end, self.reason = world.time, scripted.seconds, None, None

    def cancel(self, reason):
        if self.reason is None:
            self.reason = reason
            self.due = min(self.due, self.age + self.scripted.after_cancel)

    def wait(self, cancellation=None, timeout=None):
        cancellation = cancellation or Cancellation()
        deadline = math.inf if timeout is None else self.world.time + timeout
        while self.end is None and not cancellation.canceled:
            if self.world.time >= deadline - 1e-9:
                break
            self.world.step()
        return self.end

    @property
    def age(self):
        return self.world.time - self.begun

    def step(self):
        if self.kind == "drive":
            if not self.world.lost:
                self.world.x += self.scripted.speed * STEP
                self.world.yaw += self.scripted.turn * STEP
            self.on_progress(self.world.progress(self.scripted.reported))
        if self.age >= self.due - 1e-9:
            self.finish()

    def finish(self):
        scripted = self.scripted
        if self.reason is not None and self.due < scripted.seconds:
            self.answer(GoalStatus.PREEMPTED, CANCELED[self.kind], f"stopped: {self.reason}")
            return
        state = GoalStatus.SUCCEEDED if scripted.outcome < 10 else GoalStatus.ABORTED
        text = f"{self.name} ends with {scripted.outcome}"
        self.answer(scripted.state or state, scripted.outcome, text)

    def answer(self, state, outcome, message):
        value = {"plan": "path", "drive": "drive"}.get(self.kind)
        values = {value: f"value of {self.name}"} if value else {}
        values["lasting"] = self.scripted.lasting
        self.end = GoalEnd(int(outcome), message, state, **values)
        self.world.active.remove(self)
        self.world.calls.append(f"end of {self.name}")


class World(Clock, SubActions):
    """Time, robot and servers. Scripts by kind; the last entry of each one repeats."""

    def __init__(self, goal_x=1000.0, **scripts):
        self.scripts = {kind: list(entries) for kind, entries in scripts.items()}
        self.time = self.x = self.yaw = 0.0
        self.jump = 0.0  # of the clock that is asked
        self.goal_x, self.lost, self.times = goal_x, False, 1
        self.active, self.calls, self.log, self.events = [], [], [], []
        self.counts = {"plan": 0, "drive": 0, "recover": 0}
        self.starts = []
        self.values = {parameter.name: parameter.default for parameter in PARAMETERS}
        self.cancellation = Cancellation()

    # Clock

    def now(self):
        return self.time + self.jump

    def wait_until(self, moment, cancellation):
        raise AssertionError("nothing in here waits by the clock")

    def step(self):
        assert self.time < 2000.0, f"no end: {self.calls[-20:]}"
        self.time += STEP
        for goal in list(self.active):
            goal.step()
        while self.events and self.events[0][0] <= self.time:
            self.events.pop(0)[1]()

    def at(self, moment, event):
        self.events = sorted(self.events + [(moment, event)], key=lambda pair: pair[0])

    def progress(self, outcome=0):
        if self.lost:
            return None
        pose = Pose.at((self.x, 0.0, 0.0), self.yaw)
        return DriveProgress(pose, abs(self.goal_x - self.x), outcome)

    # SubActions

    def plan(self):
        return self.begin("plan", "plan")

    def drive(self, path, on_progress):
        assert path.startswith("value of plan")
        begun = self.time
        for goal in list(self.active):
            if goal.kind == "drive":
                if goal.reason is not None:
                    goal.answer(GoalStatus.PREEMPTED, 101, f"stopped: {goal.reason}")
                    continue
                goal.answer(GoalStatus.PREEMPTED, 101, TAKEN_OVER)
                begun = goal.begun  # the drive goes on
        drive = self.begin("drive", "drive", on_progress)
        drive.begun = begun
        return drive

    def recover(self, behavior):
        return self.begin("recover", behavior)

    def begin(self, kind, name, on_progress=None):
        number = self.counts[kind]
        self.counts[kind] += 1
        if kind != "recover":
            name = f"{name} {number}"
        script = self.scripts.get(kind) or [Scripted()]
        goal = FakeGoal(self, kind, name, script[min(number, len(script) - 1)], on_progress)
        self.active.append(goal)
        self.calls.append(name)
        self.starts.append((name, round(self.time, 2)))
        kinds = [goal.kind for goal in self.active]
        assert len(kinds) == len(set(kinds)), f"at once: {kinds}"
        assert not {"drive", "recover"} <= set(kinds), "two command the robot"
        return goal

    # The execution

    def localized(self):
        return self.times

    def run(self, *behaviors):
        execution = MoveBaseExecution(
            self, self, lambda: self.values, behaviors, self.log.append, self.localized
        )
        end = execution.run(self.cancellation)
        assert end.message
        last = self.counts["drive"] and f"value of drive {self.counts['drive'] - 1}"
        assert end.drive in (None, last)
        return end

    @property
    def begun(self):
        """The sub-goals that were begun, in their order."""
        return [name for name, _ in self.starts]


def plan(*args, **fields):
    return Scripted(*args, **fields)


drive = recover = plan
