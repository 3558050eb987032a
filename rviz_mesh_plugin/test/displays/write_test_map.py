#!/usr/bin/python3
"""Writes a map of everything that RViz shows: write_test_map.py FILE [SQUARES].

SQUARES squares (4) of 1 m along the x-axis at z = 0, seen from above, each of four vertices and two
faces of its own. Squares 0 to 3 have what the tests know by heart.
"""
import sys
from typing import Sequence

import numpy as np
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh


def picture(top: Sequence[int], bottom: Sequence[int]) -> np.ndarray:
    """(64, 64, 3) uint8: the upper half has one color, the lower half the other."""
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:32] = top
    pixels[32:] = bottom
    return pixels


def test_map(squares: int) -> Mesh:
    """The mesh with its attributes; squares beyond the fourth are like it."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    index = np.minimum(np.arange(squares), 3)
    vertices = np.concatenate([corners + np.float32([i, 0, 0]) for i in range(squares)])
    colors = np.uint8([[255, 0, 0], [0, 0, 255], [10, 200, 90], [255, 255, 255]])
    faces = (
        np.uint32([[[0, 1, 2], [0, 2, 3]]])
        + 4 * np.arange(squares, dtype=np.uint32)[:, np.newaxis, np.newaxis]
    )
    return Mesh(
        vertices=vertices,
        faces=faces.reshape(-1, 3).astype(np.uint32),
        vertex_colors=np.repeat(colors[index], 4, axis=0),
        vertex_costs={
            "height_diff": np.repeat(index, 4).astype(np.float32),
            "roughness": np.repeat(3 - index, 4).astype(np.float32),
        },
        layer_parameters={
            "roughness": {"layer_info": {"unit": "m", "comparison": "above", "threshold": 1.5}}
        },
        face_attributes={"steepness": np.repeat(index % 2, 2).astype(np.float32)},
        texture_coordinates=np.tile(corners[:, :2], (squares, 1)),
        textures={
            0: picture((200, 100, 0), (0, 100, 200)),
            1: picture((60, 70, 80), (60, 70, 80)),
        },
        materials=Materials(
            colors=np.uint8([[1, 2, 3], [4, 5, 6], [90, 30, 150]]),
            texture_indices=np.int32([0, 1, -1]),
            face_materials=np.repeat(np.minimum(index, 2), 2).astype(np.uint32),
        ),
        labels={
            "tree_1": Label(np.uint32([0, 1])),
            "wall_1": Label(np.uint32([4, 5]), (10, 20, 30)),
        },
    )


if __name__ == "__main__":
    MapFile.write(sys.argv[1], test_map(int(sys.argv[2]) if len(sys.argv) > 2 else 4))
