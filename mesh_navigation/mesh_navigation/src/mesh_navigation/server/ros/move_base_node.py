"""The action move_base."""

from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import MoveBaseAction, MoveBaseFeedback, MoveBaseResult

from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation, any_of
from mesh_navigation.base.messages import float32, pose_message
from mesh_navigation.base.outcomes import (
    ExePathOutcome,
    GetPathOutcome,
    MoveBaseOutcome,
    NotReady,
    RecoveryOutcome,
)
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.progress_watch import angle_between
from mesh_navigation.move_base.move_base_execution import MoveBaseExecution
from mesh_navigation.move_base.sub_goals import GoalEnd, SubActions
from mesh_navigation.plugins.planner import PlanFailure
from mesh_navigation.server.ros.slot_action_node import Parts, RunningGoal, SlotActionServer
from mesh_navigation.surface.face_points import find_face_point

NAME = "move_base"


class _Ends(NamedTuple):
    """Where a goal begins and shall end, in the map's frame."""

    map: MeshMap
    start: Pose
    target: Pose


class MoveBaseServer(SlotActionServer):
    """Serves ``~move_base``: one goal at a time, a newer one replaces it."""

    def __init__(self, parts: Parts, *servers: SlotActionServer) -> None:
        """
        Args:
            parts: what it works with.
            servers: get_path, exe_path and recovery, which get the sub-goals from within this
                process.
        """
        super().__init__(
            "~move_base", MoveBaseAction, MoveBaseResult, MoveBaseOutcome, "going to the goal"
        )
        self._parts = parts
        self._servers = servers

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        unknown = self._unknown(goal)
        return (None, unknown[1]) if unknown else (NAME, "")

    def _rejected_result(self, goal: Any, why_not: str) -> Any:
        unknown = self._unknown(goal)
        outcome = unknown[0] if unknown else MoveBaseOutcome.INTERNAL_ERROR
        return MoveBaseResult(outcome=int(outcome), message=why_not)

    def _unknown(self, goal: Any) -> Optional[Tuple[int, str]]:
        """The first plugin named that there is not: the outcome of its action, and a sentence."""
        parts, invalid_behavior = self._parts, RecoveryOutcome.INVALID_PLUGIN
        named = [(parts.planners, goal.planner, GetPathOutcome.INVALID_PLUGIN)]
        named += [(parts.controllers, goal.controller, ExePathOutcome.INVALID_PLUGIN)]
        named += [(parts.behaviors, name, invalid_behavior) for name in goal.recovery_behaviors]
        for plugins, name, outcome in named:
            if plugins.choose(name) is None:
                return outcome, plugins.why_not(name)
        return None

    def _outcome(self, name: str) -> int:
        if name not in MoveBaseOutcome.__members__:  # Its parts have one for this.
            return int(GetPathOutcome[name])
        return super()._outcome(name)

    def _other_result(self, running: RunningGoal, result: Any, outcome: str, message: str) -> Any:
        if outcome == "STOPPED" and running.data is None:
            return self._result(outcome, message)
        result = super()._other_result(running, result, outcome, message)
        if outcome == "STOPPED" and running.data.drive is not None:
            result.outcome = int(ExePathOutcome.STOPPED)
        return result

    def _execute(self, running: RunningGoal, name: str, cancellation: Cancellation) -> Any:
        goal = running.get_goal()
        try:
            frame = self._parts.gate.wait(cancellation).map.frame_id
            self._parts.transforms.wait_until_localized(frame, cancellation)
            patience = self._parts.values["planner_patience"]
            ready = self._parts.gate.wait_for_data(cancellation, patience, "planner_patience")
            ends = self._ends(goal, ready.map, cancellation)
        except NotReady as error:
            outcome, unknown = self._outcome(error.kind), float("nan")
            return MoveBaseResult(outcome, error.message, unknown, unknown, PoseStamped())
        try:  # What is off the map stays there, whatever recovery behaviors do.
            find_face_point(ends.map, ends.target.position, "goal", GetPathOutcome.INVALID_GOAL)
        except PlanFailure as failure:
            return self._filled(GoalEnd(failure.outcome, failure.message), ends)
        actions = SubActions(
            *self._servers,
            pose_message(ends.target, ends.map.frame_id),
            goal.planner,
            goal.controller,
            lambda feedback: _publish(running, feedback),
        )
        execution = MoveBaseExecution(
            actions,
            self._parts.clock,
            lambda: self._parts.values,
            self._behaviors(goal),
            self._log,
            self._parts.localization.times,
        )
        replaced = self._parts.gate.replaced(ready)
        with any_of(cancellation, replaced) as stop:
            end = execution.run(stop)
        # What was asked for is the way on the map of before.
        if replaced.canceled and not (cancellation.canceled or end.succeeded):
            outcome = ExePathOutcome.MAP_ERROR if end.drive else GetPathOutcome.MAP_ERROR
            message = f"going to the goal stopped: {replaced.reason}"
            end = end._replace(outcome=int(outcome), message=message)
        running.data = end
        return self._filled(end, ends)

    def _behaviors(self, goal: Any) -> List[str]:
        behaviors = self._parts.behaviors
        chosen = map(behaviors.choose, goal.recovery_behaviors)
        return [name for name in chosen if name] or behaviors.names

    def _ends(self, goal: Any, mesh_map: MeshMap, cancellation: Cancellation) -> _Ends:
        frame = mesh_map.frame_id
        start = self._robot_pose(frame, cancellation)
        # Once, at the beginning: a goal in a frame that moves, as that of the robot does, would be
        # another one for each plan.
        target = self._parts.transforms.pose_in(frame, goal.target_pose, "goal", cancellation)
        fault = target.fault()
        if fault:
            raise NotReady("INVALID_GOAL", f"goal: {fault}")
        return _Ends(mesh_map, start, target.normalized())

    def _robot_pose(self, frame: str, cancellation: Cancellation) -> Pose:
        return self._parts.transforms.robot_pose(frame, cancellation)

    def _filled(self, end: GoalEnd, ends: _Ends) -> MoveBaseResult:
        result = MoveBaseResult(outcome=int(end.outcome), message=end.message)
        drive = end.drive
        if drive is not None and drive.final_pose.header.frame_id:
            result.final_pose = drive.final_pose
            result.dist_to_goal, result.angle_to_goal = drive.dist_to_goal, drive.angle_to_goal
            return result
        at_once = Cancellation()
        at_once.cancel("the answer does not wait for TF")
        try:
            pose = self._robot_pose(ends.map.frame_id, at_once)
        except NotReady:
            pose = ends.start  # the last that is known
        result.final_pose = pose_message(pose, ends.map.frame_id, rospy.Time.now())
        result.dist_to_goal = float32(np.linalg.norm(pose.position - ends.target.position))
        result.angle_to_goal = angle_between(pose, ends.target)
        return result

    def _log(self, message: str) -> None:
        if not self.is_stopping:
            rospy.logwarn("%s: %s", self.name, message)


def _publish(running: RunningGoal, feedback: Any) -> None:
    running.publish_feedback(
        MoveBaseFeedback(*(getattr(feedback, field) for field in MoveBaseFeedback.__slots__))
    )
