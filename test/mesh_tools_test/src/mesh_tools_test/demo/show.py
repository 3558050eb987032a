"""Map server, planners, robot and RViz: plans of all planners, a drive, and pictures of them."""
import os

from osmesa_harness.back_ends import BackEnd, environment_of

from mesh_tools_test.demo import driven, navigation_node, plans, results
from mesh_tools_test.demo.drive_node import Driver, simulate_time, start_robot
from mesh_tools_test.demo.layers import PICTURES, server_config
from mesh_tools_test.demo.planners import DIJKSTRA, EXACT, PLANNERS, WAVE_FRONT, planner_config
from mesh_tools_test.demo.processes import free_port, process, roscore, subscribers, wait_until
from mesh_tools_test.demo.rviz_config import GOAL_TOPIC, SERVER, rviz_config
from mesh_tools_test.demo.screenshot import settled_picture


def show_and_plan(report, stack, output, made):
    """Start map, server, robot and RViz; plan, drive, take pictures. The nodes live as long as the
    stack.

    :returns: URI of the master, and the drive
    """
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

    first = plan_with_all(report, plan, made.mesh_map)
    camera = Camera(stack, output, uri, server, (start, goal, frame))
    limits = plans.color_limits([first[DIJKSTRA].potential, first[WAVE_FRONT].potential])
    for planner, name in results.POTENTIALS:
        plan(planner)  # the last plan's potential is the one that is shown
        with report.step(f"potential of {planner.title}") as notes:
            notes.append(camera.take(name, plans.POTENTIAL, limits, planner))
    for name, layer, layer_limits in PICTURES:
        if name == results.ARRIVED:
            way = drive(report, driver, (start, goal, frame), first[WAVE_FRONT].length)
            plan(WAVE_FRONT)  # while it drove, there were plans from where it was
        with report.step(f"picture of {layer}") as notes:
            notes.append(camera.take(name, layer, layer_limits, WAVE_FRONT))
    return uri, way


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


def drive(report, driver, scene, planned):
    """Let the robot go to the goal, which is compared with the plan in the report.

    :param scene: start (3,), goal (3,), frame
    :param planned: length of the path [m]
    """
    start, goal, frame = scene
    with report.step("drive") as notes:
        pose = navigation_node.pose(goal, frame, navigation_node.heading(start, goal))
        way = driver.drive(pose, WAVE_FRONT.name, planned)
        notes.append(f"{way.outcome}: {way.message}")
    report.table(driven.table(way))
    return way


class Camera:
    """Takes pictures of RViz on a virtual screen."""

    def __init__(self, stack, output, uri, server, scene):
        """
        :param server: (name, process, log file)
        :param scene: start (3,), goal (3,), frame
        """
        self._screen = stack.enter_context(environment_of(BackEnd.OSMESA_X, os.environ))
        self._output, self._uri, self._server, self._scene = output, uri, server, scene
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
                lambda: all(subscribers(self._uri, topic) for topic in topics),
                60,
                "RViz's subscription of the paths",
                [self._server, rviz],
            )
            picture = settled_picture(self._screen, rviz)
        picture.save(self._output / name)
        size = f"{picture.width} x {picture.height} pixels"
        return f"{name}, {size}, drawn by OSMesa on a virtual screen"
