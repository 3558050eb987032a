"""Things that stand around on a map: boxes, cylinders and balls of any proportions."""

from typing import Any, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from mesh_map.base.errors import MeshMapError

from mesh_navigation.base.pose import Pose, rotate

BOX, CYLINDER, SPHERE = "box", "cylinder", "sphere"
SHAPES = (BOX, CYLINDER, SPHERE)
MAX_OBSTACLES = 10_000


class Obstacle(NamedTuple):
    """A solid thing in the map's frame."""

    shape: str
    """One of `SHAPES`; a cylinder stands along its z axis."""
    pose: Pose
    """Of its middle."""
    size: np.ndarray
    """(3,) m along its axes: edges of the box around it."""

    @classmethod
    def checked(cls, shape: str, pose: Pose, size: Any) -> "Obstacle":
        """The same, checked.

        Raises:
            MeshMapError: another shape, no pose, or a size that is not above 0.
        """
        if shape not in SHAPES:
            raise MeshMapError(f"an obstacle is a {shape!r}", "known: " + ", ".join(SHAPES))
        fault = pose.fault()
        if fault:
            raise MeshMapError(f"the pose of a {shape}: {fault}")
        sizes = np.asarray(size, dtype=np.float64)
        if sizes.shape != (3,) or not np.all(np.isfinite(sizes) & (sizes > 0)):
            raise MeshMapError(
                f"the size of a {shape} is {sizes.tolist()}", "three numbers above 0 are needed"
            )
        return cls(shape, pose.normalized(), sizes)

    def _own(self, vectors: np.ndarray) -> np.ndarray:
        """(N,3) vectors of the map as seen from the obstacle, scaled so that its size is 2."""
        axes = np.stack([rotate(self.pose.orientation, axis) for axis in np.eye(3)], axis=1)
        return vectors @ axes * (2 / self.size)

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(N,) bool of (N,3) points: whether they are in it, or on its hull."""
        x, y, z = self._own(points - self.pose.position).T
        if self.shape == SPHERE:
            return x * x + y * y + z * z <= 1
        sides = x * x + y * y <= 1 if self.shape == CYLINDER else np.maximum(abs(x), abs(y)) <= 1
        return sides & (abs(z) <= 1)

    def ray_distances(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """(N,) m at which rays first meet the hull, from outside or within; inf: never.

        Args:
            origins: (N,3), or (3,) for all.
            directions: (N,3) of length 1.
        """
        rays = np.atleast_2d(self._own(directions))
        starts = np.broadcast_to(self._own(origins - self.pose.position), rays.shape)
        if self.shape == SPHERE:
            enter, leave = _in_round(starts, rays)
        elif self.shape == CYLINDER:
            enter, leave = _in_both(
                _in_round(starts[:, :2], rays[:, :2]), _in_slabs(starts[:, 2:], rays[:, 2:])
            )
        else:
            enter, leave = _in_slabs(starts, rays)
        first = np.where(enter >= 0, enter, leave)
        return np.where((enter <= leave) & (first >= 0), first, np.inf)


Span = Tuple[np.ndarray, np.ndarray]  # of each ray: where it begins and ends to be within


def _in_both(first: Span, second: Span) -> Span:
    return np.maximum(first[0], second[0]), np.minimum(first[1], second[1])


def _in_slabs(starts: np.ndarray, rays: np.ndarray) -> Span:
    """Rays within -1 to 1 in each of the K columns of (N,K) arrays."""
    still = rays == 0
    speed = np.where(still, 1.0, rays)
    ends = np.stack([(-1 - starts) / speed, (1 - starts) / speed])
    inside = abs(starts) <= 1
    enter = np.where(still, np.where(inside, -np.inf, np.inf), ends.min(axis=0))
    leave = np.where(still, np.where(inside, np.inf, -np.inf), ends.max(axis=0))
    return enter.max(axis=1), leave.min(axis=1)


def _in_round(starts: np.ndarray, rays: np.ndarray) -> Span:
    """Rays within the unit ball, or circle, of (N,3) or (N,2) arrays."""
    speed = np.sum(rays * rays, axis=1)
    still = speed == 0
    speed = np.where(still, 1.0, speed)
    # From the point of the ray that is nearest to the middle: no cancellation far away.
    nearest = -np.sum(starts * rays, axis=1) / speed
    closest = starts + nearest[:, None] * rays
    square = 1 - np.sum(closest * closest, axis=1)
    half = np.sqrt(np.maximum(square, 0) / speed)
    hits = square >= 0
    enter = np.where(hits, np.where(still, -np.inf, nearest - half), np.inf)
    leave = np.where(hits, np.where(still, np.inf, nearest + half), -np.inf)
    return enter, leave


def ray_distances(
    obstacles: Sequence[Obstacle], origins: np.ndarray, directions: np.ndarray
) -> np.ndarray:
    """(N,) m to the first obstacle, inf where there is none; arguments of one's method."""
    nearest = np.full(len(directions), np.inf)
    for obstacle in obstacles:
        np.minimum(nearest, obstacle.ray_distances(origins, directions), out=nearest)
    return nearest


def is_within(obstacles: Sequence[Obstacle], point: np.ndarray) -> bool:
    """Whether a point (3,) is in one of them."""
    return any(obstacle.contains(point[None])[0] for obstacle in obstacles)


def read_obstacles(value: Any) -> Tuple[List[Obstacle], List[str]]:
    """Obstacles from a parameter, and one sentence for each entry that is none.

    Args:
        value: list of ``{type: box, position: [x, y, z], size: [x, y, z], yaw: 0}``, yaw in rad.
    """
    if not isinstance(value, (list, tuple)):
        return [], [f"obstacles is no list but {value!r}"]
    found, complaints = [], []
    if len(value) > MAX_OBSTACLES:
        complaints.append(f"of {len(value)} obstacles the first {MAX_OBSTACLES} are used")
    for index, entry in enumerate(value[:MAX_OBSTACLES]):
        try:
            found.append(_read(entry))
        except MeshMapError as error:
            complaints.append(f"obstacles[{index}] is skipped: {error}")
    return found, complaints


def _read(entry: Any) -> Obstacle:
    if not isinstance(entry, Mapping):
        raise MeshMapError(f"it is {entry!r}", "{type, position, size, yaw} is needed")
    return Obstacle.checked(
        entry.get("type", BOX),
        Pose.at(_numbers(entry, "position"), *_numbers({"yaw": [entry.get("yaw", 0.0)]}, "yaw", 1)),
        _numbers(entry, "size"),
    )


def _numbers(entry: Mapping[str, Any], name: str, count: int = 3) -> np.ndarray:
    value = entry.get(name)
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (count,) or not np.all(np.isfinite(numbers)):
        raise MeshMapError(
            f"its {name} is {value!r}", "finite numbers are needed: " + _SHAPE[count]
        )
    return numbers


_SHAPE = {1: "one", 3: "[x, y, z]"}
