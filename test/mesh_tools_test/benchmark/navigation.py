#!/usr/bin/python3
"""How the robot arrives, and what control and the server take.

    navigation.py [--drives 100] [--faces 2000000] [--only PART ...] [--json FILE]

Parts: drives (random trips with random headings on the outdoor world, across the storeys of a car
park, in a building of large faces with things that are surfaces of their own, on rough ground and,
where it is at hand, on tray.ply; with the shipped configuration, in simulated time, with slip and
noise), geodesics (paths there beside exact geodesics, by length alone), cycles (of the
controller on a map of a million vertices), server (the real node beside a simulated robot:
late cycles at 20 Hz with a plan every second, get_path, memory). Floors hold for 2 million faces.
With --seed N only that trip is driven on each world. Exit code 1 when a drive fails.
"""

import argparse
import json
import sys
from typing import Any, Callable, Dict, List, Optional

from mesh_navigation.body.robot_shape import RobotShape
from mesh_tools_test.base import figures
from mesh_tools_test.driving import cycles, drives, server_ros
from mesh_tools_test.driving.geodesics import excess, excess_table
from mesh_tools_test.driving.verdicts import Statistics, Verdict, failures, table
from mesh_tools_test.driving.worlds import DrivingWorld, worlds

PARTS = ("drives", "geodesics", "cycles", "server")
GROUND = 60_000  # faces of the outdoor world for drives: edges of 0.3 m
TIMED = 3  # drives over which cycles are timed


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--drives", type=int, default=100, help="on each world")
    parser.add_argument("--seed", type=int, help="drive this trip only")
    parser.add_argument("--planner", default="", help="a shipped one, else the first")
    parser.add_argument(
        "--radius", type=float, help="of the robot that drives (m), else the shipped; 0: a point"
    )
    parser.add_argument("--pairs", type=int, default=1000, help="of paths on each world")
    parser.add_argument("--worlds", nargs="+", metavar="NAME", help="only these")
    parser.add_argument("--faces", type=int, default=2_000_000, help="of the large map")
    parser.add_argument("--minutes", type=float, default=2.0, help="that the server drives")
    parser.add_argument("--plans", type=int, default=500, help="over which memory is watched")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    if min(options.drives, options.plans, options.pairs) < 1 or not options.minutes > 0:
        parser.error("at least 1 drive, plan and pair, and more than 0 minutes")
    found: Dict[str, Any] = {}
    failed = False
    if "drives" in options.only:
        seeds = list(range(options.drives)) if options.seed is None else [options.seed]
        some = driven(seeds, options.planner, options.radius, options.worlds)
        print(table(some), failures(some), sep="\n", flush=True)
        failed = any(each.failed for each in some)
        found["drives"] = {each.name: [one._asdict() for one in each.verdicts] for each in some}
    if "geodesics" in options.only:
        paths = [each for make in chosen(options.worlds) for each in excess(make(), options.pairs)]
        print(excess_table(paths), flush=True)
        failed |= any(each.failed for each in paths)
        found["geodesics"] = [{**each._asdict(), "ratios": each.ratios.tolist()} for each in paths]
    timed: List[figures.Figure] = []
    if "cycles" in options.only:
        timed += cycles.cycles(options.faces, TIMED)
    if "server" in options.only:
        timed += server_ros.measure(options.faces, options.minutes, options.plans)
    if timed:
        print(figures.table(timed))
    found["figures"] = [figure._asdict() for figure in timed]
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(found, file, indent=2)
    return int(failed)


def driven(
    seeds: List[int], planner: str, radius: Optional[float], names: Optional[List[str]]
) -> List[Statistics]:
    """Of all worlds; failures are told at once."""
    some = []
    shape = None if radius is None else RobotShape(radius=radius)
    for make in chosen(names):
        world = make()
        print("%s: %d drives" % (world.name, len(seeds)), file=sys.stderr, flush=True)
        some.append(drives.driven(world, seeds, planner, tell, shape))
    return some


def chosen(names: Optional[List[str]]) -> List[Callable[[], DrivingWorld]]:
    """The worlds of these names, or all."""
    return [make for name, make in worlds(GROUND).items() if not names or name in names]


def tell(verdict: Verdict) -> None:
    """What is wrong with a drive."""
    if verdict.fault:
        print("  seed %d: %s" % (verdict.seed, verdict.fault), file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
