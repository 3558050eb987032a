"""Command line of the demo."""
import argparse
import os
import shlex
import signal
import sys
from contextlib import ExitStack
from pathlib import Path

from mesh_map.errors import MeshMapError
from mesh_msgs.outdoor_world import LEAST_FACES, MOST_FACES
from mesh_msgs_hdf5.errors import MapFileError
from osmesa_harness.back_ends import BackEnd, HeadlessError, environment_of

from mesh_tools_test.demo import navigation_node, pipeline
from mesh_tools_test.demo.layers import PICTURES, server_config
from mesh_tools_test.demo.processes import (
    DemoError,
    free_port,
    process,
    roscore,
    subscribers,
    wait_until,
)
from mesh_tools_test.demo.report import Report
from mesh_tools_test.demo.rviz_config import GOAL_TOPIC, ROBOT_FRAME, SERVER, rviz_config
from mesh_tools_test.demo.screenshot import settled_picture

PLANNER = "dijkstra_mesh_planner"


def arguments(argv):
    """The parsed command line."""
    parser = argparse.ArgumentParser(
        prog="./run demo",
        description="From a mesh file to RViz and a planned path.",
        epilog="example: ./run demo forest.ply",
    )
    parser.add_argument("file", nargs="?", type=Path, help="PLY, OBJ, STL, DAE or HDF5")
    parser.add_argument("--output", type=Path, default=Path("demo"), help="folder (%(default)s)")
    parser.add_argument("--faces", type=int, default=200_000, help="size of the generated world")
    parser.add_argument("--seed", type=int, default=0, help="seed of the generated world")
    parser.add_argument("--headless", action="store_true", help="no window, even with a DISPLAY")
    options = parser.parse_args(argv)
    if not LEAST_FACES <= options.faces <= MOST_FACES:
        parser.error(f"--faces must be from {LEAST_FACES} to {MOST_FACES}, not {options.faces}")
    if options.seed < 0:
        parser.error(f"--seed must not be negative, as {options.seed} is")
    return options


def show_and_plan(report, stack, output, made):
    """Start map, server and RViz; plan; take pictures. The nodes live as long as the stack."""
    logs = output / "logs"
    frame, start, goal = made.mesh_map.frame_id, made.start, made.goal
    layers = output / "layers.yaml"
    layers.write_text(server_config(made.layers), encoding="utf-8")
    with report.step("start roscore") as notes:
        uri = stack.enter_context(roscore(logs, free_port()))
        notes.append(uri)
    with report.step("start map and server") as notes:
        launch = ["roslaunch", "--wait", "mesh_navigation", "mesh_navigation.launch"]
        launch += [f"map_file:={made.path.resolve()}", f"map_config:={layers.resolve()}"]
        server = stack.enter_context(process("mesh_navigation", launch, logs))
        uuid = navigation_node.wait_for_map(server)
        notes.append(f"node {SERVER}, mesh {uuid}")
        navigation_node.place_robot(start, goal, frame, ROBOT_FRAME)
    with report.step("plan") as notes:
        navigation_node.show_goal(start, goal, frame, GOAL_TOPIC)
        result, positions = navigation_node.plan(start, goal, frame, PLANNER)
        notes.append(f"{len(positions)} poses, {result.cost:.2f} m; {result.message}")
    config = output / "mesh_tools.rviz"
    screen = stack.enter_context(environment_of(BackEnd.OSMESA_X, os.environ))
    for name, layer, limits in PICTURES:
        config.write_text(rviz_config(start, goal, frame, layer, limits, PLANNER), encoding="utf-8")
        with report.step(f"picture of {layer}") as notes:
            picture = take_picture(uri, logs, config, screen, server)
            picture.save(output / name)
            notes.append(f"{name}, {picture.width} x {picture.height} pixels")
            notes.append("drawn by OSMesa on a virtual screen")
    return uri, config


def take_picture(uri, logs, config, screen, server):
    """RViz with a configuration, as long as it takes to draw it."""
    command = ["rviz", "--disable-anti-aliasing", "-d", str(config.resolve())]
    with process("rviz", command, logs, screen) as rviz:
        topic = f"{SERVER}/{PLANNER}/path"
        wait_until(lambda: subscribers(uri, topic), 60, "RViz's subscription", [server, rviz])
        return settled_picture(screen, rviz)


def show_on_screen(stack, output, config, uri):
    """RViz on the user's screen, until the user closes it."""
    print(f"RViz is on your screen; the demo ends when you close it ({uri}).", flush=True)
    command = ["rviz", "-d", str(config.resolve())]
    _, rviz, log = stack.enter_context(process("rviz_on_screen", command, output / "logs"))
    if rviz.wait() != 0:
        print(f"RViz ended with code {rviz.returncode} on {os.environ['DISPLAY']}; see {log}")


def how_to_go_on(path, layers, config):
    """What to type next, as text."""
    file, layers, config = (shlex.quote(str(each.resolve())) for each in (path, layers, config))
    return (
        "Go on, in ./run shell or wherever the workspace is sourced:\n"
        f"  rosrun mesh_msgs_hdf5 mesh_tool info {file}\n"
        f"  roslaunch mesh_navigation mesh_navigation.launch map_file:={file} "
        f"map_config:={layers}\n"
        "  rosservice call /move_base_flex/mesh_map/height_diff/set_parameters "
        "'{config: {doubles: [{name: threshold, value: 0.5}]}}'\n"
        f"  rviz -d {config}"
    )


def demo(options, output):
    """All steps, the results in the folder `output`."""
    report = Report()
    made = pipeline.prepare(report, output, options.file, options.faces, options.seed)
    with ExitStack() as stack:
        uri, config = show_and_plan(report, stack, output, made)
        (output / "report.md").write_text(report.markdown(), encoding="utf-8")
        pictures = ", ".join(name for name, _, _ in PICTURES)
        print(
            f"\nWritten to {output}/: {made.path.name}, {pictures}, report.md, layers.yaml, "
            "mesh_tools.rviz, logs/"
        )
        if options.headless or not os.environ.get("DISPLAY"):
            print("No window was opened: there is no DISPLAY, or --headless was given.")
        else:
            show_on_screen(stack, output, config, uri)
    print(how_to_go_on(made.path, output / "layers.yaml", config))


def interrupt(number, _frame):
    """End in order: the children go as the stack unwinds, and no second signal cuts that short."""
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)
    print("demo: interrupted", file=sys.stderr)
    sys.exit(128 + number)


def main(argv=None):
    """Run the demo; the exit code is 0 on success, 1 on failure, 2 on usage, 130 on Ctrl+C."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupt)
    options = arguments(argv)
    try:
        with pipeline.output_folder(options.output):
            demo(options, options.output)
        return 0
    except (DemoError, HeadlessError, MapFileError, MeshMapError) as error:
        reason = str(error)
    except OSError as error:
        reason = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    print(f"demo: error: {reason}", file=sys.stderr)
    return 1
