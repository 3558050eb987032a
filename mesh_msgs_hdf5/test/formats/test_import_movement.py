"""Meshes that are turned, scaled and moved while they are imported."""
import numpy as np
import pytest
from mesh_writers import Gltf, dae, obj, ply, stl, xyz

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Features, Mesh

# a corner with no symmetry: the right-handed order of its edges from the first vertex is outside
POINTS = np.float32([[1, 2, 3], [2, 2, 3], [1, 4, 3], [1, 2, 7]])
FACES = np.uint32([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
TURN = np.array([[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1.0]])
MIRROR = np.diag([-1.0, 1, 1, 1])
SHEAR = np.array([[2, 1, 0, 0], [0, 3, 0, 0], [0, 0.5, 1, 0], [0, 0, 0, 1.0]])


def text_of(matrix):
    return ",".join(repr(float(value)) for value in matrix.ravel())


def normals_of(vertices, faces):
    a, b, c = vertices.astype(float)[faces].transpose(1, 0, 2)
    found = np.cross(b - a, c - a)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def outward(mesh):
    """Whether all faces look away from the middle."""
    middle = mesh.vertices.mean(0)
    away = mesh.vertices[mesh.faces].mean(1) - middle
    return ((normals_of(mesh.vertices, mesh.faces) * away).sum(1) > 0).all()


WRITERS = {
    "a.ply": lambda: ply(xyz(POINTS), FACES),
    "a.obj": lambda: obj(POINTS, FACES),
    "a.stl": lambda: stl(POINTS, FACES),
    "a.off": lambda: (
        "OFF\n4 4 0\n"
        + "".join("%g %g %g\n" % tuple(row) for row in POINTS)
        + "".join("3 %d %d %d\n" % tuple(row) for row in FACES)
    ).encode(),
    "a.dae": lambda: dae(POINTS, FACES).encode(),
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("matrix", [TURN, MIRROR, SHEAR, TURN @ MIRROR])
def test_every_format_is_moved(tmp_path, name, matrix):
    (tmp_path / name).write_bytes(WRITERS[name]())
    assert outward(Mesh(POINTS, FACES))
    plain, _ = read_mesh(tmp_path / name)
    mesh, report = read_mesh(tmp_path / name, transform=matrix)
    expected = plain.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    assert np.allclose(mesh.vertices, expected, rtol=0, atol=1e-5) and outward(mesh)
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    assert any("mirrors: faces were turned over" in note for note in report.notes) == mirrored
    assert mesh.source["options"]["transform"] == tuple(matrix.ravel())


def test_normals_follow_also_where_it_is_no_rotation(tmp_path):
    """Those of a plane stay across it (the inverse transposed does that, the matrix does not)."""
    normals = np.tile(normals_of(POINTS, FACES)[3], (4, 1))
    columns = xyz(POINTS) + [("n" + axis, "f", normals[:, i]) for i, axis in enumerate("xyz")]
    (tmp_path / "a.ply").write_bytes(ply(columns, FACES))
    for matrix in (SHEAR, MIRROR @ SHEAR, TURN):
        mesh, _ = read_mesh(tmp_path / "a.ply", transform=matrix)
        across = normals_of(mesh.vertices, mesh.faces)[3]
        assert np.allclose(mesh.vertex_normals, across, rtol=0, atol=1e-6)


def test_y_up_and_scale_come_before_the_transform(tmp_path):
    (tmp_path / "a.obj").write_bytes(obj(POINTS, FACES))
    mesh, _ = read_mesh(tmp_path / "a.obj", up="y")
    assert np.array_equal(mesh.vertices, np.stack([POINTS[:, 0], -POINTS[:, 2], POINTS[:, 1]], 1))
    mesh, _ = read_mesh(tmp_path / "a.obj", up="y", scale=0.001, transform=TURN)
    expected = np.stack([POINTS[:, 2] + 1e4, POINTS[:, 0] + 2e4, POINTS[:, 1] + 3e4], 1) / 1000
    assert np.allclose(mesh.vertices, expected, rtol=0, atol=1e-5) and outward(mesh)
    assert mesh.source["options"] == {"up": "y", "scale": 0.001, "transform": tuple(TURN.ravel())}


def test_what_formats_say_of_their_axes_is_applied_once(tmp_path):
    (tmp_path / "z.dae").write_text(dae(POINTS, FACES, "Z_UP", "0.01"))
    (tmp_path / "y.dae").write_text(dae(POINTS, FACES, "Y_UP"))
    document = Gltf()
    document.mesh(POINTS, FACES)
    (tmp_path / "y.glb").write_bytes(document.data())
    for name, up in (("z.dae", "z"), ("y.dae", "y"), ("y.glb", "y")):
        plain, said = read_mesh(tmp_path / name)[0], read_mesh(tmp_path / name, up=up)[0]
        assert np.array_equal(plain.vertices, said.vertices), name
        with pytest.raises(MapFileError, match="says that %s is up" % up):
            read_mesh(tmp_path / name, up="zy"[up == "z"])
    assert np.allclose(
        np.ptp(read_mesh(tmp_path / "z.dae")[0].vertices, axis=0), [0.01, 0.02, 0.04]
    )


def test_coordinates_of_a_country_keep_their_digits(tmp_path):
    """The transform is applied in float64, before the origin is chosen."""
    far = POINTS.astype(float) + [4e5 + 0.0625, 5.8e6 + 0.03125, 0]
    (tmp_path / "a.ply").write_bytes(ply(xyz(far, "d"), FACES))
    mesh, _ = read_mesh(tmp_path / "a.ply", origin="auto", transform=TURN)
    exact = far @ TURN[:3, :3].T + TURN[:3, 3]
    assert any(mesh.origin) and np.allclose(mesh.vertices + np.array(mesh.origin), exact, 0, 1e-6)


def test_a_map_is_moved_with_its_origin_and_features(tmp_path):
    mesh = Mesh(POINTS, FACES, origin=(100.0, 0.0, 5.0), layer_parameters={"a": {"radius": 1.0}})
    mesh.vertex_costs = {"a": np.ones(4, np.float32)}
    mesh.features = Features(POINTS[:2].copy(), np.ones((2, 3), np.float32))
    MapFile.write(tmp_path / "a.h5", mesh)
    moved, _ = read_mesh(tmp_path / "a.h5", transform=TURN)
    exact = (POINTS + np.array(mesh.origin)) @ TURN[:3, :3].T + TURN[:3, 3]
    assert np.allclose(moved.vertices + np.array(moved.origin), exact, rtol=0, atol=1e-4)
    places = moved.features.locations + np.array(moved.origin)
    assert np.allclose(places, exact[:2], rtol=0, atol=1e-4)
    assert list(moved.vertex_costs) == ["a"] and set(moved.layer_parameters["a"]) == {"carried_by"}


def test_a_file_of_ours_with_an_origin(tmp_path):
    mesh = Mesh(POINTS, FACES, origin=(4e5, 5e6, 0.0))
    write_mesh(tmp_path / "a.ply", mesh)
    moved, _ = read_mesh(tmp_path / "a.ply", transform=TURN)
    exact = (POINTS + np.array(mesh.origin)) @ TURN[:3, :3].T + TURN[:3, 3]
    assert np.allclose(moved.vertices + np.array(moved.origin), exact, rtol=0, atol=1e-5)


def test_as_options_of_the_command(tmp_path, capsys):
    (tmp_path / "a.obj").write_bytes(obj(POINTS, FACES))
    rows = "\n".join(" ".join(map(repr, row)) for row in MIRROR.tolist())
    (tmp_path / "matrix.txt").write_text(rows)
    words = ["import", str(tmp_path / "a.obj"), str(tmp_path / "a.h5"), "--force", "--transform"]
    for matrix in (text_of(MIRROR), str(tmp_path / "matrix.txt")):
        assert main([*words, matrix, "--scale", "2"]) == 0
        assert "faces were turned over" in capsys.readouterr().out
        assert np.allclose(MapFile(tmp_path / "a.h5").vertices, POINTS * [-2, 2, 2])
    assert main([*words, text_of(TURN.T)]) == 1
    assert "column by column (transpose it" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words,text",
    [
        (["--scale", "0"], "scale"),
        (["--scale", "mm"], "scale"),
        (["--up", "x"], "--up"),
        (["--transform", "1,2,3"], "No such file"),
        (["--transform", "1 2"], "No such file"),
    ],
)
def test_wrong_options_are_wrong_usage(capsys, words, text):
    with pytest.raises(SystemExit) as ended:
        main(["import", "a.obj", "a.h5", *words])
    err = capsys.readouterr().err
    assert ended.value.code == 2 and text in err and err.count("\n") == 1


@pytest.mark.parametrize(
    "options,text",
    [
        ({"scale": -1}, "scale -1"),
        ({"up": "w"}, "up is 'w'"),
        ({"transform": [1, 2]}, "2 numbers, not 16"),
        ({"transform": np.diag([1, 1, 0, 1.0])}, "flat"),
        ({"transform": np.diag([1, 1, np.nan, 1])}, "finite"),
        ({"transform": np.ones((4, 4))}, "last row"),
    ],
)
def test_wrong_values_are_refused(tmp_path, options, text):
    (tmp_path / "a.obj").write_bytes(obj(POINTS, FACES))
    with pytest.raises(MapFileError, match=text):
        read_mesh(tmp_path / "a.obj", **options)
