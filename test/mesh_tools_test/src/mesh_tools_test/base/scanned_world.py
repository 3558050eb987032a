"""The world that is scanned and reconstructed: rough ground with a bridge, stairs and walls."""

import math
from typing import Iterator, NamedTuple, Sequence, Tuple, Union

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.recording import RecordedScan, record_scans
from mesh_map.scans.tour import tour
from mesh_map.scans.trajectory import Trajectory
from mesh_msgs.outdoor_world import outdoor_world

SIZE, FACES = 40.0, 400_000  # m; edges of about 10 cm
SCANS = 60
SENSOR_HEIGHT = 1.2  # m above the ground
LIDAR = LidarModel(
    rings=64,
    columns=1024,
    lowest=-math.radians(40),
    highest=math.radians(15),
    max_range=30.0,
    noise=0.015,
    reflect_range=60.0,
)
# Places of the world, and parts of its side.
Places = Sequence[Union[str, Tuple[float, float]]]
# Over and under the bridge, up to the stairs' landing, around the hills and into the walled garden.
TOUR: Places = (
    *("start", "bridge_deck", (0.45, 0.10), "goal", (0.45, 0.05), (0.42, -0.14), (0.14, -0.42)),
    *((-0.35, -0.42), (-0.05, -0.25), "under_bridge", (0.02, 0.42), (-0.07, -0.11)),
    *((-0.33, 0.03), "landing", (-0.45, 0.18)),
)
# 112 m: over the bridge, around, and back under it.
LOOP: Places = (
    *("start", "bridge_deck", (0.45, 0.05), (0.42, -0.14), (0.14, -0.42)),
    *("under_bridge", (-0.33, 0.03)),
)


class ScannedWorld(NamedTuple):
    """mesh: the truth; colors: (V, 3) uint8; sensor: the true drive of the lidar."""

    mesh: MeshGeometry
    colors: np.ndarray
    sensor: Trajectory

    def scans(
        self,
        lidar: LidarModel = LIDAR,
        count: int = SCANS,
        seed: int = 0,
        drift: OdometryDrift = OdometryDrift(),
    ) -> Iterator[RecordedScan]:
        """So many, evenly along the drive, with poses that drift; by default 2.8 M points."""
        times = self.sensor.times
        rate = (count - 1e-6) / (times[-1] - times[0] - lidar.duration)
        odometry = drift.of(self.sensor, seed)
        scans = record_scans(
            self.mesh,
            self.sensor,
            lidar=lidar,
            odometry=odometry,
            rate=rate,
            seed=seed,
            colors=self.colors,
        )
        return (scan for scan, _ in zip(scans, range(count)))


def scanned_world(
    faces: int = FACES, seed: int = 0, size: float = SIZE, places: Places = TOUR
) -> ScannedWorld:
    """The world and a drive through places of it, that begins and ends at the first one.

    :raises ValueError: as outdoor_world().
    """
    world = outdoor_world(faces, seed, size=size, trees=False, stairs=True)
    assert world.colors is not None
    mesh = MeshGeometry(world.vertices, world.faces)
    waypoints = []
    for place in (*places, places[0]):
        if isinstance(place, str):
            waypoints.append(world.places[place])
        else:
            xy = np.array(place) * size
            found = mesh.spatial_index.cast(origin=[*xy, 100.0], direction=[0.0, 0.0, -1.0])
            assert found is not None
            waypoints.append(tuple(found.position))
    drive = tour(mesh, waypoints=waypoints, speed=1.0)
    return ScannedWorld(mesh, world.colors, drive.above(SENSOR_HEIGHT))
