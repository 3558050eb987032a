"""The action get_path."""

from typing import Any, Callable, Mapping, NamedTuple, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import GetPathAction, GetPathResult
from nav_msgs.msg import Path

from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import path_message
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.plan_execution import PlanExecution
from mesh_navigation.plugins.planner import MeshPlanner, PlanFailure, PlanResult
from mesh_navigation.plugins.plugin_list import PluginList
from mesh_navigation.server.map_gate import MapGate, MapNotReady, Ready
from mesh_navigation.server.plan_store import PlanStore
from mesh_navigation.server.ros.slot_action_node import SlotActionServer
from mesh_navigation.server.ros.transforms_ros import Transforms
from mesh_navigation.server.running_goal import RunningGoal

Ends = Tuple[Pose, Pose]


class Plan(NamedTuple):
    """What came of a goal, for those who show it."""

    result: PlanResult
    map: MeshMap
    ends: Optional[Ends]
    """Start and goal in the map's frame; None if these are not known."""


class GetPathServer(SlotActionServer):
    """Serves ``~get_path``."""

    tells_of_sub_goals = False  # move_base says what fails; while it drives, plans come often.

    def __init__(
        self,
        planners: PluginList,
        gate: MapGate,
        transforms: Transforms,
        values: Mapping[str, Any],
        plans: PlanStore,
        show: Callable[[Plan], None],
    ) -> None:
        """
        Args:
            planners: to choose from by name.
            gate: where the map and the planners come from.
            transforms: for poses in other frames and the robot's.
            values: of the parameters planner_patience, planner_max_retries and robot_frame.
            plans: gets each plan before the client has it.
            show: called with what came of each goal, after the client has its answer.
        """
        super().__init__("~get_path", GetPathAction, GetPathResult, GetPathOutcome, "planning")
        self._planners = planners
        self._gate = gate
        self._transforms = transforms
        self._values = values
        self._plans = plans
        self._show = show
        self._current_goal = rospy.Publisher("~current_goal", PoseStamped, queue_size=1)
        self._paths = {
            name: rospy.Publisher(f"~{name}/path", Path, queue_size=1, latch=True)
            for name in planners.names
        }

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        return self._planners.choose(goal.planner), self._planners.why_not(goal.planner)

    def _execute(self, running: RunningGoal, name: str, cancellation: Cancellation) -> Any:
        goal = running.get_goal()
        ready, ends = None, None
        try:
            self._current_goal.publish(goal.target_pose)
            ready = self._ready(cancellation)
            fault = ready.planners.fault(name)
            if fault:
                raise PlanFailure(GetPathOutcome.NOT_INITIALIZED, fault)
            ends = self._ends(goal, ready.map.frame_id, cancellation)
            result = self._plan(ready, ready.planners[name], ends, goal.tolerance, cancellation)
        except PlanFailure as failure:
            result = failure.as_result()
        frame = ready.map.frame_id if ready else ""
        path = path_message(result.poses, frame, rospy.Time.now())
        if ready:
            running.data = Plan(result, ready.map, ends), path
            if result.succeeded:
                self._plans.put(result.poses, result.plan_field)
                if not self._gate.is_current(ready):
                    self._plans.clear()  # Nobody finds a field of another map.
        return GetPathResult(int(result.outcome), result.message, path, result.cost)

    def _ready(self, cancellation: Cancellation) -> Ready:
        try:
            return self._gate.wait(cancellation)
        except MapNotReady as error:
            raise PlanFailure(GetPathOutcome[error.kind], error.message) from error

    def _ends(self, goal: Any, frame: str, cancellation: Cancellation) -> Ends:
        if goal.use_start_pose:
            start = self._transforms.pose_in(frame, goal.start_pose, "start", cancellation)
        else:
            robot_frame = self._values["robot_frame"]
            start = self._transforms.robot_pose(frame, robot_frame, cancellation)
        return start, self._transforms.pose_in(frame, goal.target_pose, "goal", cancellation)

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
            self._values["planner_patience"],
            self._values["planner_max_retries"],
        )
        planning, replaced = Cancellation(), self._gate.replaced(ready)
        with cancellation.calling(lambda: planning.cancel(cancellation.reason)):
            with replaced.calling(lambda: planning.cancel(replaced.reason)):
                result = execution.run(planning)
        # A plan on a map that is gone is none, however it ended.
        if replaced.canceled and not cancellation.canceled:
            message = f"planning stopped: {replaced.reason}"
            return PlanResult(GetPathOutcome.MAP_ERROR, message)
        return result

    def _canceled_result(self, running: RunningGoal, result: Any, message: str) -> Any:
        return self._result("CANCELED", message)

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
