"""The arguments of the command plan."""

import argparse
import math
import sys
from typing import Any, List

from mesh_msgs_hdf5.completion import bash_script

from mesh_map.errors import one_line

from mesh_navigation.planning import SHORT_NAMES

PROGRAM = "plan"
TROUBLE = 2  # exit code: wrong usage, or a file that cannot be used


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> None:
        complain(f"{message} ({PROGRAM} --help)")
        sys.exit(TROUBLE)


class _Completion(argparse.Action):
    def __call__(self, *_arguments: Any) -> None:
        sys.stdout.write(bash_script(PROGRAM, "mesh_navigation", alone=False))
        sys.exit(0)


def make_parser() -> argparse.ArgumentParser:
    """The parser of the arguments."""
    parser = _Parser(
        prog=PROGRAM,
        usage="%(prog)s FILE --start X Y [Z] --goal X Y [Z] [--planner NAME] [options]",
        allow_abbrev=False,
        description="Plan a path over a mesh map and say how long it is. Needs no roscore.",
        epilog="exit codes: 0 there is a path, 1 there is none, 2 wrong usage or file. "
        "example: rosrun mesh_navigation plan garden.h5 --start 1 2 --goal 8 9 0.5 --png plan.png",
    )
    parser.add_argument("file", metavar="FILE", help="map file, or any mesh that can be imported")
    text = "x, y and z in meters; without z where there is only one surface"
    for name in ("--start", "--goal"):
        parser.add_argument(name, type=_place, required=True, metavar="X Y Z", help=text)
    text = "heading at the goal in degrees (default: that of the straight line to it)"
    parser.add_argument("--yaw", type=_number, metavar="DEGREES", help=text)
    text = f"{', '.join(SHORT_NAMES)} (default: wave_front), or the type of any plugin"
    parser.add_argument(
        "--planner", default="wave_front", metavar="NAME", help=text
    ).completer = lambda **others: list(SHORT_NAMES)
    text = "the path may end so far from a goal that cannot be reached, in meters"
    parser.add_argument("--tolerance", type=_distance, default=0.0, metavar="M", help=text)
    text = "parameters of the planner, such as cost_limit=0.5"
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help=text)
    text = "layers as in mesh_navigation's config/mesh_map.yaml (default: every vertex is free)"
    parser.add_argument("--layers", metavar="FILE.yaml", help=text)
    text = "which mesh of a map file with several (default: mesh, or the only one)"
    parser.add_argument("--part", default="", metavar="NAME", help=text)
    text = "draw the potential and the path from above"
    parser.add_argument("--png", metavar="OUT.png", help=text)
    parser.add_argument("--force", action="store_true", help="replace OUT.png if it exists")
    parser.add_argument("--json", action="store_true", help="output for programs, with the poses")
    text = "print what makes bash complete these arguments, for .bashrc"
    parser.add_argument("--completion", nargs=0, action=_Completion, help=text)
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    return parser


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _place(text: str) -> List[float]:
    numbers = [_number(word) for word in text.split(",")]
    if len(numbers) not in (2, 3):
        raise ValueError(text)
    return numbers


def _distance(text: str) -> float:
    value = _number(text)
    if value < 0:
        raise ValueError(text)
    return value


_number.__name__, _distance.__name__, _place.__name__ = "number", "distance", "X Y [Z]"


def joined(words: List[str]) -> List[str]:
    """The words with an option's values joined to it: argparse takes -1e-3 for an option, and a
    file that follows a list for a part of it."""
    joined: List[str] = []
    rest = list(words)
    while rest:
        word = rest.pop(0)
        values: List[str] = []
        while rest and len(values) < _COUNTS.get(word, 0) and _is_number(rest[0]):
            values.append(rest.pop(0))
        if values:
            joined.append(f"{word}={','.join(values)}")
        elif word == "--set":
            while rest and (not values or "=" in rest[0]) and not rest[0].startswith("-"):
                values.append(rest.pop(0))
            joined += [f"--set={value}" for value in values] or [word]
        else:
            joined.append(word)
    return joined


_COUNTS = {"--start": 3, "--goal": 3, "--yaw": 1, "--tolerance": 1}  # of numbers, at most


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def complete(parser: argparse.ArgumentParser) -> None:
    """Tell the shell what could come next, and end; without argcomplete: nothing."""
    try:
        import argcomplete
    except ImportError:
        sys.exit(1)
    argcomplete.autocomplete(parser, always_complete_options="long")


def complain(text: str) -> None:
    """One line on standard error."""
    sys.stderr.write(f"{PROGRAM}: error: {one_line(text)}\n")
