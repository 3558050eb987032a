#!/usr/bin/python3
"""Faces are selected in RViz: the paper's Table 1, beside a scan of all faces by OpenCL.

    selection.py [--faces N ...] [--repeats N] [--json FILE]

Single faces, a ball of 1 m and a rectangle of an eighth of the window's sides, each at 41 places
(--repeats), from the mouse event to the updated index buffer; then a stroke of the brush; then what
edits of many faces take of the GUI thread (its CPU without drawing, at a time and in all), and all
faces selected of a frame (CPU). Meshes are the generated outdoor world with as many faces as the
paper's datasets. The tool is the one of RViz's plugin, in RViz's own panel, 1280 x 960, drawn by
OSMesa. Floors hold for two cores without a GPU.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Dict, List

from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.base.figures import Figure, table
from mesh_tools_test.base.programs import find_program, run_in_rviz
from mesh_tools_test.display.rviz_benchmark import write_world

PROGRAM = "selection_benchmark"
SECONDS = 600.0  # of one mesh
# Table 1 of the paper: dataset, faces, milliseconds of single, box and radius
TABLE = (
    ("Botanical Garden", 1_430_188, {"single": 104.3, "box": 101.8, "radius": 147.3}),
    ("Stone Quarry", 1_904_178, {"single": 148.6, "box": 146.0, "radius": 267.4}),
    ("Physics Campus", 1_617_772, {"single": 97.1, "box": 121.4, "radius": 134.8}),
    ("Farmer's Pit", 794_509, {"single": 82.5, "box": 81.8, "radius": 90.1}),
    ("Market Garden", 2_656_283, {"single": 168.6, "box": 189.0, "radius": 214.8}),
)
FLOORS = {"single": 1.0, "radius": 2.0, "box": 10.0}  # milliseconds
LEAST_RATE = 60.0  # events of the brush a second
MOST_AT_A_TIME = 50.0  # milliseconds of the GUI thread
MOST_OF_PLAIN = 1.5  # times a frame without a selection
EDITS = {
    "box": "box through the mesh",
    "all": "Ctrl+A",
    "invert": "Ctrl+I",
    "undo": "undo",
    "redo": "redo",
    "grow": "grow",
    "brush": "brush of 5 m, ten moves",
    "hide": "hide what it selected",
    "show_all": "show all",
    "undo_hide": "undo both",
}


def figures(values: Dict[str, float], paper: Dict[str, float]) -> List[Figure]:
    """The lines of one mesh."""
    found = []
    for mode, floor in FLOORS.items():
        name = f"{mode}, {values[mode + '_faces']:,.0f} faces"
        scan = values.get("scan_" + mode)
        found.append(Figure(name, values[mode], "ms", "linear OpenCL scan", scan, floor))
        found.append(Figure(f"{mode}, 95 of 100", values[mode + "_tail"], "ms"))
        if paper:
            found.append(Figure(name, values[mode], "ms", "the paper (its GPU)", paper[mode]))
    found.append(Figure("stroke, events", values["stroke_rate"], "1/s", "", None, LEAST_RATE))
    found.append(Figure("stroke, longest event", values["stroke_longest"], "ms"))
    for key, name in EDITS.items():
        found.append(Figure(f"GUI, {name}", values["gui_" + key], "ms", "", None, MOST_AT_A_TIME))
        found.append(Figure(f"GUI, {name}, in all", values[f"gui_{key}_all"], "ms"))
    found.append(Figure("hidden until it is gone", values["hide_until_gone"], "ms"))
    found.append(Figure("  until laid out without it", values["hide_until_drawn"], "ms"))
    plain = values["frame_plain"]
    found.append(
        Figure(
            "frame, all selected",
            values["frame_all_selected"],
            "ms",
            "plain",
            plain,
            MOST_OF_PLAIN * plain,
        )
    )
    return found


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--faces", type=int, nargs="+", help="other sizes than the paper's")
    parser.add_argument("--repeats", type=int, default=41, help="places in each mode")
    parser.add_argument("--json", metavar="FILE", help="also write the values there")
    options = parser.parse_args()
    program = find_program(PROGRAM)
    if program is None:
        print("not measured: the C++ program was not built (OpenCL or libgtest-dev was not there)")
        return 0
    meshes = TABLE
    if options.faces:
        meshes = tuple(("outdoor world", faces, {}) for faces in options.faces)
    results = {}
    for name, faces, paper in meshes:
        vertices, triangles = exact_world(faces)
        print(f"{name}: {len(vertices):,} vertices, {len(triangles):,} faces")
        with tempfile.TemporaryDirectory(prefix="selection") as folder:
            write_world(folder, vertices, triangles)
            values = run_in_rviz(program, [folder, str(options.repeats)], SECONDS)
        print(table(figures(values, paper)))
        results[str(faces)] = values
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=2), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
