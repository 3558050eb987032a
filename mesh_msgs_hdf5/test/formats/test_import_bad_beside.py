"""Files that a mesh names: nothing outside its folder is read, nothing that is damaged stops it."""
import os
import struct
import zlib

import numpy as np
import pytest
from mesh_writers import SQUARE, Gltf, image_bytes, obj, pixels

from mesh_msgs_hdf5.formats.base import images
from mesh_msgs_hdf5.formats.base.beside import Folder
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.formats.obj import obj_materials
from mesh_msgs_hdf5.model.errors import MapFileError

IMAGE = image_bytes(pixels(1))
VT = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


@pytest.fixture
def folder(tmp_path):
    """The folder of the mesh, inside one where a secret is."""
    (tmp_path / "secret.png").write_bytes(IMAGE)
    (tmp_path / "secret.mtl").write_text("newmtl stone\nKd 1 0 0\n")
    (tmp_path / "mesh").mkdir()
    return tmp_path / "mesh"


def read(folder, texture="a.png", library="a.mtl", files=()):
    text = "mtllib %s\n" % library + obj(SQUARE, []).decode() + VT
    text += "usemtl stone\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    (folder / "a.obj").write_text(text)
    (folder / "a.mtl").write_text("newmtl stone\nKd 0 0 1\nmap_Kd %s\n" % texture)
    for name, data in dict(files).items():
        (folder / name).write_bytes(data)
    mesh, report = read_mesh(folder / "a.obj")
    assert np.array_equal(mesh.vertices, SQUARE)
    return mesh, report


@pytest.mark.parametrize(
    "name",
    [
        "../secret.png",
        "{above}/secret.png",
        "x/../../secret.png",
        "..\\secret.png",
        "link.png",
        "folder/secret.png",
        "/etc/passwd",
        "../mesh/../secret.png",
    ],
)
def test_textures_outside_the_folder(folder, name):
    os.symlink(folder.parent / "secret.png", folder / "link.png")
    os.symlink(folder.parent, folder / "folder")
    mesh, report = read(folder, name.format(above=folder.parent))
    assert not mesh.textures and mesh.materials.texture_indices.tolist() == [-1]
    assert len(report.notes) == 1 and report.notes[0].endswith(
        "is outside the folder of the mesh, where nothing is read"
    )


@pytest.mark.parametrize("name", ["../secret.mtl", "/etc/passwd", "link.mtl"])
def test_material_files_outside_the_folder(folder, name):
    os.symlink(folder.parent / "secret.mtl", folder / "link.mtl")
    mesh, report = read(folder, library=name)
    assert mesh.materials is None
    assert "outside the folder of the mesh" in report.notes[0]


@pytest.mark.parametrize("name", ["../secret.bin", "%2e%2e/secret.bin", "file:///etc/passwd"])
def test_buffers_outside_the_folder(folder, name):
    gltf = Gltf()
    gltf.mesh(SQUARE, [0, 1, 2])
    (folder.parent / "secret.bin").write_bytes(gltf.binary)
    (folder / "a.gltf").write_bytes(gltf.files(name))
    with pytest.raises(MapFileError) as refused:
        read_mesh(folder / "a.gltf")
    assert refused.value.code == "missing" and "buffer 0" in refused.value.message


def test_what_is_beside_it_is_found_by_its_last_name(folder):
    (folder / "secret.png").write_bytes(IMAGE)
    mesh, report = read(folder, "/home/somebody/textures/secret.png")
    assert len(mesh.textures) == 1 and report.notes == []


def test_names_in_latin_1(folder):
    """As programs on other systems write them: in both files, not as the disk has them."""
    text = "mtllib a.mtl\n" + obj(SQUARE, []).decode() + VT + "usemtl ä\nf 1/1 2/2 3/3\n"
    (folder / "a.obj").write_bytes(text.encode("latin-1"))
    (folder / "a.mtl").write_bytes("newmtl ä\nmap_Kd Größe.png\n".encode("latin-1"))
    (folder / "Größe.png").write_bytes(IMAGE)
    mesh, report = read_mesh(folder / "a.obj")
    assert len(mesh.textures) == 1 and report.notes == []


@pytest.mark.parametrize("name", ["A.PNG", "sub/../A.png", "C:\\pictures\\A.Png"])
def test_a_file_whose_name_differs_in_case_is_named(folder, name):
    (folder / "sub").mkdir()
    mesh, report = read(folder, name, files={"a.png": IMAGE})
    assert not mesh.textures
    assert report.notes == ["left out: texture %s is not there, but a.png is: name it so" % name]


@pytest.mark.parametrize(
    "name,reason",
    [
        ("gone.png", "is not there"),
        ("gone\0.png", "has no name"),
        ("loop.png", "is not there"),
        ("pipe.png", "is not there"),
        ("folder.png", "is not there"),
        ("a.mtl", "is no image that can be read"),
        ("a.obj", "is no image that can be read"),
    ],
)
def test_textures_that_are_no_files(folder, name, reason):
    os.symlink("loop.png", folder / "loop.png")
    os.mkfifo(folder / "pipe.png")
    (folder / "folder.png").mkdir()
    mesh, report = read(folder, name)
    assert not mesh.textures and len(report.notes) == 1 and reason in report.notes[0]


def test_material_files_that_are_no_files(folder):
    os.symlink("loop.mtl", folder / "loop.mtl")
    for name in ("loop.mtl", "gone.mtl", "a.obj"):
        _, report = read(folder, library=name)
        assert any("which is not there" in n or "in no file" in n for n in report.notes)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def huge_png(width, height):
    """A small file that says that it is an image of this size."""
    head = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000)))


