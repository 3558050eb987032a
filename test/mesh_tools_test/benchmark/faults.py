#!/usr/bin/python3
"""How soon a robot is told to stop when something goes wrong, with real processes.

    faults.py [--faults 15] [--only FAULT ...] [--json FILE]

Faults: tf (TF of odometry stops), cloud (that of the obstacle layer stops), lock (a planner holds
Python's lock for 8 s), controller (it blocks), server and guard (SIGKILL), stuck (SIGSTOP of the
guard), map (it is reloaded), layer (a required one fails), wall (across the hall, beyond braking
distance plus 0.5 s). Measured is from the moment from which it is a fault (an age or a rate is
passed; 0.3 s without the server, or a guard that is stuck; after a wall came, 0.5 s and the time
that braking takes) to the command to stand on the topic of the base. Exit code 1 where that takes
longer than its bound, the robot moves once more or hits something, or a goal has no answer. Time is
the computer's.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Dict, List

from mesh_tools_test.faults.cases_ros import CASES, run
from mesh_tools_test.faults.stage_ros import Stage
from mesh_tools_test.faults.verdicts import Run, table

PLUGINS = Path(__file__).resolve().parent / "faulty_plugins"


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faults", type=int, default=15, help="of each kind")
    parser.add_argument("--only", nargs="+", choices=CASES, default=list(CASES), metavar="FAULT")
    parser.add_argument("--json", metavar="FILE", help="also write the runs there")
    options = parser.parse_args()
    if options.faults < 1:
        parser.error("at least 1 fault")
    runs: Dict[str, List[Run]] = {}
    with tempfile.TemporaryDirectory() as folder, Stage(Path(folder), PLUGINS) as stage:
        for name in options.only:
            case = CASES[name]
            print("%s: %d times" % (case.text, options.faults), file=sys.stderr, flush=True)
            runs[case.text] = [run(stage, case) for _ in range(options.faults)]
    print(table(runs))
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({name: [one._asdict() for one in some] for name, some in runs.items()}, file)
    return int(any(one.broken for some in runs.values() for one in some))


if __name__ == "__main__":
    sys.exit(main())
