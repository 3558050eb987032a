"""Helpers that tests of several rooms share are in support/."""

import gc
import sys
from pathlib import Path

import pytest
from mesh_msgs.testing import expect_a_busy_machine

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))
expect_a_busy_machine()


def pytest_collection_finish():
    """What is there before the first test stays: garbage is not looked for in it each time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True, scope="module")
def packages_are_looked_through_once(request):
    """Not for each layer that a test makes, but for the tests of just that."""
    if request.module.__name__.rpartition(".")[2] == "test_plugins":
        yield
        return
    from mesh_map.base.plugins import scanned_once

    with scanned_once():
        yield
