"""FBX, 3DS and archives of COLLADA, which assimp reads in a process of its own."""
import numpy as np
import pytest
from mesh_writers import dae, image_bytes, pixels
from scene_files import archive, exported, fbx

from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.model.errors import MapFileError

POINTS = np.float32([[1, 2, 3], [2, 2, 3], [1, 4, 3], [1, 2, 7]])
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
IMAGE = pixels(5)


def surface(vertices, faces):
    """Corners of each face in the order in which it is turned, from the least on."""
    found = []
    for face in np.asarray(vertices, float)[np.asarray(faces)].round(5).tolist():
        first = face.index(min(face))
        found.append(face[first:] + face[:first])
    return sorted(found)


def check(path, expected, **options):
    mesh, report = read_mesh(path, **options)
    assert surface(mesh.vertices, mesh.faces) == surface(expected, FACES)
    return report


def z_up(points):
    return points[:, [0, 2, 1]] * [1, -1, 1]


@pytest.mark.parametrize("up,unit", [(1, 1.0), (2, 100.0), (1, 2.5)])
def test_fbx_says_its_unit_and_axes(tmp_path, up, unit):
    (tmp_path / "a.fbx").write_bytes(fbx(POINTS, FACES, up, unit))
    expected = (POINTS if up == 2 else z_up(POINTS)) * unit / 100
    report = check(tmp_path / "a.fbx", expected)
    assert report.format == "FBX" and "FBX's unit (%g m)" % (unit / 100) in report.notes[0]
    check(tmp_path / "a.fbx", expected, up="xyz"[up])
    with pytest.raises(MapFileError, match="FBX says that %s is up" % "xyz"[up]):
        read_mesh(tmp_path / "a.fbx", up="xzy"[up])
    check(tmp_path / "a.fbx", expected * 2, scale=2)


def test_fbx_as_text_and_by_its_content(tmp_path):
    data = exported(tmp_path, "fbxa", POINTS, np.uint32(FACES))
    assert data.startswith(b"; FBX")
    for text, unit in ((data, 0.01), (_with_unit(data, b"UnitScaleFactor", b"100"), 1.0)):
        (tmp_path / "a.bin").write_bytes(text)
        check(tmp_path / "a.bin", z_up(POINTS) * unit)


def _with_unit(data, name, value):
    lines = data.split(b"\n")
    for index, line in enumerate(lines):
        if b'"' + name + b'"' in line:
            lines[index] = line.rpartition(b",")[0] + b", " + value
    return b"\n".join(lines)


def test_images_in_fbx(tmp_path):
    coordinates = np.float32([[0, 0], [1, 0], [0, 1], [0.5, 0.25]])
    data = fbx(POINTS, FACES, 2, 100.0, image_bytes(IMAGE), coordinates)
    (tmp_path / "a.fbx").write_bytes(data)
    mesh, report = read_mesh(tmp_path / "a.fbx")
    assert len(mesh.textures) == 1, report.notes
    assert np.array_equal(mesh.textures[0], IMAGE)
    assert (mesh.materials.texture_indices[mesh.materials.face_materials] == 0).all()
    order = [np.flatnonzero((POINTS == vertex).all(1))[0] for vertex in mesh.vertices]
    assert np.array_equal(mesh.texture_coordinates, coordinates[order])


def test_3ds_has_z_up_and_no_unit(tmp_path):
    (tmp_path / "a.3ds").write_bytes(exported(tmp_path, "3ds", POINTS, np.uint32(FACES)))
    report = check(tmp_path / "a.3ds", POINTS)
    assert "3DS says no unit: meters were taken; --scale is for others" in report.notes
    check(tmp_path / "a.3ds", POINTS, up="z")
    with pytest.raises(MapFileError, match="3DS says that z is up"):
        read_mesh(tmp_path / "a.3ds", up="y")


@pytest.mark.parametrize("up", ["Y_UP", "Z_UP"])
def test_collada_in_an_archive(tmp_path, up):
    (tmp_path / "a.zae").write_bytes(archive(dae(POINTS, FACES, up, "0.5")))
    expected = (POINTS if up == "Z_UP" else z_up(POINTS)) / 2
    assert check(tmp_path / "a.zae", expected).format == "ZAE"
    check(tmp_path / "a.zae", expected, up=up[0].lower())
    with pytest.raises(MapFileError, match="says that"):
        read_mesh(tmp_path / "a.zae", up="zy"[up == "Z_UP"])


def test_images_in_an_archive(tmp_path):
    from test_import_textures import textured_dae

    text = textured_dae()
    (tmp_path / "a.dae").write_text(text)
    (tmp_path / "wall 1.png").write_bytes(image_bytes(IMAGE))
    wanted, _ = read_mesh(tmp_path / "a.dae")
    (tmp_path / "inner").mkdir()
    inside = [("images/wall 1.png", image_bytes(IMAGE))]
    (tmp_path / "inner" / "a.zae").write_bytes(archive(text, inside))
    mesh, report = read_mesh(tmp_path / "inner" / "a.zae")
    assert len(wanted.textures) == len(mesh.textures) == 1, report.notes
    assert np.array_equal(mesh.textures[0], IMAGE)
    indices = [m.materials.texture_indices[m.materials.face_materials] for m in (mesh, wanted)]
    assert np.array_equal(*indices)


@pytest.mark.parametrize("form", ["fbx", "fbxa", "3ds", "zae"])
def test_damaged_files_are_one_clear_error(tmp_path, form):
    """Cut short and with other bytes: refused, or another mesh; this process goes on."""
    data = {
        "fbx": lambda: fbx(POINTS, FACES),
        "fbxa": lambda: exported(tmp_path, "fbxa", POINTS, np.uint32(FACES)),
        "3ds": lambda: exported(tmp_path, "3ds", POINTS, np.uint32(FACES)),
        "zae": lambda: archive(dae(POINTS, FACES)),
    }[form]()
    random = np.random.default_rng(1)
    path = tmp_path / ("a." + form[:3])
    refused = 0
    for length in np.linspace(1, len(data) - 1, 3).astype(int):
        refused += not _is_read(path, data[:length])
    for _ in range(5):
        changed = bytearray(data)
        for place in random.integers(30, len(data), 6):
            changed[place] = random.integers(256)
        refused += not _is_read(path, bytes(changed))
    assert refused >= 2
    assert not _is_read(path, b"hello")


def _is_read(path, data):
    path.write_bytes(data)
    try:
        mesh, _ = read_mesh(path)
    except MapFileError as error:
        assert "\n" not in str(error)
        return False
    return len(mesh.faces) > 0


def test_settings_that_say_nothing_of_use(tmp_path):
    """What is missing or odd is as most programs have it: centimeters, y up."""
    for name, value in ((b"UpAxis", b"7"), (b"UnitScaleFactor", b"-1")):
        data = exported(tmp_path, "fbxa", POINTS, np.uint32(FACES))
        (tmp_path / "a.fbx").write_bytes(_with_unit(data, name, value))
        check(tmp_path / "a.fbx", z_up(POINTS) / 100)
