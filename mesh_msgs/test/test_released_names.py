"""Names of earlier releases that programs import and include."""
import subprocess

import mesh_msgs.msg
from mesh_msgs.msg import MeshGeometry, MeshTriangleIndices, TriangleIndices


def test_triangle_indices_is_the_message_of_today():
    assert TriangleIndices is MeshTriangleIndices
    assert mesh_msgs.msg.TriangleIndices is TriangleIndices
    mesh = MeshGeometry(faces=[TriangleIndices([0, 1, 2])])
    assert mesh.faces == [MeshTriangleIndices([0, 1, 2])]


def test_triangle_indices_in_cpp(tmp_path):
    """Faces of the old name go into the mesh of today, which only the same type can."""
    source = tmp_path / "old.cpp"
    source.write_text(
        "#include <mesh_msgs/MeshGeometry.h>\n#include <mesh_msgs/TriangleIndices.h>\n"
        "void add(mesh_msgs::MeshGeometry& mesh, const mesh_msgs::TriangleIndices& face)\n"
        "{ mesh.faces.push_back(face); }\n"
        "mesh_msgs::TriangleIndicesPtr made() { return mesh_msgs::TriangleIndicesPtr(); }\n"
        "mesh_msgs::TriangleIndices_<std::allocator<void>> other;\n"
    )
    found = subprocess.run(
        ["pkg-config", "--cflags-only-I", "mesh_msgs"],
        stdout=subprocess.PIPE,
        universal_newlines=True,
        check=True,
    ).stdout.split()
    subprocess.run(["g++", "-std=c++14", "-fsyntax-only", *found, str(source)], check=True)
