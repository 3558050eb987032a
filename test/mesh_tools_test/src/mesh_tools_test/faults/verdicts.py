"""Whether the robot was stopped in time, and the table of it."""

import math
import statistics
from typing import Dict, List, NamedTuple, Sequence

BOUND = 0.5  # s, from the moment of a fault to the command to stand


class Run(NamedTuple):
    """One fault in one drive."""

    stop_time: float
    """s, from the moment of the fault; inf if the robot was never told to stand."""
    moves: int
    """Commands to move after the stop, as long as the fault was there."""
    room: float
    """m, between the robot and what it could hit, at the least; below 0 it has hit it."""
    answer: str
    """Outcome of the goal; empty if none came."""
    message: str = ""
    """What came with the answer."""
    remark: str = ""
    """Why the fault could not be tried; all else says nothing then."""

    @property
    def broken(self) -> bool:
        """Whether it is not as it has to be."""
        late = not self.stop_time <= BOUND
        return bool(self.remark or late or self.moves or self.room < 0.0 or not self.answer)


def table(runs: Dict[str, Sequence[Run]]) -> str:
    """For people, one line for each fault."""
    lines = ["%-18s %4s %9s %9s %11s %10s %6s %8s  %s" % _HEAD]
    lines += [_line(name, some) for name, some in runs.items()]
    lines += ["%s: %s" % (name, run.remark) for name in runs for run in runs[name] if run.remark]
    return "\n".join(line.rstrip() for line in lines)


_HEAD = ("stop within %g s" % BOUND, "n", "p50, ms", "max, ms", "of bound", "collisions")
_HEAD += ("moves", "answers", "")


def _line(name: str, runs: Sequence[Run]) -> str:
    tried = [run for run in runs if not run.remark]
    times = [run.stop_time for run in tried] or [math.inf]
    answers: List[str] = [run.answer for run in tried if run.answer]
    kinds = ["%s %d" % (kind, answers.count(kind)) for kind in sorted(set(answers))]
    broken = sum(run.broken for run in runs)
    return "%-18s %4d %9.0f %9.0f %9.2f x %10d %6d %8d  %s: %s" % (
        name,
        len(runs),
        1000.0 * statistics.median(times),
        1000.0 * max(times),
        max(times) / BOUND,
        sum(run.room < 0.0 for run in tried),
        sum(run.moves for run in tried),
        len(answers),
        "BROKEN in %d" % broken if broken else "kept",
        ", ".join(kinds) or "no answer",
    )
