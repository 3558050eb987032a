"""What the tests of all rooms share."""

import pytest


@pytest.fixture(autouse=True, scope="module")
def packages_are_looked_through_once():
    """Not for each plugin that a test makes."""
    from mesh_map.base.plugins import scanned_once

    with scanned_once():
        yield
