"""Where the robot drives: maps with the layers of the shipped configuration, or others."""

import os
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence

import numpy as np
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_msgs.outdoor_world import outdoor_world
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mesh_tools_test.driving import shipped
from mesh_tools_test.driving.furnished_building import Thing, furnished_building
from mesh_tools_test.driving.rough_terrain import rough_terrain

INSCRIBED_RADIUS, INFLATION_RADIUS = 0.3, 0.8  # m, of the robot, and what it keeps clear of
COST_LIMIT = 1.0  # of the planners, by default


class DrivingWorld:
    """A map, and where on it trips may begin and end.

    Attributes:
        name: for tables.
        mesh_map: with its layers.
        faces: (K,) ascending: faces that a robot may stand on, of one connected open ground.
            Whether a robot with a radius gets from each to each other one is not looked at.
        storeys: of the ends of trips, None where they may be anywhere: two sets of faces; trips
            lead from one to the other.
        things: that are known to stand there, apart from the map.
    """

    def __init__(
        self,
        name: str,
        mesh_map: MeshMap,
        heights: Sequence[float] = (),
        radius: float = 0.0,
        things: Sequence[Thing] = (),
    ) -> None:
        """
        Args:
            name: for tables.
            mesh_map: with its layers.
            heights: of the storeys (m), if trips lead from one to the other.
            radius: of the robot (m): at all corners of the faces it has that room.
            things: see there.
        """
        self.name, self.mesh_map, self.things = name, mesh_map, things
        self.faces = connected_open_faces(mesh_map)
        if radius > 0.0:
            front = SurfaceFront.of(mesh_map.geometry)
            distance = ObstacleDistance(front=front, max_distance=radius)
            distance.compute(~np.isfinite(mesh_map.costs))
            has_room = ~np.isfinite(distance.distances())
            self.faces = self.faces[has_room[mesh_map.faces[self.faces]].all(axis=1)]
        self.storeys: Optional[List[np.ndarray]] = None
        if heights:
            z = mesh_map.vertices[mesh_map.faces[self.faces]][:, :, 2]
            self.storeys = [self.faces[(z == height).all(axis=1)] for height in heights]


def connected_open_faces(mesh_map: MeshMap, cost_limit: float = COST_LIMIT) -> np.ndarray:
    """(K,) ascending: the largest set of faces that may be crossed anywhere and that are joined
    by edges. SciPy finds them, so that no solver of the project says what can be reached."""
    costs = mesh_map.costs
    with np.errstate(invalid="ignore"):
        open_vertices = np.isfinite(costs) & (costs <= cost_limit)
    open_faces = open_vertices[mesh_map.faces].all(axis=1)
    open_faces[mesh_map.geometry.faces_without_area] = False
    sides = mesh_map.topology.face_edges.astype(np.int64)
    count = len(open_faces)
    at = np.repeat(np.flatnonzero(open_faces), 3)
    edges = sides[open_faces].ravel()
    graph = coo_matrix(
        (np.ones(len(at), np.int8), (at, count + edges)), shape=(count + edges.max() + 1,) * 2
    )
    labels = connected_components(graph, directed=False)[1][:count]
    labels = np.where(open_faces, labels, -1)
    return np.flatnonzero(labels == np.argmax(np.bincount(labels[open_faces])))


def layer(name: str, kind: str, **params: Any) -> Dict[str, Any]:
    """An entry of a list of layers."""
    return {"name": name, "type": "mesh_layers/%sLayer" % kind, "params": params}


def robot_layers(step: float = 0.25, radius: float = 0.3) -> List[Dict[str, Any]]:
    """Where a small robot must not go: steps, steep ground, borders, low ceilings; and what it
    keeps from them.

    Args:
        step: m of height difference that are lethal.
        radius: m within which it is measured.
    """
    return [
        layer("height_diff", "HeightDiff", threshold=step, radius=radius, factor=0.2),
        layer("steepness", "Steepness", threshold=0.7, factor=0.2),
        layer("border", "Border", factor=0.0),
        layer("clearance", "Clearance", robot_height=0.7),
        layer(
            "inflation",
            "Inflation",
            inscribed_radius=INSCRIBED_RADIUS,
            inflation_radius=INFLATION_RADIUS,
            inscribed_value=1.5,
            repulsive_field=False,
        ),
    ]


def with_layers(mesh_map: MeshMap, layers: List[Dict[str, Any]]) -> MeshMap:
    """The map, after it has computed these; RuntimeError if one is left out."""
    mesh_map.compute_layers(layers)
    if mesh_map.layer_errors:
        raise RuntimeError("layers are left out: %s" % mesh_map.layer_errors)
    return mesh_map


def outdoor(faces: int = 60_000) -> DrivingWorld:
    """Hills, a road, walls, trees, a bridge."""
    world = outdoor_world(faces=faces, seed=0)
    mesh_map = shipped.shipped_map(world.vertices, world.faces, shipped.radius())
    return _shipped("outdoor", mesh_map)


def car_park(size: float = 24.0, cells: int = 96) -> DrivingWorld:
    """Two square floors above each other, joined by a ramp; all trips go from one to the other.

    Args:
        size: m, of a side; the upper floor is at an eighth of it, so that the ramp is as gentle.
        cells: along a side.
    """
    world = zoo.two_storeys(cells=cells, size=size, height=size / 8)
    mesh_map = shipped.shipped_map(world.vertices, world.faces, shipped.radius())
    return _shipped("two storeys", mesh_map, (0.0, size / 8))


def building() -> DrivingWorld:
    """Few large faces, refined when they are loaded; walls and furniture are parts of their own."""
    world = furnished_building()
    mesh_map = shipped.shipped_map(world.vertices, world.faces)
    return _shipped("building", mesh_map, things=world.things)


def rough(size: float = 30.0) -> DrivingWorld:
    """Rolling ground with noise of 5 cm."""
    return _shipped("rough", shipped.shipped_map(*rough_terrain(size)))


def tray(path: Path) -> DrivingWorld:
    """The coarse test world of other people: edges of half a meter, upright walls."""
    return _shipped("tray", shipped.shipped_map_of(path))


def _shipped(
    name: str, mesh_map: MeshMap, heights: Sequence[float] = (), things: Sequence[Thing] = ()
) -> DrivingWorld:
    return DrivingWorld(name, mesh_map, heights, shipped.radius(), things)


def tray_file() -> Optional[Path]:
    """Where tray.ply is, None if it is not at hand."""
    repository = Path(__file__).resolve().parents[5]
    folder = Path(os.environ.get("MESH_TOOLS_DATA", repository.parent / "shared" / "data"))
    path = folder / "tray.ply"
    return path if path.is_file() else None


def worlds(faces: int) -> Dict[str, Callable[[], DrivingWorld]]:
    """All that are at hand, by name; the outdoor world with about that many faces."""
    found: Dict[str, Callable[[], DrivingWorld]] = {
        "outdoor": lambda: outdoor(faces),
        "storeys": car_park,
        "building": building,
        "rough": rough,
    }
    path = tray_file()
    if path is not None:
        found["tray"] = lambda: tray(path)
    return found
