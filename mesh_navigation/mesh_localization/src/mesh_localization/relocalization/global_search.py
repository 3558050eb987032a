"""Where a robot is, of which nothing but a scan is known."""

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Callable, List, NamedTuple, Optional, Tuple

import numpy as np
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.registration.point_to_plane import RAYS, PlaneTarget, Registration
from mesh_map.registration.rigid import inverse, numbers_of

from mesh_localization.relocalization.heading_scores import heading_scores
from mesh_localization.relocalization.pose_sampling import (
    SearchRegion,
    PoseLimits,
    SampledPlaces,
    places_around,
    sampled_places,
)
from mesh_localization.relocalization.range_panorama import Panorama, map_ranges, panorama_of
from mesh_localization.tracking.localizer import BaseScan, TrackingOptions
from mesh_localization.tracking.ray_fates import RayFate, ray_fates

_PROBES = 4096  # lines through the map, by which its ground is estimated
_CHUNK = 1 << 19  # rays that are cast at once
_FINE = 0.4  # m between places, from which on they are laid onto the map
_OFF = 0.6, 0.06  # of the spacing, and of a range, that ranges are off between places and headings
_REACH = 1.0  # m within which the surface is looked for
_NEAREST = 0.1  # m within which points count in the end
_FEW, _MANY = 300, 2000  # rays with which many poses are tried, and few
_TELLING = 2 / 3  # of these, how many do not end on the plane under the robot, as far as there are
_PLANE = 0.1, 0.02  # m, and of a range, that ground is off the plane under the robot
_BEST = 12  # poses that are tried with many rays
_SAME = 0.5, 0.2  # m and rad, within which two poses are one
_RANGE_NOISE, _CORRELATED = 0.01, 50.0  # m, and rays that err together, as in tracking
_UNSURE = np.diag(np.square([1.0, 1.0, 0.3, 0.1, 0.1, 0.2]))  # where the scan does not tell

Progress = Callable[[float], None]


class SearchState(IntEnum):
    """What came of a search."""

    NOT_FOUND = 0
    AMBIGUOUS = 1
    FOUND = 2


@dataclass(frozen=True)
class SearchOptions:
    """How a map is searched, and when a pose is believed.

    Attributes:
        base_height: m of the base's frame above the ground.
        spacing: m between the places that are looked at first; larger on maps that would take more
            than `most_rays`.
        most_rays: that are cast from these.
        kept: places around which is looked closer, ascending: at first, and up to which if that
            has found none that is sure.
        candidates: poses that the scan is laid onto the map at.
        margin: share of the rays that the best pose has to explain more than another one.
        least_share: of the rays, that it has to explain; what obstacles hide is not explained.
            Of both, those count that do not end on the plane under the robot.
        limits: where a robot can stand.
    """

    base_height: float = 0.0
    spacing: float = 1.0
    most_rays: int = 8_000_000
    kept: Tuple[int, ...] = (1200, 4000)
    candidates: int = 80
    margin: float = 0.1
    least_share: float = 0.4
    limits: PoseLimits = field(default_factory=PoseLimits)


class _Sample(NamedTuple):
    """Rays of a scan: points and origins (N, 3) m in the base's frame; telling: (N,) bool, which
    end off the plane under the robot."""

    points: np.ndarray
    origins: np.ndarray
    telling: np.ndarray

    @classmethod
    def of(
        cls, points: np.ndarray, origins: np.ndarray, telling: np.ndarray, most: int
    ) -> "_Sample":
        """At most so many, of which enough are telling."""
        order = np.random.default_rng(0).permutation(len(points))
        some = order[telling[order]][: int(most * _TELLING)]
        others = order[~telling[order]][: int(most * (1 - _TELLING))]
        which = np.sort(np.concatenate([some, others]))
        return cls(points[which], origins[which], telling[which])


