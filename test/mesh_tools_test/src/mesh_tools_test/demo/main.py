"""Command line of the demo."""
import argparse
import io
import os
import shlex
import signal
import sys
from contextlib import ExitStack
from pathlib import Path

from mesh_map.base.errors import MeshMapError
from mesh_msgs.outdoor_world import LEAST_FACES, MOST_FACES
from mesh_msgs_hdf5.model.errors import MapFileError
from osmesa_harness.back_ends import HeadlessError

from mesh_tools_test.demo import pipeline
from mesh_tools_test.demo.grid_figure import grid_figure, grid_map, plans_on_grid
from mesh_tools_test.demo.processes import DemoError, process
from mesh_tools_test.demo.report import Report
from mesh_tools_test.demo.results import FILES, GRID, LAYERS, PLANNERS, REPORT, RVIZ
from mesh_tools_test.demo.show import plan_and_show, plan_drive_and_show, write_configs


def arguments(argv):
    """The parsed command line."""
    parser = argparse.ArgumentParser(
        prog="./run demo",
        description="From a mesh file, or scans, to a robot that drives, and RViz.",
        epilog="examples: ./run demo forest.ply; ./run demo scans.bag",
    )
    text = "a mesh: PLY, OBJ, STL, DAE or HDF5; or scans: a bag, PCD, LAS, LAZ, a folder of clouds"
    parser.add_argument("file", nargs="?", type=Path, help=text)
    parser.add_argument("--output", type=Path, default=Path("demo"), help="folder (%(default)s)")
    parser.add_argument("--faces", type=int, default=200_000, help="size of the generated world")
    parser.add_argument("--seed", type=int, default=0, help="seed of the generated world")
    parser.add_argument(
        "--short", action="store_true", help="one plan and one picture, no drive: within a minute"
    )
    parser.add_argument("--headless", action="store_true", help="no window, even with a DISPLAY")
    options = parser.parse_args(argv)
    if not LEAST_FACES <= options.faces <= MOST_FACES:
        parser.error(f"--faces must be from {LEAST_FACES} to {MOST_FACES}, not {options.faces}")
    if options.seed < 0:
        parser.error(f"--seed must not be negative, as {options.seed} is")
    return options


def show_on_screen(stack, output, uri):
    """RViz on the user's screen, until the user closes it."""
    print(f"RViz is on your screen; the demo ends when you close it ({uri}).")
    command = ["rviz", "-d", str((output / RVIZ).resolve())]
    _, rviz, log = stack.enter_context(process("rviz_on_screen", command, output / "logs"))
    if rviz.wait() != 0:
        print(f"RViz ended with code {rviz.returncode} on {os.environ['DISPLAY']}; see {log}")


def how_to_go_on(made, output):
    """What to type next, as text."""
    paths = made.path, output / LAYERS, output / PLANNERS, output / RVIZ
    file, layers, planners, config = (shlex.quote(str(path.resolve())) for path in paths)
    start, goal = (" ".join(f"{value:.2f}" for value in point) for point in (made.start, made.goal))
    return (
        "Go on, in ./run shell or wherever the workspace is sourced:\n"
        f"  rosrun mesh_msgs_hdf5 mesh_tool info {file}\n"
        f"  rosrun mesh_navigation plan {file} --start {start} --goal {goal} --layers {layers}\n"
        f"  roslaunch mesh_navigation simulation.launch map_file:={file} map_config:={layers} "
        f"planner_config:={planners} initial_pose:='[{start.replace(' ', ', ')}, 0]'\n"
        f"  rosrun mesh_navigation go_to {goal}\n"
        "  rosservice call /move_base_flex/mesh_map/height_diff/set_parameters "
        "'{config: {doubles: [{name: threshold, value: 0.5}]}}'\n"
        f"  rviz -d {config}"
    )


def demo(options, output):
    """All steps, the results in the folder `output`."""
    report = Report()
    made = pipeline.prepare(report, output, options.file, options.faces, options.seed)
    write_configs(output, made)
    try:
        show(report, options, output, made)
    finally:  # With a map there is a way to go on, whatever failed.
        print(how_to_go_on(made, output))


def show(report, options, output, made):
    """All steps after those that make the map."""
    if not options.short:
        show_grid(report, output)
    with ExitStack() as stack:
        steps = plan_and_show if options.short else plan_drive_and_show
        uri, way = steps(report, stack, output, made)
        (output / REPORT).write_text(report.markdown(), encoding="utf-8")
        files = ", ".join(name for name in FILES if (output / name).exists())
        print(f"\nWritten to {output}/: {made.path.name}, {files}, logs/")
        if way is not None and not way.succeeded:
            raise DemoError(f"the robot did not arrive: {way.outcome}: {way.message}")
        if options.headless or not os.environ.get("DISPLAY"):
            print("No window was opened: there is no DISPLAY, or --headless was given.")
        else:
            show_on_screen(stack, output, uri)


def show_grid(report, output):
    """The figure of two planners on a regular grid."""
    with report.step("picture of a grid") as notes:
        mesh_map = grid_map()
        found = plans_on_grid(mesh_map)
        grid_figure(mesh_map, found).save(output / GRID)
        notes += [GRID, *(f"{each.title} {each.error}" for each in found)]


def interrupt(number, _frame):
    """End in order: the children go as the stack unwinds, and no second signal cuts that short."""
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)
    print("demo: interrupted", file=sys.stderr)
    sys.exit(128 + number)


def main(argv=None):
    """Run the demo; the exit code is 0 on success, 1 on failure, 2 on usage, 130 on Ctrl+C."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # into files and pipes, too
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
