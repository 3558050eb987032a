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
from mesh_msgs_hdf5.completion import wanted
from mesh_msgs_hdf5.errors import MapFileError
from mesh_msgs_hdf5.progress import Progress
from mesh_msgs_hdf5.writing.save import check_target, save_file

from mesh_map.errors import MeshMapError, one_line
from mesh_map.mesh_map import MeshMap

from mesh_navigation.command_line import TROUBLE, complain, complete
from mesh_navigation.map_loading import load_map
from mesh_navigation.outcomes import GetPathOutcome
from mesh_navigation.path import path_length
from mesh_navigation.plan_arguments import PROGRAM, joined, make_parser
from mesh_navigation.planner import MeshPlanner, PlanResult
from mesh_navigation.planning import check_planner, ends, make_planner, plan_interruptibly
from mesh_navigation.pose import Pose

NO_PATH, INTERRUPTED = 1, 130


def main(argv: Optional[List[str]] = None) -> int:
    """Run the command; returns the exit code."""
    parser = make_parser()
    if wanted():
        complete(parser)
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
    except Exception as error:  # A plugin may raise anything; this is no answer that says no path.
        traceback.print_exc()
        complain(PROGRAM, f"{type(error).__name__}: {error}")
    return TROUBLE


def _run(arguments: argparse.Namespace) -> int:
    parameters = _parameters(arguments.set)
    check_planner(arguments.planner, parameters)
    if arguments.png is not None:
        _check_picture(arguments.png, arguments.force)
    seconds: Dict[str, float] = {}
    with Progress(arguments.quiet) as progress:

        def tell(share: float, what: str) -> None:
            progress.stage(what)
            progress.part(share)

        begin = time.monotonic()
        mesh_map = load_map(arguments.file, arguments.layers, arguments.part, tell)
        seconds["map"] = _lap(begin)
        progress.stage(f"preparing {arguments.planner}")
        begin = time.monotonic()
        start, goal = ends(mesh_map, arguments.start, arguments.goal)
        planner = make_planner(mesh_map, arguments.planner, parameters)
        if arguments.yaw is not None:
            goal = Pose.at(goal.position, math.radians(arguments.yaw))
        seconds["preparation"] = _lap(begin)
        progress.stage("planning")
        begin = time.monotonic()
        result = plan_interruptibly(planner, start, goal, arguments.tolerance)
        seconds["plan"] = _lap(begin)
        if arguments.png is not None:
            progress.stage(f"drawing {arguments.png}")
            _draw(arguments, mesh_map, planner, result, [start, goal], progress)
    _report(arguments, mesh_map, result, [start, goal], seconds)
    return 0 if result.succeeded else NO_PATH


def _lap(begin: float) -> float:
    return time.monotonic() - begin


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
    progress: Progress,
) -> None:
    from mesh_navigation.picture import plan_picture  # it takes a moment to load what draws

    title = f"{os.path.basename(arguments.file)}: {arguments.planner}, "
    length = path_length(result.poses[:, :3]) if len(result.poses) else 0.0
    title += f"{length:.2f} m" if len(result.poses) else _name(result.outcome)
    picture = plan_picture(
        mesh_map, result, places, planner.values.get("cost_limit"), title, progress=progress.part
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
            "layers": layers,
            "planner": arguments.planner,
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
