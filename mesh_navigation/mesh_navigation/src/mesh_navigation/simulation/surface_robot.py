"""A robot that drives on the faces of a mesh."""

import math
from typing import Any, Callable, NamedTuple, Optional

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.walk import SurfaceWalk, WalkEnd
from mesh_map.geometry.walk_start import walk_start

from mesh_navigation.base.pose import Pose, multiply, quaternion_from_axes, rotate, vector_text
from mesh_navigation.base.robot import Velocity
from mesh_navigation.controllers.vector3 import cross
from mesh_navigation.simulation.wheels import BaseLimits, Wheels
from mesh_navigation.surface.up_normals import face_up_normals

PLACING = 1.0  # m from the surface, where a robot may be put
_SAME = 1e-6  # m, of surfaces at the same place
LONGEST_STEP = 0.02  # s that are computed at once
_OBSTRUCTIONS = {
    WalkEnd.BORDER: "the surface ends here",
    WalkEnd.BLOCKED: "the surface is too steep here",
    WalkEnd.NOWHERE: "there is no way on from here",
}


class Motion(NamedTuple):
    """A short piece of a drive, on the ground or as wheels count it."""

    distance: float
    """m."""
    turn: float
    """To the left (rad)."""


class MotionNoise:
    """Errors whose variance is proportional to the motion, so that the steps do not matter."""

    def __init__(self, share: float, seed: int) -> None:
        """
        Args:
            share: standard deviation (m) of the way after 1 m, (rad) of the heading after 1 m, and
                (rad) after turning by 1 rad.
            seed: the same seed makes the same errors.
        """
        if not 0 <= share < math.inf:
            raise ValueError(f"noise of motions is {share}, but has to be >= 0 and finite")
        self._share = share
        self._random = np.random.default_rng(seed)

    def on(self, motion: Motion) -> Motion:
        """The motion with errors; none where there is no motion."""
        if self._share == 0:
            return motion
        way, bend, turn = (self._share * self._random.standard_normal(3)).tolist()
        root = math.sqrt(abs(motion.distance))
        return Motion(
            motion.distance + way * root,
            motion.turn + bend * root + turn * math.sqrt(abs(motion.turn)),
        )


REACH = 5  # times the height of a step: how far its side may go, along a ramp or askew


class SteepGround:
    """Walks of a robot over a mesh. Which way faces are wound makes no difference."""

    def __init__(self, geometry: MeshGeometry, max_slope: Optional[float], max_step: float) -> None:
        """
        Args:
            geometry: the mesh.
            max_slope: rad; faces that are steeper stop the robot. None: none does.
            max_step: m; but not where they lead up or down by no more.
        """
        self._geometry, self._max_step = geometry, max_step
        self.gentle: Optional[np.ndarray] = None
        """(F,) bool, the faces that do not stop it; None for all."""
        if max_slope is not None:
            upward = np.abs(geometry.face_normals @ geometry.up)
            gentle = upward >= math.cos(min(max_slope, math.pi / 2)) - 1e-6
            self.gentle = gentle | geometry.faces_without_area

    def walk(self, start: SurfaceWalk, length: float) -> SurfaceWalk:
        """Straight on (m, below 0: back) as far as it gets."""
        walker = self._geometry.walker
        walk = walker.walk(start=start, length=length, mask=self.gentle)
        if walk.end == WalkEnd.BLOCKED and self._is_step(walk, math.copysign(1.0, length)):
            return walker.walk(start=start, length=length)
        return walk

    def _is_step(self, walk: SurfaceWalk, sign: float) -> bool:
        """Whether what stopped a walk is so low that wheels climb it."""
        ahead = self._geometry.walker.walk(
            start=walk, length=sign * REACH * self._max_step, path=True
        )
        if ahead.path is None or self.gentle is None:
            return False
        steep = ~self.gentle[ahead.path.faces]
        if not steep.any():
            return False
        first = int(np.argmax(steep))
        rest = steep[first:]
        if rest.all():
            return False  # it does not end within reach
        last = first + int(np.argmin(rest))
        side = ahead.path.points[last] - ahead.path.points[first]
        return abs(float(side @ self._geometry.up)) <= self._max_step + 1e-6


