"""What several tests share."""
import os
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs_hdf5.mesh import Mesh


@pytest.fixture
def full_mesh():
    """A small mesh with one of everything, special values among them."""
    rng = np.random.default_rng(7)
    costs = rng.random(40).astype(np.float32)
    costs[:3] = np.inf, np.nan, -0.0
    return Mesh(
        vertices=rng.normal(size=(40, 3)).astype(np.float32),
        faces=rng.integers(0, 40, (60, 3)).astype(np.uint32),
        vertex_normals=rng.normal(size=(40, 3)).astype(np.float32),
        vertex_colors=rng.integers(0, 256, (40, 3)).astype(np.uint8),
        vertex_costs={"height_diff": costs, "Grün und weich": costs[::-1].copy()},
        frame_id="floor_2",
        source={"file": "x.ply", "notes": ["ä"]},
        layer_parameters={"height_diff": {"radius": 0.3, "type": "mesh_layers/HeightDiffLayer"}},
    )


def data_folder():
    """The folder of real meshes beside the repository, or skip."""
    folder = (
        os.environ.get("MESH_TOOLS_DATA") or Path(__file__).resolve().parents[3] / "shared/data"
    )
    if not Path(folder).is_dir():
        pytest.skip("no folder of real meshes: set MESH_TOOLS_DATA")
    return Path(folder)


@pytest.fixture
def real_mesh():
    """A function from a file name to its path among the real meshes."""
    folder = data_folder()

    def find(name):
        if not (folder / name).is_file():
            pytest.skip("%s is not among the real meshes" % name)
        return folder / name

    return find
