"""A generated outdoor world of any size.

Hills, a road, a path, walls, trees, stairs on request, and a bridge one can drive over and under.
It is what a large scanned map is like, without a download: irregular triangles, steep and gentle
ground, vertical walls, several components, and two levels at the bridge.
"""

from typing import List, Optional

import numpy as np

from mesh_msgs.world import bridge, layout as plan, structures
from mesh_msgs.world.part import WorldPart
from mesh_msgs.world.terrain import Terrain
from mesh_msgs.world.triangulation import triangulate
from mesh_msgs.world.zoo_mesh import ZooMesh

LEAST_FACES, MOST_FACES = 1_000, 10_000_000
SIZES = 24.0, 100.0  # m, the smallest and the largest side
LEAST_WITH_STAIRS = 38.0  # m, the smallest side that has room for them
_TRAITS = frozenset("boundary manifold oriented orientable multi_level".split())


def outdoor_world(
    faces: int = 200_000,
    seed: int = 0,
    *,
    size: Optional[float] = None,
    trees: bool = True,
    stairs: bool = False,
) -> ZooMesh:
    """Generate an outdoor world of about `faces` triangles (within 2 %).

    The same arguments give the same bytes. Vertices are in meters around the origin, z up; the side
    of the square world grows from 24 m (1,000 faces) over 60 m (200,000) to 100 m (2 million and
    more), so that the structures keep their real size at any resolution. Ground, walls, trunks and
    bridge are one manifold surface whose only boundary is the border of the world; the crowns of
    the trees are closed surfaces of their own.

    Colors are those of grass, rock, road, path, stone, wood, leaves and concrete. Places (each a
    vertex): `start` and `goal`, far apart on ground that can be driven on, a walled garden around
    the goal; `bridge_deck` in the middle of the bridge, and `under_bridge` on the road beneath it.

    :param size: the side of the world in meters, 24 to 100 (with stairs 38 to 100); None: as above.
    :param trees: whether there are any; without them the world is one component.
    :param stairs: steps of 17 cm up to a landing, and a ramp down behind it (`landing` is a place).
    :raises ValueError: if `faces` is not within 1,000 .. 10,000,000, or the side of the world not
      within its limits.
    """
    # Written so that NaN is refused, too.
    if not LEAST_FACES <= faces <= MOST_FACES:
        raise ValueError(
            f"outdoor_world: faces = {faces}, but {LEAST_FACES} to {MOST_FACES} are possible"
        )
    if size is None:
        size = float(np.clip(60.0 * (faces / 200_000) ** 0.222, *SIZES))
    least = LEAST_WITH_STAIRS if stairs else SIZES[0]
    if not least <= size <= SIZES[1]:
        text = "outdoor_world: size = %s, but %g to %g m are possible"
        raise ValueError(text % (size, least, SIZES[1]))
    edge = size * float(np.sqrt(2.0 / faces))
    layout = plan.WorldLayout(size, seed, trees, stairs)
    terrain = Terrain(layout, seed, edge)
    parts = _parts(layout, terrain, edge, seed)

    rings = [ring for part in parts for ring in part.rings]
    cover = np.concatenate([part.cover for part in parts])
    ground_faces = faces - sum(len(part.faces) for part in parts)
    ground = triangulate(size, ground_faces, rings, cover, seed)
    points = np.concatenate([ground.free] + rings)
    return _assemble(terrain, parts, points, len(ground.free), ground.faces)


def _parts(layout: plan.WorldLayout, terrain: Terrain, edge: float, seed: int) -> List[WorldPart]:
    rng = np.random.default_rng([seed, 6])
    parts = [bridge.bridge(terrain.height, edge, rng)]
    parts += [structures.wall(wall, terrain.height, edge, rng) for wall in layout.walls]
    if layout.stairs is not None:
        parts.append(structures.stairs(layout.stairs, terrain.height, edge, rng))
    parts += [structures.trunk(tree, terrain.height, edge, rng) for tree in layout.trees]
    # Nobody drives on leaves: larger triangles.
    parts += [structures.crown(tree, terrain.height, 1.6 * edge, rng) for tree in layout.trees]
    return parts


def _assemble(
    terrain: Terrain,
    parts: List[WorldPart],
    ground: np.ndarray,
    free: int,
    ground_faces: np.ndarray,
) -> ZooMesh:
    """Join the ground (points (N, 2), the first `free` of them not on rings) and the structures."""
    lifted = np.column_stack([ground, terrain.height(ground)])
    vertices = np.concatenate([lifted] + [part.vertices for part in parts])
    faces = [ground_faces.astype(np.uint32)]
    ring, own = free, len(ground)
    for part in parts:
        size = sum(len(points) for points in part.rings)
        moved = np.where(part.faces < size, part.faces + ring, part.faces - size + own)
        faces.append(moved.astype(np.uint32))
        ring, own = ring + size, own + len(part.vertices)
    color = terrain.color(ground, _slopes(lifted, ground_faces))
    colors = np.concatenate([color] + [part.colors for part in parts])
    vertices = vertices.astype(np.float32)

    layout = terrain.layout
    places = {}
    spots = {"start": layout.start, "goal": layout.goal, "under_bridge": (0.0, 0.0)}
    for name, where in spots.items():
        places[name] = vertices[np.square(ground - where).sum(axis=1).argmin()]
    first = np.cumsum([len(ground)] + [len(part.vertices) for part in parts])
    deck = vertices[first[0] : first[1]]
    high = (np.abs(deck[:, 1]) < 1.0) & (deck[:, 2] > plan.PATH_LEVEL)
    places["bridge_deck"] = deck[high][np.square(deck[high, :2]).sum(axis=1).argmin()]
    if layout.stairs is not None:
        number = 1 + len(layout.walls)
        own = vertices[first[number] : first[number + 1]]
        top = own[own[:, 2] >= own[:, 2].max() - 1e-3]
        away = np.square(top[:, :2] - layout.stairs.landing_middle).sum(axis=1)
        places["landing"] = top[away.argmin()]
    return ZooMesh(
        "outdoor_world",
        vertices,
        np.concatenate(faces),
        _TRAITS,
        np.clip(np.rint(colors), 0, 255).astype(np.uint8),
        {name: (float(x), float(y), float(z)) for name, (x, y, z) in places.items()},
    )


def _slopes(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the angles (radians) between the z axis and the area-weighted vertex normals."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    sums = [
        sum(np.bincount(faces[:, corner], normals[:, axis], len(vertices)) for corner in range(3))
        for axis in range(3)
    ]
    return np.arctan2(np.hypot(sums[0], sums[1]), sums[2])
