"""RViz with the configuration of this package, where its plugin is installed."""

import os
import shutil
import sys
import tempfile
from typing import List, Mapping, Optional, Sequence

import rospkg

from mesh_navigation.commands.command_line import told_more

PLUGIN = "rviz_mesh_plugin"
CONFIGURATION = "rviz/mesh_navigation.rviz"
SERVER = "move_base_flex"
NODE_NAME = "_node_name:="
_HELP = """usage: mesh_rviz [_node_name:=SERVER] [CONFIGURATION.rviz] [RVIZ'S OPTIONS]

RViz with the map, costs, paths, the robot, the goal tool and the panel of navigation, for the
server of this name (default: move_base_flex). A configuration of one's own takes the place of ours.
"""


def missing(environment: Mapping[str, str]) -> str:
    """Why RViz cannot be shown, with the way out; empty where it can."""
    try:
        rospkg.RosPack().get_path(PLUGIN)
    except rospkg.ResourceNotFound:
        return f"the package {PLUGIN} is not installed, or not on ROS_PACKAGE_PATH; build it"
    if shutil.which("rviz", path=environment.get("PATH")) is None:
        return "there is no program rviz on PATH; install rviz"
    if not (environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")):
        return "there is no screen: set DISPLAY"
    return ""


def configuration(node_name: str) -> str:
    """The path of the configuration for a server of this name.

    That of this package is for move_base_flex; for another one, a copy with its topics is made in
    the temporary folder, in which RViz's Save would write, too.
    """
    path = os.path.join(rospkg.RosPack().get_path("mesh_navigation"), CONFIGURATION)
    if node_name == SERVER:
        return path
    with open(path, encoding="utf-8") as file:
        text = file.read().replace(f"/{SERVER}/", f"/{node_name}/")
    folder = tempfile.mkdtemp(prefix="mesh_rviz_")
    copy = os.path.join(folder, os.path.basename(CONFIGURATION))
    with open(copy, "w", encoding="utf-8") as file:
        file.write(text)
    return copy


def command_line(arguments: Sequence[str]) -> List[str]:
    """What is run; arguments are those of roslaunch, or a configuration of one's own.

    Among those of roslaunch, _node_name:=<name> is the server, by default move_base_flex.
    """
    given = [one for one in arguments if ":=" not in one]
    names = [one[len(NODE_NAME) :] for one in arguments if one.startswith(NODE_NAME)]
    own = given or ["-d", configuration(names[-1].strip("/") if names else SERVER)]
    others = [one for one in arguments if ":=" in one and not one.startswith(NODE_NAME)]
    return ["rviz", *own, *others]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Becomes RViz; where that cannot be, says why and returns 0: what else runs goes on."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if {"-h", "--help"}.intersection(arguments):
        print(f"{_HELP}\n{told_more('rviz')}", end="")
        return 0
    why_not = missing(os.environ)
    if why_not:
        print(f"RViz is left out, all else goes on: {why_not}", file=sys.stderr, flush=True)
        return 0
    words = command_line(arguments)
    os.execvp(words[0], words)
