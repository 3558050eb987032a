"""Many drives on a world, judged."""

from typing import Any, Callable, List, Mapping

from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.simulation.driving import drive, make_controller

from mesh_tools_test.driving.trips import trip
from mesh_tools_test.driving.verdicts import Statistics, Verdict, judged
from mesh_tools_test.driving.worlds import DrivingWorld

WHEELS = {"slip": 0.05, "noise": 0.02}  # what the simulated ground does to its motion


def driven(
    world: DrivingWorld,
    seeds: List[int],
    planner: str = "wave_front",
    controller: Mapping[str, Any] = {},
    on_verdict: Callable[[Verdict], None] = lambda verdict: None,
    shape: RobotShape = RobotShape(),
    **body: Any,
) -> Statistics:
    """The trips of these seeds.

    Args:
        world: where.
        seeds: of the trips; that of a trip is that of the noise as well.
        planner: see `mesh_navigation.execution.planning.make_planner`.
        controller: its parameters, those that differ from their defaults.
        on_verdict: called after each drive.
        shape: of the robot, for planner and controller.
        body: of the simulated robot, see `mesh_navigation.simulation.surface_robot.SurfaceRobot`;
            by default `WHEELS`.
    """
    has = Body(world.mesh_map.geometry, shape)
    plans = make_planner(world.mesh_map, planner, body=has)
    follows = make_controller(world.mesh_map, parameters=controller, body=has)
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
            seed=seed,
            **(body or WHEELS),
        )
        verdicts.append(judged(wanted, went, world, costs, shape.inscribed_radius))
        on_verdict(verdicts[-1])
    return Statistics(world.name, verdicts)