class SurfaceRobot:
    """A point with a heading on the surface, straight on or in arcs as its wheels turn.

    On a plane its arcs are exact, whatever the steps. The surface's border stops it, and so do
    faces that it must not enter. It belongs to one thread at a time. The same seed and the same
    commands make the same drive.
    """

    def __init__(
        self,
        surface: Any,
        pose: Pose,
        *,
        seed: int = 0,
        slip: float = 0.0,
        noise: float = 0.0,
        odometry_noise: float = 0.0,
        odometry_yaw_drift: float = 0.0,
        limits: BaseLimits = BaseLimits(),
        max_slope: Optional[float] = None,
        max_step: float = 0.2,
        is_free: Callable[[np.ndarray], bool] = lambda position: True,
    ) -> None:
        """
        Args:
            surface: a `MeshMap` or a `MeshGeometry`.
            pose: where it begins, see `put`.
            seed: of all noise.
            slip: share of what its wheels turn that does not move it, 0 to 1.
            noise: of the motion on the ground, see `MotionNoise`; wheels do not count it.
            odometry_noise: of what wheels count.
            odometry_yaw_drift: what the heading that they count gains on each meter (rad/m).
            limits: of its base.
            max_slope: rad; it does not enter faces that are steeper. None: it climbs walls, too.
            max_step: m; with max_slope: sides of steps that are not higher do not stop it.
            is_free: whether a place (3,) is not within something else; it does not go there.
        """
        self.geometry: MeshGeometry = getattr(surface, "geometry", surface)
        self.change_odometry(slip, odometry_yaw_drift)
        self._noise = MotionNoise(noise, seed)
        self._counting = MotionNoise(odometry_noise, seed + 1)
        self._wheels = Wheels(limits)
        self._ground = SteepGround(self.geometry, max_slope, max_step)
        self.is_free = is_free
        self.obstruction = ""
        """What stopped it in the last step in which it was to go somewhere; empty: nothing."""
        self.driven = 0.0
        """Meters on the ground, back ones too."""
        self.place = self._found(pose)
        """Where it is on the surface: face, position, heading, normal."""
        self._counted = np.zeros(3)
        self.drift = -_yaw(self.place.direction)
        """Heading of the odometry minus the true one (rad)."""

    def change_odometry(self, slip: float, yaw_drift: float) -> None:
        """How wrong it is from now on, see ``slip`` and ``odometry_yaw_drift`` of the class.

        Raises:
            ValueError: there is no such slip or drift.
        """
        if not 0 <= slip <= 1:
            raise ValueError(f"slip of a robot is {slip}, but has to be from 0 to 1")
        if not math.isfinite(yaw_drift):
            raise ValueError(f"the drift of an odometry is {yaw_drift}, but has to be finite")
        self._slip, self._yaw_drift = slip, yaw_drift

    def jump_odometry(self, x: float, y: float, yaw: float) -> None:
        """The odometry jumps, the robot stays.

        Args:
            x, y: ahead and to the left, as it was before (m).
            yaw: to the left (rad).
        """
        self._counted = self._counted + rotate(self.odometry.orientation, (x, y, 0.0))
        self.drift += yaw

    def put(self, pose: Pose) -> None:
        """Put the robot elsewhere, standing still; the odometry does not notice.

        Args:
            pose: of any attitude, its x axis shows the heading; the robot stands on the side of the
                surface that looks up, at the nearest point of it.

        Raises:
            MeshMapError: that is farther than `PLACING`, or it is no pose.
        """
        self.place = self._found(pose)
        self._wheels = Wheels(self._wheels.limits)

    @property
    def pose(self) -> Pose:
        """The true pose."""
        ahead, up = self.place.direction.tolist(), self.place.normal.tolist()
        return Pose(self.place.position, quaternion_from_axes(ahead, cross(up, ahead), up))

    @property
    def velocity(self) -> Velocity:
        """Of its wheels, which may slip."""
        return self._wheels.velocity

    @property
    def odometry(self) -> Pose:
        """What wheels and a level tell: like the true pose at first, upright where it began, later
        off in place and heading, never in roll and pitch."""
        turn = np.array([0.0, 0.0, math.sin(self.drift / 2), math.cos(self.drift / 2)])
        return Pose(self._counted, multiply(turn, self.pose.orientation))

    def step(self, velocity: Velocity, seconds: float) -> None:
        """Command a velocity for some time."""
        count = max(1, math.ceil(seconds / LONGEST_STEP - 1e-6))
        for _ in range(count):
            self._step(velocity, seconds / count)

    def _step(self, command: Velocity, seconds: float) -> None:
        mean = self._wheels.advance(command, seconds)
        # Only a base that goes sideways has another direction than its heading.
        side = math.atan2(mean.y, mean.x) if mean.y else 0.0
        speed = math.hypot(mean.x, mean.y) if mean.y else mean.x
        wheels = Motion(speed * seconds, mean.yaw * seconds)
        grip = 1.0 - self._slip
        ground = self._noise.on(Motion(wheels.distance * grip, wheels.turn * grip))
        before = self.place
        middle = before.turned(ground.turn / 2 + side)
        share = self._go(middle, _chord(ground), ground.turn / 2 - side)
        if share < 1:
            self._wheels.block()
            wheels = wheels._replace(distance=wheels.distance * share)
        counted = self._counting.on(wheels)
        drifted = counted.turn + self._yaw_drift * abs(counted.distance)
        counted = counted._replace(turn=drifted)
        moved = _chord(ground) * share
        along = (self.place.position - before.position) / moved if moved else middle.direction
        astray = counted.turn - ground.turn
        step = _turned(along * _chord(counted), self.drift + astray / 2)
        self._counted = self._counted + step
        self.drift += astray

    def _go(self, start: SurfaceWalk, length: float, turn: float) -> float:
        """Go straight on from there, then turn; returns which share of the length was free."""
        if not length:
            self.place = start.turned(turn)
            return 1.0
        walk = self._ground.walk(start, length)
        self.obstruction = _OBSTRUCTIONS.get(walk.end, "")
        if walk.end == WalkEnd.NOWHERE or self._runs_into(walk, start):
            walk = start._replace(length=0.0)
        self.driven += walk.length
        self.place = walk.turned(turn)
        return walk.length / abs(length)

    def _runs_into(self, walk: SurfaceWalk, start: SurfaceWalk) -> bool:
        """Whether it is not free there. Where it is not free already, it may go away."""
        if self.is_free(walk.position) or not self.is_free(start.position):
            return False
        self.obstruction = "an obstacle is in the way"
        return True

    def _found(self, pose: Pose) -> SurfaceWalk:
        fault = pose.fault()
        if fault:
            raise MeshMapError(f"no pose for a robot: {fault}")
        geometry, pose = self.geometry, pose.normalized()
        empty = geometry.faces_without_area
        point = geometry.spatial_index.closest(
            point=pose.position, max_distance=PLACING, mask=~empty if empty.any() else None
        )
        if point is None:
            raise MeshMapError(
                f"no surface within {PLACING:.2f} m of {vector_text(pose.position)}",
                "put the robot nearer to the mesh",
            )
        upward = geometry.spatial_index.closest(
            point=point.position, max_distance=_SAME, normal=geometry.up, max_angle=math.pi / 2
        )
        point = upward or point  # and not on the bottom of a thing that stands on the floor
        axes = [rotate(pose.orientation, axis) for axis in np.eye(3)]
        point = walk_start(geometry, point, axes[0], axes[2], mask=self._ground.gentle)
        normal = face_up_normals(geometry, np.array([point.face]))[0]
        along = next(
            flat for flat in (_flattened(axis, normal) for axis in axes) if flat @ flat > 1e-6
        )
        ahead = along / np.linalg.norm(along)
        return SurfaceWalk(
            point.face, point.position, point.barycentric, ahead, normal, 0.0, WalkEnd.ARRIVED
        )


def _chord(motion: Motion) -> float:
    """The straight way (m) between the ends of an arc; negative for one that was driven back."""
    half = motion.turn / 2
    return motion.distance * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)


def _flattened(vector: np.ndarray, normal: np.ndarray) -> np.ndarray:
    return vector - (vector @ normal) * normal


def _turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """A vector (3,) turned about z."""
    return rotate((0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)), vector)


def _yaw(heading: np.ndarray) -> float:
    return math.atan2(heading[1], heading[0])