class PoseFit(NamedTuple):
    """A scan laid onto the map.

    Attributes:
        pose: (4, 4) of the base in the map.
        covariance: (6, 6) of it in the frame of the base: m, then rad.
        explained: of the rays that end off the plane under the robot, the share that the map
            explains; those that end at obstacles before it are not among these.
        share: the same, of the rays that end on the map or go through it.
        fit: what ranks poses: `explained`, less the rays that go through the map.
    """

    pose: np.ndarray
    covariance: np.ndarray
    explained: float
    share: float
    fit: float


class SearchResult(NamedTuple):
    """What came of a search.

    Attributes:
        state: whether to believe it.
        reason: a sentence for people.
        best: None where nothing fits at all.
        second: the best one elsewhere; None where there is none.
    """

    state: SearchState
    reason: str
    best: Optional[PoseFit] = None
    second: Optional[PoseFit] = None


class GlobalSearch:
    """Finds a robot on a map by one scan.

    The scan is compared with what would be seen from places all over the ground, in all headings;
    closer around those where it fits best; and at the best of these it is laid onto the map. The
    same scan has the same result, on any machine. It belongs to one thread at a time.
    """

    def __init__(
        self,
        geometry: MeshGeometry,
        options: SearchOptions = SearchOptions(),
        tracking: TrackingOptions = TrackingOptions(),
    ) -> None:
        """
        Args:
            geometry: the map.
            options: how it is searched.
            tracking: when the map explains a ray, and which share of them is enough.
        """
        self.geometry, self.options, self.tracking = geometry, options, tracking
        self.target = PlaneTarget(geometry.spatial_index, geometry.face_normals)

    def search(
        self,
        scan: BaseScan,
        *,
        region: Optional[SearchRegion] = None,
        progress: Optional[Progress] = None,
        cancel: Optional[CancelFlag] = None,
    ) -> SearchResult:
        """Look for the pose at which a scan was made.

        Args:
            scan: of one moment.
            region: where to look; None: everywhere.
            progress: called with the share that is done, 0 to 1.
            cancel: ends it.

        Raises:
            Canceled: by `cancel`.
        """
        told = progress or (lambda share: None)
        origins = np.broadcast_to(scan.origins, scan.points.shape)
        telling = self._telling(scan.points, origins)
        least, count = self.tracking.least_rays, int(telling.sum())
        if count < least:
            text = "%d of the scan's %d points are off the plane under the robot, %d are needed"
            return SearchResult(SearchState.NOT_FOUND, text % (count, len(telling), least))
        view = panorama_of(scan.points[telling], origins[telling], self.options.base_height)
        places, spacing = self._places(view, region, cancel)
        if not len(places.positions):
            where = "on this map"
            if region is not None:
                at = "%.1f, %.1f, %.1f" % tuple(region.center)
                where = "within %g m of %s" % (region.radius, at)
            text = "there is no ground %s on which the robot could stand" % where
            return SearchResult(SearchState.NOT_FOUND, text)
        told(0.05)
        scores = self._scores(view, places, spacing, cancel, lambda share: told(0.05 + 0.5 * share))
        order = np.argsort(-scores.max(axis=1), kind="stable")
        fits: List[PoseFit] = []
        begin, done = 0, 0.55
        for end in self.options.kept:
            if begin >= len(order):
                break
            closer = places.part(order[begin:end])
            poses = self._candidates(*self._looked_closer(view, closer, spacing, cancel))
            samples = [_Sample.of(scan.points, origins, telling, most) for most in (_FEW, _MANY)]
            fits = self._laid(samples, poses, fits, cancel)
            result = self._judged(fits)
            if result.state == SearchState.FOUND:
                break
            begin, done = end, 0.5 + 0.5 * done
            told(done)
        told(1.0)
        return result

    def _places(
        self, view: Panorama, region: Optional[SearchRegion], cancel: Optional[CancelFlag]
    ) -> Tuple[SampledPlaces, float]:
        """As many as can be looked at, and how many m they are apart."""
        options, geometry = self.options, self.geometry
        size = geometry.vertices.max(axis=0) - geometry.vertices.min(axis=0)
        widths = np.sort(size)[1:].astype(np.float64)
        if region is not None:
            widths = np.minimum(widths, 2 * region.radius)
        probe = math.sqrt(float(widths.prod()) / _PROBES)
        spacing = options.spacing
        if probe > spacing:
            found = sampled_places(
                geometry, probe, region=region, limits=options.limits, cancel=cancel
            )
            rays = len(found.positions) * view.ranges.size
            spacing = max(spacing, probe * math.sqrt(rays / options.most_rays))
        limits = options.limits
        return (
            sampled_places(geometry, spacing, region=region, limits=limits, cancel=cancel),
            spacing,
        )

    def _scores(
        self,
        view: Panorama,
        places: SampledPlaces,
        spacing: float,
        cancel: Optional[CancelFlag],
        progress: Progress = lambda share: None,
    ) -> np.ndarray:
        """(P, A) float32, of each place and heading."""
        tolerances = np.float32(_OFF[0] * spacing + _OFF[1] * view.ranges)
        step = max(1, _CHUNK // view.ranges.size)
        found = [np.zeros((0, view.ranges.shape[1]), np.float32)]
        for begin in range(0, len(places.positions), step):
            some = places.part(np.arange(begin, min(begin + step, len(places.positions))))
            seen = map_ranges(self.geometry.spatial_index, some, view, cancel)
            found.append(heading_scores(view.ranges, seen, tolerances))
            progress((begin + len(seen)) / len(places.positions))
        return np.concatenate(found)

    def _looked_closer(
        self,
        view: Panorama,
        places: SampledPlaces,
        spacing: float,
        cancel: Optional[CancelFlag],
    ) -> Tuple[SampledPlaces, np.ndarray, float]:
        """Places around others, as near to each other as registration needs it, their scores and
        their spacing."""
        while True:
            spacing /= 3
            limits = self.options.limits
            places = places_around(self.geometry, places, spacing, limits=limits, cancel=cancel)
            scores = self._scores(view, places, spacing, cancel)
            if spacing <= _FINE:
                return places, scores, spacing
            best = np.argsort(-scores.max(axis=1), kind="stable")
            places = places.part(best[: self.options.kept[0]])

    def _candidates(
        self, places: SampledPlaces, scores: np.ndarray, spacing: float
    ) -> List[np.ndarray]:
        """Poses (4, 4) of the base: the best ones that are neither neighbors nor alike."""
        headings = scores.shape[1]
        flat = scores.ravel()
        if not len(flat):
            return []
        most = min(100 * self.options.candidates, len(flat))
        order = np.argpartition(-flat, most - 1)[:most]
        order = order[np.lexsort((order, -flat[order]))]
        where, heading = order // headings, order % headings
        positions = places.positions[where]
        open_ones = np.ones(len(order), bool)
        poses: List[np.ndarray] = []
        for number in range(len(order)):
            if not open_ones[number]:
                continue
            aside = np.linalg.norm(positions - positions[number], axis=1)
            turned = (heading - heading[number] + headings // 2) % headings - headings // 2
            open_ones &= (aside > 1.5 * spacing) | (abs(turned) > 1)
            angle = heading[number] * (2 * np.pi / headings)
            sine, cosine = math.sin(angle), math.cos(angle)
            turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
            pose = np.eye(4)
            frame = places.frames[where[number]]
            pose[:3, :3] = frame @ turn
            pose[:3, 3] = positions[number] + self.options.base_height * frame[:, 2]
            poses.append(pose)
            if len(poses) == self.options.candidates:
                break
        return poses

    def _telling(self, points: np.ndarray, origins: np.ndarray) -> np.ndarray:
        """(N,) bool: points that are not on the plane under the robot, which looks the same
        wherever the ground is even."""
        above = abs(points[:, 2] + self.options.base_height)
        return above > _PLANE[0] + _PLANE[1] * np.linalg.norm(points - origins, axis=1)

    def _laid(
        self,
        samples: "List[_Sample]",
        poses: List[np.ndarray],
        known: List[PoseFit],
        cancel: Optional[CancelFlag],
    ) -> List[PoseFit]:
        """The scan laid onto the map at each, and what was known before, without those that came to
        the same pose; the best one first.

        Args:
            samples: two of the scan's rays: few for all poses, many for the best.
        """
        fits = [PoseFit(pose, _UNSURE, 0.0, 0.0, 0.0) for pose in poses]
        for sample, most, reach in zip(samples, (len(fits), _BEST), (_REACH, 3 * _NEAREST)):
            laid = []
            for fit in fits[:most]:
                if cancel is not None and cancel.is_set():
                    raise Canceled()
                found = self.target.register(
                    sample.points,
                    fit.pose,
                    origins=sample.origins,
                    matching=RAYS,
                    max_distance=reach,
                    min_distance=_NEAREST,
                    cancel=cancel,
                )
                if found is not None:
                    laid.append(self._fit(sample, found))
            fits = _distinct(laid)
        return _distinct(fits + known)

    def _fit(self, sample: "_Sample", found: Registration) -> PoseFit:
        fates = ray_fates(
            self.target, sample.points, sample.origins, found.pose, self.tracking.tolerance
        )
        variance = max(found.residual, _RANGE_NOISE) ** 2 * _CORRELATED
        covariance = np.linalg.inv(np.linalg.inv(_UNSURE) + found.information / variance)
        explained = np.mean(fates.fates[sample.telling] == RayFate.EXPLAINED)
        # Ground that is there wherever a robot stands tells nothing, but ground that is missing.
        through = fates.count(RayFate.THROUGH) / np.count_nonzero(sample.telling)
        share = explained / max(explained + through, 1e-9)
        return PoseFit(
            found.pose, covariance, float(explained), float(share), float(explained - through)
        )

    def _judged(self, fits: List[PoseFit]) -> SearchResult:
        if not fits:
            return SearchResult(SearchState.NOT_FOUND, "the scan fits nowhere on the map")
        best, second = fits[0], fits[1] if len(fits) > 1 else None
        if best.share < self.tracking.ok_share or best.explained < self.options.least_share:
            text = "the scan fits nowhere: at best the map explains %.0f %% of its rays, and %.0f"
            text += " %% of those that meet the map go through it"
            shares = 100 * best.explained, 100 - 100 * best.share
            return SearchResult(SearchState.NOT_FOUND, text % shares, best, second)
        if second is not None and second.fit > best.fit - self.options.margin:
            text = "it may be in two places, %.1f m and %.0f degrees apart, that explain %.0f and"
            text += " %.0f %% of the rays"
            apart = numbers_of(inverse(best.pose) @ second.pose)
            distance, turn = np.linalg.norm(apart[:3]), np.degrees(np.linalg.norm(apart[3:]))
            shares = 100 * best.explained, 100 * second.explained
            text = text % (distance, turn, *shares)
            return SearchResult(SearchState.AMBIGUOUS, text, best, second)
        text = "the map explains %.0f %% of the rays" % (100 * best.explained)
        if second is not None:
            text += ", at the next best place %.0f %%" % (100 * second.explained)
        return SearchResult(SearchState.FOUND, text, best, second)


def _distinct(fits: List[PoseFit]) -> List[PoseFit]:
    """The best one first, without others at the same pose."""
    kept: List[PoseFit] = []
    for fit in sorted(fits, key=lambda fit: -fit.fit):
        for other in kept:
            apart = numbers_of(inverse(other.pose) @ fit.pose)
            if np.linalg.norm(apart[:3]) < _SAME[0] and np.linalg.norm(apart[3:]) < _SAME[1]:
                break
        else:
            kept.append(fit)
    return kept
