#!/usr/bin/python3
"""RViz in long use: what stays in its memory.

    endurance.py [--only PART] [--cycles 1000] [--minutes 15] [--loads 6] [--json FILE]

cycles: displays are added, a mesh of 50,000 faces is loaded, half of it is selected and labelled,
displays are reset and removed, again and again. costs: a layer of 2 million faces comes ten times a
second, each time with other values. loads: meshes of 0.7 million faces one after the other, then
none. RViz's panel and manager are drawn by OSMesa without a screen; memory is what the system
counts as resident, with what OSMesa keeps of the largest frames it has drawn (tens of MB in blocks
of 64 KB), which a graphics card does not. Together they take half an hour.
"""

import argparse
import json
import sys
from pathlib import Path

from mesh_tools_test.base.figures import table
from mesh_tools_test.base.programs import find_program
from mesh_tools_test.display import endurance


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", choices=list(endurance.FACES), help="one part")
    parser.add_argument("--cycles", type=int, default=1000)
    parser.add_argument("--minutes", type=float, default=15.0)
    parser.add_argument("--loads", type=int, default=6)
    parser.add_argument("--faces", type=int, help="of the mesh (default: as said above)")
    parser.add_argument("--json", metavar="FILE", help="also write all that was measured there")
    options = parser.parse_args()
    program = find_program(endurance.PROGRAM)
    if program is None:
        print("not measured: the C++ program was not built (libgtest-dev was not there)")
        return 0
    amounts = {
        "cycles": options.cycles,
        "costs": 60.0 * options.minutes,
        "loads": options.loads,
    }
    results = {}
    for part in [options.only] if options.only else list(endurance.FACES):
        faces = options.faces or endurance.FACES[part]
        print(f"{part}: {amounts[part]:g} of {faces:,} faces")
        results[part] = endurance.measure(program, part, faces, amounts[part])
        print(endurance.course(results[part]))
        print(table(endurance.figures(part, results[part])))
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=2), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
