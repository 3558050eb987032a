"""The command plan: one path over a map, without ROS.

Exit codes: 0 there is a path, 1 there is none, 2 wrong usage, or a file that cannot be used.
"""

import argparse
import json
import math
import os
import sys
import time
import traceback
from typing import Any, Dict, List, Optional

import numpy as np
import yaml
from mesh_msgs_hdf5.commands.completion import wanted
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.files.save import check_target, save_file
from mesh_msgs_hdf5.rendering.render_camera import VIEWS, parsed_view
from mesh_msgs_hdf5.rendering.render_scale import SCALES

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.text import one_line

from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.path import path_length
from mesh_navigation.base.pose import Pose
from mesh_navigation.commands.command_line import (
    TROUBLE,
    CommandParser,
    complain,
    complete,
    is_number,
    number,
)
from mesh_navigation.execution.planning import (
    SHORT_NAMES,
    body_on,
    check_planner,
    ends,
    make_planner,
    plan_interruptibly,
    round_shape,
)
from mesh_navigation.plugins.planner import MeshPlanner, PlanResult
from mesh_navigation.surface.map_loading import load_map

PROGRAM = "plan"
NO_PATH, INTERRUPTED = 1, 130


def main(argv: Optional[List[str]] = None) -> int:
    """Run the command; returns the exit code."""
    parser = make_parser()
    if wanted():
        complete(parser)
    arguments: Optional[argparse.Namespace] = None
    try:
        arguments = parser.parse_args(joined(sys.argv[1:] if argv is None else argv))
        code = _run(arguments)
        sys.stdout.flush()
        return code
    except (MeshMapError, MapFileError) as error:
        complain(PROGRAM, str(error))
    except MemoryError:
        complain(PROGRAM, "there is not enough memory for this map (use a machine with more)")
    except BrokenPipeError:  # the reader of our output has gone, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:  # what concerns the files is one of the errors above
        complain(PROGRAM, f"cannot write the output: {error.strerror or error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        complain(PROGRAM, "interrupted")
        return INTERRUPTED
    except PLUGIN_FAILURES as error:  # This is no answer that says no path.
        if arguments is None:  # the parser has said what there is to say
            raise
        traceback.print_exc()
        complain(PROGRAM, error_line(error))
    return TROUBLE


def _run(arguments: argparse.Namespace) -> int:
    parameters = _parameters(arguments.set)
    check_planner(arguments.planner, parameters)
    shape = round_shape(arguments.robot_radius)
    if arguments.png is not None:
        _check_picture(arguments.png, arguments.force)
    seconds: Dict[str, float] = {}
    with ProgressLine(arguments.quiet) as progress:

        def tell(share: float, what: str) -> None:
            progress.stage(what)
            progress.part(share)

        begin = time.monotonic()
        origin = arguments.origin and [*arguments.origin, 0.0][:3]
        mesh_map = load_map(
            arguments.file,
            arguments.layers,
            arguments.part,
            tell,
            origin,
            arguments.robot_radius,
            arguments.max_edge_length,
        )
        seconds["map"] = time.monotonic() - begin
        progress.stage(f"preparing {arguments.planner}")
        begin = time.monotonic()
        start, goal = ends(mesh_map, arguments.start, arguments.goal)
        body = body_on(mesh_map, shape)
        planner = make_planner(mesh_map, arguments.planner, parameters, body)
        if arguments.yaw is not None:
            goal = Pose.at(goal.position, math.radians(arguments.yaw))
        seconds["preparation"] = time.monotonic() - begin
        progress.stage("planning")
        begin = time.monotonic()
        result = plan_interruptibly(planner, start, goal, arguments.tolerance)
        seconds["plan"] = time.monotonic() - begin
        if arguments.png is not None:
            progress.stage(f"drawing {arguments.png}")
            _draw(arguments, mesh_map, planner, result, [start, goal], progress)
    _report(arguments, mesh_map, result, [start, goal], seconds)
    return 0 if result.succeeded else NO_PATH


def _parameters(texts: List[str]) -> Dict[str, Any]:
    """What --set says, values as in YAML."""
    parameters = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not (name and sign):
            raise MeshMapError(f"--set {text}: it is no NAME=VALUE")
        try:
            parameters[name] = yaml.safe_load(value)
        except yaml.YAMLError as error:
            raise MeshMapError(f"--set {text}: {value!r} is no value: {error}") from error
    return parameters


def _check_picture(path: str, force: bool) -> None:
    if not path.lower().endswith(".png"):
        raise MeshMapError(f"{path}: the name of a picture ends with .png")
    check_target(path, force)


def _draw(
    arguments: argparse.Namespace,
    mesh_map: MeshMap,
    planner: MeshPlanner,
    result: PlanResult,
    places: List[Pose],
    progress: ProgressLine,
) -> None:
    # It takes a moment to load what draws.
    from mesh_navigation.commands.picture import plan_picture

    title = f"{os.path.basename(arguments.file)}: {arguments.planner}, "
    length = path_length(result.poses[:, :3]) if len(result.poses) else 0.0
    title += f"{length:.2f} m" if len(result.poses) else _name(result.outcome)
    picture = plan_picture(
        mesh_map,
        result,
        places,
        planner.values.get("cost_limit"),
        title,
        progress=progress.part,
        view=arguments.view,
        stops=SCALES[arguments.scale],
    )
    save_file(arguments.png, picture, overwrite=arguments.force)


def _report(
    arguments: argparse.Namespace,
    mesh_map: MeshMap,
    result: PlanResult,
    places: List[Pose],
    seconds: Dict[str, float],
) -> None:
    length = path_length(result.poses[:, :3]) if len(result.poses) else None
    layers = list(mesh_map.layers)
    if arguments.json:
        value = {
            "map": os.fsencode(arguments.file).decode("utf-8", "backslashreplace"),
            "frame_id": mesh_map.frame_id,
            "origin": mesh_map.origin.tolist(),
            "layers": layers,
            "planner": arguments.planner,
            "robot_radius": arguments.robot_radius,
            "uuid": mesh_map.uuid,
            "faces": len(mesh_map.faces),
            "start": places[0].position.tolist(),
            "goal": places[1].position.tolist(),
            "outcome": result.outcome,
            "outcome_name": _name(result.outcome),
            "message": result.message,
            "length": length,
            "cost": float(result.cost) if result.succeeded else None,
            "seconds": seconds,
            "picture": arguments.png,
            "poses": np.asarray(result.poses, dtype=np.float64).tolist(),
        }
        print(json.dumps(value, allow_nan=False))
        return
    print(one_line(f"{_name(result.outcome)} ({result.outcome}): {result.message}"))
    if length is not None:
        print(f"length {length:.3f} m, cost {result.cost:.3f}, {1e3 * seconds['plan']:.1f} ms")
    print(
        f"{arguments.planner} on {len(mesh_map.vertices)} vertices, layers: "
        f"{', '.join(layers) or 'none, every vertex is free'}; the map took "
        f"{seconds['map']:.2f} s, the planner {seconds['preparation']:.2f} s to prepare"
    )
    if arguments.png is not None:
        print(one_line(f"{arguments.png}: written"))


def _name(outcome: int) -> str:
    known = {int(value): value.name for value in GetPathOutcome}
    return known.get(outcome, "SUCCESS" if outcome < 10 else "FAILURE")


def make_parser() -> argparse.ArgumentParser:
    """The parser of the arguments."""
    parser = CommandParser(
        "the-command-plan",
        prog=PROGRAM,
        usage="%(prog)s FILE --start X Y [Z] --goal X Y [Z] [--planner NAME] [options]",
        description="Plan a path over a mesh map and say how long it is. Needs no roscore.",
        epilog="exit codes: 0 there is a path, 1 there is none, 2 wrong usage or file. "
        "example: rosrun mesh_navigation plan garden.h5 --start 1 2 --goal 8 9 0.5 --png plan.png",
    )
    parser.add_argument("file", metavar="FILE", help="map file, or any mesh that can be imported")
    text = "x, y and z in meters; without z where there is only one surface"
    for name in ("--start", "--goal"):
        parser.add_argument(name, type=_place, required=True, metavar="X Y Z", help=text)
    text = "heading at the goal in degrees (default: that of the straight line to it)"
    parser.add_argument("--yaw", type=number, metavar="DEGREES", help=text)
    text = f"{', '.join(SHORT_NAMES)} (default: wave_front), or the type of any plugin"
    parser.add_argument(
        "--planner", default="wave_front", metavar="NAME", help=text
    ).completer = lambda **others: list(SHORT_NAMES)
    text = "the path may end so far from a goal that cannot be reached, in meters"
    parser.add_argument("--tolerance", type=_distance, default=0.0, metavar="M", help=text)
    text = "the path keeps so far from what is lethal or unknown, in meters (default: 0, a point)"
    parser.add_argument("--robot-radius", type=_distance, default=0.0, metavar="M", help=text)
    text = "parameters of the planner, such as cost_limit=0.5"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=text)
    text = "layers as in mesh_navigation's config/mesh_map.yaml (default: every vertex is free)"
    parser.add_argument("--layers", metavar="FILE.yaml", help=text)
    text = "which mesh of a map file with several (default: mesh, or the only one)"
    parser.add_argument("--part", default="", metavar="NAME", help=text)
    text = "subtracted from the coordinates of a mesh, as of a UTM zone, in meters (default Z: 0)"
    parser.add_argument("--origin", type=_place, metavar="X Y Z", help=text)
    text = "halve longer edges, with the faces around them (default: that of the layers, else none)"
    parser.add_argument("--max-edge-length", type=_distance, metavar="M", help=text)
    text = "draw the potential and the path, without what is far above both"
    parser.add_argument("--png", metavar="OUT.png", help=text)
    text = (
        "of the picture: %s, or AZIMUTH,ELEVATION in degrees of the place to look from (default: "
    )
    text = (text + "top, or iso where storeys lie over each other)") % ", ".join(VIEWS)
    view = parser.add_argument("--view", type=parsed_view, metavar="VIEW", help=text)
    view.completer = lambda **others: list(VIEWS)
    text = "colors of the potential, as in RViz"
    parser.add_argument("--scale", choices=sorted(SCALES), default="rainbow", help=text)
    parser.add_argument("--force", action="store_true", help="replace OUT.png if it exists")
    parser.add_argument("--json", action="store_true", help="output for programs, with the poses")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    return parser


