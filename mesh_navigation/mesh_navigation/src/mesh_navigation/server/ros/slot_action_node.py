"""What the actions of the server share: slots, cancels that count, and one answer to each goal."""

import itertools
import time
from enum import IntEnum
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple, Type

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus

from mesh_msgs.text import one_line

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import TAKEN_OVER, is_success
from mesh_navigation.move_base.sub_goals import Feedback, SubGoal
from mesh_navigation.plugins.plugin_list import PluginList
from mesh_navigation.server.map_gate import MapGate
from mesh_navigation.server.plan_store import PlanStore
from mesh_navigation.server.ros.action_server_node import ActionServer
from mesh_navigation.server.ros.localization_ros import Localization
from mesh_navigation.server.ros.robot_ros import RobotRos
from mesh_navigation.server.ros.transforms_ros import Transforms
from mesh_navigation.server.slots import ConcurrencySlots, SlotJob

_NUMBERS = itertools.count(1)


class Parts(NamedTuple):
    """What the actions of a server work with."""

    planners: PluginList
    """To choose from by name, as those below."""
    controllers: PluginList
    behaviors: PluginList
    gate: MapGate
    """Where the map comes from, and the plugins that are ready for it."""
    transforms: Transforms
    """For poses in other frames, and for the robot's."""
    localization: Localization
    """Without which the robot does not move."""
    robot: RobotRos
    """To be driven."""
    clock: Clock
    """By which it is driven."""
    values: Mapping[str, Any]
    """Of the server's parameters, always those of now."""
    plans: PlanStore
    """Gets each plan before the client has it; where the fields of paths are found."""


