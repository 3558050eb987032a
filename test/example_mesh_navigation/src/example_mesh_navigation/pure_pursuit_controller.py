"""Regulated pure pursuit over a surface."""

import math
from typing import Any, List, Mapping, Optional, Sequence

import numpy as np
from mesh_map.base.parameter import Parameter
from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import vector_text
from mesh_navigation.base.robot import STOP, RobotState, Velocity
from mesh_navigation.controllers.carrot import find_carrot, heading_error
from mesh_navigation.controllers.guide import Guidance, Guide
from mesh_navigation.controllers.local_costs import LocalCosts
from mesh_navigation.controllers.local_path import LocalPath
from mesh_navigation.controllers.sight import Sight
from mesh_navigation.controllers.steering import (
    approached,
    arc_to,
    braking_speed,
    free_turn,
    on_free_ground,
    stopping_distance,
    turning_speed,
)
from mesh_navigation.controllers.surface_pose import Locator, SurfacePose
from mesh_navigation.controllers.sweep import Sweep
from mesh_navigation.plugins.controller import (
    Command,
    ControlFailure,
    ControllerPlan,
    MeshController,
)

_NEAR = 0.02  # m before where it has to stop, at which it stands
_PERIOD = 0.05  # s, until the period of the cycles is known
_LONGEST = 1.0  # s without a cycle, after which the robot stands


