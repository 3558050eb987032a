"""The nodes: where their code is, and the parameters that it declares."""
from pathlib import Path
from typing import Dict, FrozenSet, List, NamedTuple, Tuple

from mesh_localization.node import parameters as localization_parameters
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import OF_ALL
from mesh_map.io.map_parameters import FILE_PARAMETERS, GEOMETRY_PARAMETERS
from mesh_map.ros.mesh_map_server import COSTS_PERIOD, LAYER_TIMEOUT
from mesh_map.ros.node_end import SHUTDOWN_TIMEOUT
from mesh_map.ros.reconfigure import MAP_PARAMETERS
from mesh_navigation.body.robot_shape import SHAPE_PARAMETERS
from mesh_navigation.commands import goal_bridge_node
from mesh_navigation.execution import server_parameters
from mesh_navigation.plugins.plugin_list import BEHAVIORS, CONTROLLERS, PLANNERS
from mesh_navigation.server.ros.check_services_node import COST_LIMIT
from mesh_navigation.simulation import parameters as simulation_parameters

from mesh_tools_test.reference.names_in_code import NameGatherer, Use, python_files
from mesh_tools_test.reference.plugin_pages import INPUTS
from mesh_tools_test.reference.repository import ROOT

_HDF5 = "mesh_msgs_hdf5/src/mesh_msgs_hdf5/"
_MAP = "mesh_map/src/mesh_map/"
_NAVIGATION = "mesh_navigation/mesh_navigation/src/mesh_navigation/"
_LOCALIZATION = "mesh_navigation/mesh_localization/src/mesh_localization/"
_LIBRARY = "mesh_msgs/src/mesh_msgs/"
_SOURCES = (_LIBRARY, _HDF5, _MAP, _NAVIGATION, _LOCALIZATION)


class Node(NamedTuple):
    """A node, or what is served within one.

    package: whose README tells of it.
    heading: below which it does.
    code: folders and files that are run by it alone, or by several nodes.
    declared: name -> parameter, as the README names it (without ~).
    others: names of parameters without a declaration, beside those that are read by their names.
    dynamic: names of parameters that dynamic_reconfigure serves.
    embeds: names of nodes whose topics and services it has, too.
    """

    name: str
    package: str
    heading: str
    code: Tuple[str, ...]
    declared: Dict[str, Parameter] = {}
    others: FrozenSet[str] = frozenset()
    embeds: Tuple[str, ...] = ()
    dynamic: Tuple[str, ...] = ()


def _declared(*parameters: Parameter, below: str = "") -> Dict[str, Parameter]:
    return {below + one.name: one for one in parameters}


NODES = (
    Node(
        "hdf5_map_server",
        "mesh_msgs_hdf5",
        "Node hdf5_map_server",
        (_HDF5 + "server", _HDF5 + "ros"),
    ),
    Node(
        "label_manager",
        "mesh_msgs_hdf5",
        "Node label_manager",
        (_HDF5 + "label_manager", _HDF5 + "ros"),
    ),
    Node(
        "mesh_map",
        "mesh_map",
        "Node `mesh_map`",
        (_MAP + "ros", _HDF5 + "ros/label_services_ros.py"),
        _declared(
            *FILE_PARAMETERS,
            *GEOMETRY_PARAMETERS,
            *MAP_PARAMETERS,
            COSTS_PERIOD,
            LAYER_TIMEOUT,
            SHUTDOWN_TIMEOUT,
            *OF_ALL,
            INPUTS,
        ),
        frozenset(["layers"]),
        dynamic=tuple(one.name for one in MAP_PARAMETERS),
    ),
    Node(
        "mbf_mesh_nav",
        "mesh_navigation",
        "Node `mbf_mesh_nav`",
        (_NAVIGATION + "server", _NAVIGATION + "velocity_guard", _NAVIGATION + "base"),
        {
            **_declared(*server_parameters.PARAMETERS, *SHAPE_PARAMETERS),
            **_declared(COST_LIMIT, SHUTDOWN_TIMEOUT),
            **_declared(*server_parameters.GUARD_PARAMETERS, below="guard/"),
        },
        frozenset(kind.parameter.lstrip("~") for kind in (PLANNERS, CONTROLLERS, BEHAVIORS)),
        ("mesh_map",),
        tuple(one.name for one in server_parameters.DYNAMIC_PARAMETERS),
    ),
    Node(
        "goal_bridge",
        "mesh_navigation",
        "Clients",
        (_NAVIGATION + "commands/goal_bridge_node.py",),
        _declared(*goal_bridge_node.PARAMETERS),
    ),
    Node(
        "surface_robot",
        "mesh_navigation",
        "Node `surface_robot`",
        (_NAVIGATION + "simulation",),
        _declared(*simulation_parameters.PARAMETERS),
    ),
    Node(
        "mesh_localization",
        "mesh_localization",
        "Node `mesh_localization`",
        (_LOCALIZATION + "node", _LOCALIZATION + "ros"),
        _declared(*localization_parameters.PARAMETERS),
        dynamic=tuple(one.name for one in localization_parameters.DYNAMIC_PARAMETERS),
    ),
)


def gathered_uses() -> List[Use]:
    """The names that the packages of nodes give to ROS."""
    own = [ROOT / name for node in NODES for name in node.code]
    paths = [path for source in _SOURCES for path in sorted(python_files(ROOT / source))]
    return NameGatherer(path for path in paths if _is_at_the_rim(path, own)).uses()


def _is_at_the_rim(path: Path, own: List[Path]) -> bool:
    """What knows nothing of ROS gives it no names, but what reads a node's parameters does."""
    return bool({path, *path.parents}.intersection(own)) or "rospy" in path.read_text("utf-8")


def uses_of(node: Node, uses: List[Use]) -> List[Use]:
    """Those in the code of a node."""
    folders = [ROOT / name for name in node.code]
    return [use for use in uses if {use.path, *use.path.parents}.intersection(folders)]


def readme_of(node: Node, packages: Dict[str, Path]) -> Path:
    """The file that tells of it."""
    return packages[node.package] / "README.md"
