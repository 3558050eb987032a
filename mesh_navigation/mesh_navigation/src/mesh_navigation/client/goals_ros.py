"""The goals of one client: sent, waited for, canceled together."""

import threading
import time
from contextlib import contextmanager
from typing import Any, Callable, Dict, Iterator, Optional, Sequence, Set

import rosgraph
import rospy
from actionlib_msgs.msg import GoalStatus
from mbf_msgs.msg import ExePathAction, GetPathAction, MoveBaseAction, RecoveryAction

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Deadline
from mesh_navigation.client.action_caller_ros import ActionCall, ActionCaller, OnFeedback
from mesh_navigation.client.navigation_result import (
    NavigationError,
    NavigationResult,
    canceled_outcome,
)

ACTIONS = {
    "get_path": GetPathAction,
    "exe_path": ExePathAction,
    "recovery": RecoveryAction,
    "move_base": MoveBaseAction,
}
POLL = 0.02  # s
PATIENT = 1.0  # s before somebody is told what is waited for
CANCEL_PATIENCE = 10.0  # s for the result of a goal that was canceled
END_PATIENCE = 2.0  # s, the same when this node ends


class Goals:
    """Sends goals to the actions of one server. From any thread."""

    def __init__(self, server: str, tell: Callable[[str], Any] = rospy.loginfo) -> None:
        """
        Args:
            server: name of its node.
            tell: gets a sentence when something takes a while.
        """
        self._server, self._tell = server, tell
        self._callers: Dict[str, ActionCaller] = {}
        self._lock = threading.Lock()
        self._jobs: Set[Cancellation] = set()
        self._ending = False
        rospy.on_shutdown(self._end)

    @contextmanager
    def job(self) -> Iterator[Cancellation]:
        """What belongs together, such as two goals one after the other, is canceled together."""
        cancellation = Cancellation()
        self._jobs.add(cancellation)
        try:
            if self._ending:
                raise rospy.ROSInterruptException("this node is shut down")
            yield cancellation
        finally:
            self._jobs.discard(cancellation)

    def cancel(self, reason: str) -> None:
        """Cancel all jobs that there are."""
        for job in list(self._jobs):
            job.cancel(reason)

    def run(
        self,
        job: Cancellation,
        action: str,
        goal: Any,
        deadline: Deadline,
        on_feedback: Optional[OnFeedback] = None,
    ) -> NavigationResult:
        """Send a goal and wait for its end; see `MeshNavigator` for what is raised."""
        self.wait_for_server(action, deadline, job)
        caller = self._caller(action)
        over = deadline.left == 0.0
        if over or job.canceled:
            reason = f"no result within {deadline.seconds:.1f} s" if over else job.reason
            return NavigationResult(canceled_outcome(action), reason, False, caller.result_type())
        return self.finish(self.begin(action, goal, on_feedback), deadline, job)

    def begin(self, action: str, goal: Any, on_feedback: Optional[OnFeedback] = None) -> ActionCall:
        """Send a goal to a server that is there; to be followed by `finish`."""
        call = self._caller(action).call(on_feedback)
        if self._ending:
            raise rospy.ROSInterruptException("this node is shut down")
        call.send(goal)
        return call

    def finish(self, call: ActionCall, deadline: Deadline, job: Cancellation) -> NavigationResult:
        """Wait for the end of a goal."""
        late = ""
        try:
            with job.calling(call.cancel):
                if not call.wait(deadline.left):
                    late = f"no result within {deadline.seconds:.1f} s: "
                    call.cancel()
                    if not call.wait(CANCEL_PATIENCE):
                        name = call.caller.name
                        raise NavigationError(f"{name}: {late}and no answer to the cancel")
        except BaseException as error:  # Ctrl+C, too: nothing goes on that nobody waits for
            call.cancel()
            if not isinstance(error, (NavigationError, rospy.ROSException)):
                _wait_for_ends([call])
            raise
        finally:
            call.caller.forget(call)
        return _result(call, late)

    def wait_for_server(
        self, action: str, deadline: Deadline, job: Optional[Cancellation] = None
    ) -> None:
        """Wait until the server is there, or the job is canceled; after a moment, say so."""
        caller = self._caller(action)
        moment = Deadline(PATIENT)
        while not (caller.has_server or job is not None and job.canceled):
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("this node is shut down")
            if deadline.left == 0.0:
                within = f"within {deadline.seconds:.1f} s"
                raise NavigationError(f"no action server {caller.name} {within}{_others()}")
            if moment.left == 0.0:
                moment = Deadline(None)
                self._tell(f"waiting for the action server {caller.name}{_others()}")
            time.sleep(POLL)

    def has_server(self, action: str) -> bool:
        """Whether a goal would be heard now."""
        return self._caller(action).has_server

    def _caller(self, action: str) -> ActionCaller:
        with self._lock:
            if action not in self._callers:
                name = f"{self._server}/{action}"
                self._callers[action] = ActionCaller(name, ACTIONS[action])
            return self._callers[action]

    def _end(self) -> None:
        self._ending = True
        self.cancel("the client is shut down")
        calls = [call for caller in list(self._callers.values()) for call in caller.calls]
        for call in calls:  # also those that belong to no job
            call.cancel()
        _wait_for_ends(calls)


def _result(call: ActionCall, late: str) -> NavigationResult:
    result = call.result
    succeeded = call.state == GoalStatus.SUCCEEDED
    outcome, message = result.outcome, result.message
    if outcome == 0 and not succeeded:
        # actionlib's servers answer so to a goal that is canceled before it comes
        action = call.caller.name.rpartition("/")[2]
        outcome, message = canceled_outcome(action), message or "canceled before it was begun"
    return NavigationResult(outcome, message if succeeded else late + message, succeeded, result)


def _wait_for_ends(calls: Sequence[ActionCall]) -> None:
    deadline = Deadline(END_PATIENCE)
    while deadline.left and not all(call.ended for call in calls):
        time.sleep(POLL)


def _others() -> str:
    """Which servers there are, for a message."""
    end = "/move_base/goal"
    try:
        subscribed = rosgraph.Master(rospy.get_name()).getSystemState()[1]
    except (rosgraph.MasterException, OSError):
        return ""
    found = sorted(topic[: -len(end)] for topic, _ in subscribed if topic.endswith(end))
    return f" (there are: {', '.join(found)})" if found else ""
