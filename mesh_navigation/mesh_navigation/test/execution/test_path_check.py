"""Paths that come from outside."""

import numpy as np
import pytest

from mesh_navigation.base.pose import Pose, transformed
from mesh_navigation.execution.path_check import normalized_path, path_fault, transformed_path
from mesh_navigation.execution.path_execution import Tolerances
from mesh_navigation.server.late_cycles import LateCycles

FINE = Tolerances(0.1, 0.1)


def path(count=4):
    poses = np.random.default_rng(1).standard_normal((count, 7))
    return normalized_path(poses)


def broken(index, column, value):
    poses = path()
    poses[index, column] = value
    return poses


@pytest.mark.parametrize(
    "poses, words",
    [
        (path(0), ["empty"]),
        (broken(2, 1, np.nan), ["1 of 4 poses are not finite", "pose 2", "nan"]),
        (broken(3, 6, -np.inf), ["not finite", "pose 3", "-inf"]),
        (broken(1, slice(3, 7), 0.0), ["1 of 4 poses", "quaternion", "pose 1", "w = 1"]),
        (broken(0, slice(3, 7), 0.6), ["quaternion", "pose 0", "0.60"]),
    ],
)
def test_faults_of_poses(poses, words):
    fault = path_fault(poses, FINE)
    assert all(word in fault for word in words), fault


@pytest.mark.parametrize("bad", [np.nan, -0.1, -np.inf])
def test_faults_of_tolerances(bad):
    assert "distance" in path_fault(path(), Tolerances(bad, 0.1))
    assert "angle" in path_fault(path(), Tolerances(0.1, bad))


def test_paths_without_fault():
    assert path_fault(path(), Tolerances(0.0, np.inf)) == ""
    assert path_fault(path() * [1, 1, 1, 1.004, 1.004, 1.004, 1.004], FINE) == ""
    assert path_fault(path() + [1e6, 0, 0, 0, 0, 0, 0], FINE) == ""


def test_transformed_as_single_poses_are():
    frame = Pose(np.array([1.0, -2.0, 0.5]), normalized_path(path(1))[0, 3:] * 1.001)
    found = transformed_path(path(), frame)
    for row, (position, orientation) in zip(
        found, (transformed(Pose(p[:3], p[3:]), frame) for p in path())
    ):
        np.testing.assert_allclose(row, [*position, *orientation], atol=1e-12)


def test_late_cycles_are_told_of_once_a_minute():
    cycles, said = LateCycles(), []
    for second in np.arange(0.0, 300.0, 0.05):
        late = 100.0 < second < 101.0 or 190.0 < second < 190.2
        sentence = cycles.note(0.5 if late else 0.01, late, second)
        said += [(round(second), sentence)] if sentence else []
    assert [second for second, _ in said] == [120, 240]
    assert "19 of 2401 control cycles" in said[0][1] and "500 ms" in said[0][1]
    assert cycles.last_words() == ""
