"""Point clouds and poses of others: PLY, PCD, KITTI, TUM."""
import struct

import h5py
import numpy as np
import pytest

from mesh_msgs_hdf5.formats.clouds import cloud as cloud_module
from mesh_msgs_hdf5.formats.clouds.poses import ScanPose, pose_lines, quaternion_of, read_poses
from mesh_msgs_hdf5.map_file.scans import read_cloud
from mesh_msgs_hdf5.model.errors import MapFileError

RNG = np.random.default_rng(5)
FIELDS = [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<f4"), ("ring", "<u2")]
FIELDS += [("t", "<f8"), ("normal_x", "<f4"), ("id", "<i4"), ("echo", "i1")]


def points(count=50, fields=tuple(FIELDS)):
    table = np.zeros(count, list(fields))
    raw = RNG.integers(0, 256, table.nbytes).astype(np.uint8)
    table = raw.view(table.dtype).copy()  # any bits: colors that are a float, NaN with a payload
    for axis in "xyz":
        table[axis] = RNG.normal(size=count)
    return table


def pcd_head(table, form, count=None):
    kinds = [table.dtype[name] for name in table.dtype.names]
    rows = [
        ("VERSION", ["0.7"]),
        ("FIELDS", table.dtype.names),
        ("SIZE", [str(kind.base.itemsize) for kind in kinds]),
        ("TYPE", [kind.base.kind.upper() for kind in kinds]),
        ("COUNT", [str(int(np.prod(kind.shape, dtype=int))) for kind in kinds]),
        ("WIDTH", [str(len(table) if count is None else count)]),
        ("HEIGHT", ["1"]),
        ("POINTS", [str(len(table) if count is None else count)]),
        ("DATA", [form]),
    ]
    lines = ["# .PCD v0.7"] + [" ".join([key, *words]) for key, words in rows]
    return ("\n".join(lines) + "\n").encode()


def lzf(data):
    """Packed by h5py's filter."""
    with h5py.File("x", "w", driver="core", backing_store=False) as file:
        file.create_dataset("x", data=data, chunks=data.shape, compression="lzf")
        skipped, packed = file["x"].id.read_direct_chunk((0,))
        assert not skipped
        return packed


def compressed(table):
    data = b"".join(table[name].tobytes() for name in table.dtype.names)
    packed = lzf(np.frombuffer(data, np.uint8))
    return (
        pcd_head(table, "binary_compressed") + struct.pack("<II", len(packed), len(data)) + packed
    )


def text(table):
    return "".join(
        " ".join(repr(v) for name in table.dtype.names for v in np.ravel(row[name]).tolist()) + "\n"
        for row in table
    ).encode()


def ply(table, form):
    names = {"f4": "float", "f8": "double", "u2": "ushort", "i4": "int32", "i1": "char"}
    lines = ["ply", "format %s 1.0" % form, "comment x", "element vertex %d" % len(table)]
    lines += ["property %s %s" % (names[table.dtype[n].str[1:]], n) for n in table.dtype.names]
    lines += ["element face 0", "property list uchar int vertex_indices", "end_header"]
    order = ">" if "big" in form else "<"
    data = (
        text(table) if form == "ascii" else table.astype(table.dtype.newbyteorder(order)).tobytes()
    )
    return ("\n".join(lines) + "\n").encode() + data


def smooth(count):
    """What LZF makes smaller, and text does not change."""
    table = np.zeros(count, FIELDS)
    for name in table.dtype.names:
        table[name] = np.arange(count) % 100
    return table


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(cloud_module, "BLOCK_ROWS", 16)


@pytest.mark.parametrize(
    "make,table",
    [
        (lambda t: pcd_head(t, "binary") + t.tobytes(), points()),
        (lambda t: pcd_head(t, "ascii") + text(t), smooth(50)),
        (compressed, smooth(5000)),
        (lambda t: ply(t, "binary_little_endian"), points()),
        (lambda t: ply(t, "binary_big_endian"), points()),
        (lambda t: ply(t, "ascii"), smooth(50)),
        (lambda t: pcd_head(t, "binary") + t.tobytes(), points(0)),
        (lambda t: ply(t, "ascii"), points(0)),
    ],
    ids=["pcd", "pcd text", "pcd lzf", "ply", "ply big", "ply text", "no points", "no text"],
)
def test_every_form_is_read_to_the_bit(tmp_path, make, table):
    path = tmp_path / "a.cloud"
    path.write_bytes(make(table))
    cloud = read_cloud(path)
    assert cloud.count == len(table) and cloud.dtype.names == table.dtype.names
    blocks = list(cloud.blocks())
    assert len(table) == 0 or len(table) > 1000 or len(blocks) > 3
    for name in table.dtype.names:
        found = [block[name].astype(table.dtype[name]).tobytes() for block in blocks]
        assert b"".join(found) == table[name].tobytes(), name
    assert cloud.channels()["points"] == ("x", "y", "z")


def test_fields_of_several_numbers_and_padding_of_pcd(tmp_path):
    fields = [("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("pad", "u1", (4,)), ("fpfh", "<f4", (33,))]
    table = points(40, fields)
    head = pcd_head(table, "binary").replace(b"pad", b"_")
    (tmp_path / "a.pcd").write_bytes(head + table.tobytes())
    cloud = read_cloud(tmp_path / "a.pcd")
    assert cloud.dtype.names == ("x", "y", "z", "fpfh") and len(cloud.channels()) == 2
    found = np.concatenate([block["fpfh"] for block in cloud.blocks()])
    assert found.tobytes() == table["fpfh"].tobytes()


GOOD = points(20)
PCD, PLY = pcd_head(GOOD, "binary") + GOOD.tobytes(), ply(GOOD, "binary_little_endian")


@pytest.mark.parametrize(
    "data,code",
    [
        (PCD[:-1], "format"),
        (PLY[:-1], "damaged"),
        (pcd_head(GOOD, "ascii") + b"1 2 3\n", "damaged"),
        (pcd_head(smooth(3), "ascii") + text(smooth(2)), "damaged"),
        (pcd_head(smooth(1), "ascii") + text(smooth(1)).replace(b"0 ", b"zero ", 1), "damaged"),
        (pcd_head(smooth(9), "binary_compressed") + b"\0" * 8, "format"),
        (compressed(smooth(5000))[:-40] + b"\x1f" * 40, "damaged"),
        (compressed(smooth(5000))[:-40] + b"\0" * 40, "damaged"),
        (pcd_head(GOOD, "zip") + GOOD.tobytes(), "format"),
        (pcd_head(GOOD, "binary", 1 << 50), "format"),
        (PCD.replace(b"SIZE 4", b"SIZE 3"), "format"),
        (PCD.replace(b"FIELDS x y", b"FIELDS x x"), "format"),
        (PCD.replace(b"DATA binary", b"DUTU binary"), "format"),
        (PCD.replace(b" y ", b" w "), "format"),
        (PLY.replace(b"float y", b"float w"), "format"),
        (PLY.replace(b"element vertex", b"element points"), "format"),
        (PLY.replace(b"property float x", b"property list uchar int x"), "format"),
        (PLY.replace(b"end_header", b"end_hunter"), "format"),
        (b"x y z\n1 2 3\n", "format"),
        (b"", "empty"),
    ],
)
def test_what_is_no_cloud_is_one_clear_error(tmp_path, data, code):
    (tmp_path / "a.pcd").write_bytes(data)
    with pytest.raises(MapFileError) as refused:
        cloud = read_cloud(tmp_path / "a.pcd")
        cloud.channels()
        list(cloud.blocks())
    assert refused.value.code == code and "\n" not in str(refused.value)


def rotation():
    matrix = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
    return matrix * np.sign(np.linalg.det(matrix))


@pytest.mark.parametrize("form", ["kitti", "tum"])
def test_poses_come_back(tmp_path, form):
    poses = []
    for time in (1.5, 1600000000.123456):
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation(), RNG.normal(size=3) * 100
        poses.append(ScanPose(matrix, time if form == "tum" else None))
    (tmp_path / "p.txt").write_text("# x\n\n" + pose_lines(poses, form))
    found = read_poses(tmp_path / "p.txt")
    assert [pose.time for pose in found] == [pose.time for pose in poses]
    for one, other in zip(found, poses):
        if form == "kitti":
            assert np.array_equal(one.matrix, other.matrix)
        assert np.allclose(one.matrix, other.matrix, atol=1e-12, rtol=0)


def test_a_quarter_around_z_is_that_in_tum(tmp_path):
    half = np.sqrt(0.5)
    (tmp_path / "p.txt").write_text("7.5 1 2 3 0 0 %r %r\n" % (half, half))
    (pose,) = read_poses(tmp_path / "p.txt")
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    assert np.allclose(pose.matrix, expected) and pose.time == 7.5
    assert np.allclose(quaternion_of(pose.matrix[:3, :3]), [0, 0, half, half])
    assert np.allclose(np.abs(quaternion_of(np.diag([-1.0, -1.0, 1.0]))), [0, 0, 1, 0])


@pytest.mark.parametrize(
    "line,words",
    [
        ("1 2 3", "line 2 has not 12 numbers"),
        ("1 2 3 4 5 6 7 x", "line 2 has not 12 numbers"),
        ("0 1 2 3 0 0 0 2", "quaternion of length 2"),
        ("2 0 0 5 0 1 0 6 0 0 1 7", "no rotation and translation"),
        ("-1 0 0 5 0 1 0 6 0 0 1 7", "no rotation and translation"),
        ("1 0 0 nan 0 1 0 6 0 0 1 7", "line 2 has not 12 numbers"),
    ],
)
def test_bad_poses(tmp_path, line, words):
    (tmp_path / "p.txt").write_text("1 0 0 5 0 1 0 6 0 0 1 7\n%s\n" % line)
    with pytest.raises(MapFileError, match=words):
        read_poses(tmp_path / "p.txt")
