"""Where the tests of all rooms find what they share."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))


@pytest.fixture(autouse=True, scope="module")
def packages_are_looked_through_once(request):
    """Not for each plugin that a test makes, but for the tests of just that."""
    if request.module.__name__.rpartition(".")[2] == "test_plugin_list":
        yield
        return
    from mesh_map.base.plugins import scanned_once

    with scanned_once():
        yield
