#!/usr/bin/python3
"""Every topic and service of hdf5_map_server for clients with the generated classes."""
import os
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
import rospy
import rostest
from mesh_msgs import msg, srv
from server_process import Server, received

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from crashers import write_crasher  # noqa: E402
from server_samples import LAYERS, everything  # noqa: E402

MAP, OTHER = everything(1), everything(2, vertices=7, faces=6)


def xyz(points):
    return np.array([[p.x, p.y, p.z] for p in points]).reshape(-1, 3)


def triples(faces):
    return np.array([face.vertex_indices for face in faces]).reshape(-1, 3)


class ServeEverything(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.paths = [os.path.join(cls.folder.name, name) for name in ("a.h5", "b.h5")]
        for path, mesh in zip(cls.paths, (MAP, OTHER)):
            MapFile.write(path, mesh)
        cls.one = Server("/all/one", "_inputFile:=" + cls.paths[0], executable="mesh_msgs_hdf5")
        broken = os.path.join(cls.folder.name, "broken.h5")
        with open(cls.paths[0], "rb") as whole, open(broken, "wb") as stream:
            stream.write(whole.read()[:3000])
        crasher = Path(cls.folder.name, "crasher.h5")
        write_crasher(crasher, MAP, "crash")
        copy = shutil.copy(cls.paths[0], os.path.join(cls.folder.name, "copy.h5"))
        files = [cls.paths[0], broken, str(crasher), cls.paths[1], copy]
        cls.two = Server("/all/two", inputFile=files)

    @classmethod
    def tearDownClass(cls):
        cls.one.stop()
        cls.two.stop()
        cls.folder.cleanup()

    def headed(self, message, mesh=MAP):
        self.assertEqual((message.uuid, message.header.frame_id), (mesh.uuid, "floor"))
        self.assertGreater(message.header.stamp.to_sec(), 0)

    def check_geometry(self, message, parts=("vertices", "normals", "faces"), mesh=MAP):
        self.headed(message, mesh)
        for name, found, expected in (
            ("vertices", xyz(message.mesh_geometry.vertices), mesh.vertices),
            ("normals", xyz(message.mesh_geometry.vertex_normals), mesh.vertex_normals),
            ("faces", triples(message.mesh_geometry.faces), mesh.faces),
        ):
            np.testing.assert_array_equal(found, expected if name in parts else np.zeros((0, 3)))

    def check_colors(self, message, mesh=MAP):
        self.headed(message, mesh)
        found = [(c.r, c.g, c.b, c.a) for c in message.mesh_vertex_colors.vertex_colors]
        expected = np.ones((len(mesh.vertices), 4), np.float32)
        expected[:, :3] = mesh.vertex_colors / np.float32(255)
        np.testing.assert_array_equal(np.float32(found), expected)

    def check_costs(self, message, name, mesh=MAP):
        self.headed(message, mesh)
        self.assertEqual(message.type, name)
        np.testing.assert_array_equal(
            np.float32(message.mesh_vertex_costs.costs), mesh.vertex_costs[name]
        )

    def test_topics(self):
        space = self.one.namespace
        (message,) = received(space + "/mesh/geometry", msg.MeshGeometryStamped, 1)
        self.check_geometry(message)
        (message,) = received(space + "/mesh/vertex_colors", msg.MeshVertexColorsStamped, 1)
        self.check_colors(message)
        messages = received(space + "/mesh/vertex_costs", msg.MeshVertexCostsStamped, 2)
        self.assertEqual(sorted(message.type for message in messages), list(LAYERS))
        for message in messages:
            self.check_costs(message, message.type)
        (message,) = received(space + "/mesh/face_costs", msg.MeshFaceCostsStamped, 1)
        self.headed(message)
        self.assertEqual(message.type, "slope")
        found = np.float32(message.mesh_face_costs.costs)
        np.testing.assert_array_equal(found, MAP.face_attributes["slope"])
        for _ in range(2):  # read for the first subscriber, kept for the next
            (message,) = received(space + "/mesh/features", msg.MeshFeatures, 1)
            self.assertEqual(message.map_uuid, MAP.uuid)
            places = xyz([feature.location for feature in message.features])
            np.testing.assert_array_equal(places, MAP.features.locations)
            numbers = [[x.data for x in feature.descriptor] for feature in message.features]
            np.testing.assert_array_equal(np.float32(numbers), MAP.features.descriptors)

    def test_uuids(self):
        self.assertEqual(self.one.call("get_uuids", srv.GetUUIDs).uuids, [MAP.uuid])
        self.assertEqual(self.one.call("get_uuid", srv.GetUUID).uuid, MAP.uuid)

    def test_get_uuid_in_the_type_that_the_released_rviz_calls_it_with(self):
        self.assertEqual(self.one.call("get_uuid", srv.GetUUIDs).uuids, [MAP.uuid])
        self.assertEqual(self.two.call("get_uuid", srv.GetUUIDs).uuids, [MAP.uuid, OTHER.uuid])
        with self.assertRaises(rospy.ServiceException):  # another type is refused, as ever
            self.one.call("get_uuid", srv.GetGeometry)
        line = self.one.wait_for("md5sums do not match")
        self.assertIn(srv.GetGeometry._md5sum, line)

    def test_geometry_services(self):
        for name, parts in (
            ("get_geometry", ("vertices", "normals", "faces")),
            ("get_geometry_vertices", ("vertices",)),
            ("get_geometry_vertexnormals", ("normals",)),
            ("get_geometry_faces", ("faces",)),
        ):
            for uuid in (MAP.uuid, "", "mesh"):
                answer = self.one.call(name, srv.GetGeometry, uuid)
                self.check_geometry(answer.mesh_geometry_stamped, parts)

    def test_colors_and_costs_services(self):
        answer = self.one.call("get_vertex_colors", srv.GetVertexColors, "mesh")
        self.check_colors(answer.mesh_vertex_colors_stamped)
        layers = self.one.call("get_vertex_cost_layers", srv.GetVertexCostLayers, "").layers
        self.assertEqual(layers, list(LAYERS))
        for name, layer, expected in (
            ("get_vertex_costs", "height_diff", "height_diff"),
            ("get_vertex_costs", "roughness", "roughness"),
            ("get_roughness", "", "roughness"),
            ("get_height_difference", "anything", "height_diff"),
        ):
            answer = self.one.call(name, srv.GetVertexCosts, MAP.uuid, layer)
            self.check_costs(answer.mesh_vertex_costs_stamped, expected)

    def test_materials_and_textures(self):
        answer = self.one.call("get_materials", srv.GetMaterials, "")
        self.headed(answer.mesh_materials_stamped)
        parts = answer.mesh_materials_stamped.mesh_materials
        self.assertEqual(list(parts.cluster_materials), [0, 1, 2])
        order = [2, 0, 1]  # the material of texture 0 stands first, as the released RViz needs it
        for number, cluster in zip(order, parts.clusters):
            found = np.flatnonzero(MAP.materials.face_materials == number).tolist()
            self.assertEqual(list(cluster.face_indices), found)
        self.assertEqual([m.has_texture for m in parts.materials], [True, True, False])
        self.assertEqual([m.texture_index for m in parts.materials], [0, 3, 2])
        found = np.float32([(m.color.r, m.color.g, m.color.b, m.color.a) for m in parts.materials])
        expected = MAP.materials.colors[order] / np.float32(255)
        np.testing.assert_array_equal(found[:, :3], expected)
        np.testing.assert_array_equal(found[:, 3], 1)
        found = np.float32([(c.u, c.v) for c in parts.vertex_tex_coords])
        np.testing.assert_array_equal(found, MAP.texture_coordinates)
        for index, encoding in ((0, "rgb8"), (3, "rgba8")):
            texture = self.one.call("get_texture", srv.GetTexture, "", index).texture
            pixels = MAP.textures[index]
            self.assertEqual((texture.uuid, texture.texture_index), (MAP.uuid, index))
            image = texture.image
            self.assertEqual((image.height, image.width), pixels.shape[:2])
            self.assertEqual((image.encoding, image.step), (encoding, pixels[0].size))
            self.assertEqual(image.data, pixels.tobytes())

    def test_labels(self):
        def found(clusters):
            return {cluster.label: list(cluster.face_indices) for cluster in clusters}

        expected = {text: label.faces.tolist() for text, label in MAP.labels.items()}
        answer = self.one.call("get_labeled_clusters", srv.GetLabeledClusters, "")
        self.assertEqual(found(answer.clusters), expected)
        answer = self.one.call("get_label_groups", srv.GetLabelGroups, "mesh")
        self.assertEqual(answer.labels, ["bench", "tree"])
        kind = srv.GetLabeledClusterGroup
        answer = self.one.call("get_labeled_cluster_group", kind, MAP.uuid, "tree")
        self.assertEqual(
            found(answer.clusters), {k: v for k, v in expected.items() if k.startswith("tree")}
        )
        answer = self.one.call("get_labeled_cluster_group", kind, "", "tre")
        self.assertEqual(answer.clusters, [])

    def test_several_maps(self):
        uuids = [MAP.uuid, OTHER.uuid]
        self.assertEqual(self.two.call("get_uuids", srv.GetUUIDs).uuids, uuids)
        self.assertEqual(self.two.call("get_uuid", srv.GetUUID).uuid, MAP.uuid)
        for mesh in (MAP, OTHER):
            answer = self.two.call("get_geometry", srv.GetGeometry, mesh.uuid)
            self.check_geometry(answer.mesh_geometry_stamped, mesh=mesh)
            answer = self.two.call("get_vertex_costs", srv.GetVertexCosts, mesh.uuid, "roughness")
            self.check_costs(answer.mesh_vertex_costs_stamped, "roughness", mesh)
        messages = received("/all/two/mesh/geometry", msg.MeshGeometryStamped, 2)
        self.assertEqual(sorted(message.uuid for message in messages), sorted(uuids))
        messages = received("/all/two/mesh/vertex_costs", msg.MeshVertexCostsStamped, 4)
        found = sorted((message.uuid, message.type) for message in messages)
        self.assertEqual(found, sorted((uuid, name) for uuid in uuids for name in LAYERS))
        messages = received("/all/two/mesh/features", msg.MeshFeatures, 2)
        self.assertEqual(sorted(message.map_uuid for message in messages), sorted(uuids))
        for uuid in ("", "mesh"):
            with self.assertRaisesRegex(rospy.ServiceException, "several.*" + ", ".join(uuids)):
                self.two.call("get_geometry", srv.GetGeometry, uuid)
        for name in ("broken.h5", "crasher.h5"):  # libhdf5 itself crashes on the second
            self.assertIn("ERROR", self.two.wait_for(name))
            self.assertEqual(len(self.two.logged(name)), 1)
        self.assertIn("a UUID stands for one map", self.two.wait_for("is not served"))
        self.assertEqual(len(self.two.logged("is not served")), 1)

    def test_what_is_unknown_is_an_error_that_names_the_known(self):
        for name, kind, more in (
            ("get_geometry", srv.GetGeometry, ()),
            ("get_geometry_vertices", srv.GetGeometry, ()),
            ("get_geometry_faces", srv.GetGeometry, ()),
            ("get_geometry_vertexnormals", srv.GetGeometry, ()),
            ("get_vertex_colors", srv.GetVertexColors, ()),
            ("get_vertex_cost_layers", srv.GetVertexCostLayers, ()),
            ("get_vertex_costs", srv.GetVertexCosts, ("roughness",)),
            ("get_roughness", srv.GetVertexCosts, ("",)),
            ("get_height_difference", srv.GetVertexCosts, ("",)),
            ("get_materials", srv.GetMaterials, ()),
            ("get_texture", srv.GetTexture, (0,)),
            ("get_labeled_clusters", srv.GetLabeledClusters, ()),
            ("get_label_groups", srv.GetLabelGroups, ()),
            ("get_labeled_cluster_group", srv.GetLabeledClusterGroup, ("tree",)),
            ("delete_label", srv.DeleteLabel, ("tree_1",)),
        ):
            with self.assertRaisesRegex(rospy.ServiceException, "'other'; known: " + MAP.uuid):
                self.one.call(name, kind, "other", *more)
        for name, kind, more, words in (
            ("get_vertex_costs", srv.GetVertexCosts, "slope", "known: height_diff, roughness"),
            ("get_texture", srv.GetTexture, 1, "no texture 1; known: 0, 3"),
            ("delete_label", srv.DeleteLabel, "tree_9", "there is no label 'tree_9'"),
        ):
            with self.assertRaisesRegex(rospy.ServiceException, words):
                self.one.call(name, kind, "", more)

    def test_parts_of_one_file(self):
        path, above = (os.path.join(self.folder.name, name) for name in ("p.h5", "q.h5"))
        MapFile.write(path, Mesh(MAP.vertices, MAP.faces))
        MapFile.write(above, Mesh(OTHER.vertices, OTHER.faces), part="upstairs")
        with h5py.File(path, "r+") as file, h5py.File(above, "r") as other:
            other.copy("upstairs", file)
        server = Server("/all/parts", inputFile=path, mesh_part="")
        self.assertEqual(server.call("get_uuids", srv.GetUUIDs).uuids, [MAP.uuid, OTHER.uuid])
        self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    rospy.init_node("serve_everything")
    rostest.rosrun("mesh_msgs_hdf5", "serve_everything", ServeEverything)
