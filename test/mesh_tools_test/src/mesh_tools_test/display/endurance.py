"""The figures of benchmark/endurance.py: what stays in RViz's memory after long use."""

import statistics
import tempfile
from typing import Dict, List

from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.base.figures import Figure
from mesh_tools_test.base.programs import lines_in_rviz
from mesh_tools_test.display.rviz_benchmark import write_world

PROGRAM = "endurance_benchmark"
FACES = {"cycles": 50_000, "costs": 2_000_000, "loads": 700_000}
SECONDS = 7200.0  # of one part, at most
WARM = 10  # cycles: buffers and caches have grown
GROWTH = 50.0  # MB

Course = Dict[str, Dict[int, float]]


def measure(program: str, part: str, faces: int, amount: float) -> Course:
    """What the C++ program prints: name -> step -> value in bytes or milliseconds."""
    with tempfile.TemporaryDirectory(prefix="endurance") as folder:
        write_world(folder, *exact_world(faces))
        course: Course = {}
        for words in lines_in_rviz(program, [folder, part, f"{amount:g}"], SECONDS):
            if len(words) == 3:
                name, step, value = words
                course.setdefault(name, {})[int(step)] = float(value)
    return course


def course(values: Course) -> str:
    """Resident memory at each step."""
    steps = [f"{step}: {1e-6 * value:.0f}" for step, value in values["resident"].items()]
    return f"MB resident after step {', '.join(steps)}"


def _middle(values: List[float]) -> float:
    return 1e-6 * statistics.median(values)


def figures(part: str, values: Course) -> List[Figure]:
    """The table of one part, with the floors."""
    steps = {step: 1e-6 * value for step, value in values["resident"].items()}
    last = max(steps)
    if part == "cycles":
        return [
            Figure("the first cycle", steps[1] - steps[0], "MB"),
            Figure(f"growth after {WARM} cycles", steps[last] - steps[WARM], "MB", floor=GROWTH),
        ]
    if part == "loads":
        left = 1e-6 * values["left"][last]
        one = steps[1] - steps[0]
        return [
            Figure("shown, the first one", one, "MB"),
            Figure(f"shown, after {last}", steps[last] - steps[0], "MB", floor=2.0 * one),
            Figure(f"left of {last}, once displays are gone", left - steps[0], "MB", floor=one),
        ]
    course_ = [values["resident"][step] for step in range(1, last + 1)]
    third = max(1, last // 3)
    growth = _middle(course_[-third:]) - _middle(course_[third : 2 * third] or course_[:1])
    found = [Figure("growth, last third to second", growth, "MB", floor=GROWTH)]
    for name in ("frame_median", "frame_tail", "frame_longest"):
        times = [values[name][step] for step in range(1, last + 1)]
        found.append(Figure(f"{name}, last third", statistics.median(times[-third:]), "ms"))
    found.append(Figure("frames", sum(values["frames"].values()), ""))
    return found
