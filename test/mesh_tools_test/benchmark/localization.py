#!/usr/bin/python3
"""Where a robot is on a mesh: errors, times and states of the localization.

    localization.py [--only PART ...] [--worlds WORLD ...] [--scans 600] [--json FILE]

Parts: follow (a drive over each world: errors beside those of the odometry), obstacles (a third of
the rays ends on what is not on the map), starts (poses that are told 0.5 m and 5 degrees wrong),
drives (to goals by the localization, beside the same by the truth), nowhere (poses that are not
told at all, in a building of 100 x 100 m with two storeys), peer (GICP of Open3D on the vertices
of the map, where python3-open3d is installed). Odometry slips by 1 % and turns by 0.5 degrees a
meter; a lidar of 16 rings at 10 Hz has 15 mm of noise, and 2,000 rays of a scan are used, by one
core.
"""

import argparse
import json
import os
import sys
from typing import Callable, Dict, List

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the node does, before NumPy is loaded

from mesh_tools_test.base import figures  # noqa: E402
from mesh_tools_test.localization import drives, following, from_nowhere, peers  # noqa: E402
from mesh_tools_test.localization.worlds import FACES, WORLDS, LocalizationWorld  # noqa: E402

NAMES = ("follow", "obstacles", "starts", "drives", "nowhere", "peer")


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faces", type=int, default=FACES, help="of a world")
    parser.add_argument("--scans", type=int, default=600, help="of a drive")
    parser.add_argument("--starts", type=int, default=following.STARTS, help="in each world")
    parser.add_argument("--drives", type=int, default=drives.DRIVES, help="in each world")
    parser.add_argument("--only", nargs="+", choices=NAMES, default=NAMES, metavar="PART")
    parser.add_argument(
        "--worlds", nargs="+", choices=list(WORLDS), default=list(WORLDS), metavar="WORLD"
    )
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    if min(options.scans, options.starts, options.drives) < 1:
        parser.error("at least 1 scan, start and drive")
    parts: Dict[str, Callable[[LocalizationWorld], List[figures.Figure]]] = {
        "follow": lambda world: following.measure(world, options.scans),
        "obstacles": lambda world: following.measure_obstacles(world, options.scans),
        "starts": lambda world: following.measure_starts(world, options.starts),
        "drives": lambda world: drives.measure(world, options.drives),
        "peer": peers.measure,
    }
    found: List[figures.Figure] = []

    def show(some: List[figures.Figure]) -> None:
        print(figures.table(some, heading=not found), flush=True)
        found.extend(some)

    for name in options.worlds:
        asked = [part for part in parts if part in options.only]
        world = WORLDS[name](options.faces) if asked else None
        for part in asked:
            assert world is not None
            if name == "corridor" and part != "follow":
                continue  # what is along it is not told, however one begins
            some = parts[part](world)
            if part == "peer" and not some:
                print("peer: Open3D (python3-open3d) is not installed: no GICP beside ours")
                continue
            if options.faces != FACES:
                some = [figure._replace(floor=None) for figure in some]
            show(some)
    if "nowhere" in options.only:
        show(from_nowhere.measure())
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump([figure._asdict() for figure in found], file, indent=2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
