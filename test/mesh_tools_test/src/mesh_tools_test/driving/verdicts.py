"""Whether drives are what they have to be, and statistics of many."""

from typing import Any, List, NamedTuple, Sequence, Tuple

import numpy as np
from mesh_navigation.base.outcomes import is_success
from mesh_navigation.base.pose import vector_text
from mesh_navigation.execution.path_execution import Tolerances

from mesh_tools_test.driving import shipped
from mesh_tools_test.driving.oracle import arrival, on_the_map
from mesh_tools_test.driving.trips import Trip
from mesh_tools_test.driving.worlds import DrivingWorld

TOLERANCES = Tolerances(0.1, np.pi / 18)  # m and rad, the server's defaults
OFF_SURFACE = 1e-3  # m; the simulated robot is on the surface but for rounding
TOO_NEAR = 0.02  # m, by which a robot may come nearer to lethal ground than its radius
FASTEST = 2.5  # m/s; who is faster was moved by something else than wheels
ROUNDING = 1e-6  # of tolerances: measured here and by the controller in other words


class Verdict(NamedTuple):
    """Of one drive."""

    seed: int
    fault: str
    """Why it is no success, with numbers; empty where nothing is wrong."""
    planned: float
    """m."""
    driven: float
    """m."""
    seconds: float
    """Of simulated time."""
    distance: float
    """m, of the last pose to the goal."""
    angle: float
    """rad, between the headings there."""
    lethal_distance: float
    """m along the surface, of the pose nearest to lethal or unknown ground."""
    blocked: int = 0
    """Poses on blocked ground."""
    thing_distance: float = np.inf
    """m in plan, of the pose nearest to one of the things that are known to stand there."""
    planned_at_all: bool = True
    """Whether there was a plan; without one, `fault` says why, and that is no failure."""

    @property
    def succeeded(self) -> bool:
        return not self.fault

    @property
    def failed(self) -> bool:
        return bool(self.fault) and self.planned_at_all


def judged(
    trip: Trip,
    drive: Any,
    world: DrivingWorld,
    costs: np.ndarray,
    radius: float = 0.0,
    tolerances: Tolerances = TOLERANCES,
) -> Verdict:
    """What is wrong with a drive.

    Args:
        trip: what was to be done.
        drive: `mesh_navigation.simulation.driving.Drive`.
        world: where.
        costs: (V,) of that time.
        radius: that the robot has to keep from lethal ground (m).
        tolerances: of the goal (m and rad).
    """
    if not drive.plan.succeeded:
        told = "no plan: " + drive.plan.message
        return Verdict(trip.seed, told, *[0.0] * 3, *[np.inf] * 3, planned_at_all=False)
    track = np.asarray(drive.track, np.float64)
    if not len(track):
        message = drive.result.message
        return Verdict(trip.seed, "it never began: " + message, *[0.0] * 3, *[np.inf] * 3)
    times = np.asarray(drive.times, np.float64)
    found = on_the_map(track, world.mesh_map, costs, drive.faces)
    end = arrival(track[-1], trip.goal, world.mesh_map)
    faults = _faults(drive, track, times, found, end, tolerances)
    if not found.lethal_distance >= radius - TOO_NEAR:
        where = vector_text(track[found.nearest, :3])
        told = "it comes within %.3f m of lethal ground, at %s" % (found.lethal_distance, where)
        faults.append(told)
    thing_distance, nearest = _nearest_thing(track, world)
    if not thing_distance >= radius - TOO_NEAR:
        where = vector_text(track[nearest, :3])
        faults.append("it comes within %.3f m of a thing, at %s" % (thing_distance, where))
    return Verdict(
        trip.seed,
        "; ".join(faults),
        float(drive.planned_length),
        found.length,
        float(times[-1] - times[0]),
        end.distance,
        end.angle,
        found.lethal_distance,
        len(found.blocked),
        thing_distance,
    )


def _nearest_thing(track: np.ndarray, world: DrivingWorld) -> Tuple[float, int]:
    """m in plan of the pose nearest to one, and the number of that pose."""
    layer = shipped.configuration("mesh_map")["collision"]
    body = layer["step_height"], layer["robot_height"]
    distances = np.full(len(track), np.inf)
    for thing in world.things:
        distances = np.minimum(distances, thing.distances(track[:, :3], *body))
    return float(distances.min()), int(distances.argmin())


