"""RViz with the configuration of this package, where its plugin is installed."""

import os
import shutil
import sys
from typing import List, Mapping, Optional, Sequence

import rospkg

PLUGIN = "rviz_mesh_plugin"
CONFIGURATION = "rviz/mesh_navigation.rviz"


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


def command_line(arguments: Sequence[str]) -> List[str]:
    """What is run; arguments are those of roslaunch, or a configuration of one's own."""
    given = [one for one in arguments if ":=" not in one]
    folder = rospkg.RosPack().get_path("mesh_navigation")
    own = given or ["-d", os.path.join(folder, CONFIGURATION)]
    return ["rviz", *own, *(one for one in arguments if ":=" in one)]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Becomes RViz; where that cannot be, says why and returns 0: what else runs goes on."""
    arguments = sys.argv[1:] if arguments is None else arguments
    why_not = missing(os.environ)
    if why_not:
        print(f"RViz is left out, all else goes on: {why_not}", file=sys.stderr, flush=True)
        return 0
    words = command_line(arguments)
    os.execvp(words[0], words)
