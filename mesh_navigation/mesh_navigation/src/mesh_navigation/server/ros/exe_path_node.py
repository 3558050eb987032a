"""The action exe_path."""

import copy
import math
import threading
import time
from typing import Any, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from mbf_msgs.msg import ExePathAction, ExePathFeedback, ExePathResult
from std_msgs.msg import Float32, Header

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.messages import float32, pose_message, poses_from_path, twist_message
from mesh_navigation.base.outcomes import TAKEN_OVER, ExePathOutcome, NotReady
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import Robot
from mesh_navigation.execution.path_check import normalized_path, path_fault, transformed_path
from mesh_navigation.execution.path_execution import (
    Cycle,
    ExecutionResult,
    Tolerances,
    control_period,
)
from mesh_navigation.execution.supervised_execution import SupervisedExecution
from mesh_navigation.plugins.controller import ControllerPlan, MeshController
from mesh_navigation.server.drives import Drives
from mesh_navigation.server.late_cycles import LateCycles
from mesh_navigation.server.map_gate import Ready
from mesh_navigation.server.ros.slot_action_node import Parts, RunningGoal, SlotActionServer


class _RunningDrive:
    """What is done for a goal, and for those that take over."""

    def __init__(self, name: str, key: str) -> None:
        self.name = name
        """Of the controller."""
        self.followed = key
        """Id of the goal whose path the controller has."""
        self.newest = key
        """Id of the goal whose path it shall have."""
        self.refusal: Optional[NotReady] = None
        """Why the newest goal cannot be followed; the drive is ended for it."""
        self.over = False
        """Whether a refusal would come too late to be its end."""
        self.execution: Optional[SupervisedExecution] = None
        self.ready: Optional[Ready] = None
        self.cancellation = Cancellation()
        self.lock = threading.Lock()
        self.cycle: Optional[Cycle] = None
        """The last one in which the robot's pose was known."""


