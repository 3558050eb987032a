"""What several tests share."""
import os
import sys
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs.testing import expect_a_busy_machine
from mesh_msgs_hdf5.isolation import isolated_map_file
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh

sys.path.insert(0, str(Path(__file__).resolve().parent / "support"))
expect_a_busy_machine()


def make_full_mesh():
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


def make_rich_mesh():
    """The former with textures, materials, labels, features, face attributes and origin too."""
    rng = np.random.default_rng(8)
    mesh = make_full_mesh()
    mesh.face_attributes = {
        "cost": rng.random(60).astype(np.float32),
        "segment": rng.integers(-(2**62), 2**62, 60),
        "face_normals": rng.normal(size=(60, 3)),
        "Fläche m²": rng.integers(0, 9, (60, 2)).astype(np.uint16),
    }
    mesh.face_parameters = {"cost": {"radius": 0.5}}
    mesh.vertex_attributes = {
        "class_id": rng.integers(0, 256, 40).astype(np.uint8),
        "id": rng.integers(0, 2**64, 40, dtype=np.uint64),
        "intensity": rng.random(40),
        "echo": np.where(rng.random(40) < 0.2, np.nan, rng.random(40)).astype(np.float32),
        "SIFT": rng.integers(-128, 128, (40, 7)).astype(np.int8),
        "flow": rng.normal(size=(40, 3)).astype(np.float32),
    }
    mesh.vertex_parameters = {"SIFT": {"octaves": 3}, "flow": {"unit": "m/s"}}
    mesh.texture_coordinates = rng.random((40, 2)).astype(np.float32)
    mesh.textures = {
        index: rng.integers(0, 256, shape).astype(np.uint8)
        for index, shape in ((0, (5, 7, 3)), (2, (1, 1, 4)), (10, (33, 40, 3)))
    }
    mesh.materials = Materials(
        colors=rng.integers(0, 256, (4, 3)).astype(np.uint8),
        texture_indices=np.array([0, -1, 10, 2], np.int32),
        face_materials=rng.integers(0, 4, 60).astype(np.uint32),
    )
    mesh.labels = {
        "tree_1": Label(np.array([5, 3, 4], np.uint32), (0, 128, 255)),
        "tree_2": Label(np.arange(60, dtype=np.uint32)),
        "house_2_b": Label(np.array([59], np.uint32), (1, 2, 3)),
        "a free text": Label(np.array([7, 8], np.uint32)),
        "grass": Label(np.zeros(0, np.uint32), (9, 9, 9)),
        "grass_": Label(np.array([1], np.uint32)),
        "_x": Label(np.array([2], np.uint32)),
        "a_..": Label(np.array([2], np.uint32)),
        "%_é": Label(np.array([6], np.uint32), (0, 0, 0)),
    }
    mesh.features = Features(
        rng.normal(size=(12, 3)).astype(np.float32), rng.random((12, 64)).astype(np.float32)
    )
    mesh.origin = (4.3e5, 5.79e6, -0.1)
    mesh.crs = "EPSG:25832"
    return mesh


@pytest.fixture
def full_mesh():
    """A mesh that the test may change."""
    return make_full_mesh()


@pytest.fixture
def rich_mesh():
    """A mesh of everything that the test may change."""
    return make_rich_mesh()


@pytest.fixture
def read_here(monkeypatch):
    """Map files are read in this process, for tests that do not care which one reads them."""
    from reader_here import ReaderHere

    monkeypatch.setattr(isolated_map_file, "_Reader", ReaderHere)


@pytest.fixture(scope="session")
def full_data(tmp_path_factory):
    """The bytes that MapFile.write makes of full_mesh."""
    path = tmp_path_factory.mktemp("full") / "a.h5"
    MapFile.write(path, make_full_mesh())
    return path.read_bytes()


@pytest.fixture(scope="session")
def rich_data(tmp_path_factory):
    """The bytes that MapFile.write makes of rich_mesh."""
    path = tmp_path_factory.mktemp("rich") / "a.h5"
    MapFile.write(path, make_rich_mesh())
    return path.read_bytes()


@pytest.fixture(scope="session")
def strange_data(tmp_path_factory, rich_data):
    """The same with strange things in it."""
    from raw_contents import add_strange_things

    path = tmp_path_factory.mktemp("strange") / "a.h5"
    path.write_bytes(rich_data)
    add_strange_things(path)
    return path.read_bytes()


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
