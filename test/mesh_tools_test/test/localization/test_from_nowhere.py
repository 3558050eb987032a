"""The benchmark of robots found on a large map, on a small one."""

import numpy as np
import pytest
from mesh_tools_test.base.storeys_world import HEIGHT, storeys_world
from mesh_tools_test.localization import from_nowhere


@pytest.fixture(scope="module")
def world():
    return storeys_world(30.0, edge=1.0)


def test_the_world_has_two_storeys_that_a_ramp_joins(world):
    geometry = world.mesh
    topology = geometry.topology
    corners = np.array([[0.7, 0.7, level] for level in (0.0, HEIGHT)])
    components = topology.components[
        [geometry.nearest_vertex(corner, 1.0)[0] for corner in corners]
    ]
    assert components[0] == components[1]
    poses = world.poses(6)
    assert set(poses[:, 2, 3]) == {0.0, HEIGHT}
    found = geometry.spatial_index.closest_batch(points=poses[:, :3, 3])
    np.testing.assert_allclose(found.distances, 0.0, atol=1e-6)
    clear = geometry.spatial_index.closest_batch(points=poses[:, :3, 3] + [0.0, 0.0, 0.45])
    assert (clear.distances > 0.4).all(), "something stands there"


def test_two_places_are_measured_with_each_sensor(world):
    figures = from_nowhere.measure(2, world)
    right = [figure for figure in figures if "not right" in figure.name]
    assert [figure.floor for figure in right] == [from_nowhere.MOST_WRONG, None, None]
    assert right[0].value == 0, "a lidar in a small building"
    believed = [figure.value for figure in figures if "wrong and believed" in figure.name]
    assert believed == [0, 0, 0]
