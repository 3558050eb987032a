"""Many drives on a world, judged, with the shipped configuration."""

from typing import Any, Callable, List, Optional

from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.path_execution import Tolerances
from mesh_navigation.simulation.driving import drive

from mesh_tools_test.driving import shipped
from mesh_tools_test.driving.trips import trip
from mesh_tools_test.driving.verdicts import Statistics, Verdict, judged
from mesh_tools_test.driving.worlds import DrivingWorld

WHEELS = {"slip": 0.05, "noise": 0.02}  # what the simulated ground does to its motion


def driven(
    world: DrivingWorld,
    seeds: List[int],
    planner: str = "",
    on_verdict: Callable[[Verdict], None] = lambda verdict: None,
    shape: Optional[RobotShape] = None,
    **body: Any,
) -> Statistics:
    """The trips of these seeds.

    Args:
        world: where.
        seeds: of the trips; that of a trip is that of the noise as well.
        planner: name of a shipped one; empty: the first.
        on_verdict: called after each drive.
        shape: of the robot, for planner and controller; None: the shipped one.
        body: of the simulated robot, see `mesh_navigation.simulation.surface_robot.SurfaceRobot`;
            by default `WHEELS`.
    """
    has = shipped.body(world.mesh_map, shape)
    plans = shipped.planner(world.mesh_map, has, planner)
    follows = shipped.controller(world.mesh_map, has)
    values = shipped.server()
    tolerances = Tolerances(values["dist_tolerance"], values["angle_tolerance"])
    costs = world.mesh_map.planning_costs().costs
    verdicts = []
    for seed in seeds:
        wanted = trip(world, seed)
        went = drive(
            world.mesh_map,
            plans,
            follows,
            start=wanted.start,
            goal=wanted.goal,
            values=values,
            seed=seed,
            **(body or WHEELS),
        )
        verdicts.append(judged(wanted, went, world, costs, has.radius, tolerances))
        on_verdict(verdicts[-1])
    return Statistics(world.name, verdicts)