class PurePursuitController(MeshController):
    """Drives along the poses of a plan, whatever planner it is of.

    In each cycle it finds where the robot stands, takes the farthest place of the path that it sees
    within a distance (the carrot), and drives the arc that leads there (Coulter, Implementation of
    the pure pursuit path tracking algorithm, 1992). Speed is regulated: by the acceleration that
    the arc makes to the side, by the goal, by what blocks the path, and so that the robot can stop
    on ground that was seen to be free. Where the carrot is far to the side, and for the goal's
    heading, it turns on the spot.
    """

    # What users may set; the functions of steering take their limits by the same names.
    parameters = (
        Parameter("max_lin_velocity", 0.8, 0.05, 5.0, "fastest (m/s)"),
        Parameter("max_ang_velocity", 0.8, 0.05, 5.0, "fastest turn, to either side (rad/s)"),
        Parameter("max_lin_acceleration", 1.0, 0.05, 20.0, "to drive and to brake (m/s^2)"),
        Parameter("max_ang_acceleration", 2.0, 0.05, 50.0, "of turns (rad/s^2)"),
        Parameter("max_lat_acceleration", 0.3, 0.01, 20.0, "to the side, in bends (m/s^2)"),
        Parameter("lookahead_distance", 0.6, 0.1, 5.0, "how far ahead it looks (m)"),
        Parameter("turn_angle", 0.8, 0.1, 1.5, "to the side; beyond, turns on the spot (rad)"),
        Parameter("blocked_distance", 0.3, 0.05, 5.0, "stops this far before blocked ground (m)"),
        Parameter("side_clearance", 0.1, 0.0, 1.0, "room beside it, where the path has it (m)"),
        Parameter("cost_limit", 1.0, 0.0, 10.0, "highest cost of ground that may be entered"),
        Parameter("max_path_distance", 1.0, 0.05, 10.0, "from the path that it follows (m)"),
        Parameter("max_search_distance", 0.4, 0.01, 2.0, "from the surface, still on the map (m)"),
    )

    current_angle: float = 0.0
    """From the robot's heading to where it shall look (rad); the server publishes it."""

    def initialize(self, name: str, mesh_map: MeshMap, given: Mapping[str, Any] = {}) -> List[str]:
        """Prepare for work on a map; what is made here is shared by all goals."""
        complaints = super().initialize(name, mesh_map, given)
        mesh_map.spatial_index, mesh_map.geometry.walker
        self._locator = Locator(mesh_map.geometry)
        self._guide: Optional[Guide] = None
        self._state: Optional[RobotState] = None
        self._stand: Optional[SurfacePose] = None
        self._velocity, self._period, self._time = STOP, _PERIOD, -math.inf
        return complaints

    def prepare_plan(self, plan: ControllerPlan) -> Guide:
        """What takes a while of a plan: its path, laid over the surface. Changes nothing here."""
        values, costs = self.values, self.body.costs(self.map.planning_costs().costs)
        return Guide(
            self.map.geometry,
            plan,
            costs,
            values["max_search_distance"],
            values["side_clearance"],
            values["cost_limit"],
        )

    def set_plan(self, plan: ControllerPlan) -> None:
        """Follow another plan; where the robot is and how fast it drives stays known."""
        is_prepared = isinstance(plan.prepared, Guide)
        self._guide = plan.prepared if is_prepared else self.prepare_plan(plan)
        self._goal, self._heading = self._guide.goal.position, plan.goal.heading
        self._tolerance, self._is_turning = 0.0, False

    def is_goal_reached(
        self, state: RobotState, dist_tolerance: float, angle_tolerance: float
    ) -> bool:
        """Whether it stands at the goal, with its heading, and has nothing of the path ahead."""
        values, self._tolerance = self.values, dist_tolerance
        try:
            stand = self._where(state, values)
        except ControlFailure:  # compute_velocity tells
            return False
        error = heading_error(stand, self._heading)
        return (
            self._distance(stand) <= dist_tolerance
            and not self._has_path_ahead(stand, values)
            and (error is None or abs(error) <= angle_tolerance)
            and self._velocity.x <= values["max_lin_acceleration"] * self._period
        )

    def compute_velocity(self, state: RobotState, cancellation: Cancellation) -> Command:
        """The next velocity; all of it takes a few milliseconds."""
        try:
            self._velocity = self._wanted(state, self.values)
        except BaseException:
            self._velocity = STOP  # which is what the robot gets now
            raise
        return Command(ExePathOutcome.SUCCESS, velocity=self._velocity)

    # Where it is.

    def _where(self, state: RobotState, values: Mapping[str, Any]) -> SurfacePose:
        """On the surface, and on that storey on which it was; found once in a cycle."""
        if state is not self._state or self._stand is None:
            distance = values["max_search_distance"]
            hint = self._stand
            if hint is None:
                hint = self._guide.hint(state.pose.position, 2 * distance)
            self._stand = self._locator.stand(state.pose, hint, distance, distance)
            self._state = state
        return self._stand

    def _distance(self, stand: SurfacePose) -> float:
        return math.dist(stand.position, self._goal)

    def _has_path_ahead(self, stand: SurfacePose, values: Mapping[str, Any]) -> bool:
        """Whether it is beside the goal, but a loop of the path has still to be driven; one within
        the lookahead distance is cut."""
        room = max(values["lookahead_distance"], 2 * self._tolerance)
        return self._guide.has_path_ahead(stand, False, room, values["max_path_distance"])

    def _take_period(self, now: float) -> None:
        since, self._time = now - self._time, now
        if 0.0 < since < _LONGEST:
            self._period = max(since, 0.005)
        elif since:
            self._velocity = STOP

    # What to do.

    def _wanted(self, state: RobotState, values: Mapping[str, Any]) -> Velocity:
        if self._guide is None:
            raise ControlFailure(ExePathOutcome.NOT_INITIALIZED, "there is no plan to follow")
        stand = self._where(state, values)
        self._take_period(state.time)
        fastest = values["max_lin_velocity"]
        horizon = stopping_distance(fastest, values["max_lin_acceleration"], 2 * self._period)
        horizon = max(horizon + values["blocked_distance"], values["lookahead_distance"])
        guidance = self._guide.guidance(stand, False, horizon, values["max_path_distance"])
        costs = self._costs_around(stand, horizon, guidance, values)
        sweep = Sweep(self.body.shape, costs.obstacles)
        sight = Sight(self.map.geometry, costs, stand, sweep)
        if self._is_at_goal(stand, values):
            wanted = self._turn(heading_error(stand, self._heading) or 0.0, sight, values)
        else:
            wanted = self._pursue(guidance.paths, costs, sight, values)
        return self._accelerated(wanted, sight, values)

    def _costs_around(
        self, stand: SurfacePose, reach: float, guidance: Guidance, values: Mapping[str, Any]
    ) -> LocalCosts:
        """Of this moment, with what the robot's body could touch within a reach (m)."""
        costs, goal, lead = self.map.planning_costs().costs, self._guide.goal, guidance.lead
        obstacles = self.body.obstacles(costs, stand.position, reach + lead)
        if lead:  # the plan begins where the robot stands too near, and leads away from there
            obstacles = obstacles.left_from(self._guide.start)
        limit = values["cost_limit"]
        geometry = self.map.geometry
        return LocalCosts(geometry, costs, goal.face, goal.position, limit, obstacles, lead)

    def _is_at_goal(self, stand: SurfacePose, values: Mapping[str, Any]) -> bool:
        """Whether only the heading is left: at the goal, or it would have to turn round for it."""
        distance = self._distance(stand)
        if distance > self._tolerance or self._has_path_ahead(stand, values):
            self._is_turning = False
        elif not self._is_turning:
            error = _angle_to(stand, self._goal)
            passed = error is None or abs(error) > values["turn_angle"]
            self._is_turning = passed or distance <= min(_NEAR, self._tolerance / 4)
        return self._is_turning

    def _turn(self, angle: float, sight: Sight, values: Mapping[str, Any]) -> Velocity:
        """On the spot.

        Raises:
            ControlFailure: BLOCKED_PATH, the footprint would touch something.
        """
        self.current_angle = angle
        turn = Velocity(yaw=turning_speed(angle, values, self._period))
        return free_turn(turn, sight, values, self._period)

    def _pursue(
        self,
        paths: Sequence[LocalPath],
        costs: LocalCosts,
        sight: Sight,
        values: Mapping[str, Any],
    ) -> Velocity:
        """Along the path: the first of the ways that lead there which can be seen.

        Raises:
            ControlFailure: BLOCKED_PATH.
        """
        stand, brakes, way = sight.surface_pose, values["max_lin_acceleration"], paths[0]
        reach = _leaves(way, stand.position, values["lookahead_distance"])
        room = max(self._distance(stand), way.length) if way.arrives else math.inf
        blocked = costs.first_blocked(way.points, way.faces) if len(way.faces) else None
        if blocked is not None:
            # A base follows a speed that falls with each command by half a period later.
            rest = blocked - values["blocked_distance"] - self._velocity.x * self._period / 2
            if rest < _NEAR:
                raise ControlFailure(
                    ExePathOutcome.BLOCKED_PATH,
                    f"the way of the robot at {vector_text(stand.position)} is blocked after "
                    f"{blocked:.2f} m, at {vector_text(way.at(blocked))}",
                )
            room = min(room, rest)
            reach = min(reach, blocked)
        carrot = find_carrot(sight, paths, reach, values["side_clearance"])
        if abs(carrot.angle) > values["turn_angle"]:
            return self._turn(carrot.angle, sight, values)
        self.current_angle = carrot.angle
        bend = arc_to(abs(carrot.angle), carrot.distance)
        # No farther than to the carrot has it been seen that the ground is free.
        stops = [braking_speed(each, brakes, self._period) for each in (room, carrot.distance)]
        speed = min(values["max_lin_velocity"], *stops)
        if bend > 0.0:
            to_the_side = math.sqrt(values["max_lat_acceleration"] / bend)
            speed = min(speed, to_the_side, values["max_ang_velocity"] / bend)
        wanted = Velocity(x=speed, yaw=math.copysign(bend * speed, carrot.angle))
        return on_free_ground(wanted, sight, carrot, values, self._period)

    def _accelerated(self, wanted: Velocity, sight: Sight, values: Mapping[str, Any]) -> Velocity:
        """What can be reached of a velocity within a period, but where that does not stop it on
        free ground: there the base brakes, as well as it can."""
        brakes = values["max_lin_acceleration"]
        turns = values["max_ang_acceleration"] * self._period
        velocity = Velocity(
            x=approached(wanted.x, self._velocity.x, brakes * self._period),
            yaw=approached(wanted.yaw, self._velocity.yaw, turns),
        )
        if velocity.x > wanted.x:
            reach = stopping_distance(velocity.x, brakes, self._period)
            if sight.free_arc(velocity.yaw / velocity.x, reach) is not None:
                return velocity._replace(x=wanted.x)
        return velocity


def _leaves(way: LocalPath, place: np.ndarray, distance: float) -> float:
    """How far along a way it is to where it first is so far away from a place, straight (m); where
    it never is, to its end."""
    far = np.linalg.norm(way.points - place, axis=1) >= distance
    return float(way.travelled[far.argmax()]) if far.any() else way.length


def _angle_to(stand: SurfacePose, point: np.ndarray) -> Optional[float]:
    """From the heading to a place, as seen along the surface (rad, to the left); None at it."""
    direction = stand.direction_to(tuple(point.tolist()))
    return None if direction is None else heading_error(stand, np.array(direction))
