"""Commands and nodes, by what they say to --help."""
import argparse
import importlib
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Tuple

from mesh_msgs_hdf5.commands import VERBS, mesh_tool

from mesh_tools_test.reference.markdown import block, page
from mesh_tools_test.reference.plugin_pages import exported_verbs
from mesh_tools_test.reference.repository import ROOT

_COLUMNS = "100"
_SECONDS = 60.0


class Program(NamedTuple):
    """What users start: how they do, and the file below the top of the repository."""

    command: str
    path: str


PROGRAMS = (
    Program("./run", "run"),
    Program("./run demo", "test/mesh_tools_test/nodes/demo"),
    Program("plan", "mesh_navigation/mesh_navigation/nodes/plan"),
    Program("go_to", "mesh_navigation/mesh_navigation/nodes/go_to"),
    Program("mesh_rviz", "mesh_navigation/mesh_navigation/nodes/mesh_rviz"),
    Program("headless", "test/osmesa_harness/scripts/headless"),
)
NODES = (
    Program("hdf5_map_server", "mesh_msgs_hdf5/nodes/hdf5_map_server"),
    Program("label_manager", "mesh_msgs_hdf5/nodes/label_manager"),
    Program("mesh_map", "mesh_map/nodes/mesh_map"),
    Program("mbf_mesh_nav", "mesh_navigation/mesh_navigation/nodes/mbf_mesh_nav"),
    Program("goal_bridge", "mesh_navigation/mesh_navigation/nodes/goal_bridge"),
    Program("surface_robot", "mesh_navigation/mesh_navigation/nodes/surface_robot"),
    Program("mesh_localization", "mesh_navigation/mesh_localization/nodes/mesh_localization"),
)


@contextmanager
def _wide() -> Iterator[None]:
    """Within, argparse has as much room as a page."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = _COLUMNS
    try:
        yield
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before


def helps(parser: argparse.ArgumentParser) -> Iterator[Tuple[str, str]]:
    """The name and the help of a parser without parsers below it, else of each of these."""
    below = [one for one in parser._actions if isinstance(one, argparse._SubParsersAction)]
    if not below:
        yield parser.prog, parser.format_help()
    for action in below:
        for one in action.choices.values():
            yield from helps(one)


def _verbs(packages: Dict[str, Path]) -> List[Tuple[str, str]]:
    """Name and help of every verb of mesh_tool, and of each of its actions."""
    with _wide():
        found = list(helps(mesh_tool.make_parser(VERBS)))
        for folder in packages.values():
            for name, module_name, _ in exported_verbs(folder):
                module = importlib.import_module(module_name)
                example = "example: rosrun mesh_msgs_hdf5 " + module.EXAMPLE
                program = "%s %s" % (mesh_tool.PROGRAM, name)
                parser = argparse.ArgumentParser(program, description=module.HELP, epilog=example)
                module.add_arguments(parser)
                found += helps(parser)
    return found


def _help(program: Program) -> str:
    """What a program prints; raises RuntimeError with that where it fails."""
    path = ROOT / program.path
    with path.open(encoding="utf-8") as file:
        starter = [sys.executable] if "python" in file.readline() else ["bash"]
    done = subprocess.run(
        [*starter, str(path), "--help"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=_SECONDS,
        env=dict(os.environ, COLUMNS=_COLUMNS),
        check=False,
    )
    text = done.stdout.decode("utf-8")
    if done.returncode:
        raise RuntimeError("%s --help ended with %d: %s" % (path, done.returncode, text[-500:]))
    return text.replace(str(ROOT), "…")


def command_page(packages: Dict[str, Path]) -> str:
    """The page of all commands and nodes.

    :raises RuntimeError: one that does not answer --help
    """
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        texts = dict(zip(PROGRAMS + NODES, pool.map(_help, PROGRAMS + NODES)))
        verbs = _verbs(packages)

    def sections(mark, programs):
        return [page("%s %s" % (mark, one.command), block(texts[one])) for one in programs]

    with _wide():
        own = mesh_tool.make_parser().format_help()
    return page(
        "# Commands",
        "What each says to `--help`. More of it is told with its package:"
        " [mesh_tool](packages/mesh_msgs_hdf5.md#command-mesh_tool),"
        " [plan](packages/mesh_navigation.md#the-command-plan),"
        " [go_to](packages/mesh_navigation.md#clients).",
        "## mesh_tool",
        block(own),
        *(page("### " + name, block(text)) for name, text in verbs),
        *sections("##", PROGRAMS),
        "## Nodes",
        "Their topics, services and parameters: [nodes](nodes.md).",
        *sections("###", NODES),
    )
