"""The shipped configuration of mesh_navigation, as users start it: maps, planner, controller."""

import os
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional

import numpy as np
import rospkg
import yaml
from mesh_map.map.coarse_edges import coarse_remark
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.execution.server_parameters import PARAMETERS
from mesh_navigation.plugins.controller import MeshController
from mesh_navigation.plugins.planner import MeshPlanner
from mesh_navigation.simulation.driving import make_controller
from mesh_navigation.surface.map_loading import load_map


@lru_cache(maxsize=None)
def configuration(name: str) -> Mapping[str, Any]:
    """A file of config/ by its name without .yaml."""
    folder = Path(rospkg.RosPack().get_path("mesh_navigation")) / "config"
    content: Dict[str, Any] = yaml.safe_load((folder / (name + ".yaml")).read_text("utf-8"))
    return content


def radius() -> float:
    """Of the robot (m)."""
    return float(configuration("planners")["robot_radius"])


def shipped_map(
    vertices: np.ndarray,
    faces: np.ndarray,
    max_edge_length: Optional[float] = None,
    layers: str = "mesh_map",
) -> MeshMap:
    """A mesh as it is loaded from a file, with the layers of one of the shipped configurations.

    Args:
        vertices: (V, 3) m.
        faces: (F, 3).
        max_edge_length: m; None: the one that the log recommends for this robot, half its radius.
            Where the log says nothing, single longer edges are halved until they are not.
        layers: name of the configuration, see `configuration`.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "world.h5")
        MapFile.write(file, Mesh(vertices=vertices, faces=faces))
        return shipped_map_of(file, max_edge_length, layers)


def shipped_map_of(
    file: Any, max_edge_length: Optional[float] = None, layers: str = "mesh_map"
) -> MeshMap:
    """The same of a file."""
    if max_edge_length is None:
        is_coarse = coarse_remark(load_map(file), {"the robot's radius": radius()})
        max_edge_length = 0.5 * radius() if is_coarse else radius()
    return load_map(
        file, configuration(layers), robot_radius=radius(), max_edge_length=max_edge_length
    )


def body(mesh_map: MeshMap, shape: Optional[RobotShape] = None) -> Body:
    """Of the shipped robot, or another one."""
    return Body(mesh_map.geometry, RobotShape(radius=radius()) if shape is None else shape)


def planners() -> List[Mapping[str, str]]:
    """Names and types, the default first."""
    listed: List[Mapping[str, str]] = configuration("planners")["planners"]
    return listed


def planner(mesh_map: MeshMap, of_body: Body, name: str = "") -> MeshPlanner:
    """One of `planners` with its parameters; by default the first."""
    found = next(one for one in planners() if name in ("", one["name"]))
    given = configuration("planners").get(found["name"], {})
    return make_planner(mesh_map, found["type"], given, of_body)


def controller(mesh_map: MeshMap, of_body: Body) -> MeshController:
    """The first one with its parameters."""
    found = configuration("controllers")["controllers"][0]
    given = configuration("controllers")[found["name"]]
    return make_controller(mesh_map, found["type"], given, of_body)


def server() -> Dict[str, Any]:
    """Values of the server's parameters that differ from their defaults."""
    given = {**configuration("planners"), **configuration("controllers")}
    return {one.name: given[one.name] for one in PARAMETERS if one.name in given}
