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
LAYER, LIMITS = "height_diff", (0.0, 0.3)  # what RViz shows, in meters


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


def show_and_plan(report, stack, output, path, mesh_map, start, goal):
    """Start map, server and RViz; plan; take the picture. The nodes live as long as the stack."""
    logs = output / "logs"
    config = output / "mesh_tools.rviz"
    frame = mesh_map.frame_id
    config.write_text(rviz_config(start, goal, frame, LAYER, LIMITS, PLANNER), encoding="utf-8")
    with report.step("start roscore") as notes:
        uri = stack.enter_context(roscore(logs, free_port()))
        notes.append(uri)
    with report.step("start map and server") as notes:
        launch = ["roslaunch", "--wait", "mesh_navigation", "mesh_navigation.launch"]
        launch += [f"map_file:={path.resolve()}"]
        server = stack.enter_context(process("mesh_navigation", launch, logs))
        uuid = navigation_node.wait_for_map(server)
        notes.append(f"node {SERVER}, mesh {uuid}")
        navigation_node.place_robot(start, goal, frame, ROBOT_FRAME)
    with report.step("start RViz") as notes:
        screen = stack.enter_context(environment_of(BackEnd.OSMESA_X, os.environ))
        command = ["rviz", "--disable-anti-aliasing", "-d", str(config.resolve())]
        rviz = stack.enter_context(process("rviz", command, logs, screen))
        topic = f"{SERVER}/{PLANNER}/path"
        wait_until(lambda: subscribers(uri, topic), 60, "RViz's subscription", [server, rviz])
        notes.append("drawn by OSMesa on a virtual screen, for the picture")
    with report.step("plan") as notes:
        navigation_node.show_goal(start, goal, frame, GOAL_TOPIC)
        result, positions = navigation_node.plan(start, goal, frame, PLANNER)
        notes.append(f"{len(positions)} poses, {result.cost:.2f} m; {result.message}")
    with report.step("picture") as notes:
        picture = settled_picture(screen, rviz)
        picture.save(output / "rviz.png")
        notes.append(f"rviz.png, {picture.width} x {picture.height} pixels")
    return uri, config


def show_on_screen(stack, output, config, uri):
    """RViz on the user's screen, until the user closes it."""
    print(f"RViz is on your screen; the demo ends when you close it ({uri}).", flush=True)
    command = ["rviz", "-d", str(config.resolve())]
    _, rviz, log = stack.enter_context(process("rviz_on_screen", command, output / "logs"))
    if rviz.wait() != 0:
        print(f"RViz ended with code {rviz.returncode} on {os.environ['DISPLAY']}; see {log}")


def how_to_go_on(path, config):
    """What to type next, as text."""
    file, config = shlex.quote(str(path.resolve())), shlex.quote(str(config.resolve()))
    return (
        "Go on, in ./run shell or wherever the workspace is sourced:\n"
        f"  rosrun mesh_msgs_hdf5 mesh_tool info {file}\n"
        f"  roslaunch mesh_navigation mesh_navigation.launch map_file:={file}\n"
        f"  rviz -d {config}"
    )


def demo(options, output):
    """All steps, the results in the folder `output`."""
    report = Report()
    path, mesh_map, start, goal = pipeline.prepare(
        report, output, options.file, options.faces, options.seed
    )
    with ExitStack() as stack:
        uri, config = show_and_plan(report, stack, output, path, mesh_map, start, goal)
        (output / "report.md").write_text(report.markdown(), encoding="utf-8")
        print(f"\nWritten to {output}/: {path.name}, rviz.png, report.md, mesh_tools.rviz, logs/")
        if options.headless or not os.environ.get("DISPLAY"):
            print("No window was opened: there is no DISPLAY, or --headless was given.")
        else:
            show_on_screen(stack, output, config, uri)
    print(how_to_go_on(path, config))


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
