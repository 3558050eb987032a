"""The arguments of the command go_to."""

import argparse
from typing import List

from rosgraph.names import is_legal_name

from mesh_navigation.command_line import CommandParser, is_number, number

PROGRAM = "go_to"
SERVER = "move_base_flex"


class _Parser(CommandParser):
    def error(self, message: str) -> None:
        # The space of `_plain` is not the user's.
        super().error(message.replace(": ' -", ": '-"))


def make_parser() -> argparse.ArgumentParser:
    """The parser of the arguments."""
    parser = _Parser(
        prog=PROGRAM,
        usage="%(prog)s X Y Z [YAW] [options]",
        description="Let the robot go to a place on the map, and wait until it is there. "
        "Ctrl+C stops it.",
        epilog="exit codes: 0 it is there (or there is a plan), 1 it is not, 2 wrong usage or no "
        "server, 130 Ctrl+C. example: rosrun mesh_navigation go_to 8 9 0.5",
    )
    for name in "XYZ":
        parser.add_argument(name.lower(), metavar=name, type=number, help="m")
    text = "heading at the goal in degrees (default: as the path arrives)"
    parser.add_argument("heading", metavar="YAW", nargs="?", type=number, help=text)
    parser.add_argument("--yaw", type=number, metavar="DEGREES", help="another way to say YAW")
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
    return f" {word}" if word.startswith("-") and is_number(word) else word


def _seconds(text: str) -> float:
    value = number(text)
    if value <= 0:
        raise ValueError(text)
    return value


def _node(text: str) -> str:
    if not text or not is_legal_name(text):
        raise ValueError(text)
    return text


_seconds.__name__, _node.__name__ = "number of seconds", "name of a node"
