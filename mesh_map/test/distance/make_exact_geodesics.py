#!/usr/bin/python3
"""Computes exact_geodesics.npz: exact geodesic distances on the meshes of geodesic_samples.py.

    make_exact_geodesics.py [--sources 3] [--samples 500] [--output exact_geodesics.npz]

Needs pygeodesic (pip install pygeodesic), which no package depends on, and the meshes of the data
folder (environment variable MESH_TOOLS_DATA).
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))  # meshes.py
import geodesic_samples  # noqa: E402

MOST_BYTES = 200_000


def measured(mesh, sources, count, random):
    """The arrays of one mesh: sources, sampled vertices, and distances between them."""
    from pygeodesic import geodesic

    algorithm = geodesic.PyGeodesicAlgorithmExact(
        np.ascontiguousarray(mesh.vertices, np.float64), np.ascontiguousarray(mesh.faces, np.int32)
    )
    total = len(mesh.vertices)
    starts = np.sort(random.choice(total, sources, replace=False))
    vertices = np.sort(random.choice(total, min(count, total), replace=False))
    rows = [algorithm.geodesicDistances(np.array([start]), vertices)[0] for start in starts]
    distances = np.array(rows)
    if not (np.isfinite(distances).all() and distances.max() < 1e6):
        raise SystemExit("%s: not all vertices are reached" % mesh.name)
    return starts.astype(np.uint32), vertices.astype(np.uint32), distances.astype(np.float32)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sources", type=int, default=3, help="of each mesh")
    parser.add_argument("--samples", type=int, default=500, help="vertices of each mesh")
    parser.add_argument("--output", default=str(geodesic_samples.FILE), help="file to write")
    options = parser.parse_args()
    arrays = {}
    for number, (name, recipe) in enumerate(geodesic_samples.RECIPES.items()):
        mesh, start = recipe(), time.perf_counter()
        random = np.random.default_rng(number)
        found = measured(mesh, options.sources, options.samples, random)
        arrays[name + "/mesh"] = geodesic_samples.fingerprint(mesh)
        arrays.update(zip((name + "/sources", name + "/vertices", name + "/distances"), found))
        print(
            "%-14s %6d vertices, to %.1f m, %.1f s"
            % (name, len(mesh.vertices), found[2].max(), time.perf_counter() - start)
        )
    np.savez_compressed(options.output, **arrays)
    with open(options.output, "rb") as file:
        size = len(file.read())
    print("%s: %d bytes" % (options.output, size))
    return 0 if size <= MOST_BYTES else 1


if __name__ == "__main__":
    sys.exit(main())
