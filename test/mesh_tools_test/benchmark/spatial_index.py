#!/usr/bin/python3
"""Times of the spatial index beside Embree and beside a linear OpenCL scan, in the same run.

    spatial_index.py [--faces 2000000] [--repeats 5] [--only PART ...] [--growth] [--plot PNG]
        [--json FILE]

Parts: native (C++ beside Embree 3), selections (from Python, beside the linear scan), opencl
(batches on the OpenCL device), table1 (the five sizes and three modes of the paper's Table 1),
growth (each time from 10,000 faces to 1 million, with --growth to 10 million). Floors hold for
2 million faces on two cores. The mesh is the generated outdoor world.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any, List, Optional

import numpy as np
from mesh_map.spatial.spatial_index import SpatialIndex

from mesh_tools_test.base import figures
from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.spatial import growth, native, opencl, selections, table_one
from mesh_tools_test.spatial.linear_scan import LinearScan

PARTS = ("native", "selections", "opencl", "table1", "growth")
FLOORS_HOLD = 2_000_000  # faces


def linear_scan(vertices: np.ndarray, faces: np.ndarray) -> Optional[LinearScan]:
    """The peer without a hierarchy, None where no OpenCL device is."""
    device = opencl.device()
    return None if device is None else LinearScan(vertices, faces, device)


def measure(options: Any) -> List[figures.Figure]:
    """The figures of the parts that share one mesh, printed as they come."""
    vertices, faces = exact_world(options.faces)
    print(f"outdoor world, {len(vertices):,} vertices, {len(faces):,} faces; medians")
    device = opencl.device_name()
    print(f"OpenCL device: {device}" if device else "no OpenCL device: native code answers")
    found: List[figures.Figure] = []
    if "native" in options.only:
        beside = native.measure(vertices, faces, options.repeats)
        if beside is None:
            print("not measured: C++ and Embree (libembree-dev was not there when this was built)")
        found += beside or []
    if {"selections", "opencl"} & set(options.only):
        index = SpatialIndex(vertices, faces)
        scan = linear_scan(vertices, faces)
        if "selections" in options.only:
            found += selections.measure(index, vertices, scan, options.repeats)
        if "opencl" in options.only and device:
            found += opencl.measure(index, vertices, scan, options.repeats)
    if options.faces > FLOORS_HOLD:
        found = [figure._replace(floor=None) for figure in found]
    return found


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faces", type=int, default=2_000_000, help="size of the mesh")
    parser.add_argument("--repeats", type=int, default=5, help="of which the median is taken")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, metavar="PART")
    parser.add_argument("--growth", action="store_true", help="growth to 10 million faces")
    parser.add_argument("--plot", metavar="PNG", type=Path, help="also draw the growth there")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error("at least 1 repeat")
    results: List[figures.Figure] = []
    if set(options.only) - {"table1", "growth"}:
        results = measure(options)
        print(figures.table(results))
    if "table1" in options.only:
        print("\nTable 1 of the paper in milliseconds; ours on generated worlds of as many faces\n")
        print(table_one.table(options.repeats, opencl.device()))
    if "growth" in options.only or options.growth:
        sizes = [size for size in growth.SIZES if size <= options.faces] or [options.faces]
        sizes += [growth.LARGE] if options.growth else []
        grown = growth.measured(sizes, min(options.repeats, 3))
        print("\n" + grown.table())
        if options.plot:
            grown.plot(options.plot)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([figure._asdict() for figure in results], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
