"""The action get_path."""

import threading
import time
from typing import Any, Callable, Dict, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import GetPathAction, GetPathResult
from nav_msgs.msg import Path

from mesh_map.mesh_map import MeshMap

from mesh_navigation.action_server_node import ActionServer
from mesh_navigation.cancellation import Cancellation
from mesh_navigation.map_gate import MapGate
from mesh_navigation.messages import path_message
from mesh_navigation.outcomes import GetPathOutcome
from mesh_navigation.plan_execution import PlanExecution
from mesh_navigation.planner import PlanFailure, PlanResult
from mesh_navigation.planner_list import PlannerList
from mesh_navigation.pose import Pose
from mesh_navigation.ros import Transforms
from mesh_navigation.slots import ConcurrencySlots, Job

SHUT_DOWN = "the server is shut down"

Ends = Tuple[Pose, Pose]
Show = Callable[[PlanResult, MeshMap, Optional[Ends]], None]


def _canceled_before_start() -> GetPathResult:
    message = "canceled before planning started"
    return GetPathResult(outcome=GetPathOutcome.CANCELED, message=message)


class GetPathServer:
    """Serves ``~get_path``: one thread per goal, one goal at a time per concurrency slot.

    The callbacks of the action only start and cancel threads, they never wait.
    """

    def __init__(
        self,
        planners: PlannerList,
        gate: MapGate,
        transforms: Transforms,
        values: Dict[str, Any],
        show: Show,
    ) -> None:
        """
        Args:
            planners: to choose from by name.
            gate: where the map comes from.
            transforms: for poses in other frames and the robot's.
            values: of the parameters planner_patience, planner_max_retries and robot_frame.
            show: called with each plan's result, after the client has its answer; with the map, and
                with start and goal in its frame, None if these are not known.
        """
        self._planners = planners
        self._gate = gate
        self._transforms = transforms
        self._values = values
        self._show = show
        self._slots = ConcurrencySlots()
        self._jobs: Dict[str, Job] = {}
        self._jobs_lock = threading.Lock()
        self._stopping = False
        self._current_goal = rospy.Publisher("~current_goal", PoseStamped, queue_size=1)
        self._paths = {
            name: rospy.Publisher(f"~{name}/path", Path, queue_size=1, latch=True)
            for name in planners.names
        }
        self._server = ActionServer(
            rospy.resolve_name("~get_path"), GetPathAction, self._on_goal, self._on_cancel, False
        )
        # actionlib makes the result of a goal that is canceled before it comes; its outcome 0 would
        # say SUCCESS.
        self._server.ActionResultType = _canceled_before_start

    def start(self) -> None:
        """Begin to accept goals."""
        self._server.start()

    def stop(self) -> None:
        """Answer all goals with STOPPED; returns after a second at most."""
        self._stopping = True
        end = time.monotonic() + 1.0
        for job in self._slots.cancel_all(SHUT_DOWN):
            job.join(max(0.0, end - time.monotonic()))

    def _on_goal(self, handle: Any) -> None:
        goal = handle.get_goal()
        name = self._planners.choose(goal.planner)
        if name is None:
            known = ", ".join(self._planners.names) or "none could be loaded"
            message = f"there is no planner '{goal.planner}'; known: {known}"
            result = GetPathResult(outcome=GetPathOutcome.INVALID_PLUGIN, message=message)
            handle.set_rejected(result, message)
            rospy.logwarn("get_path: %s", message)
            return
        handle.set_accepted()
        key = handle.get_goal_id().id

        def run(cancellation: Cancellation) -> None:
            try:
                self._execute(handle, name, cancellation)
            except rospy.ROSException:
                # A shutdown closes topics at any moment, and before rospy.is_shutdown() says so.
                if not self._stopping:
                    raise
            finally:
                with self._jobs_lock:
                    self._jobs.pop(key, None)

        with self._jobs_lock:
            self._jobs[key] = self._slots.start(goal.concurrency_slot, run)

    def _on_cancel(self, handle: Any) -> None:
        with self._jobs_lock:
            job = self._jobs.get(handle.get_goal_id().id)
        if job is not None:
            job.cancellation.cancel("a client canceled the goal")

    def _execute(self, handle: Any, name: str, cancellation: Cancellation) -> None:
        goal = handle.get_goal()
        mesh_map, ends = None, None
        try:
            self._current_goal.publish(goal.target_pose)
            mesh_map = self._gate.wait_for_map(cancellation)
            fault = self._planners.fault(name)
            if fault:
                raise PlanFailure(GetPathOutcome.NOT_INITIALIZED, fault)
            ends = self._ends(goal, mesh_map.frame_id, cancellation)
            result = self._plan(name, ends, goal.tolerance, cancellation)
        except PlanFailure as failure:
            result = failure.as_result()
        except Exception as error:  # A goal must get its answer, whatever is wrong in here.
            rospy.logerr("get_path: %s: %s", type(error).__name__, error)
            result = PlanResult(GetPathOutcome.INTERNAL_ERROR, f"{type(error).__name__}: {error}")
        path = path_message(result.poses, mesh_map.frame_id if mesh_map else "", rospy.Time.now())
        self._answer(handle, result, path, cancellation)
        if mesh_map is not None and not self._stopping:
            self._paths[name].publish(path)
            try:
                self._show(result, mesh_map, ends)
            except Exception as error:  # The goal is answered; a plugin's odd array ends no thread.
                if not self._stopping:
                    rospy.logerr("get_path: the plan of %s cannot be shown: %s", name, error)

    def _ends(self, goal: Any, frame: str, cancellation: Cancellation) -> Ends:
        if goal.use_start_pose:
            start = self._transforms.pose_in(frame, goal.start_pose, "start", cancellation)
        else:
            robot_frame = self._values["robot_frame"]
            start = self._transforms.robot_pose(frame, robot_frame, cancellation)
        return start, self._transforms.pose_in(frame, goal.target_pose, "goal", cancellation)

    def _plan(
        self, name: str, ends: Ends, tolerance: float, cancellation: Cancellation
    ) -> PlanResult:
        planner = self._planners[name]
        execution = PlanExecution(
            lambda attempt: planner.make_plan(*ends, tolerance, attempt),
            self._values["planner_patience"],
            self._values["planner_max_retries"],
        )
        return execution.run(cancellation)

    def _answer(
        self, handle: Any, result: PlanResult, path: Path, cancellation: Cancellation
    ) -> None:
        # Cancel requests are handled under this lock: one that came before the answer is honored.
        with self._server.lock:
            if self._stopping:
                answer = GetPathResult(GetPathOutcome.STOPPED, SHUT_DOWN, Path(), 0.0)
                handle.set_aborted(answer, answer.message)
            elif cancellation.canceled or result.outcome == GetPathOutcome.CANCELED:
                message = result.message if result.outcome == GetPathOutcome.CANCELED else ""
                message = message or f"planning stopped: {cancellation.reason}"
                answer = GetPathResult(GetPathOutcome.CANCELED, message, Path(), 0.0)
                handle.set_canceled(answer, answer.message)
            else:
                answer = GetPathResult(int(result.outcome), result.message, path, result.cost)
                finish = handle.set_succeeded if result.succeeded else handle.set_aborted
                finish(answer, answer.message)
        log = rospy.loginfo if answer.outcome < 10 else rospy.logwarn
        log("get_path: outcome %d, %s", answer.outcome, answer.message)
