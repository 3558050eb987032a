"""The arguments of the command plan."""

import argparse
from typing import List

from mesh_navigation.command_line import CommandParser, is_number, number
from mesh_navigation.planning import SHORT_NAMES

PROGRAM = "plan"


def make_parser() -> argparse.ArgumentParser:
    """The parser of the arguments."""
    parser = CommandParser(
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
        while rest and len(values) < _COUNTS.get(word, 0) and is_number(rest[0]):
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
