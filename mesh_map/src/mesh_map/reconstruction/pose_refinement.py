"""Poses of scans made better by the scans themselves: each is laid onto the surface of those before
it, and where a place is seen again, the error of the loop is spread over a pose graph."""

from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_map.base.cancel import CancelFlag
from mesh_map.geometry.topology import quantity
from mesh_map.reconstruction.signed_distance import SignedDistanceField
from mesh_map.registration.point_to_plane import PlaneTarget, Registration
from mesh_map.registration.pose_graph import PoseEdge, optimized
from mesh_map.registration.rigid import inverse, motion, moved, numbers_of
from mesh_map.scans.scan import Scan

MOST_POINTS = 24_000  # of a scan that are kept for the surface of its surroundings
_REGISTERED = 3_000  # of these that are laid onto another surface
_FARTHEST = 20.0  # m
_KEY_DISTANCE, _KEY_ANGLE = 1.0, 0.5  # m and rad; nearer scans follow the one before them
_BEFORE = 4  # key scans that make the surface which the next one is laid onto
_ROUND = 3  # ... on either side of one, to which a loop is closed
_LOOP_RADIUS, _LOOP_GAP = 10.0, 12  # m apart, and key scans between, of what may be a loop
_LOOPS_OF_ONE = 3
_LEAST_SHARE, _LEAST_COUNT = 0.7, 100  # of the points nearby that have to lie on the other surface
_COARSE = 0.2  # m, voxels of surfaces that scans are laid onto: smaller ones fall between rings
_COMPARED, _AROUND = 30, 6  # scans that are compared with others, and with how many
_ELSEWHERE = 0.3  # m
_BETTER = 0.9  # times the disagreement of the given poses, from which on others are better
_RANGE_NOISE = 0.02  # m
_CORRELATED = 50.0  # neighbors of a point that err with it
_ODOMETRY = 0.03, 0.01  # share of the way, and rad per m, that given poses may be off
_LEAST_ODOMETRY = 0.02, 0.005  # m, rad
_GATE = 4.0  # standard deviations of odometry, that a scan may lie elsewhere
_DOUBT = 3.0  # ... of a loop, from which on it counts less


class _KeyScan(NamedTuple):
    """points and origins: (N, 3) float32 in the scan's frame; few: of them for registration."""

    number: int
    points: np.ndarray
    origins: np.ndarray
    few: np.ndarray


class RefinedPoses(NamedTuple):
    """
    Attributes:
        poses: (4, 4) float64 for each scan, in their order; the first as it was.
        key_scans: how many were laid onto others.
        loops: how many times a place was recognized.
        lost: key scans that lay on nothing before them; they keep the given motion.
        moved: (2,) m: by how much poses were moved, the root of the mean square, and the most.
        errors: (2,) m: how far points are from the surface of other scans, in the mean (30 cm where
            there is none), with the given and with the refined poses. Where these are not clearly
            better, the given ones are the result.
    """

    poses: List[np.ndarray]
    key_scans: int
    loops: int
    lost: int
    moved: Tuple[float, float]
    errors: Tuple[float, float] = (0.0, 0.0)

    @property
    def is_better(self) -> bool:
        """Whether the poses are the refined ones."""
        return self.errors[1] < _BETTER * self.errors[0]

    def line(self) -> str:
        """For people."""
        if not self.is_better:
            text = (
                "poses stay as given: scans fit each other to %.3f m, with refined poses to %.3f m"
            )
            return text % self.errors
        text = "poses refined: moved by %.3f m (root mean square), %.3f m at most; %s closed"
        line = text % (*self.moved, quantity(self.loops, "loops"))
        if self.lost:
            line += "; %s lay on nothing before, and kept the given motion" % (
                quantity(self.lost, "scans")
            )
        return line

    def counts(self) -> Dict[str, Any]:
        """What json can write, without the poses."""
        values: Dict[str, Any] = {
            "key_scans": self.key_scans,
            "loops": self.loops,
            "lost": self.lost,
        }
        values.update(is_better=self.is_better, error_given=self.errors[0])
        values.update(error_refined=self.errors[1])
        return {**values, "moved_rms": self.moved[0], "moved_most": self.moved[1]}


