"""The UUID of a geometry depends on its content alone."""

import hashlib
import struct
import subprocess
import sys
import uuid

import numpy as np
import pytest

from mesh_msgs.identity import GEOMETRY_NAMESPACE, geometry_uuid

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.25, -2]], dtype=np.float32)
FACES = np.array([[0, 1, 2], [0, 1, 3]], dtype=np.uint32)
# Changing the hash would orphan every attribute in the field: this value must never change.
KNOWN = "1aa85e4b-f570-55fa-94c8-136ce2dfcbdc"
KNOWN_EMPTY = "249684e9-c544-5856-813a-db7cccec6fa1"


def test_known_values():
    assert geometry_uuid(VERTICES, FACES) == KNOWN
    assert geometry_uuid(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint32)) == KNOWN_EMPTY
    assert geometry_uuid([], []) == KNOWN_EMPTY


def test_is_the_documented_hash():
    data = struct.pack("<QQ", 4, 2)
    data += b"".join(struct.pack("<3f", *row) for row in VERTICES.tolist())
    data += b"".join(struct.pack("<3I", *row) for row in FACES.tolist())
    name = hashlib.blake2b(data, digest_size=16).hexdigest()
    result = uuid.UUID(geometry_uuid(VERTICES, FACES))
    assert result == uuid.uuid5(GEOMETRY_NAMESPACE, name)
    assert result.version == 5


@pytest.mark.parametrize("vertex_type", ["<f4", ">f4", "<f8", ">f8", "g", "O"])
@pytest.mark.parametrize("face_type", ["<u4", ">u4", "<i4", "<i8", ">u8", "u1", "i2", "f8", "O"])
def test_same_from_any_type(vertex_type, face_type):
    vertices = VERTICES.astype(vertex_type)
    faces = FACES.astype(face_type)
    if "O" in (vertex_type, face_type):
        with pytest.raises(ValueError, match="not object"):
            geometry_uuid(vertices, faces)
    else:
        assert geometry_uuid(vertices, faces) == KNOWN


def test_same_from_half_and_whole_numbers():
    vertices = np.array([[0, 1, 2], [3, 4, 5], [-6, 7, 8]])
    expected = geometry_uuid(vertices.astype(np.float32), [[0, 1, 2]])
    for kind in (np.int8, np.int64, np.float16, np.float64):
        assert geometry_uuid(vertices.astype(kind), [[0, 1, 2]]) == expected


def test_same_from_any_memory_order():
    wide = np.zeros((8, 6), dtype=np.float32)
    wide[::2, ::2] = VERTICES
    backwards = FACES[::-1].copy()[::-1]
    frozen = VERTICES.copy()
    frozen.flags.writeable = False
    for vertices in (wide[::2, ::2], np.asfortranarray(VERTICES), frozen, VERTICES.tolist()):
        for faces in (backwards, np.asfortranarray(FACES), FACES.tolist()):
            assert geometry_uuid(vertices, faces) == KNOWN


def test_any_change_shows():
    found = {geometry_uuid(VERTICES, FACES)}
    for index in np.ndindex(VERTICES.shape):
        changed = VERTICES.copy()
        changed[index] = np.nextafter(changed[index], np.float32(9))
        found.add(geometry_uuid(changed, FACES))
    for index in np.ndindex(FACES.shape):
        changed = FACES.copy()
        changed[index] += 1
        found.add(geometry_uuid(VERTICES, changed))
    found.add(geometry_uuid(VERTICES[::-1], FACES))
    found.add(geometry_uuid(VERTICES, FACES[::-1]))
    found.add(geometry_uuid(VERTICES, FACES[:, [1, 2, 0]]))
    assert len(found) == 1 + 12 + 6 + 3


def test_bytes_moved_between_vertices_and_faces_show():
    vertices = np.zeros((4, 3), dtype=np.float32)
    faces = np.zeros((4, 3), dtype=np.uint32)
    splits = {geometry_uuid(vertices[:n], faces[: 4 - n]) for n in range(5)}
    assert len(splits) == 5


def test_same_in_another_process():
    code = "from mesh_msgs.identity import geometry_uuid; import numpy as np; "
    code += f"print(geometry_uuid(np.array({VERTICES.tolist()}), np.array({FACES.tolist()})))"
    result = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, check=True, universal_newlines=True
    )
    assert result.stdout.strip() == KNOWN


def test_not_a_number_is_content_too():
    vertices = VERTICES.copy()
    vertices[2, 1] = np.nan
    vertices[3, 0] = np.inf
    assert geometry_uuid(vertices, FACES) == geometry_uuid(vertices.astype(np.float64), FACES)
    assert geometry_uuid(vertices, FACES) != KNOWN


@pytest.mark.parametrize(
    "vertices, faces, message",
    [
        (np.zeros((4, 2)), FACES, r"^vertices have to have the shape \(N, 3\), not \(4, 2\)$"),
        (np.zeros(12), FACES, r"^vertices have to have the shape \(N, 3\), not \(12,\)"),
        (
            VERTICES,
            np.zeros((2, 4), dtype=np.uint32),
            r"^faces have to have the shape .* not \(2, 4\)",
        ),
        (
            VERTICES,
            np.zeros((0, 4), dtype=np.uint32),
            r"^faces have to have the shape .* not \(0, 4\)",
        ),
        (VERTICES * 1j, FACES, "^vertices have to be numbers, not complex"),
        (VERTICES, FACES == 1, "^faces have to be whole numbers, not bool"),
        (VERTICES.astype(float) * [[1], [1], [1e60], [1e60]], FACES, r"^vertex 2 .* \(2 such"),
        (VERTICES, [[0, 1, 2], [0, 1, -1]], r"^face 1 refers to vertex -1, .* \(1 such in all"),
        (
            VERTICES,
            [[0, 2**32, 2]],
            "^face 0 refers to vertex 4294967296, which no mesh can have",
        ),
        (VERTICES, [[0, 1.5, 2]], "^face 0 refers to vertex 1.5, which no mesh can have"),
        (VERTICES, [[0, float("nan"), 2]], "^face 0 refers to vertex nan, which no mesh can have"),
    ],
)
def test_refuses_what_has_no_identity(vertices, faces, message):
    with pytest.raises(ValueError, match=message) as caught:
        geometry_uuid(vertices, faces)
    assert "\n" not in str(caught.value)
