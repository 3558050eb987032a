"""Materials and textures of PLY, OBJ and COLLADA: from beside the file, seams split or left out."""
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_writers import SQUARE, TWO_FACES, dae, image_bytes, obj, pixels, ply, xyz

from mesh_msgs_hdf5.formats.base.polygons import triangulate
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.formats.obj import obj_lines
from mesh_msgs_hdf5.model.errors import MapFileError

UV = [(0, 0), (1, 0), (1, 1), (0, 1)]
IMAGE = pixels(1)
FACES = "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
VT = "".join("vt %g %g\n" % pair for pair in UV)


@pytest.fixture
def read(tmp_path):
    """Read a file of that name and content, beside files of these: (mesh, report)."""

    def read(name, data, files=(), **options):
        for other, content in dict(files, **{name: data}).items():
            path = tmp_path / other
            path.parent.mkdir(exist_ok=True, parents=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_mesh(tmp_path / name, **options)

    return read


def textured_obj(faces=FACES, head="mtllib a.mtl\n", vt=VT):
    return head + obj(SQUARE, []).decode() + vt + "usemtl stone\n" + faces


def mtl(name="a.png", color="1 1 1"):
    return "newmtl stone\nKd %s\nmap_Kd %s\n" % (color, name)


@pytest.mark.parametrize(
    "line,file",
    [
        ("a.png", "a.png"),
        ("my wall (2).png", "my wall (2).png"),
        ("textures/a.png", "textures/a.png"),
        ("textures\\a.png", "textures/a.png"),
        ("C:\\Users\\me\\a.png", "a.png"),
        ("-s 1 1 1 -o 0 0 a b.png", "a b.png"),
        ("-blendu on -mm 0 1 -clamp off -bm 0.5 -imfchan r -texres 512 a.png", "a.png"),
        ("-s 2 7up.png", "7up.png"),
        ("-unknown.png", "-unknown.png"),
    ],
)
def test_names_of_textures(read, line, file):
    mesh, report = read(
        "a.obj", textured_obj(), {"a.mtl": mtl(line, "0.2 0.4 1"), file: image_bytes(IMAGE)}
    )
    assert list(mesh.textures) == [0] and np.array_equal(mesh.textures[0], IMAGE)
    assert mesh.texture_coordinates.tolist() == [list(pair) for pair in UV]
    assert mesh.materials.colors.tolist() == [[51, 102, 255]]
    assert mesh.materials.texture_indices.tolist() == [0]
    assert mesh.materials.face_materials.tolist() == [0, 0]
    moved = ["material stone: moving and scaling of its texture is left out"]
    assert report.notes == (moved if line.startswith(("-s", "-o")) else [])
    assert (report.materials, report.textures) == (1, 1)


def test_materials_of_several_files(read):
    """Those that faces have, in the order of the files; one image is one texture."""
    head = "mtllib a.mtl\nmtllib b c.mtl\nmtllib gone.mtl\n"
    text = head + obj(SQUARE, []).decode() + VT + "f 1 2 3\nusemtl the grass\nf 1/1 3/3 4/4\n"
    text += "usemtl what\nf 1 2 4\nusemtl stone\nf 2 3 4\nusemtl empty\nusemtl brick\nf 1 2 4\n"
    files = {
        "a.mtl": "newmtl brick\nKd 1 0 0\nmap_Kd a.png\nnewmtl unused\nmap_Kd gone.png\n",
        "b c.mtl": "newmtl the grass\nKd 0 1 0\nmap_Kd ./a.png\nnewmtl stone\nKd 0 0 1\n"
        "newmtl empty\nmap_Kd b.png\n",
        "a.png": image_bytes(IMAGE),
    }
    mesh, report = read("a.obj", text, files)
    assert mesh.materials.colors.tolist() == [
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [255] * 3,
        [255] * 3,
    ]
    assert mesh.materials.texture_indices.tolist() == [0, 0, -1, -1, -1]
    assert mesh.materials.face_materials.tolist() == [4, 1, 3, 2, 0]
    assert list(mesh.textures) == [0]
    assert report.notes == [
        "12 face corners have no texture coordinates",
        "left out: materials of gone.mtl, which is not there",
        "1 materials are in no file, and white: what",
    ]


def test_several_names_in_a_line(read):
    files = {"a.mtl": "newmtl other\n", "b.mtl": mtl(color="0 0 0"), "a.png": image_bytes(IMAGE)}
    mesh, report = read("a.obj", textured_obj(head="mtllib a.mtl b.mtl\n"), files)
    assert mesh.materials.colors.tolist() == [[0, 0, 0]] and report.notes == []


SEAMS = "f 1/1 2/2 3/3\nf 1/2 3/4 4/4\nf 4/4 1/2 2/2\n"


def test_seams_leave_coordinates_out_on_request(read):
    files = {"a.mtl": mtl(color="1 0 0"), "a.png": image_bytes(IMAGE)}
    mesh, report = read("a.obj", textured_obj(SEAMS), files, split_seams=False)
    assert mesh.source["options"] == {"split_seams": False} and mesh.seam_originals is None
    assert mesh.texture_coordinates is None and not mesh.textures
    assert mesh.materials.colors.tolist() == [[255, 0, 0]]
    assert mesh.materials.texture_indices.tolist() == [-1]
    assert len(mesh.vertices) == 4
    assert report.notes == [
        "texture coordinates left out: 2 vertices have several (seams); --split-seams keeps them",
        "left out: 1 textures, for want of coordinates",
    ]


def test_seams_without_textures_are_split_on_request(read):
    """Coordinates alone show nothing."""
    mesh, report = read("a.obj", textured_obj(SEAMS), {"a.mtl": "newmtl stone\nKd 1 0 0\n"})
    assert len(mesh.vertices) == 4 and mesh.texture_coordinates is None
    assert mesh.seam_originals is None and mesh.materials.colors.tolist() == [[255, 0, 0]]
    assert report.notes == [
        "texture coordinates left out: 2 vertices have several (seams); --split-seams keeps them"
    ]
    assert (report.split, "options" in mesh.source) == (0, False)
    mesh, report = read("a.obj", textured_obj(SEAMS), split_seams=True)
    assert len(mesh.vertices) == 6 and mesh.seam_originals.tolist() == [0, 2]
    assert mesh.source["options"] == {"split_seams": True}


def test_seams_are_split(read):
    files = {"a.mtl": mtl(), "a.png": image_bytes(IMAGE)}
    normals = "".join("vn 0 0 %d\n" % i for i in (1, 2, 3, 4))
    text = textured_obj(vt=VT + normals, faces="")
    faces = [[(1, 1), (2, 2), (3, 3)], [(1, 2), (3, 4), (4, 4)], [(4, 4), (1, 2), (2, 2)]]
    for face in faces:
        text += "f %s\n" % " ".join("%d/%d/%d" % (v, t, v) for v, t in face)
    mesh, report = read("a.obj", text, files)
    assert np.array_equal(mesh.vertices[:4], SQUARE)
    assert np.array_equal(mesh.vertices[4:], SQUARE[[0, 2]])
    assert mesh.faces.tolist() == [[0, 1, 2], [4, 5, 3], [3, 4, 1]]
    assert mesh.vertex_normals[:, 2].tolist() == [1, 2, 3, 4, 1, 3]
    uv = mesh.texture_coordinates[mesh.faces]
    assert uv.tolist() == [[list(UV[t - 1]) for _, t in face] for face in faces]
    assert report.split == 2 and len(mesh.textures) == 1
    assert report.notes == [
        "textures have seams at 2 vertices: the last 2 vertices are copies of them"
    ]
    assert "options" not in mesh.source and mesh.seam_originals.tolist() == [0, 2]
    other, _ = read("a.obj", text, files, split_seams=False)
    assert mesh.parent_uuid == other.uuid and np.array_equal(mesh.parent_faces, other.faces)
    assert np.array_equal(mesh.parent_vertices, other.vertices)


@pytest.mark.parametrize("seed", range(20))
def test_split_seams_keep_every_corner(read, seed):
    """Whatever the seams: each corner has its position, its coordinates and its normal."""
    rng = np.random.default_rng(seed)
    polygons = [rng.integers(0, 4, rng.integers(3, 6)) for _ in range(6)]
    corners = [[(v, rng.integers(0, 4)) for v in polygon] for polygon in polygons]
    text = textured_obj(faces="").replace("usemtl stone\n", "")
    for face in corners:
        text += "f %s\n" % " ".join("%d/%d" % (v + 1, t + 1) for v, t in face)
    mesh, _ = read("a.obj", text, split_seams=True)
    counts = np.array([len(face) for face in corners])
    flat = np.array([corner for face in corners for corner in face])
    expected = flat[triangulate(counts, flat[:, 0], SQUARE, ImportReport("", "OBJ")).places]
    assert np.array_equal(mesh.vertices[mesh.faces], SQUARE[expected[:, :, 0]])
    uv = np.array(UV, np.float32)[expected[:, :, 1]]
    assert np.array_equal(mesh.texture_coordinates[mesh.faces], uv)
    pairs = {tuple(pair) for pair in expected.reshape(-1, 2).tolist()}
    unused = 4 - len({v for v, _ in pairs})
    assert len(mesh.vertices) == len(pairs) + unused
    assert np.array_equal(mesh.vertices[:4], SQUARE)


def wedge_ply(
    form="binary_little_endian", numbers=(0, 1, -1), lists=None, files=("a.png", "b c.png")
):
    """MeshLab's way: texture coordinates of corners in a list, and the number of the texture."""
    faces = [[0, 1, 2], [0, 2, 3], [0, 1, 3]]
    lists = [[UV[i] for i in face] for face in faces] if lists is None else lists
    head = ["ply", "format %s 1.0" % form, "comment made for a test"]
    head += ["comment TextureFile " + file for file in files]
    head += ["element vertex 4"] + ["property float %s" % axis for axis in "xyz"]
    head += ["element face 3", "property list uchar int vertex_indices"]
    head += ["property list uchar float texcoord", "property int texnumber"]
    head += ["property uchar %s" % color for color in ("red", "green", "blue", "alpha")]
    head += ["end_header", ""]
    body = b""
    order = "<" if "little" in form else ">"
    if form == "ascii":
        for row in SQUARE.tolist():
            body += ("%r %r %r\n" % tuple(row)).encode()
    else:
        body += SQUARE.astype(order + "f4").tobytes()
    for face, uv, number in zip(faces, lists, numbers):
        flat = [value for pair in uv for value in pair]
        if form == "ascii":
            row = [3] + face + [len(flat)] + flat + [number, 7, number + 1, 9, 255]
            body += (" ".join(map(str, row)) + "\n").encode()
        else:
            body += b"\3" + np.array(face, order + "i4").tobytes() + bytes([len(flat)])
            body += np.array(flat, order + "f4").tobytes()
            body += np.array([number], order + "i4").tobytes() + bytes([7, number + 1, 9, 255])
    return "\n".join(head).encode() + body


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_with_coordinates_of_corners(read, form):
    files = {"a.png": image_bytes(IMAGE), "b c.png": image_bytes(pixels(2, bands=4))}
    mesh, report = read("a.ply", wedge_ply(form), files)
    assert mesh.texture_coordinates.tolist() == [list(pair) for pair in UV]
    assert np.array_equal(mesh.textures[0], IMAGE)
    assert np.array_equal(mesh.textures[1], pixels(2, bands=4))
    assert mesh.materials.texture_indices.tolist() == [0, 1, -1]
    assert mesh.materials.face_materials.tolist() == [0, 1, 2]
    assert (mesh.materials.colors == 255).all()
    assert mesh.face_attributes["face_colors"].tolist() == [[7, 1, 9], [7, 2, 9], [7, 0, 9]]
    assert report.notes == ["3 face corners have no texture coordinates"]


def test_ply_seams(read):
    lists = [[UV[0], UV[1], UV[2]], [UV[3], UV[2], UV[3]], [UV[0], UV[2], UV[3]]]
    data = wedge_ply(numbers=(0, 0, 0), lists=lists, files=("a.png",))
    files = {"a.png": image_bytes(IMAGE)}
    mesh, report = read("a.ply", data, files, split_seams=False)
    assert mesh.texture_coordinates is None and mesh.materials is None and not mesh.textures
    assert report.notes == [
        "texture coordinates left out: 2 vertices have several (seams); --split-seams keeps them",
        "left out: 1 textures, for want of coordinates",
    ]
    mesh, report = read("a.ply", data, files)
    assert mesh.seam_originals.tolist() == [0, 1]
    assert mesh.faces.tolist() == [[0, 1, 2], [4, 2, 3], [0, 5, 3]]
    assert mesh.texture_coordinates[mesh.faces].tolist() == [
        [list(p) for p in row] for row in lists
    ]
    assert len(mesh.textures) == 1 and report.split == 2


@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
def test_ply_with_coordinates_of_vertices(read, names):
    columns = xyz(SQUARE) + [(n, "f", np.float32(UV)[:, i]) for i, n in enumerate(names)]
    data = ply(columns, TWO_FACES).replace(b"comment made", b"comment TextureFile a.png\ncomment")
    mesh, report = read("a.ply", data, {"a.png": image_bytes(IMAGE)})
    assert mesh.texture_coordinates.tolist() == [list(pair) for pair in UV]
    assert mesh.materials.face_materials.tolist() == [0, 0] and len(mesh.textures) == 1
    assert not mesh.vertex_costs and report.notes == []


def test_ply_texture_numbers_that_name_no_file(read):
    data = wedge_ply(numbers=(0, 5, 2))
    mesh, report = read("a.ply", data, {"a.png": image_bytes(IMAGE)})
    assert mesh.materials.texture_indices.tolist() == [0, -1, -1]
    assert mesh.materials.face_materials.tolist() == [0, 2, 2]
    assert report.notes == [
        "left out: texture b c.png is not there",
        "the texture of 2 faces was left out: texnumber 5 of face 1, but there are 2 texture files",
    ]


def test_ply_values_of_faces_follow_the_triangles(read):
    after = [("area", "d", [0.5, 1e-300]), ("class", "h", [-7, 9])]
    mesh, report = read("a.ply", ply(xyz(SQUARE), [[0, 1, 2, 3], [0, 1, 2]], after=after))
    assert mesh.face_attributes["area"].tolist() == [0.5, 0.5, 1e-300]
    assert mesh.face_attributes["area"].dtype == np.float64
    assert mesh.face_attributes["class"].tolist() == [-7, -7, 9]
    assert mesh.face_attributes["class"].dtype == np.int16
    assert len(report.notes) == 2 and report.face_attributes == 2


def test_ply_whole_numbers_that_float32_does_not_hold(read):
    columns = xyz(SQUARE) + [("id", "i", [1, 2, 16777217, 4]), ("year", "H", [1, 2, 3, 65535])]
    mesh, report = read("a.ply", ply(columns, TWO_FACES))
    assert mesh.vertex_costs["year"].tolist() == [1, 2, 3, 65535] and len(mesh.vertex_costs) == 1
    assert mesh.vertex_attributes["id"].tolist() == [1, 2, 16777217, 4]
    assert mesh.vertex_attributes["id"].dtype == np.int32 and report.notes == []


def test_a_label_of_other_programs_stays_a_number(read):
    data = ply(xyz(SQUARE), TWO_FACES, after=[("label", "i", [3, 4])])
    mesh, _ = read("a.ply", data)
    assert mesh.face_attributes["label"].tolist() == [3, 4] and not mesh.labels
    mesh, _ = read("a.obj", obj(SQUARE, []) + b"g tree_1\nf 1 2 3\n")
    assert not mesh.labels


def test_dae_with_materials_and_textures(read):
    text = textured_dae()
    mesh, report = read("a.dae", text, {"wall 1.png": image_bytes(IMAGE)})
    order = [np.flatnonzero((SQUARE == v).all(axis=1))[0] for v in mesh.vertices]
    assert mesh.texture_coordinates.tolist() == [list(UV[i]) for i in order]
    assert np.array_equal(mesh.vertices[mesh.faces], SQUARE[TWO_FACES])
    of_faces = mesh.materials.face_materials
    assert mesh.materials.colors[of_faces].tolist() == [[255, 255, 255], [255, 0, 51]]
    assert mesh.materials.texture_indices[of_faces].tolist() == [0, -1]
    assert np.array_equal(mesh.textures[0], IMAGE)
    assert mesh.vertex_normals.tolist() == [[0, 0, 1]] * 4
    assert mesh.vertex_colors[np.argsort(order)].tolist() == [
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [255, 255, 255],
    ]
    assert not any("left out" in note for note in report.notes)


def test_dae_texture_that_is_not_there(read):
    mesh, report = read("a.dae", textured_dae())
    assert not mesh.textures and mesh.materials.texture_indices.tolist() == [-1, -1]
    assert "left out: texture wall 1.png is not there" in report.notes


def test_dae_seams(read):
    files = {"wall 1.png": image_bytes(IMAGE)}
    mesh, report = read("a.dae", textured_dae(seam=True), files)
    plain, _ = read("a.dae", textured_dae(seam=True), files, split_seams=False)
    assert len(mesh.vertices) == 5 and len(mesh.seam_originals) == report.split == 1
    assert mesh.parent_uuid == plain.uuid and not plain.textures and len(mesh.textures) == 1
    assert np.array_equal(mesh.vertices[mesh.faces], SQUARE[TWO_FACES])
    expected = np.array(UV, np.float32)[[[0, 1, 2], [1, 2, 3]]]
    assert np.array_equal(mesh.texture_coordinates[mesh.faces], expected)


def textured_dae(seam=False):
    """Two triangles with a material each; the first has a texture, all have normals and colors.

    seam: vertex 0 has other texture coordinates in the second one.
    """
    text = dae(SQUARE, TWO_FACES)
    sources = ""
    for name, rows, names in (
        ("n", [(0, 0, 1)], "XYZ"),
        ("t", UV, "ST"),
        ("c", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], "RGB"),
    ):
        params = "".join('<param name="%s" type="float"/>' % letter for letter in names)
        sources += (
            '<source id="%s"><float_array id="%sa" count="%d">%s</float_array><technique_common>'
            '<accessor source="#%sa" count="%d" stride="%d">%s</accessor></technique_common>'
            "</source>"
        ) % (
            name,
            name,
            len(rows) * len(names),
            " ".join("%g" % x for row in rows for x in row),
            name,
            len(rows),
            len(names),
            params,
        )
    lists = ""
    for material, face in zip(("wall", "red"), TWO_FACES):
        moved = int(seam and material == "red")
        corners = " ".join("%d 0 %d %d" % (i, i or moved, i) for i in face)
        lists += (
            '<triangles material="%s" count="1"><input semantic="VERTEX" source="#v" offset="0"/>'
            '<input semantic="NORMAL" source="#n" offset="1"/><input semantic="TEXCOORD" '
            'source="#t" offset="2" set="0"/><input semantic="COLOR" source="#c" offset="3"/>'
            "<p>%s</p></triangles>"
        ) % (material, corners)
    start, end = text.index("<polylist"), text.index("</polylist>") + len("</polylist>")
    text = text[:start] + lists + text[end:]
    text = text.replace(' <vertices\nid="v">', sources + '<vertices id="v">')
    bound = "".join(
        '<instance_material symbol="%s" target="#%s"/>' % (m, m) for m in ("wall", "red")
    )
    text = text.replace(
        '<instance_geometry url="#g"/>',
        '<instance_geometry url="#g"><bind_material><technique_common>%s</technique_common>'
        "</bind_material></instance_geometry>" % bound,
    )
    effect = (
        '<effect id="%s_e"><profile_COMMON>%s<technique sid="t"><lambert><diffuse>%s</diffuse>'
        "</lambert></technique></profile_COMMON></effect>"
    )
    surface = (
        '<newparam sid="s"><surface type="2D"><init_from>image</init_from></surface></newparam>'
        '<newparam sid="m"><sampler2D><source>s</source></sampler2D></newparam>'
    )
    library = (
        '<library_images><image id="image"><init_from>wall%201.png</init_from></image>'
        "</library_images><library_effects>"
        + effect % ("wall", surface, '<texture texture="m" texcoord="UV"/>')
        + effect % ("red", "", "<color>1 0 0.2 1</color>")
        + "</library_effects><library_materials>"
        + "".join(
            '<material id="%s"><instance_effect url="#%s_e"/></material>' % (m, m)
            for m in ("wall", "red")
        )
        + "</library_materials>"
    )
    return text.replace("<library_geometries>", library + "<library_geometries>")


