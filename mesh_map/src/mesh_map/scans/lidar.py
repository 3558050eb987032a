"""A lidar that turns on a robot: what it measures of a mesh, and of what stands on it."""

import math
from dataclasses import dataclass
from typing import Any, Callable, Optional, Union

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.base.rotation import rotated
from mesh_map.scans.scan import Scan
from mesh_map.scans.trajectory import Trajectory
from mesh_map.spatial.hits import NO_FACE, RayHits
from mesh_map.spatial.spatial_index import SpatialIndex

MOST_RINGS = 1 << 16  # a ring is a uint16 in clouds of drivers
FULL_INTENSITY = 255.0
FULL_RANGE = 10.0  # m: up to here the intensity of a white surface that is met upright is full

Hidden = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Of rays with origins (N, 3) or (3,) and directions (N, 3) of length 1, the (N,) m to what hides
the mesh; inf: nothing."""


@dataclass(frozen=True)
class LidarModel:
    """What a lidar is: rings of rays around the z axis of the sensor.

    Attributes:
        rings, columns: number of rays above each other, and around.
        lowest, highest: elevations of the first and the last ring (rad); of a single one: the
            middle of both.
        min_range, max_range: m; what is nearer or farther is not measured.
        noise: standard deviation of ranges (m), Gaussian.
        dropout: share of the rays that come back without a range, at random, 0 to 1.
        reflect_range: m at which a white surface that is met upright is just seen. Others are seen
            up to `reflect_range * sqrt(reflectance * cos(incidence))`, so that grazing rays and
            dark surfaces are lost first; inf: all are seen.
        duration: s of a revolution, in which the columns are measured one after the other; 0: all
            at once.
    """

    rings: int = 16
    columns: int = 360
    lowest: float = -math.radians(35)
    highest: float = math.radians(15)
    min_range: float = 0.3
    max_range: float = 30.0
    noise: float = 0.0
    dropout: float = 0.0
    reflect_range: float = math.inf
    duration: float = 0.0

    def __post_init__(self) -> None:
        """
        Raises:
            MeshMapError: numbers that make no lidar.
        """
        rings, columns = self.rings, self.columns
        if not 1 <= rings <= MOST_RINGS or columns < 1:
            text = "a lidar of %s rings and %s columns" % (rings, columns)
            raise MeshMapError(text, "1 to %d rings and at least 1 column" % MOST_RINGS)
        if not -math.pi / 2 <= self.lowest <= self.highest <= math.pi / 2:
            text = "a lidar with rings from %s to %s rad" % (self.lowest, self.highest)
            raise MeshMapError(text, "ascending elevations from -pi/2 to pi/2 are needed")
        if not 0 <= self.min_range < self.max_range:
            text = "a lidar with ranges from %s to %s m" % (self.min_range, self.max_range)
            raise MeshMapError(text, "ascending ranges from 0 on are needed")
        for name, value, most in (
            ("noise", self.noise, math.inf),
            ("dropout", self.dropout, 1.0),
            ("duration", self.duration, math.inf),
        ):
            if not 0 <= value <= most or math.isinf(value):
                text = "the %s of a lidar is %s" % (name, value)
                raise MeshMapError(text, "a finite number from 0 to %g is needed" % most)
        if not self.reflect_range > 0:
            text = "the reflect_range of a lidar is %s m" % self.reflect_range
            raise MeshMapError(text, "a number above 0 is needed; inf: all is seen")

    def directions(self) -> np.ndarray:
        """(rings * columns, 3) float64 of length 1 in the sensor's frame, ring by ring from the
        lowest; each ring begins ahead (x) and turns left."""
        middle = [(self.lowest + self.highest) / 2]
        several = np.linspace(self.lowest, self.highest, self.rings)
        elevation = np.repeat(np.array(middle) if self.rings == 1 else several, self.columns)
        around = np.tile(np.arange(self.columns) * (2 * math.pi / self.columns), self.rings)
        flat = np.cos(elevation)
        return np.stack([flat * np.cos(around), flat * np.sin(around), np.sin(elevation)], axis=1)


@dataclass(frozen=True)
class LidarScan:
    """One revolution as the sensor gives it out, ring by ring from the lowest.

    Attributes:
        points: (N, 3) float32 m, each in the sensor's frame as it was when the point was measured:
            the robot's motion is in them.
        times: (N,) float32 s after `time`.
        rings: (N,) uint16, 0 is the lowest.
        intensities: (N,) float32, 0 to 255, see Lidar.
        faces: (N,) uint32 that were met; NO_FACE for what hides the mesh.
        time: s when the revolution began.
        colors: (N, 3) uint8 red, green, blue; None: the mesh has none.
    """

    points: np.ndarray
    times: np.ndarray
    rings: np.ndarray
    intensities: np.ndarray
    faces: np.ndarray
    time: float = 0.0
    colors: Optional[np.ndarray] = None

    def undistorted(self, trajectory: Trajectory, name: str = "scan") -> Scan:
        """The points as if all had been measured at `time`.

        Args:
            trajectory: of the sensor, as far as it is known, such as by odometry.
            name: of the scan, for messages.
        """
        pose = trajectory.poses([self.time])[0]
        points, origins = self.points, None
        if self.times.any():
            # Columns share their moments: there are a few hundred of them, not one for each point.
            moments, column = np.unique(self.times, return_inverse=True)
            positions, rotations = trajectory.at(self.time + moments.astype(np.float64))
            turns = pose[:3, :3].T @ rotations
            shifts = (positions - pose[:3, 3]) @ pose[:3, :3]
            moved = np.einsum("nij,nj->ni", turns[column], self.points) + shifts[column]
            points, origins = np.float32(moved), np.float32(shifts[column])
        return Scan(points, pose, origins, self.colors, self.intensities, self.time, name)


class Lidar:
    """A lidar on a mesh; the same seed measures the same, to the last bit.

    Intensities are those of a Lambertian surface that is larger than the beam (Höfle and Pfeifer,
    Correction of laser scanning intensity data, 2007): 255 * reflectance * cos(incidence) *
    min(1, (10 m / range)^2). What hides the mesh is white, and met upright.

    Attributes:
        model: what it is.
        directions: those of the model.
    """

    def __init__(
        self,
        surface: Any,
        model: LidarModel = LidarModel(),
        *,
        seed: int = 0,
        colors: Optional[Any] = None,
        reflectances: Optional[Any] = None,
    ) -> None:
        """
        Args:
            surface: a MeshMap or MeshGeometry; or a SpatialIndex: then all faces are met upright,
                and there can be no colors.
            model: what it is.
            seed: of noise and dropouts.
            colors: (V, 3) uint8 red, green, blue of the vertices.
            reflectances: (V,) of the vertices or (F,) of the faces, 0 to 1; None: 1 everywhere.

        Raises:
            MeshMapError: arrays of another mesh, or out of their range.
        """
        self._index: SpatialIndex = getattr(surface, "spatial_index", surface)
        self._mesh = None if surface is self._index else surface
        self.model = model
        self.directions = model.directions()
        # Generators of their own: noise stays the same when dropouts come and go.
        self._noise = np.random.default_rng(seed)
        self._dropouts = np.random.default_rng([seed, 1])
        self._colors = None if colors is None else self._checked_colors(np.asarray(colors))
        self._reflectances = reflectances
        if reflectances is not None:
            self._reflectances = self._checked_reflectances(np.asarray(reflectances, np.float64))

    def measure(
        self,
        where: Union[Trajectory, np.ndarray],
        time: float = 0.0,
        hidden: Optional[Hidden] = None,
    ) -> LidarScan:
        """One revolution.

        Args:
            where: the sensor's trajectory in the map's frame, or its pose (4, 4) if it stands.
            time: s when the revolution begins; column c of C is measured c / C * duration later.
            hidden: what hides the mesh.
        """
        model, rays = self.model, len(self.directions)
        shares = np.arange(model.columns) / model.columns
        moments = np.float32(shares * model.duration)
        if isinstance(where, Trajectory):
            if model.duration:
                positions, rotations = where.at(time + moments.astype(np.float64))
            else:
                positions, rotations = (each[0] for each in where.at([time]))
        else:
            positions, rotations = where[:3, 3], where[:3, :3]
        origins, directions = self._rays(positions, rotations)
        hits = self._cast(origins, directions)
        ranges = np.where(hits.faces == NO_FACE, np.inf, hits.distances)
        faces = hits.faces
        if hidden is not None:
            nearer = hidden(origins, directions)
            faces = np.where(nearer < ranges, np.uint32(NO_FACE), faces)
            ranges = np.minimum(ranges, nearer)
        returned = self._returned(faces, directions, hits.barycentric)
        seen = np.isfinite(ranges)
        if math.isfinite(model.reflect_range):
            seen &= ranges <= model.reflect_range * np.sqrt(returned)
        measured = ranges
        if model.noise:
            measured = ranges + model.noise * self._noise.standard_normal(rays)
        if model.dropout:
            seen &= self._dropouts.random(rays) >= model.dropout
        seen &= (measured >= model.min_range) & (measured <= model.max_range)
        falloff = np.minimum(1.0, (FULL_RANGE / np.maximum(ranges[seen], FULL_RANGE)) ** 2)
        found = np.flatnonzero(seen)
        return LidarScan(
            points=np.float32(measured[seen, None] * self.directions[seen]),
            times=moments[found % model.columns],
            rings=np.uint16(found // model.columns),
            intensities=np.float32(FULL_INTENSITY * returned[seen] * falloff),
            faces=faces[seen],
            time=time,
            colors=self._seen_colors(faces[seen], hits.barycentric[seen]),
        )

    def ranges(self, pose: np.ndarray, hidden: Optional[Hidden] = None) -> np.ndarray:
        """(rings * columns,) exact m along each ray of a sensor that stands at a pose (4, 4); inf
        where it meets nothing. Arguments as for measure()."""
        origins, directions = self._rays(pose[:3, 3], pose[:3, :3])
        hits = self._cast(origins, directions)
        ranges = np.where(hits.faces == NO_FACE, np.inf, hits.distances)
        return ranges if hidden is None else np.minimum(ranges, hidden(origins, directions))

    def _rays(self, positions: np.ndarray, rotations: np.ndarray) -> Any:
        """Origins and directions in the map's frame, of one pose or of one for each column."""
        if rotations.ndim == 2:
            return positions, rotated(self.directions, rotations)
        shape = self.model.rings, self.model.columns, 3
        directions = np.einsum("cij,rcj->rci", rotations, self.directions.reshape(shape))
        origins = np.broadcast_to(positions, shape)
        return origins.reshape(-1, 3), directions.reshape(-1, 3)

    def _cast(self, origins: np.ndarray, directions: np.ndarray) -> RayHits:
        # Some thousand rays are not worth the way to a device, and are the same everywhere so.
        return self._index.cast_batch(origins=origins, directions=directions, back_end="native")

    def _returned(
        self, faces: np.ndarray, directions: np.ndarray, barycentric: np.ndarray
    ) -> np.ndarray:
        """(N,) reflectance * cos(incidence) of what rays met, 0 to 1."""
        returned = np.ones(len(faces))
        if self._mesh is None:
            return returned
        met = np.flatnonzero(faces != NO_FACE)
        normals = self._mesh.face_normals[faces[met]]
        returned[met] = np.minimum(abs(np.einsum("ni,ni->n", normals, directions[met])), 1.0)
        if self._reflectances is not None:
            if len(self._reflectances) == len(self._mesh.vertices):
                corners = self._reflectances[self._mesh.faces[faces[met]]]
                returned[met] *= np.einsum("ni,ni->n", corners, barycentric[met])
            else:
                returned[met] *= self._reflectances[faces[met]]
        return returned

    def _seen_colors(self, faces: np.ndarray, barycentric: np.ndarray) -> Optional[np.ndarray]:
        if self._colors is None or self._mesh is None:
            return None
        colors = np.full((len(faces), 3), 255, np.uint8)
        met = np.flatnonzero(faces != NO_FACE)
        corners = self._colors[self._mesh.faces[faces[met]]].astype(np.float64)
        colors[met] = np.rint(np.einsum("nc,nci->ni", barycentric[met], corners))
        return colors

    def _checked_colors(self, colors: np.ndarray) -> np.ndarray:
        count = 0 if self._mesh is None else len(self._mesh.vertices)
        if colors.shape != (count, 3) or colors.dtype != np.uint8:
            text = "colors of the shape %s and type %s for a mesh of %d vertices"
            hint = "(V, 3) uint8 of a MeshGeometry or MeshMap is needed"
            raise MeshMapError(text % (colors.shape, colors.dtype, count), hint)
        return colors

    def _checked_reflectances(self, values: np.ndarray) -> np.ndarray:
        mesh = self._mesh
        counts = (0, 0) if mesh is None else (len(mesh.vertices), len(mesh.faces))
        if values.ndim != 1 or len(values) not in counts or mesh is None:
            text = "reflectances of the shape %s for a mesh of %d vertices and %d faces"
            hint = "one for each vertex or face of a MeshGeometry or MeshMap is needed"
            raise MeshMapError(text % (values.shape, *counts), hint)
        wrong = ~((values >= 0) & (values <= 1))
        if wrong.any():
            text = "%d of %d reflectances are not between 0 and 1; the first is number %d"
            raise MeshMapError(text % (wrong.sum(), len(values), np.argmax(wrong)))
        return values