class ExePathServer(SlotActionServer):
    """Serves ``~exe_path``.

    A goal for the controller that is driving in the slot takes over: the robot goes on with the new
    path, without a stop.
    """

    tells_of_sub_goals = False  # move_base says itself how they end

    def __init__(self, parts: Parts) -> None:
        super().__init__("~exe_path", ExePathAction, ExePathResult, ExePathOutcome, "driving")
        self._parts = parts
        self._drives = Drives(parts.values["concurrent_drives"])
        self._current_goal = rospy.Publisher("~current_goal", PoseStamped, queue_size=1)
        self._angles, self._times = (
            {
                name: rospy.Publisher(f"~{name}/{topic}", Float32, queue_size=10)
                for name in parts.controllers.names
            }
            for topic in ("current_angle", "cycle_time")
        )

    def _chosen(self, goal: Any) -> Tuple[Optional[str], str]:
        controllers = self._parts.controllers
        return controllers.choose(goal.controller), controllers.why_not(goal.controller)

    def _execute(self, running: RunningGoal, name: str, cancellation: Cancellation) -> Any:
        with self._server.lock:  # No goal takes over while this looks for the newest one.
            goal = running.get_goal()
            drive = running.data = _RunningDrive(name, running.key)
        with cancellation.calling(lambda: drive.cancellation.cancel(cancellation.reason)):
            try:
                drive.ready = ready = self._ready(drive.cancellation)
                # What a goal changes in its controller is its own.
                controller = copy.copy(ready.controllers[name])
                self._parts.robot.frame = ready.map.frame_id
                plan, tolerances = self._prepared(goal, ready, drive.cancellation)
                with self._drives.running(
                    goal.concurrency_slot, cancellation
                ), self._parts.robot.driven(drive.cancellation, self._period) as robot:
                    result = self._drive(running, drive, robot, controller, plan, tolerances)
            except NotReady as refusal:
                return self._without_driving(refusal.kind, refusal.message)
        return self._result_of(result)

    def _ready(self, cancellation: Cancellation) -> Ready:
        """The map; where the robot is localized, with what sensors see."""
        if self._parts.localization.look().lost:
            return self._parts.gate.wait(cancellation)  # the drive waits, and says for what
        patience = self._parts.values["controller_patience"]
        return self._parts.gate.wait_for_data(cancellation, patience, "controller_patience")

    def _period(self) -> float:
        return control_period(self._parts.values)

    def _prepared(
        self, goal: Any, ready: Ready, cancellation: Cancellation
    ) -> Tuple[ControllerPlan, Tolerances]:
        """The path of a goal in the map's frame, with its field if that is known."""
        if goal.tolerance_from_action:
            tolerances = Tolerances(goal.dist_tolerance, goal.angle_tolerance)
        else:
            values = self._parts.values
            tolerances = Tolerances(values["dist_tolerance"], values["angle_tolerance"])
        poses, frames = poses_from_path(goal.path), [goal.path.header.frame_id]
        frames += [pose.header.frame_id for pose in goal.path.poses]
        fault = path_fault(poses, tolerances) or _fault_of_frames(frames)
        if fault:
            raise NotReady("INVALID_PATH", fault)
        frame = ready.map.frame_id
        source = next(filter(None, frames), "")
        if source.lstrip("/") == frame:
            field = self._parts.plans.find(poses)
            if field is not None and len(field.labels) != len(ready.map.vertices):
                field = None  # Of the map before.
            return ControllerPlan(normalized_path(poses), field), tolerances
        identity = pose_message(Pose.at((0.0, 0.0, 0.0)), source, goal.path.header.stamp)
        pose = self._parts.transforms.pose_in(frame, identity, "path", cancellation)
        return ControllerPlan(normalized_path(transformed_path(poses, pose))), tolerances

    def _drive(
        self,
        running: RunningGoal,
        drive: _RunningDrive,
        robot: Robot,
        controller: MeshController,
        plan: ControllerPlan,
        tolerances: Tolerances,
    ) -> ExecutionResult:
        ready, late = drive.ready, LateCycles()
        assert ready is not None

        def on_cycle(cycle: Cycle) -> None:
            if cycle.state is not None:
                drive.cycle = cycle
            running.publish_feedback(self._feedback(cycle))
            self._publish_figures(drive.name, controller, cycle)
            complaint = late.note(cycle.seconds, cycle.late, time.monotonic())
            if complaint:
                rospy.logwarn("exe_path: %s", complaint)

        execution = SupervisedExecution(
            robot,
            self._parts.clock,
            lambda: self._parts.values,
            on_cycle,
            lambda: self._parts.gate.fault(ready),
            lambda: ready.map.gap,
        )
        self._announce(plan, ready)
        drive.execution = execution
        result = execution.run(controller, plan, tolerances, drive.cancellation)
        complaint = late.last_words()
        if complaint:
            rospy.logwarn("exe_path: %s", complaint)
        with drive.lock:
            drive.over, refusal = True, drive.refusal
        if refusal is None:
            return result
        return result._replace(outcome=self._outcome(refusal.kind), message=refusal.message)

    # A goal that takes over

    def _taken_over(self, running: RunningGoal, handle: Any, name: str) -> bool:
        drive, goal = running.data, handle.get_goal()
        if drive is None or drive.execution is None:
            return False
        if goal.controller and name != drive.name:
            return False
        with drive.lock:  # Locked for moments only.
            if drive.refusal:
                return False
            drive.newest = handle.get_goal_id().id
        thread = threading.Thread(
            target=self._inject, args=(drive, goal, drive.newest), name="new plan", daemon=True
        )
        thread.start()
        return True

    def _inject(self, drive: _RunningDrive, goal: Any, key: str) -> None:
        """Give the controller another path; in a thread, since its frame may be waited for."""
        assert drive.execution is not None and drive.ready is not None
        try:
            plan, tolerances = self._prepared(goal, drive.ready, drive.cancellation)
        except NotReady as refusal:
            with drive.lock:
                if drive.newest == key and not drive.over:
                    drive.refusal, drive.followed = refusal, key
                    drive.cancellation.cancel(refusal.message)
            return
        plan = drive.execution.prepared(plan)
        with drive.lock:
            if drive.newest == key and drive.execution.replace(plan, tolerances):
                drive.followed = key
                self._announce(plan, drive.ready)

    def _is_outdated(self, running: RunningGoal) -> bool:
        return running.data is not None and running.data.followed != running.key

    def _preempted_result(self, running: RunningGoal) -> Any:
        cycle = running.data.cycle
        if cycle is None:
            return self._without_driving("CANCELED", TAKEN_OVER)
        result = ExecutionResult(
            ExePathOutcome.CANCELED,
            TAKEN_OVER,
            cycle.state.pose,
            cycle.dist_to_goal,
            cycle.angle_to_goal,
        )
        return self._result_of(result)

    # Messages

    def _announce(self, plan: ControllerPlan, ready: Ready) -> None:
        message = pose_message(plan.goal, ready.map.frame_id, rospy.Time.now())
        self._current_goal.publish(message)

    def _without_driving(self, outcome: str, message: str) -> ExePathResult:
        pose = self._pose_message(self._parts.robot.known_pose())
        return ExePathResult(self._outcome(outcome), message, pose, math.nan, math.nan)

    def _result_of(self, result: ExecutionResult) -> ExePathResult:
        return ExePathResult(
            int(result.outcome),
            result.message,
            self._pose_message(result.final_pose),
            float32(result.dist_to_goal),
            result.angle_to_goal,
        )

    def _feedback(self, cycle: Cycle) -> ExePathFeedback:
        feedback = ExePathFeedback(outcome=int(cycle.outcome), message=cycle.message)
        feedback.dist_to_goal = float32(cycle.dist_to_goal)
        feedback.angle_to_goal = cycle.angle_to_goal
        feedback.current_pose = self._pose_message(cycle.state.pose if cycle.state else None)
        velocity = feedback.last_cmd_vel
        velocity.header = Header(stamp=rospy.Time.now(), frame_id=self._parts.values["robot_frame"])
        velocity.twist = twist_message(cycle.velocity)
        return feedback

    def _pose_message(self, pose: Optional[Pose]) -> PoseStamped:
        """In the map's frame; without a pose one of zeros, without a frame."""
        if pose is None:
            return PoseStamped()
        return pose_message(pose, self._parts.robot.frame, rospy.Time.now())

    def _publish_figures(self, name: str, controller: MeshController, cycle: Cycle) -> None:
        angle = getattr(controller, "current_angle", None)
        if angle is not None:
            self._angles[name].publish(Float32(float(angle)))
        if self._times[name].get_num_connections():
            self._times[name].publish(Float32(cycle.seconds))


def _fault_of_frames(frames: Any) -> str:
    """What is wrong with the frames of a path and of its poses; empty ones count as the others."""
    given = next(filter(None, frames), "")
    for index, frame in enumerate(frames[1:]):
        if frame and frame.lstrip("/") != given.lstrip("/"):
            return f"pose {index} is in the frame '{frame}', the path in '{given}'"
    return ""