@pytest.mark.parametrize(
    "size", [(12000, 12000), (100000, 100000), (2**31 - 1, 1), (20000, 20000)]
)
def test_huge_images_are_not_decoded(folder, size):
    mesh, report = read(folder, files={"a.png": huge_png(*size)})
    assert not mesh.textures and len(report.notes) == 1
    assert "pixels" in report.notes[0]


def test_many_large_images_together(folder, monkeypatch):
    monkeypatch.setattr("mesh_msgs_hdf5.formats.base.material_list.MAX_PIXELS", 10)
    text = "mtllib a.mtl\n" + obj(SQUARE, []).decode() + VT
    for name in "ab":
        text += "usemtl %s\nf 1/1 2/2 3/3\n" % name
        (folder / (name + ".png")).write_bytes(image_bytes(pixels(1)))
    (folder / "a.mtl").write_text("newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n")
    (folder / "a.obj").write_text(text)
    mesh, report = read_mesh(folder / "a.obj")
    assert list(mesh.textures) == [0] and mesh.materials.texture_indices.tolist() == [0, -1]
    assert "b.png would be more than 10 pixels with those before it" in report.notes[-1]


@pytest.mark.parametrize("length", range(0, len(IMAGE), 7))
def test_images_that_are_cut_off(folder, length):
    mesh, report = read(folder, files={"a.png": IMAGE[:length]})
    assert len(mesh.textures) == len(report.notes) ^ 1


@pytest.mark.parametrize("form", ["PNG", "JPEG", "BMP", "TGA", "TIFF", "GIF"])
def test_images_of_any_bytes(form):
    """Changed bytes end in an image or in an ImageError, and in nothing else."""
    data = bytearray(image_bytes(pixels(3, 9, 8), form))
    rng = np.random.default_rng(11)
    ends = {"image": 0, "error": 0}
    for _ in range(150):
        changed = bytearray(data)
        for at in rng.integers(0, len(data), 3):
            changed[at] = rng.integers(0, 256)
        try:
            image = images.decoded(bytes(changed))
        except images.ImageError as error:
            assert str(error) and "\n" not in str(error)
            ends["error"] += 1
        else:
            assert image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] in (3, 4)
            ends["image"] += 1
    # a PNG file has a checksum for each of its parts
    assert sum(ends.values()) == 150 and (form == "PNG" or ends["image"])


def test_other_kinds_of_pixels(folder):
    from PIL import Image

    gray = np.arange(6, dtype=np.uint8).reshape(2, 3)
    deep = (gray.astype(np.uint16) << 8) + 77
    for image, expected in (
        (Image.fromarray(gray), np.stack([gray] * 3, axis=2)),
        (Image.fromarray(deep), np.stack([gray] * 3, axis=2)),
        (
            Image.merge("LA", [Image.fromarray(gray), Image.fromarray(255 - gray)]),
            np.stack([gray] * 3 + [255 - gray], axis=2),
        ),
        (Image.fromarray(np.stack([gray] * 3, axis=2)).quantize(), np.stack([gray] * 3, axis=2)),
    ):
        image.save(folder / "b.png")
        found = images.decoded((folder / "b.png").read_bytes())
        assert np.array_equal(found, expected), image.mode
    Image.fromarray(gray.astype(np.float32)).save(folder / "b.tiff")
    with pytest.raises(images.ImageError, match="pixels of floats"):
        images.decoded((folder / "b.tiff").read_bytes())


def test_files_that_are_too_large(folder, monkeypatch):
    monkeypatch.setattr(obj_materials, "MAX_MTL_BYTES", 10)
    _, report = read(folder)
    assert "materials of a.mtl, which has 35 bytes, more than 10" in report.notes[0]


def test_a_name_that_becomes_a_link_is_not_followed(folder, monkeypatch):
    """Between looking and opening, somebody puts a link there."""
    (folder / "a.png").write_bytes(IMAGE)
    there = Folder(folder / "a.obj")
    assert there.read("a.png") == (IMAGE, "")
    path, _ = there.find("a.png")
    os.unlink(path)
    os.symlink(folder.parent / "secret.png", path)
    monkeypatch.setattr(there, "find", lambda name: (path, ""))
    data, reason = there.read("a.png")
    assert data is None and "cannot be read" in reason


@pytest.mark.parametrize(
    "text",
    [
        "newmtl stone\nKd 1 0\nmap_Kd\n",
        "newmtl stone\nKd spectral file.rfl\n",
        "newmtl stone\nKd nan inf -1\n",
        "Kd 1 1 1\nmap_Kd b.png\n",
        "newmtl\nnewmtl stone\nmap_Kd -s\n",
        "newmtl stone\nmap_Kd -o 1 2 3\n",
        "\0\xff\xfe",
        "newmtl stone\n" * 1000,
    ],
)
def test_material_files_that_say_nothing(folder, text):
    (folder / "b.mtl").write_text(text, encoding="latin-1")
    mesh, report = read(folder, library="b.mtl")
    assert not mesh.textures
    assert mesh.materials is None or mesh.materials.colors.shape == (1, 3)


@pytest.mark.parametrize("only", [images._ONLY, {}])
def test_image_formats_that_are_not_read(monkeypatch, only):
    """Also with a Pillow that cannot be told which ones to try."""
    monkeypatch.setattr(images, "_ONLY", only)
    with pytest.raises(images.ImageError):
        images.decoded(image_bytes(pixels(1), "PPM"))
    assert np.array_equal(images.decoded(IMAGE), pixels(1))
