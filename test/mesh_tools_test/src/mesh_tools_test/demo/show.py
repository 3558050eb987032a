"""Map server, planners, robot and RViz: plans of all planners, a drive, and pictures of them."""
import os
from typing import Any, Callable, NamedTuple

from osmesa_harness.back_ends import BackEnd, environment_of

from mesh_tools_test.demo import driven, navigation_node, plans, results
from mesh_tools_test.demo.drive_node import Driver, simulate_time, start_robot
from mesh_tools_test.demo.layers import PICTURES, server_config
from mesh_tools_test.demo.planners import (
    DIJKSTRA,
    EXACT,
    PLANNERS,
    WAVE_FRONT,
    Shown,
    planner_config,
)
from mesh_tools_test.demo.processes import free_port, process, roscore, subscribers, wait_until
from mesh_tools_test.demo.rviz_config import GOAL_TOPIC, SERVER, rviz_config
from mesh_tools_test.demo.screenshot import settled_picture


def plan_and_show(report, stack, output, made):
    """Start map, server, robot and RViz; one plan and one picture of it, without a drive.

    The nodes live as long as the stack.

    :returns: URI of the master, and None: there is no drive
    """
    nodes = start_nodes(report, stack, output, made)
    with report.step(f"plan: {WAVE_FRONT.title}") as notes:
        notes.append(nodes.plan(WAVE_FRONT).message)
    camera = Camera(stack, output, nodes, made)
    (picture,) = (each for each in PICTURES if each[0] == results.RVIZ_PICTURE)
    take_layer(report, camera, *picture)
    return nodes.uri, None


def plan_drive_and_show(report, stack, output, made):
    """Start map, server, robot and RViz; plan with all planners, drive, take all pictures.

    The nodes live as long as the stack.

    :returns: URI of the master, and the drive
    """
    nodes = start_nodes(report, stack, output, made)
    first = plan_with_all(report, nodes.plan, made.mesh_map)
    camera = Camera(stack, output, nodes, made)
    limits = plans.color_limits([first[DIJKSTRA].potential, first[WAVE_FRONT].potential])
    for planner, name in results.POTENTIALS:
        nodes.plan(planner)  # the last plan's potential is the one that is shown
        with report.step(f"potential of {planner.title}") as notes:
            notes.append(camera.take(name, plans.POTENTIAL, limits, planner))
    for picture in PICTURES:
        if picture[0] == results.RVIZ_PICTURE:
            way = drive(report, nodes, made, first[WAVE_FRONT].length)
            nodes.plan(WAVE_FRONT)  # while it drove, there were plans from where it was
        take_layer(report, camera, *picture)
    return nodes.uri, way


def take_layer(report, camera, name, layer, limits):
    """The picture of a layer."""
    with report.step(f"picture of {layer}") as notes:
        notes.append(camera.take(name, layer, limits, WAVE_FRONT))


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
    """The files that configure the server; RViz's is written with each picture."""
    (output / results.LAYERS).write_text(
        server_config(made.layers, made.max_edge_length), encoding="utf-8"
    )
    (output / results.PLANNERS).write_text(planner_config(), encoding="utf-8")


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


class Camera:
    """Takes pictures of RViz on a virtual screen."""

    def __init__(self, stack, output, nodes, made):
        self._screen = stack.enter_context(environment_of(BackEnd.OSMESA_X, os.environ))
        self._output, self._nodes = output, nodes
        self._scene = made.start, made.goal, made.mesh_map.frame_id
        self._config = output / results.RVIZ

    def take(self, name, layer, limits, on_top):
        """RViz with a layer, as long as it takes to draw it; returns what to say of the picture.

        :param on_top: the planner whose path is drawn over the others
        """
        paths = sorted((EXACT, DIJKSTRA, WAVE_FRONT), key=lambda planner: planner is on_top)
        config = rviz_config(*self._scene, layer, limits, paths)
        self._config.write_text(config, encoding="utf-8")
        command = ["rviz", "--disable-anti-aliasing", "-d", str(self._config.resolve())]
        with process("rviz", command, self._output / "logs", self._screen) as rviz:
            topics = [f"{SERVER}/{planner.name}/path" for planner in paths]
            wait_until(
                lambda: all(subscribers(self._nodes.uri, topic) for topic in topics),
                60,
                "RViz's subscription of the paths",
                [self._nodes.server, rviz],
            )
            picture = settled_picture(self._screen, rviz)
        picture.save(self._output / name)
        size = f"{picture.width} x {picture.height} pixels"
        return f"{name}, {size}, drawn by OSMesa on a virtual screen"
