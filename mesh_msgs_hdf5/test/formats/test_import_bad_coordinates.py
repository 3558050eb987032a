"""One texture coordinate that is not finite costs no textures: it becomes the mean of its
neighbors."""
import numpy as np
import pytest
from mesh_writers import SQUARE, TWO_FACES, pixels
from seam_samples import closed_box, write_obj

from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.mesh import Materials, Mesh

PAIRS = np.float32([[0.1, 0.2], [0.9, 0.3], [0.77, 0.66], [0.4, 0.8]])


def textured():
    mesh = Mesh(SQUARE, TWO_FACES, texture_coordinates=PAIRS)
    mesh.textures = {0: pixels(1)}
    white, none = np.full((1, 3), 255, np.uint8), np.zeros(2, np.uint32)
    mesh.materials = Materials(white, np.zeros(1, np.int32), none)
    return mesh


def damage(path):
    """NaN in the place of the u of vertex 2 in an export of textured()."""
    u, v = PAIRS[2]
    if path.suffix == ".gltf":
        path = path.with_suffix(".bin")
    data = path.read_bytes()
    if path.suffix in (".obj", ".dae"):
        old, new = b"%.9g %.9g\n" % (u, v), b"NaN %.9g\n" % v
    else:
        v = v if path.suffix == ".ply" else np.float32(1 - np.float64(v))
        old, new = np.float32([u, v]).tobytes(), np.float32([np.nan, v]).tobytes()
    assert data.count(old) == 1
    path.write_bytes(data.replace(old, new))


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".glb", ".gltf", ".dae"])
def test_one_that_is_not_finite_is_the_mean(tmp_path, suffix):
    """Vertex 2 is in both faces, beside 0 and 1, and 0 and 3."""
    path = tmp_path / ("a" + suffix)
    write_mesh(path, textured())
    damage(path)
    mesh, report = read_mesh(path)
    assert len(mesh.textures) == 1 and mesh.materials.texture_indices.tolist() == [0]
    assert len(mesh.vertices) == 4
    wanted = PAIRS.copy()
    wanted[2] = (2 * PAIRS[0] + PAIRS[1] + PAIRS[3]) / 4
    found = {tuple(v): uv for v, uv in zip(mesh.vertices.tolist(), mesh.texture_coordinates)}
    assert np.allclose([found[tuple(v)] for v in SQUARE.tolist()], wanted)
    assert sum("the mean of those beside them" in note for note in report.notes) == 1


def test_seams_stay_where_one_coordinate_is_not_finite(tmp_path):
    """An OBJ of others: of the corners of a side, one has none that is finite."""
    vertices, faces, uv = closed_box()
    path = write_obj(tmp_path, (vertices, faces, uv))
    lines = path.read_text().splitlines()
    places = [i for i, line in enumerate(lines) if line.startswith("vt ")]
    whole, _ = read_mesh(path)
    lines[places[0]] = "vt nan 0.5"
    path.write_text("\n".join(lines) + "\n")
    mesh, report = read_mesh(path)
    assert len(mesh.textures) == 2 and np.isfinite(mesh.texture_coordinates).all()
    before = whole.texture_coordinates[whole.faces]
    after = mesh.texture_coordinates[mesh.faces]
    changed = (before != after).any(axis=2)
    pair = np.unique(np.float32(uv).reshape(-1, 2), axis=0)[0]
    assert np.array_equal(changed, (np.float32(uv) == pair).all(axis=2)) and changed.any()
    # inside the place of its own side of the box
    sides = np.floor(before[changed] * 3 + 1e-3)
    assert (after[changed] * 3 >= sides - 1e-3).all()
    assert (after[changed] * 3 <= sides + 1 + 1e-3).all()
    assert "texture coordinates of %d corners are not finite" % changed.sum() in report.notes[0]


def test_all_that_are_not_finite_are_left_out(tmp_path):
    path = write_obj(tmp_path, closed_box())
    lines = path.read_text().splitlines()
    lines = ["vt inf nan" if line.startswith("vt ") else line for line in lines]
    path.write_text("\n".join(lines) + "\n")
    mesh, report = read_mesh(path)
    assert mesh.texture_coordinates is None
    assert "those of all 36 corners are not finite" in report.notes[0]
