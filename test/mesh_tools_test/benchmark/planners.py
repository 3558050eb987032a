#!/usr/bin/python3
"""Times of planners and of what they are made of, beside SciPy in the same run.

    planners.py [--faces 2000000] [--repeats 5] [--only PART ...] [--growth] [--plot PNG]
        [--json FILE]

Parts: fields (Dijkstra and the wave front over the whole map), reading (to a goal 17 m away, the
path, directions), others (potpourri3d and pygeodesic, where they are installed; the latter within
20 m), plans (through the planner classes), updates (after changes of costs), success (1000 random
pairs at each of six levels of noise), growth (from 10,000 vertices to a million, with --growth to
10 million, which takes 5 GB). Floors hold for 2 million faces. Solvers run on one thread.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import List

from mesh_tools_test.base import figures
from mesh_tools_test.planning import fields, growth, plans, success, updates
from mesh_tools_test.planning.world import planning_world

PARTS = {**fields.PARTS, **plans.PARTS, **updates.PARTS}
FLOORS_HOLD = 2_100_000  # faces: the world has about as many as asked for


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    every = [*PARTS, "success", "growth"]
    parser.add_argument("--faces", type=int, default=2_000_000, help="size of the mesh")
    parser.add_argument("--repeats", type=int, default=5, help="of which the median is taken")
    parser.add_argument("--goals", type=int, default=success.GOALS, help="of success")
    parser.add_argument("--only", nargs="+", choices=every, default=every, metavar="PART")
    parser.add_argument("--growth", action="store_true", help="growth to 10 million vertices")
    parser.add_argument("--plot", metavar="PNG", type=Path, help="also draw the growth there")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    if options.repeats < 1 or options.goals < 1:
        parser.error("at least 1 repeat and 1 goal")
    found: List[figures.Figure] = []

    def show(some: List[figures.Figure]) -> None:
        if options.faces > FLOORS_HOLD:
            some = [figure._replace(floor=None) for figure in some]
        print(figures.table(some, heading=not found), flush=True)
        found.extend(some)

    if set(PARTS) & set(options.only):
        world = planning_world(options.faces)
        sizes = (len(world.vertices), len(world.faces))
        print("outdoor world, {:,} vertices, {:,} faces; medians".format(*sizes))
        for part in PARTS:
            if part in options.only:
                show(PARTS[part](world, options.repeats))
        del world
    if "success" in options.only:
        for noise in success.NOISE:
            show(success.measure(options.faces, noise, options.goals))
    if "growth" in options.only:
        sizes_of_growth = [size for size in growth.SIZES if size <= options.faces]
        sizes_of_growth += [growth.LARGE] if options.growth else []
        grown = growth.measured(sizes_of_growth or [options.faces // 2], options.repeats)
        print(grown.table())
        if options.plot:
            grown.plot(options.plot)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([figure._asdict() for figure in found], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
