"""The world of the benchmark of reconstruction, smaller than there."""

import numpy as np
import pytest
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_tools_test.base.scanned_world import LIDAR, SCANS, scanned_world

FEW = LidarModel(rings=16, columns=128, lowest=LIDAR.lowest, highest=LIDAR.highest, noise=0.015)


@pytest.fixture(scope="module")
def world():
    return scanned_world(faces=60_000)


def test_its_scans_lie_on_it_and_see_most_of_it(world):
    assert world.sensor.length > 200
    assert world.sensor.positions[0] == pytest.approx(world.sensor.positions[-1], abs=0.2)
    scans = list(world.scans(FEW))
    assert len(scans) == SCANS and [each.scan.time for each in scans] == sorted(
        each.scan.time for each in scans
    )
    points = np.concatenate([each.scan.in_map() for each in scans])
    away = world.mesh.spatial_index.closest_batch(points=points).distances
    # Ranges have noise along the rays, which meet most of the ground at an angle.
    assert 0.003 < away.mean() < 0.012 and away.max() < 0.1
    assert all((each.scan.pose == each.truth).all() for each in scans)
    above = world.mesh.spatial_index.closest_batch(points=world.sensor.positions).distances
    assert 0.3 < above.min() and above.max() < 1.3


def test_poses_drift_but_the_truth_does_not(world):
    exact = list(world.scans(FEW, count=9))
    drifted = list(world.scans(FEW, count=9, drift=OdometryDrift(yaw=0.001, slip=0.002)))
    for one, other in zip(exact, drifted):
        assert (one.truth == other.truth).all()
        assert one.measured.points.tolist() == other.measured.points.tolist()
    assert 0.1 < np.linalg.norm(drifted[-1].scan.pose[:3, 3] - drifted[-1].truth[:3, 3]) < 10