@pytest.mark.parametrize(
    "form,bands", [("PNG", 3), ("PNG", 4), ("BMP", 3), ("TGA", 4), ("TIFF", 3), ("TGA", 3)]
)
def test_image_formats(read, form, bands):
    image = pixels(5, 7, 4, bands)
    name = "a." + form.lower()
    files = {"a.mtl": mtl(name), name: image_bytes(image, form)}
    mesh, report = read("a.obj", textured_obj(), files)
    assert np.array_equal(mesh.textures[0], image) and report.notes == []


def test_a_file_that_is_a_link_into_the_folder(read, tmp_path):
    (tmp_path / "real.png").write_bytes(image_bytes(IMAGE))
    os.symlink("real.png", tmp_path / "a.png")
    mesh, _ = read("a.obj", textured_obj(), {"a.mtl": mtl()})
    assert np.array_equal(mesh.textures[0], IMAGE)


CORNER = st.tuples(st.integers(1, 4), st.none() | st.integers(1, 4), st.none() | st.integers(1, 2))


def written(corner, back):
    """v, v/t, v//n or v/t/n; back: counted from the end."""
    vertex, texture, normal = (
        None if n is None else n - (count + 1) * back for n, count in zip(corner, (4, 4, 2))
    )
    text = str(vertex)
    if texture is not None or normal is not None:
        text += "/" + ("" if texture is None else str(texture))
    return text if normal is None else text + "/" + str(normal)


