"""What of scans was left out, or is odd, counted by kind: one line for each."""

from typing import Any, Dict, List, Mapping

from mesh_map.geometry.topology import quantity

# kind -> the line, of its count, and of how many scans and the first of them
_LINES = {
    "not_finite": "left out: {points} that are not finite, in {scans}",
    "no_return": "left out: {points} at the sensor itself, which say nothing, in {scans}",
    "too_near": "left out: {points} nearer than --min_range, in {scans}",
    "too_far": "left out: {points} farther than --max_range, in {scans}",
    "outside": "left out: {points} too far from the map's origin, in {scans}",
    "decimated": "left out: {points} by --decimate, in {scans}",
    "empty": "left out: {scans} without a point",
    "no_pose": "left out: {scans} without a pose: {reason}",
    "unreadable": "left out: {scans} that cannot be read: {reason}",
    "no_origin": "left out: {scans} too far from the map's origin: {reason}",
    "jump": "the pose jumps {times}, first to {first}: {reason}",
    "no_times": "motion within {scans} is not undone: {reason}",
    "odd_transform": "left out: {transforms} that are no rotation and translation: {reason}",
    "no_colors": "{scans} without colors among such with colors",
    "no_intensities": "{scans} without intensities among such with intensities",
    "late_colors": "colors of {scans} are not used: the first scan has none",
    "late_intensities": "intensities of {scans} are not used: the first scan has none",
}
_NOUNS = ("points", "times", "transforms")


class LeftOutCounts:
    """Counts by kind; the same things in any order of work give the same lines."""

    def __init__(self, stored: Mapping[str, Any] = {}) -> None:
        """stored: what `stored()` gave; numbers go on from there."""
        self._kinds: Dict[str, Dict[str, Any]] = {
            kind: dict(entry) for kind, entry in stored.items() if kind in _LINES
        }

    def add(self, kind: str, where: str, count: int = 1, reason: str = "") -> None:
        """Count something.

        Args:
            kind: not_finite, empty, no_pose, ... (see the table of this module).
            where: the scan.
            count: of points; 0 is nothing.
            reason: that of the first counts.
        """
        if count:
            entry = self._kinds.setdefault(
                kind, {"count": 0, "scans": 0, "first": where, "reason": reason}
            )
            entry["count"] += int(count)
            entry["scans"] += 1

    def count(self, kind: str) -> int:
        """How many points, or scans where points are not counted."""
        return int(self._kinds[kind]["count"]) if kind in self._kinds else 0

    def lines(self) -> List[str]:
        """One for each kind that there is, in the order of the table."""
        lines = []
        for kind, template in _LINES.items():
            entry = self._kinds.get(kind)
            if entry is None:
                continue
            many = "%d scans (first: %s)" % (entry["scans"], entry["first"])
            scans = "1 scan (%s)" % entry["first"] if entry["scans"] == 1 else many
            counted = {noun: quantity(entry["count"], noun) for noun in _NOUNS}
            values = {"scans": scans, "first": entry["first"], "reason": entry["reason"]}
            lines.append(template.format(**counted, **values))
        return lines

    def go_back(self, stored: Mapping[str, Any]) -> None:
        """Forget what was counted since `stored()` gave this."""
        self._kinds = {kind: dict(entry) for kind, entry in stored.items()}

    def stored(self) -> Dict[str, Dict[str, Any]]:
        """What json can write: kind -> count, scans, first, reason."""
        return {kind: dict(self._kinds[kind]) for kind in _LINES if kind in self._kinds}
