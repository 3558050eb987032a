"""The action get_path."""

from typing import Any, Callable, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import GetPathAction, GetPathResult
from nav_msgs.msg import Path

from mesh_navigation.base.cancellation import Cancellation, any_of
from mesh_navigation.base.messages import path_message
from mesh_navigation.base.outcomes import GetPathOutcome, NotReady
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.plan_execution import PlanExecution
from mesh_navigation.move_base.sub_goals import PlanAnswer
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult
from mesh_navigation.server.map_gate import Ready
from mesh_navigation.server.ros.plan_topics_ros import Plan
from mesh_navigation.server.ros.slot_action_node import Parts, RunningGoal, SlotActionServer

Ends = Tuple[Pose, Pose]


class GetPathServer(SlotActionServer):
    """Serves ``~get_path``."""

    tells_of_sub_goals = False  # move_base says what fails; while it drives, plans come often.

    def __init__(self, parts: Parts, show: Callable[[Plan], None]) -> None:
        """
        Args:
            parts: what it works with.
            show: called with what came of each goal, after the client has its answer.
        """
        super().__init__("~get_path", GetPathAction, GetPathResult, GetPathOutcome, "planning")
        self._parts = parts
        self._show = show
        self._current_goal = rospy.Publisher("~current_goal", PoseStamped, queue_size=1)
        self._paths = {
            name: rospy.Publisher(f"~{name}/path", Path, queue_size=1, latch=True)
            for name in parts.planners.names
        }

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        planners = self._parts.planners
        return planners.choose(goal.planner), planners.why_not(goal.planner)

    def _execute(self, running: RunningGoal, name: str, cancellation: Cancellation) -> Any:
        goal = running.get_goal()
        ready, ends = None, None
        try:
            self._current_goal.publish(goal.target_pose)
            if not goal.use_start_pose:
                frame = self._parts.gate.wait(cancellation).map.frame_id
                self._parts.transforms.wait_until_localized(frame, cancellation)
            patience = self._parts.values["planner_patience"]
            ready = self._parts.gate.wait_for_data(cancellation, patience, "planner_patience")
            planner = ready.planners[name]
            ends = self._ends(goal, ready.map.frame_id, cancellation)
            result = self._plan(ready, planner, ends, goal.tolerance, cancellation)
        except NotReady as error:
            result = PlanResult(self._outcome(error.kind), error.message)
        frame = ready.map.frame_id if ready else ""
        path = path_message(result.poses, frame, rospy.Time.now())
        if ready:
            running.data = Plan(result, ready.map, ends), path
            if result.succeeded:
                self._parts.plans.put(result.poses, result.plan_field)
                if not self._parts.gate.is_current(ready):
                    self._parts.plans.clear()  # Nobody finds a field of another map.
        answer = PlanAnswer(int(result.outcome), result.message, path, result.cost)
        answer.lasting = result.lasting
        return answer

    def _ends(self, goal: Any, frame: str, cancellation: Cancellation) -> Ends:
        transforms = self._parts.transforms
        if goal.use_start_pose:
            start = transforms.pose_in(frame, goal.start_pose, "start", cancellation)
        else:
            start = transforms.robot_pose(frame, cancellation)
        return start, transforms.pose_in(frame, goal.target_pose, "goal", cancellation)

    def _plan(
        self,
        ready: Ready,
        planner: MeshPlanner,
        ends: Ends,
        tolerance: float,
        cancellation: Cancellation,
    ) -> PlanResult:
        execution = PlanExecution(
            lambda attempt: planner.make_plan(*ends, tolerance, attempt),
            self._parts.values["planner_patience"],
            self._parts.values["planner_max_retries"],
            lambda: bool(ready.map.clearable_layers),
        )
        replaced = self._parts.gate.replaced(ready)
        with any_of(cancellation, replaced) as stop:
            result = execution.run(stop)
        # A plan on a map that is gone is none, however it ended.
        if replaced.canceled and not cancellation.canceled:
            message = f"planning stopped: {replaced.reason}"
            return PlanResult(GetPathOutcome.MAP_ERROR, message)
        return result

    def _other_result(self, running: RunningGoal, result: Any, outcome: str, message: str) -> Any:
        return self._result(outcome, message)

    def _ended(self, running: RunningGoal, result: Any) -> None:
        if running.data is None or self.is_stopping:
            return
        plan, path = running.data
        self._paths[running.name].publish(path)
        try:
            self._show(plan)
        except Exception as error:  # The goal is answered; a plugin's odd array ends no thread.
            if not self.is_stopping:
                text = "get_path: the plan of %s cannot be shown: %s"
                rospy.logerr(text, running.name, error)
