"""The arguments of the command go_to."""

import argparse
import math
import sys
from typing import Any, List

from mesh_msgs_hdf5.completion import bash_script
from rosgraph.names import is_legal_name

from mesh_map.errors import one_line

PROGRAM = "go_to"
SERVER = "move_base_flex"
TROUBLE = 2  # exit code: wrong usage, or no server


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> None:
        # The space of `_plain` is not the user's.
        complain(f"{message} ({PROGRAM} --help)".replace(": ' -", ": '-"))
        sys.exit(TROUBLE)


class _Completion(argparse.Action):
    def __call__(self, *_arguments: Any) -> None:
        sys.stdout.write(bash_script(PROGRAM, "mesh_navigation", alone=False))
        sys.exit(0)


def make_parser() -> argparse.ArgumentParser:
    """The parser of the arguments."""
    parser = _Parser(
        prog=PROGRAM,
        usage="%(prog)s X Y Z [YAW] [options]",
        allow_abbrev=False,
        description="Let the robot go to a place on the map, and wait until it is there. "
        "Ctrl+C stops it.",
        epilog="exit codes: 0 it is there (or there is a plan), 1 it is not, 2 wrong usage or no "
        "server, 130 Ctrl+C. example: rosrun mesh_navigation go_to 8 9 0.5",
    )
    for name in "XYZ":
        parser.add_argument(name.lower(), metavar=name, type=_number, help="m")
    text = "heading at the goal in degrees (default: as the path arrives)"
    parser.add_argument("heading", metavar="YAW", nargs="?", type=_number, help=text)
    parser.add_argument("--yaw", type=_number, metavar="DEGREES", help="another way to say YAW")
    text = "of X Y Z (default: that of the map)"
    parser.add_argument("--frame", default="", metavar="FRAME", help=text)
    text = "node of the navigation server (default: %(default)s)"
    parser.add_argument("--server", default=SERVER, type=_node, metavar="NAME", help=text)
    text = "name of the {} (default: the server's first)"
    for kind in ("planner", "controller"):
        parser.add_argument(f"--{kind}", default="", metavar="NAME", help=text.format(kind))
    text = "recovery behavior, may be repeated (default: all of the server's)"
    parser.add_argument("--recovery", action="append", default=[], metavar="NAME", help=text)
    text = "stop if it is not there after so many seconds"
    parser.add_argument("--timeout", type=_seconds, metavar="S", help=text)
    text = "only plan, and say how long the way is"
    parser.add_argument("--plan-only", action="store_true", help=text)
    parser.add_argument("--json", action="store_true", help="output for programs")
    text = "print what makes bash complete these arguments, for .bashrc"
    parser.add_argument("--completion", nargs=0, action=_Completion, help=text)
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress")
    return parser


def parsed(parser: argparse.ArgumentParser, words: List[str]) -> argparse.Namespace:
    """The arguments, YAW and --yaw as one ``yaw`` (degrees, or None)."""
    arguments = parser.parse_args([_plain(word) for word in words])
    if arguments.heading is not None and arguments.yaw is not None:
        parser.error("YAW and --yaw say the same; give one")
    if arguments.yaw is None:
        arguments.yaw = arguments.heading
    return arguments


def _plain(word: str) -> str:
    """argparse takes -1e-3 for an option, but nothing that has a space in it."""
    return f" {word}" if word.startswith("-") and _is_number(word) else word


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _seconds(text: str) -> float:
    value = _number(text)
    if value <= 0:
        raise ValueError(text)
    return value


def _node(text: str) -> str:
    if not text or not is_legal_name(text):
        raise ValueError(text)
    return text


_number.__name__, _seconds.__name__ = "number", "number of seconds"
_node.__name__ = "name of a node"


def tell(text: str) -> None:
    """One line on standard error."""
    sys.stderr.write(f"{PROGRAM}: {one_line(text)}\n")


def complain(text: str) -> None:
    """The same of an error."""
    tell(f"error: {text}")
