"""What OBJ and MTL files say that a mesh cannot hold, or that does not fit together, is said."""
import pytest
from mesh_writers import SQUARE, image_bytes, obj, pixels

from mesh_msgs_hdf5.formats.importer import read_mesh

VT = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
TEXT = "mtllib a.mtl\n" + obj(SQUARE, []).decode() + VT
TEXT += "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n"


def read(folder, mtl):
    (folder / "a.png").write_bytes(image_bytes(pixels(1)))
    (folder / "a.mtl").write_text(mtl)
    (folder / "a.obj").write_text(TEXT)
    return read_mesh(folder / "a.obj")


@pytest.mark.parametrize(
    "lines,words",
    [
        ("d 0.5\n", "its transparency (d, Tr)"),
        ("d -halo 0.5\n", "its transparency (d, Tr)"),
        ("Tr 0.25\n", "its transparency (d, Tr)"),
        ("map_d a.png\n", "its texture of transparency (map_d)"),
        ("Kd 2 -1 0.5\n", "its color (Kd) beyond 0..1"),
        ("map_Ka a.png\n", "its texture of ambient light (map_Ka), the only one"),
        ("newmtl a\nKd 1 0 0\n", "an entry of its own (it is there twice: the last values count)"),
    ],
)
def test_what_a_material_says_and_a_mesh_cannot_hold(tmp_path, lines, words):
    _, report = read(tmp_path, "newmtl b\nmap_Kd a.png\nnewmtl a\n" + lines)
    assert report.notes == ["left out of 1 materials: %s; the first is a" % words]


def test_what_says_nothing_more_is_not_noted(tmp_path):
    mtl = "newmtl a\nKd 1 0 0\nd 1.0\nTr 0\nmap_Ka a.png\nmap_Kd a.png\nNs 10\nillum 2\n"
    _, report = read(tmp_path, mtl + mtl.replace("newmtl a", "newmtl b"))
    assert report.notes == []


def test_many_materials_are_one_note(tmp_path):
    _, report = read(tmp_path, "newmtl a\nd 0.5\nTr 0.5\nnewmtl b\nmap_Kd a.png\nd 0.25\n")
    assert report.notes == ["left out of 2 materials: its transparency (d, Tr); the first is a"]
