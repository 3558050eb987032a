"""Sensors that do not sit where it is said."""

import numpy as np
import pytest

from mesh_localization.tracking.mounting_watch import MountingWatch


def watch(count, scans, seed=0):
    """After `count` scans of each sensor: name -> (shift, height), with noise of 2 cm."""
    random, result = np.random.default_rng(seed), MountingWatch()
    for _ in range(count):
        for name, (shift, height) in scans.items():
            noise = 0.02 * random.standard_normal(4)
            result.add(name, np.array(shift) + noise[:3], height + noise[3])
    return result


STILL = (0.0, 0.0, 0.0)


def test_noise_is_no_fault():
    assert watch(2000, {"front": (STILL, 0.0), "rear": (STILL, 0.01)}).fault == ""


@pytest.mark.parametrize("height, side", [(0.1, "0.10 m above"), (-0.12, "0.12 m below")])
def test_a_base_that_floats_is_told(height, side):
    fault = watch(60, {"front": (STILL, height)}).fault
    assert side in fault and "front" in fault and "base_height" in fault
    assert watch(40, {"front": (STILL, height)}).fault == "", "too soon"


def test_two_sensors_that_pull_apart():
    fault = watch(60, {"front": ((0.0, 0.05, 0.0), 0.0), "rear": ((0.0, -0.05, 0.0), 0.0)}).fault
    assert "front" in fault and "0.05" in fault


def test_one_sensor_alone_that_corrects_odometry_is_no_fault():
    assert watch(500, {"front": ((0.1, 0.0, 0.0), 0.0)}).fault == ""


def test_a_fault_that_was_mended_is_forgotten():
    mended = watch(100, {"front": (STILL, 0.2)})
    assert mended.fault
    for _ in range(300):
        mended.add("front", np.zeros(3), 0.0)
    assert mended.fault == ""


def test_heights_that_are_not_known_say_nothing():
    assert watch(100, {"front": (STILL, np.nan)}).fault == ""
