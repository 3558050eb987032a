#!/usr/bin/python3
"""Writes a generated mesh for tests in C++: write_world.py NAME FILE.

NAME is one of the zoo, "building", or "stairs" (of CAD: a floor, and stairs that touch it). FILE
has two uint32 (V, F), V * 3 float32 in meters and F * 3 uint32, little-endian.
"""

import sys

import numpy as np
from mesh_msgs.world.building import building
from mesh_msgs.world.solids import floor, joined, stairs
from mesh_msgs.zoo import all_meshes


def main() -> None:
    """Writes it."""
    name, path = sys.argv[1:3]
    if name == "building":
        vertices, faces = building()
    elif name == "stairs":
        steps = stairs((2.0, 0.0, 0.0), 1.2, 0.3, 0.17, 8, 0.3)
        vertices, faces = joined(floor((0.0, -1.0), (6.0, 3.0), 0.25), steps)
    else:
        mesh = next(mesh for mesh in all_meshes() if mesh.name == name)
        vertices, faces = mesh.vertices, mesh.faces
    with open(path, "wb") as file:
        file.write(np.array([len(vertices), len(faces)], "<u4").tobytes())
        file.write(np.asarray(vertices, "<f4").tobytes())
        file.write(np.asarray(faces, "<u4").tobytes())


if __name__ == "__main__":
    main()