class RunningGoal:
    """A goal from when it is accepted to its answer, for the hooks of `SlotActionServer`.

    It has the methods of actionlib's handle that a hook needs. When another goal takes over what is
    running, it is that one from then on.
    """

    def __init__(self, handle: Any, name: str, local: Optional[SubGoal]) -> None:
        self.handle = handle
        self.name = name
        """Of the plugin."""
        self.cancellation = Cancellation()
        self.answered = False
        self.data: Any = None
        """For the hooks: what ``_execute`` leaves for ``_ended`` and ``_taken_over``."""
        self.local = local

    @property
    def key(self) -> str:
        """The goal's id."""
        return str(self.handle.get_goal_id().id)

    def get_goal(self) -> Any:
        """The goal itself."""
        return self.handle.get_goal()

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback, to who is in this process too; nothing after the answer."""
        local = self.local
        with self.handle.action_server.lock:
            if self.answered:
                return
            self.handle.publish_feedback(feedback)
        if local is not None and local.on_feedback is not None:
            local.on_feedback(feedback)


class SlotActionServer:
    """Serves one action: a thread per goal, one goal at a time per concurrency slot.

    The callbacks of the action only start and cancel threads, they never wait. Derived classes
    override the hooks, whose names begin with one underscore.
    """

    tells_of_sub_goals = True
    """Whether ends of move_base's sub-goals are logged (else for debugging only)."""

    def __init__(
        self, name: str, action: Type, result: Type, outcomes: Type[IntEnum], doing: str
    ) -> None:
        """
        Args:
            name: of the action, such as "~get_path".
            action, result: its types of mbf_msgs.
            outcomes: with CANCELED, INTERNAL_ERROR, and those of `_outcome`.
            doing: what the action does, as a noun for messages: "planning".
        """
        self.name = name.lstrip("~")
        self.outcomes = outcomes
        self.doing = doing
        self._result_type = result
        self._slots = ConcurrencySlots()
        self._running: Dict[str, RunningGoal] = {}  # by goal id; used under the server's lock
        self._in_slot: Dict[int, RunningGoal] = {}
        self._jobs: List[SlotJob] = []
        self._stopping = ""
        self._server = ActionServer(
            rospy.resolve_name(name), action, self._on_goal, self._on_cancel, False
        )
        # actionlib makes the result of a goal that is canceled before it comes; its outcome 0 would
        # say SUCCESS.
        self._server.ActionResultType = self._canceled_before_start

    # Hooks

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        """The name of the plugin for a goal; None and a sentence why not, to reject it."""
        raise NotImplementedError(f"{type(self).__name__} does not override _chosen()")

    def _rejected_result(self, goal: Any, why_not: str) -> Any:
        """The result of a goal that is rejected."""
        return self._result("INVALID_PLUGIN", why_not)

    def _taken_over(self, running: RunningGoal, handle: Any, name: str) -> bool:
        """Whether what runs in the slot goes on with a new goal instead of being replaced.

        Called in the callback, under the server's lock, with goals that are neither answered nor
        canceled: it must not wait. After True, ``running`` is the new goal, and the old one is
        answered with `_preempted_result`.
        """
        return False

    def _preempted_result(self, running: RunningGoal) -> Any:
        """The result of the old goal when another one takes over."""
        return self._result("CANCELED", TAKEN_OVER)

    def _execute(self, running: RunningGoal, name: str, cancellation: Cancellation) -> Any:
        """Do what the goal asks for, in the thread of the goal; returns the result.

        It has an outcome and a message; with CANCELED the goal is canceled, with an outcome of
        success it has succeeded, with all others it is aborted. Whatever is raised is answered with
        INTERNAL_ERROR. The cancellation may have come before.
        """
        raise NotImplementedError(f"{type(self).__name__} does not override _execute()")

    def _is_outdated(self, running: RunningGoal) -> bool:
        """Whether another goal took over after what the result is about: `_execute` again.

        Called under the server's lock, just before the answer.
        """
        return False

    def _other_result(self, running: RunningGoal, result: Any, outcome: str, message: str) -> Any:
        """The result of a goal that was canceled at the last moment, or when the server is shut
        down.

        Args:
            running: the goal.
            result: what it would have been.
            outcome: CANCELED or STOPPED.
            message: what to say instead.
        """
        result.outcome, result.message = self._outcome(outcome), message
        return result

    def _ended(self, running: RunningGoal, result: Any) -> None:
        """Called after the answer, in the thread of the goal."""

    def _outcome(self, name: str) -> int:
        """An outcome by name; besides those of the enum, INVALID_PLUGIN and STOPPED are needed."""
        return int(self.outcomes[name])

    # For the server

    def start(self) -> None:
        """Begin to accept goals."""
        self._server.start()

    def stop(self, reason: str) -> None:
        """Answer all goals with STOPPED; does not wait, see `join`."""
        with self._server.lock:
            self._stopping = reason
        self._jobs = self._slots.cancel_all(reason)

    def join(self, seconds: float) -> None:
        """After `stop`: wait until all goals are answered, but not longer than that."""
        end = time.monotonic() + seconds
        for job in self._jobs:
            job.join(max(0.0, end - time.monotonic()))

    @property
    def is_stopping(self) -> bool:
        """Whether the server is shut down: topics may close at any moment."""
        return bool(self._stopping)

    def send(
        self, goal: Any, on_feedback: Optional[Feedback] = None, owner: str = "local"
    ) -> SubGoal:
        """Send a goal from within this process: it runs, and is seen on topics, as all others do.

        Args:
            goal: the goal message.
            on_feedback: gets each feedback, in the thread of the goal: it must not block.
            owner: how the goal's id begins.
        """
        now = rospy.Time.now()
        goal_id = f"{owner}-{next(_NUMBERS)}-{now.to_sec():.3f}"
        local = SubGoal(goal_id, lambda reason: self._cancel(goal_id, reason), on_feedback)
        message = self._server.ActionGoal(goal_id=GoalID(id=goal_id, stamp=now), goal=goal)
        message.header.stamp = now
        with self._server.lock:
            if self._stopping:
                # The topics are closing; nobody but the sender would hear of this goal.
                local.finish(GoalStatus.ABORTED, self._result("STOPPED", self._stopping))
                return local
            self._server.local[goal_id] = local
            self._server.internal_goal_callback(message)
        return local

    # The callbacks of actionlib, under the server's lock

    def _on_goal(self, handle: Any) -> None:
        goal = handle.get_goal()
        try:
            name, why_not = self._chosen(goal)
        except Exception as error:  # An exception in here would leave the goal without an answer.
            name, why_not = None, one_line(f"{type(error).__name__}: {error}")
        if name is None:
            handle.set_rejected(self._rejected_result(goal, why_not), why_not)
            rospy.logwarn("%s: %s", self.name, why_not)
            return
        if self._stopping:
            handle.set_accepted()
            handle.set_aborted(self._result("STOPPED", self._stopping), self._stopping)
            return
        slot = int(getattr(goal, "concurrency_slot", 0))
        if self._was_taken_over(slot, handle, name):
            return
        handle.set_accepted()
        local = self._server.local.get(handle.get_goal_id().id)
        running = RunningGoal(handle, name, local)
        self._running[running.key] = self._in_slot[slot] = running
        job = self._slots.start(slot, lambda cancellation: self._run(running, slot, cancellation))
        running.cancellation = job.cancellation

    def _was_taken_over(self, slot: int, handle: Any, name: str) -> bool:
        running = self._in_slot.get(slot)
        if running is None or running.answered or running.cancellation.canceled:
            return False
        if not self._taken_over(running, handle, name):
            return False
        old, result = running.handle, self._preempted_result(running)
        self._running.pop(running.key, None)
        handle.set_accepted()
        running.handle, running.name = handle, name
        running.local = self._server.local.get(running.key)
        self._running[running.key] = running
        old.set_canceled(result, result.message)
        return True

    def _on_cancel(self, handle: Any) -> None:
        self._cancel_running(handle.get_goal_id().id, "a client canceled the goal")

    # In other threads

    def _cancel(self, goal_id: str, reason: str) -> None:
        with self._server.lock:
            self._cancel_running(goal_id, reason)
            self._server.internal_cancel_callback(GoalID(id=goal_id))

    def _cancel_running(self, goal_id: str, reason: str) -> None:
        running = self._running.get(goal_id)
        if running is not None:
            running.cancellation.cancel(reason)

    def _run(self, running: RunningGoal, slot: int, cancellation: Cancellation) -> None:
        try:
            answer = None
            while answer is None:
                result = self._executed(running, cancellation)
                answer = self._answer(running, slot, result, cancellation)
            self._ended(running, answer)
        except rospy.ROSException:
            # A shutdown closes topics at any moment, and before rospy.is_shutdown() says so.
            if not self._stopping:
                raise
        except Exception as error:  # The goal is answered; what comes after it ends no thread.
            if not self._stopping:
                rospy.logerr("%s: after the answer: %s: %s", self.name, type(error).__name__, error)
        finally:
            running.data = None

    def _executed(self, running: RunningGoal, cancellation: Cancellation) -> Any:
        try:
            result = self._execute(running, running.name, cancellation)
            if not isinstance(result, self._result_type):
                raise TypeError(f"the result is a {type(result).__name__}")
            return result
        except (Exception, SystemExit) as error:  # A goal must get its answer, whatever is wrong.
            text = one_line(f"{type(error).__name__}: {error}")
            if not self._stopping:
                rospy.logerr("%s: %s", self.name, text)
            return self._result("INTERNAL_ERROR", text)

    def _answer(
        self, running: RunningGoal, slot: int, result: Any, cancellation: Cancellation
    ) -> Any:
        """Send the one answer and return it; None if the result is about a goal of before."""
        # Cancel requests are handled under this lock: one that came before the answer is honored.
        with self._server.lock:
            canceled = self._outcome("CANCELED")
            if not (self._stopping or cancellation.canceled) and self._is_outdated(running):
                return None
            if self._stopping:
                result = self._other_result(running, result, "STOPPED", self._stopping)
                finish = running.handle.set_aborted
            elif cancellation.canceled or result.outcome == canceled:
                if result.outcome != canceled or not result.message:
                    message = f"{self.doing} stopped: {cancellation.reason}"
                    result = self._other_result(running, result, "CANCELED", message)
                finish = running.handle.set_canceled
            elif is_success(result.outcome):
                finish = running.handle.set_succeeded
            else:
                finish = running.handle.set_aborted
            result.message = one_line(result.message)  # What is no Unicode cannot be sent.
            running.answered = True
            self._running.pop(running.key, None)
            if self._in_slot.get(slot) is running:
                del self._in_slot[slot]
            finish(result, result.message)
        log = rospy.loginfo if is_success(result.outcome) else rospy.logwarn
        if running.local is not None and not self.tells_of_sub_goals:
            log = rospy.logdebug
        log("%s: outcome %d, %s", self.name, result.outcome, result.message)
        return result

    def _result(self, outcome: str, message: str) -> Any:
        """A result with nothing but these two."""
        return self._result_type(outcome=self._outcome(outcome), message=message)

    def _canceled_before_start(self) -> Any:
        return self._result("CANCELED", f"canceled before {self.doing} started")
