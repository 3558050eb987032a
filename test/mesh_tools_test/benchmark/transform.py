#!/usr/bin/python3
"""Times of moving a mesh into another frame, beside one product in NumPy in the same run.

    transform.py [--vertices 1000000] [--repeats 9] [--json FILE]

The product is `vertices @ R.T + t` alone. A mesh has normals and faces too, so even the least work
is more than twice as much.
"""

import argparse
import json
import statistics
import time

import numpy as np
from geometry_msgs.msg import TransformStamped
from mesh_msgs import arrays
from mesh_msgs.transform import rotation_and_translation, transform_geometry


def median_ms(action, repeats: int) -> float:
    """Median time of an action in milliseconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return 1000.0 * statistics.median(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--vertices", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    rng = np.random.default_rng(0)
    vertices, normals = rng.normal(size=(2, arguments.vertices, 3))
    faces = rng.integers(0, len(vertices), (2 * len(vertices), 3)).astype(np.uint32)
    motion = TransformStamped()
    motion.transform.rotation.w = motion.transform.rotation.z = 0.5**0.5
    motion.transform.translation.x = 10.0
    rotation, translation = rotation_and_translation(motion)
    figures = {"product": median_ms(lambda: vertices @ rotation.T + translation, arguments.repeats)}
    for name, shown in (("vertices", normals[:0]), ("vertices and normals", normals)):
        mesh = arrays.MeshGeometryStamped(mesh_geometry=arrays.MeshGeometry(vertices, shown, faces))
        figures[name] = median_ms(lambda: transform_geometry(mesh, motion), arguments.repeats)
    print("%d vertices, %d faces" % (len(vertices), len(faces)))
    for name, value in figures.items():
        print("  %-22s %8.1f ms %6.2fx" % (name, value, value / figures["product"]))
    if arguments.json:
        with open(arguments.json, "w") as stream:
            json.dump(figures, stream, indent=2)


if __name__ == "__main__":
    main()
