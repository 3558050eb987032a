"""Map server, planners, robot and RViz: plans of all planners, a drive, and pictures of them."""
from typing import Any, Callable, NamedTuple

from mesh_tools_test.demo import driven, navigation_node, pictures, plans, results
from mesh_tools_test.demo.drive_node import Driver, simulate_time, start_robot
from mesh_tools_test.demo.layers import server_config
from mesh_tools_test.demo.photographer import Photographer
from mesh_tools_test.demo.planners import (
    DIJKSTRA,
    EXACT,
    PLANNERS,
    WAVE_FRONT,
    Shown,
    planner_config,
)
from mesh_tools_test.demo.processes import free_port, process, roscore
from mesh_tools_test.demo.rviz_config import GOAL_TOPIC, SERVER, user_config


def plan_and_show(report, stack, output, made):
    """Start map, server, robot and RViz; one plan and one picture of it, without a drive.

    The nodes live as long as the stack.

    :returns: URI of the master, and None: there is no drive
    """
    nodes = start_nodes(report, stack, output, made)
    with report.step(f"plan: {WAVE_FRONT.title}") as notes:
        notes.append(nodes.plan(WAVE_FRONT).message)
    photographer = Photographer(stack, output, nodes.uri, nodes.server, made)
    take(report, photographer, pictures.PLAN, pictures.PLAN.limits)
    return nodes.uri, None


def plan_drive_and_show(report, stack, output, made):
    """Start map, server, robot and RViz; plan with all planners, drive, take all pictures.

    The nodes live as long as the stack.

    :returns: URI of the master, and the drive
    """
    nodes = start_nodes(report, stack, output, made)
    first = plan_with_all(report, nodes.plan, made.mesh_map)
    photographer = Photographer(stack, output, nodes.uri, nodes.server, made)
    limits = plans.color_limits([first[DIJKSTRA].potential, first[WAVE_FRONT].potential])
    for picture in pictures.POTENTIALS:
        potential = nodes.plan(picture.planner).potential  # the last plan's is the one shown
        take(report, photographer, picture, limits, potential)
    for picture in pictures.LAYERS:
        take(report, photographer, picture, picture.limits)
    way = drive(report, nodes, made, first[WAVE_FRONT].length)
    nodes.plan(WAVE_FRONT)  # while it drove, there were plans from where it was
    take(report, photographer, pictures.PLAN, pictures.PLAN.limits, arrived=True)
    return nodes.uri, way


def take(report, photographer, picture, limits, potential=None, arrived=False):
    """A picture as a step of the report; see Photographer.take."""
    with report.step(f"picture {picture.file}") as notes:
        notes.append(photographer.take(picture, limits, potential, arrived))


class Nodes(NamedTuple):
    """URI of the master, (name, process, log file) of the server, who drives, and who plans."""

    uri: str
    server: Any
    driver: Driver
    plan: Callable[[Shown], plans.Plan]


def start_nodes(report, stack, output, made):
    """Start roscore, robot and server, and wait until there can be plans."""
    frame, start, goal = made.mesh_map.frame_id, made.start, made.goal
    with report.step("start roscore") as notes:
        uri = stack.enter_context(roscore(output / "logs", free_port()))
        notes.append(uri)
    with report.step("start map and server") as notes:
        simulate_time()
        robot = stack.enter_context(start_robot(output, start, goal))
        server = stack.enter_context(start_server(output, made))
        uuid = navigation_node.wait_for_map(server)
        notes.append(f"node {SERVER}, mesh {uuid}")
        navigation_node.show_goal(start, goal, frame, GOAL_TOPIC)
        client = navigation_node.PlanClient(server)
        # The planners are ready when one has answered: the times of the others are for plans.
        client.plan(start, start, frame, EXACT.name)
        driver = Driver(client.navigator, robot)

    def plan(planner):
        return client.plan(start, goal, frame, planner.name)

    return Nodes(uri, server, driver, plan)


def write_configs(output, made):
    """The files that configure the server, and RViz for the user."""
    (output / results.LAYERS).write_text(
        server_config(made.layers, made.max_edge_length), encoding="utf-8"
    )
    (output / results.PLANNERS).write_text(planner_config(), encoding="utf-8")
    ends = made.start, made.goal
    config = user_config(pictures.PLAN, made.mesh_map.vertices, *ends, made.mesh_map.frame_id)
    (output / results.RVIZ).write_text(config, encoding="utf-8")


def start_server(output, made):
    """The navigation server on the map, configured by two files; see processes.process."""
    layers, planners = output / results.LAYERS, output / results.PLANNERS
    launch = ["roslaunch", "--wait", "mesh_navigation", "mesh_navigation.launch"]
    launch += [f"map_file:={made.path.resolve()}", f"map_config:={layers.resolve()}"]
    launch += [f"planner_config:={planners.resolve()}"]
    return process("mesh_navigation", launch, output / "logs")


def plan_with_all(report, plan, mesh_map):
    """Two plans of each planner, compared in the report; the first one by planner is returned."""
    first, rows = {}, []
    for planner in PLANNERS:
        with report.step(f"plan: {planner.title}") as notes:
            first[planner] = plan(planner)
            again = plan(planner)
            notes.append(first[planner].message)
        rows.append(plans.compared(planner.title, first[planner], again, mesh_map))
    report.table(plans.table(rows))
    return first


def drive(report, nodes, made, planned):
    """Let the robot go to the goal, which is compared with the plan in the report.

    :param planned: length of the path [m]
    """
    with report.step("drive") as notes:
        yaw = navigation_node.heading(made.start, made.goal)
        pose = navigation_node.pose(made.goal, made.mesh_map.frame_id, yaw)
        way = nodes.driver.drive(pose, WAVE_FRONT.name, planned)
        notes.append(f"{way.outcome}: {way.message}")
    report.table(driven.table(way))
    return way