def refine_poses(
    scans: Iterable[Scan],
    *,
    voxel_size: float,
    min_range: float = 0.0,
    max_range: float = np.inf,
    progress: Callable[[str, float], None] = lambda stage, share: None,
    is_stopped: Callable[[], bool] = lambda: False,
    cancel: Optional[CancelFlag] = None,
) -> RefinedPoses:
    """Lay scans onto each other.

    The poses of the scans have to be about right: by odometry or a SLAM, drifting by some percent
    of the way. Of each key scan 24,000 points stay in memory.

    Args:
        scans: in the order of their times; read once.
        voxel_size: m, of the field that the scans are for.
        min_range, max_range: m; points nearer (as those of the robot itself) or farther away, or
            farther than 20 m, are not used here.
        progress: told a stage and which share of it is done.
        is_stopped: asked now and then; if it says so, what there is then is the result.
        cancel: ends it with Canceled.
    """
    limits = min_range, min(max_range, _FARTHEST)
    coarse = max(voxel_size, min(2 * voxel_size, _COARSE))
    work = _Refinement(coarse, limits, cancel)
    for scan in scans:
        work.add(scan)
    return work.finish(progress, is_stopped)


class _Refinement:
    def __init__(
        self, voxel_size: float, ranges: Tuple[float, float], cancel: Optional[CancelFlag]
    ) -> None:
        self.given: List[np.ndarray] = []
        self._voxel_size, self._ranges, self._cancel = voxel_size, ranges, cancel
        self._keys: List[_KeyScan] = []
        self._poses: List[np.ndarray] = []  # of key scans
        self._edges: List[PoseEdge] = []
        self._lost = 0

    def add(self, scan: Scan) -> None:
        self.given.append(np.array(scan.pose, np.float64))
        if not self._is_key(self.given[-1]):
            return
        key = self._key_scan(scan, len(self.given) - 1)
        if not self._keys:
            self._keys.append(key)
            self._poses.append(self.given[-1])
            return
        before = len(self._keys) - 1
        step = inverse(self.given[self._keys[before].number]) @ self.given[-1]
        sure = _odometry_information(step)
        self._edges.append(PoseEdge(before, before + 1, step, sure))
        guess = self._poses[before] @ step
        target = self._surface(range(max(0, before + 1 - _BEFORE), before + 1), before)
        prior = sure * _RANGE_NOISE**2 * _CORRELATED
        found = self._registered(target, key, step, 3 * self._voxel_size, prior)
        if found is not None:
            off = numbers_of(inverse(step) @ found.pose)
            found = found if off @ sure @ off < _GATE**2 else None
        self._keys.append(key)
        if found is None:
            self._lost += 1
            self._poses.append(guess)
        else:
            self._poses.append(self._poses[before] @ found.pose)
            self._edges.append(_edge(before, before + 1, found, np.inf))

    def _is_key(self, pose: np.ndarray) -> bool:
        if not self._keys:
            return True
        step = inverse(self.given[self._keys[-1].number]) @ pose
        turned = np.arccos(np.clip((np.trace(step[:3, :3]) - 1) / 2, -1, 1))
        return bool(np.linalg.norm(step[:3, 3]) > _KEY_DISTANCE or turned > _KEY_ANGLE)

    def _key_scan(self, scan: Scan, number: int) -> _KeyScan:
        origins = np.zeros((1, 3), np.float32) if scan.origins is None else scan.origins
        origins = np.broadcast_to(origins, scan.points.shape)
        ranges = np.linalg.norm(scan.points - origins, axis=1)
        near = (ranges >= self._ranges[0]) & (ranges <= self._ranges[1])
        points, origins = scan.points[near], origins[near]
        random = np.random.default_rng(number)
        if len(points) > MOST_POINTS:
            kept = np.sort(random.permutation(len(points))[:MOST_POINTS])
            points, origins = points[kept], origins[kept]
        return _KeyScan(
            number, points, origins, _one_of_each_cell(points, self._voxel_size, random)
        )

    def _surface(self, keys: Iterable[int], frame: int) -> Optional[PlaneTarget]:
        """Of some key scans, in the frame of one."""
        field = SignedDistanceField(voxel_size=self._voxel_size)
        back = inverse(self._poses[frame])
        for number in keys:
            pose = back @ self._poses[number]
            key = self._keys[number]
            field.integrate(moved(pose, key.points), moved(pose, key.origins), cancel=self._cancel)
        surface = field.extract(least_weight=0.1, cancel=self._cancel)
        return PlaneTarget.of(surface.vertices, surface.faces) if len(surface.faces) else None

    def _registered(
        self,
        target: Optional[PlaneTarget],
        key: _KeyScan,
        pose: np.ndarray,
        reach: float,
        prior: Optional[np.ndarray] = None,
    ) -> Optional[Registration]:
        if target is None or not len(key.few):
            return None
        found = target.register(
            key.points[key.few],
            pose,
            origins=key.origins[key.few],
            prior=prior,
            max_distance=reach,
            min_distance=self._voxel_size / 2,
            cancel=self._cancel,
        )
        if found is None or found.share < _LEAST_SHARE or found.count < _LEAST_COUNT:
            return None
        return found

    def finish(
        self, progress: Callable[[str, float], None], is_stopped: Callable[[], bool]
    ) -> RefinedPoses:
        loops: Dict[Tuple[int, int], PoseEdge] = {}
        # What is a loop is seen better once the first ones are closed.
        for _ in range(3):
            before = len(loops)
            self._close_loops(loops, progress, is_stopped)
            self._poses = optimized(self._poses, self._edges + list(loops.values()))
            if len(loops) == before or is_stopped():
                break
        # Registrations err by centimeters where scans are sparse: poses that are better stay.
        refined = self._poses
        given = [self.given[key.number] for key in self._keys]
        errors = self._disagreement(given, list(loops)), self._disagreement(refined, list(loops))
        is_better = errors[1] < _BETTER * errors[0]
        poses = self._all_poses() if is_better else [pose.copy() for pose in self.given]
        shifts = [np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(poses, self.given)]
        most = float(max(shifts, default=0.0))
        mean = float(np.sqrt(np.mean(np.square(shifts)))) if shifts else 0.0
        return RefinedPoses(poses, len(self._keys), len(loops), self._lost, (mean, most), errors)

    def _disagreement(self, poses: List[np.ndarray], loops: Sequence[Tuple[int, int]]) -> float:
        """m: how far points of key scans are from the surface of others, in the mean; no more than
        _ELSEWHERE of each. Others are those to which loops were closed, which alone tell of drift;
        without loops, those nearby.
        """
        places = np.array([pose[:3, 3] for pose in poses]).reshape(-1, 3)
        compared: List[Tuple[int, List[int]]] = []
        for early, late in sorted(loops):
            low, high = max(0, early - _ROUND), min(len(poses), early + _ROUND + 1)
            compared.append((late, list(range(low, high))))
        for number in range(0 if loops else len(poses)):
            apart = np.linalg.norm(places - places[number], axis=1)
            near = [k for k in np.argsort(apart, kind="stable").tolist() if k != number]
            compared.append((number, [k for k in near[:_AROUND] if apart[k] < _LOOP_RADIUS]))
        before, self._poses = self._poses, poses
        sums = np.zeros(2)
        try:
            for number, others in compared[:: 1 + len(compared) // _COMPARED]:
                target = self._surface(others, number) if others else None
                if target is not None:
                    key = self._keys[number]
                    hits = target.index.closest_batch(
                        points=key.points[key.few],
                        max_distance=_ELSEWHERE,
                        back_end="native",
                        cancel=self._cancel,
                    )
                    sums += np.minimum(hits.distances, _ELSEWHERE).sum(), len(hits.distances)
        finally:
            self._poses = before
        return float(sums[0] / sums[1]) if sums[1] else 0.0

    def _close_loops(
        self,
        loops: Dict[Tuple[int, int], PoseEdge],
        progress: Callable[[str, float], None],
        is_stopped: Callable[[], bool],
    ) -> None:
        places = np.array([pose[:3, 3] for pose in self._poses]).reshape(-1, 3)
        wanted: Dict[int, List[int]] = {}
        for late in range(_LOOP_GAP, len(places)):
            apart = np.linalg.norm(places[: late - _LOOP_GAP + 1] - places[late], axis=1)
            near = np.argsort(apart, kind="stable")
            for early in near[apart[near] < _LOOP_RADIUS][:_LOOPS_OF_ONE].tolist():
                wanted.setdefault(early, []).append(late)
        for done, (early, lates) in enumerate(sorted(wanted.items())):
            if is_stopped():
                return
            progress("closing loops", done / len(wanted))
            low, high = max(0, early - _ROUND), min(len(self._keys), early + _ROUND + 1)
            target = self._surface(range(low, high), early)
            for late in lates:
                guess = inverse(self._poses[early]) @ self._poses[late]
                reach = 0.5 if (early, late) in loops else 1.0
                found = self._registered(target, self._keys[late], guess, reach)
                if found is not None and found.residual < self._voxel_size / 2:
                    loops[early, late] = _edge(early, late, found, _DOUBT)

    def _all_poses(self) -> List[np.ndarray]:
        """Those of key scans; others go from what the one before them was moved to what the one
        behind them was, evenly along the way."""
        steps = [np.linalg.norm(b[:3, 3] - a[:3, 3]) for a, b in zip(self.given, self.given[1:])]
        ways = np.concatenate([[0.0], np.cumsum(steps)])
        poses = []
        key = 0
        for number, pose in enumerate(self.given):
            while key + 1 < len(self._keys) and self._keys[key + 1].number <= number:
                key += 1
            before = self._keys[key].number
            found = self._poses[key] @ inverse(self.given[before]) @ pose
            if key + 1 < len(self._keys) and number > before:
                behind = self._keys[key + 1].number
                other = self._poses[key + 1] @ inverse(self.given[behind]) @ pose
                share = (ways[number] - ways[before]) / max(ways[behind] - ways[before], 1e-9)
                found = found @ motion(share * numbers_of(inverse(found) @ other))
            poses.append(found)
        return poses


def _edge(first: int, second: int, found: Registration, doubt: float) -> PoseEdge:
    noise = max(_RANGE_NOISE, found.residual)
    information = found.information / (noise**2 * _CORRELATED)
    return PoseEdge(first, second, found.pose, information, doubt)


def _odometry_information(step: np.ndarray) -> np.ndarray:
    way = float(np.linalg.norm(step[:3, 3]))
    place = max(_LEAST_ODOMETRY[0], _ODOMETRY[0] * way)
    turn = max(_LEAST_ODOMETRY[1], _ODOMETRY[1] * way)
    return np.diag([place**-2] * 3 + [turn**-2] * 3)


def _one_of_each_cell(points: np.ndarray, size: float, random: np.random.Generator) -> np.ndarray:
    """Some of the points, one of each cell at most, so that near ground does not outweigh all."""
    order = random.permutation(len(points))
    for cell in (size, 2 * size, 4 * size):
        cells = np.floor(points[order] / cell).astype(np.int64)
        first = np.unique(cells, axis=0, return_index=True)[1]
        if len(first) <= 2 * _REGISTERED:
            break
    return np.sort(order[np.sort(first)[:_REGISTERED]])
