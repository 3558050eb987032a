#!/usr/bin/python3
"""Times of layers, changes and start of a mesh map, beside NumPy, SciPy and numba in the same run.

    layers.py [--faces 2000000] [--repeats 5] [--only PART ...] [--json FILE]

Parts: geometry, near (roughness and height difference at 0.3 m), far (at 1 m), others,
collision (outdoors, and in a hall with things that stand there), inflation, combination, changes
(of parameters, and of a thousand vertices), obstacles (a cloud of 100,000 points), meanwhile (such
clouds while another layer is computed), start (of the node mesh_map from a file with stored layers;
memory). Floors hold for 2 million faces on two cores. The mesh is the
generated outdoor world with the noise of a scanner. numba is asked where python3-numba is
installed.
"""

import argparse
import json
import sys
from typing import List

from mesh_tools_test.base import figures
from mesh_tools_test.base.noisy_world import noisy_world
from mesh_tools_test.layers import changing, computing, starting

PARTS = {**computing.PARTS, **changing.PARTS, **starting.PARTS}
FLOORS_HOLD = 2_100_000  # faces: the world has about as many as asked for


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faces", type=int, default=2_000_000, help="size of the mesh")
    parser.add_argument("--repeats", type=int, default=5, help="of which the median is taken")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error("at least 1 repeat")
    world = noisy_world(options.faces)
    print(f"outdoor world, {len(world.vertices):,} vertices, {len(world.faces):,} faces; medians")
    found: List[figures.Figure] = []
    for part in PARTS:
        if part in options.only:
            some = PARTS[part](world, options.repeats)
            if len(world.faces) > FLOORS_HOLD:
                some = [figure._replace(floor=None) for figure in some]
            print(figures.table(some, heading=not found), flush=True)
            found += some
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([figure._asdict() for figure in found], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
