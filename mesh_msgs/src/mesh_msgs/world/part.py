"""What a structure of the generated outdoor world is made of: a surface that grows out of holes in
the ground.

The boundary of such a hole is a ring of vertices that the ground and the structure share, so that
ground, walls, trunks and bridge are one surface without a seam.
"""

from typing import Callable, List, NamedTuple

import numpy as np

from mesh_msgs.world.zoo_mesh import grid_faces

# Heights (N,) of the ground at points (N, 2).
Height = Callable[[np.ndarray], np.ndarray]


class WorldPart(NamedTuple):
    """A structure on rings of the ground."""

    # The rings, each (R, 2), counter-clockwise seen from above.
    rings: List[np.ndarray]
    # (K, 3): discs x, y, radius that together with the rings' edges cover the holes
    cover: np.ndarray
    # (N, 3): the vertices that do not belong to the ground
    vertices: np.ndarray
    # (N, 3) RGB, floats 0..255
    colors: np.ndarray
    # (F, 3): indices count the vertices of the rings first, then those of the structure
    faces: np.ndarray


def random_faces(index: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Triangles over a grid of indices, the diagonals at random."""
    return grid_faces(index, rng.random((index.shape[0] - 1, index.shape[1] - 1)) < 0.5)


def closed(index: np.ndarray) -> np.ndarray:
    """The grid of indices with its first row again as its last."""
    return np.concatenate([index, index[:1]])


def mottled(
    color: np.ndarray, count: int, rng: np.random.Generator, strength: float = 0.16
) -> np.ndarray:
    """The color (3,) or (N, 3), a little lighter or darker at each of `count` vertices."""
    return color * (1.0 + strength * (rng.random((count, 1)) - 0.5))
