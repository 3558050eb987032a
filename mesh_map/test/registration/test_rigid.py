"""Rigid motions and their six numbers."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mesh_map.registration.rigid import adjoint, inverse, motion, moved, numbers_of


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.5, 3.0, np.pi - 1e-6, np.pi])
def test_numbers_and_matrices_are_each_others(angle):
    random = np.random.default_rng(0)
    for _ in range(20):
        axis = random.standard_normal(3)
        numbers = np.r_[random.normal(size=3), angle * axis / np.linalg.norm(axis)]
        matrix = motion(numbers)
        expected = Rotation.from_rotvec(numbers[3:]).as_matrix()
        np.testing.assert_allclose(matrix[:3, :3], expected, atol=1e-12)
        np.testing.assert_allclose(motion(numbers_of(matrix)), matrix, atol=1e-7)
        np.testing.assert_allclose(inverse(matrix) @ matrix, np.eye(4), atol=1e-12)
        points = random.normal(size=(5, 3))
        back = moved(inverse(matrix), moved(matrix, points))
        np.testing.assert_allclose(back, points, atol=1e-12)


def test_the_adjoint_puts_a_small_motion_on_the_other_side():
    random = np.random.default_rng(1)
    for _ in range(20):
        pose, small = motion(random.normal(size=6)), 1e-7 * random.normal(size=6)
        after, before = pose @ motion(small), motion(adjoint(pose) @ small) @ pose
        np.testing.assert_allclose(after, before, atol=1e-12)
