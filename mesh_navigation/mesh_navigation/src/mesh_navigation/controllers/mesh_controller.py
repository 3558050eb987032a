"""The controller of this package: follows the field or the path of its own plan."""

import math
from typing import Any, List, Mapping, NamedTuple, Optional, Sequence

import numpy as np

from mesh_map.base.parameter import Parameter
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.map.mesh_map import MeshMap

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import vector_text
from mesh_navigation.base.robot import STOP, RobotState, Velocity
from mesh_navigation.controllers.carrot import find_carrot, heading_error
from mesh_navigation.controllers.local_costs import LocalCosts
from mesh_navigation.controllers.guide import Guide
from mesh_navigation.controllers.sight import Sight
from mesh_navigation.controllers.stuck_watch import StuckWatch
from mesh_navigation.controllers.surface_pose import MAX_STEPS, Locator, SurfacePose
from mesh_navigation.controllers.sweep import Sweep
from mesh_navigation.controllers.steering import (
    CLEARANCE,
    Ahead,
    approached,
    free_turn,
    on_free_ground,
    speed_before_bends,
    steer,
    stopping_distance,
    turning_speed,
)
from mesh_navigation.plugins.controller import (
    Command,
    ControlFailure,
    ControllerPlan,
    MeshController as Controller,
)

FIELD, PATH = "field", "path"

PARAMETERS = (
    Parameter("max_lin_velocity", 1.0, 0.0, 5.0, "fastest (m/s)"),
    Parameter("max_ang_velocity", 0.5, 0.0, 2.0, "fastest turn, to either side (rad/s)"),
    Parameter("max_lin_acceleration", 1.0, 0.05, 20.0, "to drive and to brake (m/s^2)"),
    Parameter("max_ang_acceleration", 2.0, 0.05, 50.0, "of turns (rad/s^2)"),
    Parameter("min_lin_velocity", 0.05, 0.0, 1.0, "slowest on arrival (m/s)"),
    Parameter("arrival_fading", 0.5, 0.0, 5.0, "slows down over this way to the goal (m)"),
    Parameter("ang_vel_factor", 1.0, 0.1, 10.0, "multiplies turns, within their limit"),
    Parameter("lin_vel_factor", 1.0, 0.1, 10.0, "multiplies speeds, within their limit"),
    Parameter("max_angle", 20.0, 1.0, 180.0, "to the carrot; beyond, turns on the spot (deg)"),
    Parameter("lookahead_distance", 0.6, 0.05, 5.0, "how far ahead it looks (m)"),
    Parameter("blocked_distance", 0.3, 0.0, 5.0, "stops this far before blocked surface (m)"),
    Parameter("side_clearance", 0.1, 0.0, 1.0, "room beside it, where the plan has it (m)"),
    Parameter("cost_limit", 1.0, 0.0, 10.0, "highest cost of ground that may be entered"),
    Parameter("max_path_distance", 1.0, 0.05, 10.0, "from the path that it follows (m)"),
    Parameter("max_search_radius", 0.4, 0.01, 2.0, "around where it was, for the surface (m)"),
    Parameter("max_search_distance", 0.4, 0.01, 2.0, "from the surface, still on the map (m)"),
    Parameter("turn_to_goal_heading", True, description="turns to the goal's heading at the end"),
    Parameter(
        "stuck_timeout", 4.0, 0.0, 60.0, "told to move, but not moving (s), 0: not looked at"
    ),
    Parameter("follow", FIELD, description="of the plan: field or path", choices=(FIELD, PATH)),
)


FIRST_PERIOD = 0.05  # s, until the period of the cycles is known
_PERIODS = 0.005, 1.0  # s that a period is taken for, whatever the clock says
_NOBODY_ASKED = 2.0  # s without a cycle, after which the robot stands
_NEAR = 0.02  # m before where it has to stop, at which it stands
_STILL = 1e-4  # m/s, rad/s; what is slower does not get the robot on
_WELL_HEADED = 0.25
_LOOP = 0.1  # m; a path that leads farther away from the goal than that is a loop
_OUT_OF_NARROW = 0.2  # m from where there is too little room beside obstacles
_TURN_ROUND = math.radians(170)  # beyond this, left and right are as good


