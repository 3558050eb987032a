#!/usr/bin/python3
"""From scans to maps: times, accuracy and memory of the reconstruction, and refined poses.

    reconstruction.py [--only PART ...] [--scans 60] [--repeats 3] [--pictures DIR] [--json FILE]

Parts: field (integration and extraction beside one thread; memory), accuracy (of the mesh beside
the surface as it comes out of the field; against the truth), refine (poses of a loop by odometry
that drifts, laid onto each other), bag (10 million points to a saved map with five layers, by the
command in a process of its own), peer (screened Poisson of Open3D, where python3-open3d is
installed). The world is 40 x 40 m of rough ground with bridge, stairs and walls, generated; 60
scans of it have 2.8 million points with colors and 15 mm of noise. Floors hold for these, on two
cores.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Callable, Dict, List

from mesh_tools_test.base import figures
from mesh_tools_test.base.scanned_world import FACES, SCANS
from mesh_tools_test.reconstruction import accuracy, bags_ros, fields, peers, pictures, poses
from mesh_tools_test.reconstruction.scene import Scene

Part = Callable[[Scene], List[figures.Figure]]


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    names = ("field", "accuracy", "refine", "bag", "peer")
    parser.add_argument("--faces", type=int, default=FACES, help="of the world")
    parser.add_argument("--scans", type=int, default=SCANS, help="of the world")
    parser.add_argument("--columns", type=int, default=0, help="of the lidar, else all it has")
    parser.add_argument("--points", type=int, default=bags_ros.POINTS, help="in the bag")
    parser.add_argument("--repeats", type=int, default=3, help="of which the median is taken")
    parser.add_argument("--only", nargs="+", choices=names, default=names, metavar="PART")
    parser.add_argument("--pictures", metavar="DIR", type=Path, help="also draw them into DIR")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    if min(options.repeats, options.scans, options.points) < 1 or options.columns < 0:
        parser.error("at least 1 repeat, scan and point, and no columns below 0")
    parts: Dict[str, Part] = {
        "field": lambda scene: fields.measure(scene, options.repeats),
        "accuracy": lambda scene: accuracy.measure(scene, options.repeats),
        "refine": poses.measure,
        "bag": lambda scene: bags_ros.measure(scene, options.points),
        "peer": peers.measure,
    }
    scene = Scene(options.faces, options.scans, options.columns)
    sizes = (len(scene.world.mesh.faces), len(scene.scans), scene.points)
    print("world of %d faces, %d scans of %.2f M points; medians, of long parts one run" % sizes)
    found: List[figures.Figure] = []
    for name in names:
        if name not in options.only:
            continue
        some = parts[name](scene)
        if not scene.is_usual or options.points != bags_ros.POINTS:
            some = [figure._replace(floor=None) for figure in some]
        print(figures.table(some, heading=not found), flush=True)
        if not some:
            print("%s: Open3D (python3-open3d) is not installed: no Poisson beside it" % name)
        found += some
    if options.pictures:
        for path in pictures.write_pictures(scene, options.pictures):
            print(path)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([figure._asdict() for figure in found], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
