"""Figures of a benchmark: what was measured, beside what, and the floor that it must keep."""

import statistics
import time
from typing import Any, Callable, List, NamedTuple, Optional, Tuple


class Figure(NamedTuple):
    """A line of the table.

    `peer_value` is the other's figure in the same unit and the same run, None where it was not
    measured. Units that end in "/s" are better where they are larger, all others where smaller.
    """

    name: str
    value: float
    unit: str
    peer: str = ""
    peer_value: Optional[float] = None
    floor: Optional[float] = None

    @property
    def more_is_better(self) -> bool:
        return self.unit.endswith("/s")

    @property
    def ratio(self) -> Optional[float]:
        """How many times better than the peer."""
        if self.peer_value is None:
            return None
        better, worse = self.peer_value, self.value
        if self.more_is_better:
            better, worse = worse, better
        return better / worse if worse else None

    @property
    def keeps_floor(self) -> bool:
        if self.floor is None:
            return True
        return self.value >= self.floor if self.more_is_better else self.value <= self.floor


def timed(action: Callable[[], Any], repeats: int) -> Tuple[float, Any]:
    """Median time of an action in milliseconds, and what it returned."""
    times, result = [], None
    for _ in range(repeats):
        start = time.perf_counter()
        result = action()
        times.append(time.perf_counter() - start)
    return 1000.0 * statistics.median(times), result


def million_per_second(count: int, milliseconds: float) -> float:
    """A rate of, say, rays: 10^6 of them per second."""
    return count / 1000.0 / milliseconds


def table(figures: List[Figure], heading: bool = True) -> str:
    """The figures for people, one a line; a floor that is missed stands out."""
    lines = ["%-42s %10s %-6s  %-9s %s" % ("", "", "", "better", "than, in the same run")]
    lines = lines if heading else []
    for figure in figures:
        peer = ""
        if figure.ratio is not None:
            peer = "%8.2f x %s: %.4g" % (figure.ratio, figure.peer, figure.peer_value)
        if figure.floor is not None:
            bound = "at least" if figure.more_is_better else "at most"
            verdict = "" if figure.keeps_floor else ", MISSED"
            peer += "%s(floor: %s %g%s)" % (
                "  " if peer else " " * 11,
                bound,
                figure.floor,
                verdict,
            )
        line = "%-42s %10.4g %-6s %s" % (figure.name, figure.value, figure.unit, peer)
        lines.append(line.rstrip())
    return "\n".join(lines)
