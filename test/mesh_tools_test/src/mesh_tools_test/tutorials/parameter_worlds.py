"""Small worlds in which one sees what a parameter does: tracks of steps and slopes, and rooms."""
import math
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

import numpy as np
from mesh_map.geometry.refinement import refine
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.world.solids import Part, box, floor, joined
from mesh_msgs.world.zoo_mesh import grid_faces

Rectangle = Tuple[float, float, float, float]  # x, y from; x, y to (m)
STEPS, SLOPES = (0.1, 0.2, 0.3), (10, 20, 30, 40)  # m, degrees
_WIDTH, _RISE = 1.6, 0.3  # m: of a track, and of its slopes
_RISER = 0.01  # m along x: no step of a scan is quite upright
_LEVEL = 0.9  # m between steps and slopes
_WALL = 2.0  # m high


class Thing(NamedTuple):
    """What stands or hangs on a track: x from and to, z from and to (m)."""

    begin: float
    end: float
    low: float
    high: float


THINGS = (
    Thing(1.0, 1.6, 0.0, 0.15),
    Thing(2.6, 3.2, 0.0, 0.3),
    Thing(4.2, 4.8, 0.0, 0.6),
    Thing(5.8, 6.8, 0.8, 0.88),
    Thing(7.8, 8.8, 1.1, 1.18),
    Thing(9.8, 10.8, 1.6, 1.68),
)
"""Three to climb, or to go around, and three to drive under."""


class Track(NamedTuple):
    """A surface along x that is the same all across, and what is on it.

    middle: vertices of the ground along its middle, in the order of x.
    """

    mesh_map: MeshMap
    middle: np.ndarray
    things: Sequence[Thing] = ()

    @property
    def profile(self) -> np.ndarray:
        """(N, 2) m: x and z along the middle."""
        return self.mesh_map.vertices[self.middle][:, [0, 2]]


class Room(NamedTuple):
    """A floor with walls, seen from above.

    floor: (F,) bool, the faces to be drawn.
    """

    mesh_map: MeshMap
    floor: np.ndarray
    walls: Sequence[Rectangle]


def layer(name: str, kind: str, **params: Any) -> Dict[str, Any]:
    """A layer of ours as a configuration has it."""
    return {"name": name, "type": f"mesh_layers/{kind}Layer", "params": params}


def steps_and_slopes() -> Tuple[List[Tuple[float, float]], List[Tuple[float, float, str]]]:
    """Corners (x, z) of a profile with STEPS and then SLOPES, down and up in turn; and the place
    of each with its name."""
    corners, names, x, z = [(0.0, 0.0)], [], 0.0, 0.0
    for step in STEPS:
        x += _LEVEL
        corners += [(x, z), (x + _RISER, z + step)]
        z += step
        names.append((x, z, f"step {step:g} m"))
    for number, slope in enumerate(SLOPES):
        run = _RISE / math.tan(math.radians(slope))
        x += _LEVEL
        corners.append((x, z))
        names.append((x + run / 2, z if number % 2 == 0 else z + _RISE, f"{slope}°"))
        x, z = x + run, z - _RISE if number % 2 == 0 else z + _RISE
        corners.append((x, z))
    return [*corners, (x + _LEVEL, z)], names


def track(
    corners: Sequence[Tuple[float, float]], edge: float, things: Sequence[Thing] = ()
) -> Track:
    """A track along a profile with edges of about that length."""
    pieces = []
    for start, end in zip(corners, corners[1:]):
        count = max(1, round(math.dist(start, end) / edge))
        pieces.append(np.linspace(start, end, count, endpoint=False))
    profile = np.concatenate([*pieces, [corners[-1]]])
    across = np.linspace(0.0, _WIDTH, 2 * max(1, round(_WIDTH / edge / 2)) + 1)
    x, y = np.meshgrid(profile[:, 0], across, indexing="ij")
    z = np.broadcast_to(profile[:, 1:], x.shape)
    index = np.arange(x.size).reshape(x.shape)
    ground = np.stack([x, y, z], axis=2).reshape(-1, 3), grid_faces(index)
    boxes = [
        box((each.begin, 0.2, each.low), (each.end, _WIDTH - 0.2, each.high)) for each in things
    ]
    return Track(_map(joined(ground, *boxes)), index[:, len(across) // 2], things)


def coarse_steps(max_edge_length: float) -> Track:
    """Steps of _RISE, far from each other, as of CAD: no vertices between, where edges are not made
    shorter (m; 0: they are not)."""
    corners, z = [(0.0, 0.0)], 0.0
    for x in (1.5, 4.0, 6.5):
        corners += [(x, z), (x + _RISER, z + _RISE)]
        z += _RISE
    made = track([*corners, (8.0, z)], 10.0)
    derived = refine(made.mesh_map.vertices, made.mesh_map.faces, max_edge_length or 100.0)
    if derived is None:
        return made
    mesh_map = _map((derived.vertices, derived.faces))
    middle = np.flatnonzero(np.abs(derived.vertices[:, 1] - _WIDTH / 2) < 1e-4)
    order = np.lexsort((derived.vertices[middle, 2], derived.vertices[middle, 0]))
    return Track(mesh_map, middle[order])


def room(
    size: Tuple[float, float],
    walls: Sequence[Rectangle],
    edge: float,
    max_edge_length: float = 0.0,
    mound: float = 0.0,
) -> Room:
    """A floor from (0, 0) with upright walls.

    :param size: m along x and y
    :param edge: m, of the floor's faces
    :param max_edge_length: m; 0: edges stay as they are
    :param mound: m, the height of one in the middle; its foot is 3 m from there
    """
    ground = floor((0.0, 0.0), size, edge)
    if mound:
        away = np.hypot(*(ground[0][:, :2] - np.array(size) / 2).T)
        ground[0][:, 2] = mound / 2 * (1 + np.cos(math.pi * np.minimum(away / 3.0, 1.0)))
    boxes = [box((a, b, -0.1), (c, d, _WALL)) for a, b, c, d in walls]
    vertices, faces = joined(ground, *boxes)
    is_floor = np.arange(len(faces)) < len(ground[1])
    derived = refine(vertices, faces, max_edge_length) if max_edge_length else None
    if derived is not None:
        vertices, faces = derived.vertices, derived.faces
        is_floor = is_floor[derived.face_parents]
    return Room(_map((vertices, faces)), is_floor, walls)


def _map(part: Part) -> MeshMap:
    vertices, faces = part
    return MeshMap(np.asarray(vertices, np.float32), np.asarray(faces, np.uint32))
