"""Helpers that tests of several rooms share are in support/."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))


@pytest.fixture(autouse=True, scope="module")
def packages_are_looked_through_once(request):
    """Not for each layer that a test makes, but for the tests of just that."""
    if request.module.__name__.rpartition(".")[2] == "test_plugins":
        yield
        return
    from mesh_map.base.plugins import scanned_once

    with scanned_once():
        yield
