"""Paths find the field that they were made from."""

import io

import numpy as np
import pytest
from nav_msgs.msg import Path
from genpy import Time

from mesh_navigation.base.messages import path_message, poses_from_path
from mesh_navigation.plugins.planner import PlanField
from mesh_navigation.server.plan_store import PlanStore


def field(number):
    return PlanField(np.full(3, float(number)), 1.0, None, 0, np.zeros(3))


def poses(number):
    return np.random.default_rng(number).standard_normal((5, 7))


def test_finds_what_was_put():
    store = PlanStore(3)
    for number in range(3):
        store.put(poses(number), field(number))
    for number in range(3):
        assert store.find(poses(number)).labels[0] == number
    assert store.find(poses(1)[:-1]) is None
    assert store.find(np.nextafter(poses(1), 9.0)) is None


def test_forgets_what_was_not_used_for_the_longest_time():
    store = PlanStore(3)
    for number in range(3):
        store.put(poses(number), field(number))
    store.find(poses(0))
    store.put(poses(9), field(9))
    assert store.find(poses(1)) is None
    assert all(store.find(poses(number)) for number in (0, 2, 9))
    store.put(poses(9), None)
    assert store.find(poses(9)) is None
    store.clear()
    assert store.find(poses(0)) is None


@pytest.mark.parametrize("layout", [np.ascontiguousarray, np.asfortranarray])
def test_a_path_survives_the_wire(layout):
    store, given = PlanStore(), layout(poses(4) / 3)
    store.put(given, field(4))
    wire, received = io.BytesIO(), Path()
    path_message(given, "map", Time(7)).serialize(wire)
    received.deserialize(wire.getvalue())
    assert store.find(poses_from_path(received)).labels[0] == 4


def test_an_empty_path():
    assert poses_from_path(Path()).shape == (0, 7)
    assert PlanStore().find(poses_from_path(Path())) is None