class _Attempt(NamedTuple):
    """To get on."""

    spare: float
    """Share of the room beside obstacles that is kept."""
    reach: float
    """Share of the way ahead in which the carrot is."""


# Straight over bumps is not quite where an arc leads: where it would lead too near to obstacles,
# one to a nearer place of the way, beside them, may not.
_ATTEMPTS = (_Attempt(1.0, 1.0), _Attempt(0.0, 1.0), _Attempt(0.0, 0.5), _Attempt(0.0, 0.25))


class _Narrow(NamedTuple):
    """Where an attempt would not do."""

    position: np.ndarray
    least: int
    """The first attempt that may."""
    version: int
    """Of the costs."""


class MeshController(Controller):
    """Drives along the field of its plan, or along the path, to the goal and its heading.

    In each cycle it finds where the robot stands on the surface, the way from there, and the
    farthest point of it, up to lookahead_distance, to which a straight line over the surface
    crosses nothing blocked (the carrot), and drives an arc there. It slows down on arrival, before
    surface that is blocked by now, and where the arc would leave free ground; where it has stopped,
    it fails with BLOCKED_PATH. A robot that was pushed away goes on from where it is.
    """

    parameters = PARAMETERS

    current_angle: float = 0.0
    """From the robot's heading to where it shall look (rad), to the left positive."""

    def initialize(self, name: str, mesh_map: MeshMap, given: Mapping[str, Any] = {}) -> List[str]:
        complaints = super().initialize(name, mesh_map, given)
        mesh_map.spatial_index, mesh_map.geometry.walker  # now rather than in the first cycle
        FieldTracer.of(mesh_map.geometry)
        self._locator = Locator(mesh_map.geometry)
        self._guide: Optional[Guide] = None
        self._watch: Optional[StuckWatch] = None
        self._state: Optional[RobotState] = None
        self._surface_pose: Optional[SurfacePose] = None
        self._period = FIRST_PERIOD
        self._cycle: Optional[float] = None
        self._velocity = STOP
        self._remark = ""
        self._narrow: Optional[_Narrow] = None
        return complaints

    def prepare_plan(self, plan: ControllerPlan) -> Guide:
        values = self.values
        return Guide(
            self.map.geometry,
            plan,
            self.body.costs(self.map.planning_costs().costs),
            values["max_search_distance"],
            values["side_clearance"],
            values["cost_limit"],
        )

    def set_plan(self, plan: ControllerPlan) -> None:
        is_prepared = isinstance(plan.prepared, Guide)
        self._guide = plan.prepared if is_prepared else self.prepare_plan(plan)
        goal, heading = self._guide.goal, plan.goal.heading
        if self._watch is None:
            self._watch = StuckWatch()
        elif (
            math.dist(goal.position, self._goal.position) > _NEAR
            or heading @ self._goal_heading < 0.99
        ):
            self._watch.take_new_goal()  # all else stays: a newer plan sets no stuck robot free
            self._narrow = None
        self._goal, self._goal_heading = goal, heading
        self._is_turning = False
        self._tolerance = self._angle_tolerance = 0.0
        self._heading_error, self._had_to_turn = math.inf, False

    def forget_place(self) -> None:
        self._surface_pose = self._state = self._watch = self._narrow = self._cycle = None
        self._velocity = STOP

    def is_goal_reached(
        self, state: RobotState, dist_tolerance: float, angle_tolerance: float
    ) -> bool:
        values = self.values
        self._tolerance, self._angle_tolerance = dist_tolerance, angle_tolerance
        try:
            surface_pose = self._stand(state, values)
        except ControlFailure:  # compute_velocity tells
            return False
        if self._distance_to_goal(surface_pose) > dist_tolerance or self._has_path_ahead(
            surface_pose
        ):
            return False
        if values["turn_to_goal_heading"]:
            error = heading_error(surface_pose, self._goal_heading)
            if error is not None and not self._is_headed(abs(error), angle_tolerance):
                return False
        at_once = values["max_lin_acceleration"] * self._period
        if abs(self._velocity.x) > max(values["min_lin_velocity"], at_once):
            return False  # it stands sooner, and nearer to the goal, if it brakes
        return self._sees_goal(surface_pose, dist_tolerance)

    def _is_headed(self, error: float, tolerance: float) -> bool:
        """Whether the heading is met; a robot that had to turn for it goes on as long as it gets
        better, to `_WELL_HEADED` of the tolerance."""
        before, self._heading_error = self._heading_error, error
        if error > tolerance:
            self._had_to_turn = True
            return False
        return not (self._had_to_turn and _WELL_HEADED * tolerance < error < before)

    def compute_velocity(self, state: RobotState, cancellation: Cancellation) -> Command:
        try:
            return self._command(state, self.values)
        except BaseException:
            self._velocity = STOP  # which is what the robot gets now
            raise

    def _command(self, state: RobotState, values: Mapping[str, Any]) -> Command:
        if self._guide is None or self._watch is None:
            raise ControlFailure(ExePathOutcome.NOT_INITIALIZED, "there is no plan to follow")
        surface_pose = self._stand(state, values)
        self._take_period(state.time)
        self._watch.look(surface_pose)
        if self._watch.is_stuck(values["stuck_timeout"]):
            raise ControlFailure(ExePathOutcome.ROBOT_STUCK, self._stuck_text(surface_pose))
        distance = self._distance_to_goal(surface_pose)
        remark = ""
        if self._is_at_goal(surface_pose, distance):
            wanted = self._turn_to_goal(surface_pose, values)
        else:
            wanted, remark = self._drive(surface_pose, distance, values)
        velocity = self._accelerated(wanted, values)
        if all(max(abs(each.x), abs(each.yaw)) < _STILL for each in (wanted, velocity)):
            raise ControlFailure(ExePathOutcome.NO_VALID_CMD, _no_speed_text(distance, values))
        self._velocity = velocity
        self._watch.commanded(velocity, self._period)
        is_new = remark != self._remark
        self._remark = remark
        return Command(ExePathOutcome.SUCCESS, remark if is_new else "", velocity)

    # Where it is.

    def _stand(self, state: RobotState, values: Mapping[str, Any]) -> SurfacePose:
        """Where the robot stands in this cycle; found once."""
        if state is not self._state or self._surface_pose is None:
            distance, radius = values["max_search_distance"], values["max_search_radius"]
            hint = self._surface_pose
            if hint is None:
                hint = self._guide.hint(state.pose.position, distance + radius)
            self._surface_pose = self._locator.stand(state.pose, hint, distance, radius)
            self._state = state
        return self._surface_pose

    def _take_period(self, now: float) -> None:
        since = math.inf if self._cycle is None else now - self._cycle
        if 0.0 < since < _NOBODY_ASKED:
            self._period = min(max(since, _PERIODS[0]), _PERIODS[1])
        elif since:
            self._velocity = STOP  # nobody has asked for long, or time has jumped: it stands
        self._cycle = now

    def _distance_to_goal(self, surface_pose: SurfacePose) -> float:
        return math.dist(surface_pose.position, self._goal.position)

    def _sees_goal(self, surface_pose: SurfacePose, tolerance: float) -> bool:
        """Whether the goal is near over the surface, too, not only through a wall or a floor."""
        line = self.map.geometry.walker.line(
            start=surface_pose, target=self._goal.position, up=surface_pose.up, max_steps=MAX_STEPS
        )
        if math.dist(line.position, self._goal.position) <= tolerance / 2:
            return True
        nearest = self._guide.nearest(surface_pose.position, self.values["max_path_distance"])
        rest = self._guide.ahead(nearest, 3 * tolerance)
        return rest.arrives and rest.length <= 2 * tolerance

    def _is_at_goal(self, surface_pose: SurfacePose, distance: float) -> bool:
        """Whether only the heading is left: near to the goal, or within half of the tolerance and
        the goal is not ahead any more. Then it drives again only beyond the tolerance."""
        if distance > max(self._tolerance, 2 * _NEAR) or self._has_path_ahead(surface_pose):
            self._is_turning = False
        elif self._is_turning:
            # Narrower tolerances than that wait until it has turned.
            turns = self.values["turn_to_goal_heading"]
            error = heading_error(surface_pose, self._goal_heading) if turns else None
            has_turned = error is None or abs(error) <= self._angle_tolerance
            self._is_turning = distance <= self._tolerance or not has_turned
        elif distance <= min(_NEAR, self._tolerance / 4):
            self._is_turning = True
        elif distance <= self._tolerance / 2:
            direction = surface_pose.direction_to(tuple(self._goal.position))
            angle = 0.0 if direction is None else heading_error(surface_pose, np.array(direction))
            self._is_turning = angle is None or abs(angle) > math.radians(self.values["max_angle"])
        return self._is_turning

    def _has_path_ahead(self, surface_pose: SurfacePose) -> bool:
        """Whether it is beside the goal, but the path has still to be driven, as loops have."""
        values = self.values
        room = 2 * self._tolerance + _LOOP
        is_field = values["follow"] == FIELD
        return self._guide.has_path_ahead(surface_pose, is_field, room, values["max_path_distance"])

    # What to do.

    def _turn_to_goal(self, surface_pose: SurfacePose, values: Mapping[str, Any]) -> Velocity:
        error = heading_error(surface_pose, self._goal_heading)
        if error is None or not values["turn_to_goal_heading"]:
            error = 0.0
        self.current_angle = error = self._same_side(error)
        turn = Velocity(yaw=turning_speed(error, values, self._period))
        sight = self._sight(self._local_costs(surface_pose, 0.0, values), surface_pose)
        return free_turn(turn, sight, values, self._period)

    def _local_costs(
        self,
        surface_pose: SurfacePose,
        reach: float,
        values: Mapping[str, Any],
        lead: float = 0.0,
    ) -> LocalCosts:
        """Of this moment, with what is so near that it could be touched within a reach (m); lead:
        how far the plan leads out of closed ground (m)."""
        costs, goal = self.map.planning_costs().costs, self._goal
        clearance = values["side_clearance"]
        obstacles = self.body.obstacles(costs, surface_pose.position, reach + lead, clearance)
        if lead > 0.0:
            obstacles = obstacles.left_from(self._guide.start)
        return LocalCosts(
            self.map.geometry,
            costs,
            goal.face,
            goal.position,
            values["cost_limit"],
            obstacles,
            lead,
        )

    def _sight(self, local_costs: LocalCosts, surface_pose: SurfacePose) -> Sight:
        sweep = Sweep(self.body.shape, local_costs.obstacles)
        return Sight(self.map.geometry, local_costs, surface_pose, sweep)

    def _drive(self, surface_pose: SurfacePose, distance: float, values: Mapping[str, Any]) -> Any:
        brakes, lookahead = values["max_lin_acceleration"], values["lookahead_distance"]
        stopping = stopping_distance(self._velocity.x, brakes, 2 * self._period)
        gap = values["blocked_distance"]
        ahead = stopping + max(gap, lookahead / 2)
        horizon = max(lookahead, values["arrival_fading"], ahead) + CLEARANCE
        guidance = self._guide.guidance(
            surface_pose, values["follow"] == FIELD, horizon, values["max_path_distance"]
        )
        way = guidance.paths[0]
        local_costs = self._local_costs(surface_pose, horizon, values, guidance.lead)
        stop, reach = math.inf, lookahead
        blocked = local_costs.first_blocked(way.points, way.faces) if len(way.faces) else None
        if blocked is not None:
            # Bases follow a speed that falls with each command by half a period later.
            stop, reach = blocked - gap - self._velocity.x * self._period / 2, min(reach, blocked)
            if blocked - gap < _NEAR:
                raise ControlFailure(
                    ExePathOutcome.BLOCKED_PATH,
                    f"the way of the robot at {vector_text(surface_pose.position)} is blocked "
                    f"after {blocked:.2f} m, at {vector_text(way.at(blocked))}; it stops "
                    f"{gap:.2f} m before (blocked_distance)",
                )
        # Never nearer to obstacles than the side_clearance, but where the way itself is, or where
        # there is nothing else: straight over rough ground is not quite where an arc leads.
        keeps, room = local_costs.obstacles, values["side_clearance"]
        spare = float(keeps.distances(way.points).min()) - keeps.keep
        spare = min(max(spare, 0.0), room)
        for attempt in self._attempts(surface_pose, spare > 0.0):
            kept = keeps.keep + attempt.spare * spare
            sight = self._sight(local_costs.keeping(kept), surface_pose)
            try:
                carrot = find_carrot(sight, guidance.paths, attempt.reach * reach, room)
                self.current_angle = self._same_side(carrot.angle)
                # Only as far as that is looked ahead: no faster than it can stop there.
                near = carrot.is_near or attempt.reach < 1.0
                carrot = carrot._replace(angle=self.current_angle, is_near=near)
                goal = max(distance, way.length) if way.arrives else math.inf
                bends = speed_before_bends(way, surface_pose.up, stopping, values, self._period)
                steered = steer(carrot, Ahead(goal, stop, bends), values, self._period)
                wanted = on_free_ground(steered, sight, carrot, values, self._period)
            except ControlFailure:
                if attempt is _ATTEMPTS[-1]:
                    self._look_far_again()
                    raise
            else:
                if wanted.x > 0.0 or not steered.x > 0.0 or attempt.spare == 0.0:
                    break
            tried = _ATTEMPTS.index(attempt) + 1
            self._narrow = _Narrow(surface_pose.position, tried, self._costs_version())
        self._brake_hard(sight, wanted, values)
        return wanted, guidance.remark

    def _attempts(self, surface_pose: SurfacePose, is_spare: bool) -> Sequence["_Attempt"]:
        """Those that come into question. Near to where one would not do, it does not: with each of
        them the robot looks at another place, and would turn to and fro."""
        first = 0 if is_spare else 1
        if self._narrow is not None:
            if math.dist(self._narrow.position, surface_pose.position) < _OUT_OF_NARROW:
                first = max(first, self._narrow.least)
            else:
                self._narrow = None
        return _ATTEMPTS[first:]

    def _look_far_again(self) -> None:
        """Where nothing has been found, as soon as something else is on the map: what was in the
        way may have gone."""
        if self._narrow is not None and self._narrow.version != self._costs_version():
            self._narrow = None

    def _costs_version(self) -> int:
        return self.map.planning_costs().version

    def _same_side(self, angle: float) -> float:
        """The angle, or that the other way round where the robot turns that way already."""
        if abs(angle) > _TURN_ROUND and angle * self._velocity.yaw < 0.0:
            return angle - math.copysign(2 * math.pi, angle)
        return angle

    def _brake_hard(self, sight: Sight, wanted: Velocity, values: Mapping[str, Any]) -> None:
        """Where max_lin_acceleration does not stop it on free ground, it is the base that brakes,
        as well as it can."""
        slower = self._accelerated(wanted, values)
        if slower.x <= wanted.x + 1e-9 and not (sight.has_obstacles and slower.x > 0.0):
            return
        length = stopping_distance(slower.x, values["max_lin_acceleration"], self._period / 2)
        if sight.free_arc(slower.yaw / slower.x, max(length - _NEAR, 0.0)) is not None:
            self._velocity = self._velocity._replace(x=wanted.x)
            if sight.has_obstacles:
                self._velocity = wanted

    def _accelerated(self, wanted: Velocity, values: Mapping[str, Any]) -> Velocity:
        """What can be reached of a velocity within this cycle."""
        linear = values["max_lin_acceleration"] * self._period
        angular = values["max_ang_acceleration"] * self._period
        x = approached(wanted.x, self._velocity.x, linear)
        yaw = approached(wanted.yaw, self._velocity.yaw, angular)
        return Velocity(x=min(x, values["max_lin_velocity"]), yaw=yaw)

    def _stuck_text(self, surface_pose: SurfacePose) -> str:
        return f"the robot at {vector_text(surface_pose.position)} {self._watch.text()}"


def _no_speed_text(distance: float, values: Mapping[str, Any]) -> str:
    return (
        f"no speed is left to get on, {distance:.3f} m from the goal: max_lin_velocity is "
        f"{values['max_lin_velocity']:.2f} m/s, max_ang_velocity "
        f"{values['max_ang_velocity']:.2f} rad/s"
    )
