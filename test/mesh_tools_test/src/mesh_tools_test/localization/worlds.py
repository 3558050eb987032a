"""The worlds in which a robot is localized: a truth that is scanned, and a map of it."""

import math
from dataclasses import dataclass
from typing import Callable, Dict

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.reconstruction.drivable_surface import drivable
from mesh_map.reconstruction.options import SurfaceOptions
from mesh_map.reconstruction.signed_distance import SignedDistanceField
from mesh_map.registration.point_to_plane import PlaneTarget
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.tour import tour
from mesh_map.scans.trajectory import Trajectory
from mesh_msgs.world.solids import box
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_tools_test.base.scanned_world import SENSOR_HEIGHT, scanned_world
from mesh_tools_test.base.storeys_world import storeys_world

FACES = 1_000_000
RATE = 10.0  # scans in a second
RAYS = 2000  # of a scan
DRIFT = OdometryDrift(slip=0.01, yaw=math.radians(0.5))
LIDAR = LidarModel(
    lowest=-math.radians(35), highest=math.radians(15), noise=0.015, duration=1 / RATE
)
CORRIDOR = 40.0  # m that are driven; its ends are beyond the reach of the lidar
_ROUGHNESS = 0.05  # m, standard deviation of the heights of vertices
_VOXEL = 0.1  # m
_STOREYS = 40.0  # m, side of the building
_REACH = 35.0  # m from the ends of the corridor, which the lidar does not see from there


@dataclass(frozen=True)
class LocalizationWorld:
    """
    Attributes:
        name: for people.
        truth: what the lidar sees.
        target: the map, whose batches are cast by one thread.
        sensor: the true drive of the lidar.
        geometry: of the map.
    """

    name: str
    truth: MeshGeometry
    target: PlaneTarget
    sensor: Trajectory
    geometry: MeshGeometry


def _world(
    name: str, truth: MeshGeometry, sensor: Trajectory, geometry: MeshGeometry
) -> LocalizationWorld:
    target = PlaneTarget(geometry.spatial_index, geometry.face_normals)
    target.index.threads = 1
    return LocalizationWorld(name, truth, target, sensor, geometry)


def outdoor(faces: int) -> LocalizationWorld:
    """Hills with a bridge, stairs and walls, 40 x 40 m."""
    world = scanned_world(faces)
    return _world("outdoor", world.mesh, world.sensor, world.mesh)


def rough_ground(faces: int) -> LocalizationWorld:
    """The same with vertices that scatter in height."""
    world = scanned_world(faces)
    vertices = world.mesh.vertices.copy()
    vertices[:, 2] += np.random.default_rng(0).normal(0.0, _ROUGHNESS, len(vertices))
    mesh = MeshGeometry(vertices, world.mesh.faces)
    return _world("rough ground", mesh, world.sensor, mesh)


def two_storeys(faces: int) -> LocalizationWorld:
    """A building of two storeys with a ramp, 40 x 40 m."""
    edge = math.sqrt(4 * _STOREYS**2 / faces)
    mesh = storeys_world(_STOREYS, edge).mesh
    drive = tour(mesh, count=8).above(SENSOR_HEIGHT)
    return _world("two storeys", mesh, drive, mesh)


def reconstructed(faces: int) -> LocalizationWorld:
    """The outdoor world, and the map that was made of 60 scans of it with voxels of 0.10 m."""
    world = scanned_world(faces)
    field = SignedDistanceField(voxel_size=_VOXEL)
    for each in world.scans():
        field.integrate(each.scan.in_map(), each.scan.origins_in_map())
    found = field.extract()
    surface = Mesh(vertices=found.vertices, faces=found.faces, vertex_normals=found.normals)
    made = drivable(surface, SurfaceOptions())[0]
    return _world(
        "reconstructed", world.mesh, world.sensor, MeshGeometry(made.vertices, made.faces)
    )


def corridor(faces: int) -> LocalizationWorld:
    """Walls, floor and ceiling without any feature along them; `faces` are not asked for."""
    half = CORRIDOR / 2 + _REACH
    mesh = MeshGeometry(*box([-half, -1.5, 0.0], [half, 1.5, 2.6]))
    count = int(20 * CORRIDOR) + 1
    positions = np.zeros((count, 3))
    positions[:, 0] = np.linspace(-CORRIDOR / 2, CORRIDOR / 2, count)
    positions[:, 2] = SENSOR_HEIGHT
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    drive = Trajectory(positions[:, 0] - positions[0, 0], positions, turns)
    return _world("corridor", mesh, drive, mesh)


WORLDS: Dict[str, Callable[[int], LocalizationWorld]] = {
    "outdoor": outdoor,
    "storeys": two_storeys,
    "rough": rough_ground,
    "reconstructed": reconstructed,
    "corridor": corridor,
}