def _faults(
    drive: Any,
    track: np.ndarray,
    times: np.ndarray,
    found: Any,
    end: Any,
    tolerances: Tolerances,
) -> List[str]:
    faults = []
    if not is_success(drive.result.outcome):
        faults.append("outcome %d: %s" % (drive.result.outcome, drive.result.message))
    else:
        if not end.distance <= tolerances.distance + ROUNDING:
            faults.append("it ends %.3f m from the goal" % end.distance)
        if not end.angle <= tolerances.angle + ROUNDING:
            faults.append("it ends %.1f degrees from the goal's heading" % np.degrees(end.angle))
    if not np.isfinite(track).all():
        faults.append("poses that are not finite")
    if len(found.blocked):
        where = vector_text(track[found.blocked[0], :3])
        faults.append("%d poses on blocked ground, first %s" % (len(found.blocked), where))
    if not found.off_surface <= OFF_SURFACE:
        faults.append("it leaves the surface by %.3f m" % found.off_surface)
    if len(track) > 1:
        speeds = np.linalg.norm(np.diff(track[:, :3], axis=0), axis=1) / np.diff(times)
        if not speeds.max() <= FASTEST:
            faults.append("it jumps: %.2f m/s" % speeds.max())
    return faults


class Statistics(NamedTuple):
    """Of the drives on one world."""

    name: str
    verdicts: Sequence[Verdict]

    @property
    def failed(self) -> List[Verdict]:
        return [verdict for verdict in self.verdicts if verdict.failed]

    @property
    def planned(self) -> List[Verdict]:
        """Those that had a plan."""
        return [verdict for verdict in self.verdicts if verdict.planned_at_all]

    @property
    def detours(self) -> np.ndarray:
        """(K,) driven by planned length, of drives that arrived and were planned to lead
        somewhere."""
        return np.array(
            [
                each.driven / each.planned
                for each in self.verdicts
                if each.succeeded and each.planned
            ]
            or [np.nan]
        )


_COLUMNS = (
    ("poses on", "lethal"),
    ("to lethal", "least, m"),
    ("to things", "least, m"),
    ("driven/planned", "median"),
    ("driven/planned", "worst"),
    ("driven (m)", "median"),
    ("time (s)", "median"),
    ("mean", "m/s"),
    ("position", "worst, m"),
    ("heading", "worst, deg"),
)


def table(some: Sequence[Statistics]) -> str:
    """For people, one line a world. Poses and the distance to lethal ground are of drives with a
    plan, all else of those that arrived."""
    rows = [["world", "plans", "arrived"] + [name for name, _ in _COLUMNS]]
    rows += [["", "", ""] + [kind for _, kind in _COLUMNS]]
    rows += [_row(each) for each in some]
    return "\n".join(
        ("%-12s %-10s %-10s" % (*row[:3],) + "".join(" %14s" % value for value in row[3:])).rstrip()
        for row in rows
    )


def _row(of: Statistics) -> List[str]:
    good = [verdict for verdict in of.verdicts if verdict.succeeded]
    plans, drives = len(of.planned), len(of.verdicts)
    row = [of.name, "%d of %d" % (plans, drives), "%d of %d" % (len(good), plans)]
    if not plans:
        return row
    row.append("%d" % sum(verdict.blocked for verdict in of.planned))
    row.append("%.3f" % min(verdict.lethal_distance for verdict in of.planned))
    nearest = min(verdict.thing_distance for verdict in of.planned)
    row.append("%.3f" % nearest if np.isfinite(nearest) else "-")
    if not good:
        return row
    driven = np.array([verdict.driven for verdict in good])
    seconds = np.array([verdict.seconds for verdict in good])
    return row + [
        "%.3f" % np.median(of.detours),
        "%.3f" % of.detours.max(),
        "%.1f" % np.median(driven),
        "%.1f" % np.median(seconds),
        "%.2f" % (driven.sum() / max(seconds.sum(), 1e-9)),
        "%.3f" % max(verdict.distance for verdict in good),
        "%.1f" % np.degrees(max(verdict.angle for verdict in good)),
    ]


def failures(some: Sequence[Statistics]) -> str:
    """One line for each drive that failed or had no plan, with what it takes to drive it again."""
    return "\n".join(
        "%s, seed %d: %s" % (each.name, verdict.seed, verdict.fault)
        for each in some
        for verdict in each.verdicts
        if verdict.fault
    )
