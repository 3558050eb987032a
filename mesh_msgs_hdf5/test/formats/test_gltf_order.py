"""glTF of ours that another program has reordered: nothing lands on another triangle."""
import json

import numpy as np
import pytest

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.formats.importer import read_mesh


def edited(folder, mesh, change):
    """The mesh as glTF after a change of its JSON."""
    write_mesh(folder / "a.gltf", mesh)
    document = json.loads((folder / "a.gltf").read_text())
    change(document)
    (folder / "a.gltf").write_text(json.dumps(document))
    return read_mesh(folder / "a.gltf")


def primitives(document):
    return document["meshes"][0]["primitives"]


def swap(document):
    primitives(document).reverse()


def drop(document):
    del primitives(document)[0]


@pytest.mark.parametrize("change", [swap, drop])
def test_what_faces_have_is_left_out_where_they_are_others(tmp_path, rich_mesh, change):
    found, report = edited(tmp_path, rich_mesh, change)
    assert not found.labels and not found.face_attributes
    (note,) = [note for note in report.notes if "another program" in note]
    assert "its faces: the order" in note
    assert note.endswith(
        "left out: 9 labels, 4 face attributes, which belong to them by their number"
    )
    # what vertices have is as it was, and each triangle has its material
    assert identical(found.vertices, rich_mesh.vertices)
    for name, values in rich_mesh.vertex_attributes.items():
        assert identical(found.vertex_attributes[name], values), name
    of_faces = {}
    for face, number in zip(rich_mesh.faces.tolist(), rich_mesh.materials.face_materials.tolist()):
        of_faces.setdefault(tuple(face), set()).add(number)
    numbers = found.materials.face_materials.tolist()
    assert all(n in of_faces[tuple(f)] for f, n in zip(found.faces.tolist(), numbers))
    assert len(found.faces) == len(rich_mesh.faces) or change is drop


def test_what_vertices_have_by_number_is_left_out_where_they_are_others(tmp_path, rich_mesh):
    def swap_vertices(document):
        """As programs do that sort vertices: two change places, in the faces, too."""
        data = bytearray((tmp_path / "a.bin").read_bytes())

        def of(accessor):
            view = document["bufferViews"][document["accessors"][accessor]["bufferView"]]
            return view["byteOffset"], document["accessors"][accessor]["count"]

        for primitive in primitives(document):
            start, count = of(primitive["indices"])
            index = np.frombuffer(data, "<u4", count, start).copy()
            index = np.select([index == 3, index == 7], [7, 3], index).astype("<u4")
            data[start : start + 4 * count] = index.tobytes()
        start, count = of(primitive["attributes"]["POSITION"])
        places = np.frombuffer(data, "<f4", 3 * count, start).reshape(-1, 3).copy()
        places[[3, 7]] = places[[7, 3]]
        data[start : start + 12 * count] = places.tobytes()
        (tmp_path / "a.bin").write_bytes(data)

    whole, _ = edited(tmp_path, rich_mesh, lambda document: None)
    for name in ("a.gltf", "a.bin"):
        (tmp_path / name).unlink()
    found, report = edited(tmp_path, rich_mesh, swap_vertices)
    assert sorted(whole.vertex_attributes) == sorted(rich_mesh.vertex_attributes)
    lost = set(whole.vertex_attributes) - set(found.vertex_attributes)
    assert lost and not found.labels and not found.face_attributes
    (note,) = [note for note in report.notes if "another program" in note]
    assert "faces or vertices" in note and "%d vertex attributes" % len(lost) in note


def test_a_scaled_scene_keeps_everything(tmp_path, rich_mesh):
    """Vertices and faces are where they were in the lists."""
    found, report = edited(tmp_path, rich_mesh, lambda d: d["nodes"][0].update(scale=[2, 2, 2]))
    assert not any("another program" in note for note in report.notes)
    assert np.allclose(found.vertices, 2 * rich_mesh.vertices)
    assert identical(found.faces, rich_mesh.faces) and sorted(found.labels) == sorted(
        rich_mesh.labels
    )


def test_files_of_before_have_no_checksums(tmp_path, rich_mesh):
    def forget(document):
        extras = document["asset"]["extras"]
        extras["mesh_tools"] = [r for r in extras["mesh_tools"] if "checksums" not in r]

    found, _ = edited(tmp_path, rich_mesh, forget)
    assert sorted(found.labels) == sorted(rich_mesh.labels)
    assert sorted(found.face_attributes) == sorted(rich_mesh.face_attributes)