def _place(text: str) -> List[float]:
    numbers = [number(word) for word in text.split(",")]
    if len(numbers) not in (2, 3):
        raise ValueError(text)
    return numbers


def _distance(text: str) -> float:
    value = number(text)
    if value < 0:
        raise ValueError(text)
    return value


_distance.__name__, _place.__name__ = "distance", "X Y [Z]"


def joined(words: List[str]) -> List[str]:
    """The words with an option's values joined to it: argparse takes -1e-3 for an option, and a
    file that follows a list for a part of it."""
    joined: List[str] = []
    rest = list(words)
    while rest:
        word = rest.pop(0)
        values: List[str] = []
        while rest and len(values) < _COUNTS.get(word, 0) and _are_numbers(rest[0]):
            values += rest.pop(0).split(",")
        if values:
            joined.append(f"{word}={','.join(values)}")
        elif word == "--set":
            while rest and (not values or "=" in rest[0]) and not rest[0].startswith("-"):
                values.append(rest.pop(0))
            joined += [f"--set={value}" for value in values] or [word]
        else:
            joined.append(word)
    return joined


def _are_numbers(word: str) -> bool:
    return all(is_number(each) for each in word.split(","))


_COUNTS = {"--start": 3, "--goal": 3, "--origin": 3}  # of numbers, at most
_COUNTS.update(
    {"--yaw": 1, "--tolerance": 1, "--robot-radius": 1, "--max-edge-length": 1, "--view": 1}
)
