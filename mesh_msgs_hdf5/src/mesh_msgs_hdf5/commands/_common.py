"""What the verbs of mesh_tool share: options and output."""
import argparse
import json
import math
import os
from typing import Any, Dict, Iterable, Optional, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.files.probe import read_head
from mesh_msgs_hdf5.files.save import check_target
from mesh_msgs_hdf5.formats.base.foreign_labels import read_class_names
from mesh_msgs_hdf5.model.errors import MapFileError

MAP_SUFFIXES = (".h5", ".hdf5")


def add_output_options(parser: argparse.ArgumentParser, quiet: str = "no progress bar") -> None:
    """The options --json and --quiet."""
    parser.add_argument("--json", action="store_true", help="output for programs, strict JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help=quiet)


def add_part(parser: argparse.ArgumentParser, whose: str = "a map file with several") -> None:
    """The option --part."""
    text = "which mesh of %s (default: mesh, or the only one)" % whose
    parser.add_argument("--part", metavar="NAME", help=text)


def add_actions(
    parser: argparse.ArgumentParser,
    verb: str,
    actions: Dict[str, Tuple[str, str]],
    of_a_part: bool = True,
) -> Dict[str, argparse.ArgumentParser]:
    """A parser with FILE and the common options for each action: name -> (help, example).

    of_a_part: --part is one of them.
    """
    below = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    parsers = {}
    for name, (text, example) in actions.items():
        epilog = "example: rosrun mesh_msgs_hdf5 mesh_tool %s %s %s" % (verb, name, example)
        parsers[name] = below.add_parser(name, help=text, description=text, epilog=epilog)
        parsers[name].add_argument("file", metavar="FILE", help="the map file")
        if of_a_part:
            add_part(parsers[name])
        add_output_options(parsers[name], "say nothing but what was asked for")
    return parsers


def say(arguments: argparse.Namespace, value: Any, lines: Iterable[str]) -> None:
    """Print a result: value for programs (--json), else the lines, unless --quiet."""
    if arguments.json:
        print(json_text(value))
    elif not arguments.quiet:
        for line in lines:
            print(line[: len(line) - len(line.lstrip(" "))] + one_line(line))


def json_text(value: Any) -> str:
    """Strict JSON in ASCII: what JSON has no numbers for becomes "NaN", "Infinity", "-Infinity"."""
    return json.dumps(_plain(value), indent=2, allow_nan=False)


def _plain(value):
    if isinstance(value, dict):
        return {_plain(str(key)): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if value != value else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, str):  # a file name may hold bytes that are no text
        return value.encode("utf-8", "backslashreplace").decode("utf-8")
    return value


def check_output(source: Optional[str], target: str, force: bool, suffixes=MAP_SUFFIXES) -> None:
    """Refuse early what cannot be read or written.

    source: the file that is read; it must not be the target.
    """
    if not target.lower().endswith(tuple(suffixes)):
        named = " or ".join(suffixes)
        raise MapFileError(
            "name", target, "the name of the output ends with %s" % named, "IN OUT, in this order"
        )
    check_target(target, force)
    if source is not None:
        read_head(source)
        if os.path.exists(target) and os.path.samefile(source, target):
            raise MapFileError("exists", target, "IN and OUT are the same file", "name another OUT")


def add_classes(parser: argparse.ArgumentParser) -> None:
    """The option --classes."""
    text = "with --ids: the numbers of classes in this table (JSON or CSV), others come behind them"
    parser.add_argument("--classes", metavar="TABLE", help=text)


def known_classes(arguments: argparse.Namespace) -> Dict[int, str]:
    """The classes of --classes by their numbers. Raises MapFileError."""
    return read_class_names(arguments.classes).classes if arguments.classes is not None else {}


def class_table(output: str) -> str:
    """The name of the table of classes beside a file."""
    return os.path.splitext(output)[0] + "_classes.json"


def own_output(arguments: argparse.Namespace) -> str:
    """Where a verb writes whose OUT.h5 may be left out: then FILE itself, in one step; checked."""
    output = arguments.output
    if output is None:
        output, arguments.force = arguments.input, True
        read_head(output)
        check_output(None, output, True)
    else:
        check_output(arguments.input, output, arguments.force)
    return str(output)


def file_bytes(path: str) -> int:
    """The size of a file that was just written."""
    return os.stat(path).st_size