@settings(max_examples=200)
@given(
    faces=st.lists(st.lists(CORNER, min_size=3, max_size=4), min_size=1, max_size=4),
    back=st.booleans(),
    same=st.booleans(),
)
def test_corners_of_every_form(tmp_path, faces, back, same):
    """Any mixture of the four forms of corners, against a reader of one corner at a time."""
    if same:  # all corners of the first one's form, as most files have it
        form = [n is None for n in faces[0][0]]
        faces = [
            [tuple(None if f else n or 1 for f, n in zip(form, corner)) for corner in face]
            for face in faces
        ]
    text = obj(SQUARE, []).decode() + VT + "vn 0 0 1\nvn 0 1 0\n"
    text += "".join("f %s\n" % " ".join(written(c, back) for c in face) for face in faces)
    (tmp_path / "a.obj").write_text(text)
    mesh, report = read_mesh(tmp_path / "a.obj", split_seams=True)
    corners = [face[i] for face in faces for k in range(1, len(face) - 1) for i in (0, k, k + 1)]
    places = mesh.vertices[mesh.faces.reshape(-1)]
    assert np.array_equal(places, SQUARE[[vertex - 1 for vertex, _, _ in corners]])
    known = np.array([texture is not None for _, texture, _ in corners])
    uv = np.array([UV[(texture or 1) - 1] for _, texture, _ in corners])
    if mesh.texture_coordinates is None:
        assert not uv[known].any()
    else:
        found = mesh.texture_coordinates[mesh.faces.reshape(-1)]
        assert np.array_equal(found[known], uv[known])
    normals = {}
    for vertex, _, normal in corners:
        normals.setdefault(vertex, set()).add(normal)
    one = all(len(found) == 1 for found in normals.values())
    if any(normal is None for _, _, normal in corners) or not one:
        assert mesh.vertex_normals is None
    else:
        expected = [[0, 0, 1] if normal == 1 else [0, 1, 0] for _, _, normal in corners]
        assert mesh.vertex_normals[mesh.faces.reshape(-1)].tolist() == expected


def test_words_that_are_no_numbers_are_counted_through_the_blocks(read, monkeypatch):
    monkeypatch.setattr(obj_lines, "_BLOCK_BYTES", 20)
    text = obj(SQUARE, TWO_FACES).decode()
    with pytest.raises(MapFileError, match="vertices: value 7 is no number: '2,0'"):
        read("a.obj", text.replace("1.0 2.0", "1.0 2,0"))
    with pytest.raises(MapFileError, match="face 1 has a corner that is none: 'x/1'"):
        read("a.obj", text.replace("f 1 3 4", "f 1 x/1 4"))
