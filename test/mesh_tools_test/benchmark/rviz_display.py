#!/usr/bin/python3
"""RViz shows a large mesh: rviz_mesh_plugin beside RViz's own Marker and one Ogre ManualObject.

    rviz_display.py [--faces 2000000 ...] [--peers marker manual_object] [--quiet SECONDS]
                    [--pictures FOLDER] [--json FILE]

Each way has a process of its own with RViz's panel and manager, 1280 x 960, drawn by OSMesa without
a screen. The mesh is the generated outdoor world. A message is handed over within the process; a
picture is complete when it has stayed the same for the quiet time. Floors hold for 2 and for 10
million faces on two cores. 10 million with peers take 8 GB.
"""

import argparse
import json
import sys
from pathlib import Path

from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.base.figures import table
from mesh_tools_test.base.programs import find_program
from mesh_tools_test.display import rviz_benchmark


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faces", type=int, nargs="+", default=[rviz_benchmark.FLOORS_HOLD])
    parser.add_argument(
        "--peers", nargs="*", choices=list(rviz_benchmark.PEERS), default=list(rviz_benchmark.PEERS)
    )
    parser.add_argument("--quiet", type=float, help="seconds (default: 2, and 0.6 a million faces)")
    parser.add_argument("--pictures", type=Path, help="folder for what was seen")
    parser.add_argument("--json", metavar="FILE", help="also write the values there")
    options = parser.parse_args()
    program = find_program(rviz_benchmark.PROGRAM)
    if program is None:
        print("not measured: the C++ program was not built (libgtest-dev was not there)")
        return 0
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
    results = {}
    for faces in options.faces:
        vertices, triangles = exact_world(faces)
        print(f"outdoor world, {len(vertices):,} vertices, {len(triangles):,} faces")
        quiet = options.quiet if options.quiet is not None else 2.0 + 0.6e-6 * faces
        setup = rviz_benchmark.Setup(quiet, options.pictures)
        subjects = ["mesh", *options.peers]
        values = rviz_benchmark.measure(program, vertices, triangles, subjects, setup)
        print(table(rviz_benchmark.figures(values, len(vertices), len(triangles))))
        print(rviz_benchmark.drawn(values, len(triangles)))
        results[str(faces)] = values
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=2), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
