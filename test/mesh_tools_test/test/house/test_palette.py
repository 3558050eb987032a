"""RViz and mesh_tool have one palette."""

import re
from pathlib import Path

import numpy as np
import pytest
from mesh_msgs_hdf5.rendering import render_scale

HEADER = Path(__file__).parents[4] / "rviz_mesh_plugin" / "src" / "coloring" / "color_scale.h"


@pytest.mark.parametrize("name", ["LETHAL", "UNKNOWN"])
def test_lethal_and_unknown_look_the_same_everywhere(name):
    found = re.search(name + r"_COST_COLOR\{(\d+), (\d+), (\d+), 255\}", HEADER.read_text("utf-8"))
    expected = np.array(found.groups(), float) / 255.0
    np.testing.assert_allclose(getattr(render_scale, name), expected)
