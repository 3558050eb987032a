#!/usr/bin/python3
"""What hdf5_map_server stores of what it receives, and what becomes of it when nodes end."""
import os
import shutil
import signal
import sys
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
from mesh_msgs import arrays, msg, srv
from mesh_msgs.diagnostics_ros import ERROR
from mesh_msgs.testing import wait_until
from mesh_msgs.testing_ros import HeardDiagnostics, connected
from server_process import Publishers, Server, received
from std_msgs.msg import String
from std_srvs.srv import Trigger

from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.ros.map_messages import MapMessages

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from mesh_writers import ply, xyz  # noqa: E402
from server_samples import everything  # noqa: E402

MAP = everything(1)
FACES = len(MAP.faces)


def labeled(text, faces, override=True, uuid=MAP.uuid):
    message = msg.MeshFaceClusterStamped(uuid=uuid, override=override)
    message.cluster.label, message.cluster.face_indices = text, faces
    return message


def layer(name, costs, uuid=MAP.uuid):
    message = arrays.MeshVertexCostsStamped(uuid=uuid, type=name)
    message.mesh_vertex_costs.costs = np.float32(costs)
    return message


class StoreInAMap(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.path = os.path.join(self.folder, "a.h5")
        self.space = "/store/" + self._testMethodName
        self.publishers = Publishers()
        self.servers = []

    def tearDown(self):
        for server in self.servers:
            server.stop(signal.SIGKILL)
            for line in server.logged("[ERROR]"):  # says why a test has failed
                sys.stderr.write(line + "\n")

    def serve(self, *arguments, space="", **parameters):
        if not any(argument.startswith("_inputFile") for argument in arguments):
            arguments += ("_inputFile:=" + self.path,)
        self.servers.append(Server(self.space + space, *arguments, **parameters))
        return self.servers[-1]

    def send(self, topic, message, space=""):
        self.publishers.send("%s%s/%s" % (self.space, space, topic), message)

    def labels_of(self, server):
        clusters = server.call("get_labeled_clusters", srv.GetLabeledClusters, "").clusters
        return {cluster.label: list(cluster.face_indices) for cluster in clusters}

    def store_label(self, server, message, space=""):
        """Send it until it is stored: returned from new_cluster_label."""
        seen = []
        topic = server.namespace + "/new_cluster_label"
        subscriber = rospy.Subscriber(topic, msg.MeshFaceCluster, seen.append)
        wait_until(lambda: connected(subscriber), "a connection to " + topic)
        self.send("cluster_label", message, space)
        wait_until(lambda: seen, "the stored label")
        subscriber.unregister()
        return seen[0]

    def test_everything_that_is_sent_is_served_and_stored(self):
        MapFile.write(self.path, Mesh(MAP.vertices, MAP.faces, frame_id="floor"))
        server = self.serve("_save_delay:=0.2")
        messages = MapMessages(_Members(MAP), MAP.uuid, rospy.Time(3))
        for topic, message in (
            ("store/vertex_costs", messages.vertex_costs("height_diff")),
            ("store/face_costs", messages.face_costs("slope")),
            ("store/vertex_colors", messages.vertex_colors()),
            ("store/materials", messages.materials()),  # before its textures
            ("store/texture", messages.texture(0)),
            ("store/texture", messages.texture(3)),
            ("store/features", messages.features()),
        ):
            self.send(topic, message)
        space = server.namespace
        (found,) = received(space + "/mesh/vertex_costs", arrays.MeshVertexCostsStamped, 1)
        np.testing.assert_array_equal(
            found.mesh_vertex_costs.costs, MAP.vertex_costs["height_diff"]
        )
        update = arrays.MeshVertexCostsSparseStamped(uuid=MAP.uuid, type="height_diff")
        update.mesh_vertex_costs = arrays.MeshVertexCostsSparse([1, 5], [0.25, np.inf], 0.0)
        self.send("store/vertex_costs_update", update)
        expected = MAP.vertex_costs["height_diff"].copy()
        expected[[1, 5]] = 0.25, np.inf

        def is_updated():
            answer = server.call("get_vertex_costs", srv.GetVertexCosts, "", "height_diff")
            costs = np.float32(answer.mesh_vertex_costs_stamped.mesh_vertex_costs.costs)
            return np.array_equal(costs, expected, equal_nan=True)

        wait_until(is_updated, "the update of a layer")
        received(space + "/mesh/face_costs", msg.MeshFaceCostsStamped, 1)
        received(space + "/mesh/vertex_colors", msg.MeshVertexColorsStamped, 1)
        received(space + "/mesh/features", msg.MeshFeatures, 1)

        def is_stored():
            mesh = MapFile(self.path).read()
            return (
                set(mesh.textures) == {0, 3}
                and mesh.materials is not None
                and mesh.features is not None
                and mesh.vertex_colors is not None
                and np.array_equal(mesh.vertex_costs.get("height_diff"), expected, equal_nan=True)
                and "slope" in mesh.face_attributes
            )

        wait_until(is_stored, "everything in the file")
        mesh = MapFile(self.path).read()
        np.testing.assert_array_equal(mesh.vertex_colors, MAP.vertex_colors)
        np.testing.assert_array_equal(mesh.face_attributes["slope"], MAP.face_attributes["slope"])
        np.testing.assert_array_equal(mesh.texture_coordinates, MAP.texture_coordinates)
        for name in ("colors", "texture_indices"):  # of each face: messages number them anew
            found, wanted = getattr(mesh.materials, name), getattr(MAP.materials, name)
            np.testing.assert_array_equal(
                found[mesh.materials.face_materials], wanted[MAP.materials.face_materials]
            )
        for index, pixels in MAP.textures.items():
            np.testing.assert_array_equal(mesh.textures[index], pixels)
        np.testing.assert_array_equal(mesh.features.locations, MAP.features.locations)
        np.testing.assert_array_equal(mesh.features.descriptors, MAP.features.descriptors)
        self.assertEqual(server.stop(), 0)
        again = self.serve()
        found = received(space + "/mesh/vertex_costs", arrays.MeshVertexCostsStamped, 1)
        np.testing.assert_array_equal(found[0].mesh_vertex_costs.costs, expected)
        texture = again.call("get_texture", srv.GetTexture, "", 3).texture
        self.assertEqual(texture.image.data, MAP.textures[3].tobytes())

    def test_what_was_just_received_is_saved_at_the_end(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            MapFile.write(self.path, MAP)
            server = self.serve("_save_delay:=1000")
            self.send("store/vertex_costs", layer("late", np.arange(12)))
            topic = server.namespace + "/mesh/vertex_costs"
            received(topic, arrays.MeshVertexCostsStamped, 3)
            self.store_label(server, labeled("tree_3", [7]))
            self.assertNotIn("late", MapFile(self.path).layer_names())
            self.assertEqual(server.stop(number), 0)
            file = MapFile(self.path)
            np.testing.assert_array_equal(file.vertex_costs("late"), np.arange(12))
            self.assertEqual(file.label("tree_3").faces.tolist(), [7])
            self.assertEqual(os.listdir(self.folder), ["a.h5"])

    def test_save_map_and_one_line_each(self):
        MapFile.write(self.path, MAP)
        server = self.serve("_save_delay:=1000")
        answer = server.call("save_map", Trigger)
        self.assertEqual((answer.success, answer.message), (True, "no changes"))
        self.store_label(server, labeled("tree_1", [5, 6]))
        self.send("store/vertex_costs", layer("slope", np.zeros(12)))
        topic = server.namespace + "/mesh/vertex_costs"
        received(topic, arrays.MeshVertexCostsStamped, 3)
        answer = server.call("save_map", Trigger)
        self.assertTrue(answer.success)
        self.assertRegex(answer.message, r"^saved 1 layer to .*a\.h5 in .* s; saved 1 label to ")
        self.assertEqual(MapFile(self.path).label("tree_1").faces.tolist(), [5, 6])
        server.wait_for("saved 1 label")
        self.assertEqual(len(server.logged("saved 1 layer")), 1)
        os.rename(self.path, self.path + ".away")
        self.send("store/vertex_costs", layer("steep", np.ones(12)))
        received(topic, arrays.MeshVertexCostsStamped, 4)
        answer = server.call("save_map", Trigger)
        self.assertFalse(answer.success)
        self.assertIn("no such file", answer.message)
        os.rename(self.path + ".away", self.path)
        answer = server.call("save_map", Trigger)
        self.assertRegex(answer.message, "^saved 1 layer")
        np.testing.assert_array_equal(MapFile(self.path).vertex_costs("steep"), np.ones(12))

    def test_an_endless_stream_is_saved_too(self):
        MapFile.write(self.path, MAP)
        self.serve("_save_delay:=0.2")
        update = arrays.MeshVertexCostsSparseStamped(uuid=MAP.uuid, type="stream")
        update.mesh_vertex_costs = arrays.MeshVertexCostsSparse([1], [0.5], 0.0)

        def is_saved():
            self.send("store/vertex_costs_update", update)
            return "stream" in MapFile(self.path).layer_names()

        wait_until(is_saved, "a save between messages that come all the time")

    def test_labels(self):
        MapFile.write(self.path, MAP)
        server = self.serve()
        stored = self.store_label(server, labeled("tree_1", [8, 0], override=False, uuid="mesh"))
        self.assertEqual((stored.label, list(stored.face_indices)), ("tree_1", [0, 2, 8]))
        stored = self.store_label(server, labeled("tree_1", [4]))
        self.assertEqual(list(stored.face_indices), [4])
        stored = self.store_label(server, labeled("free text", [1]))
        self.assertEqual(list(self.labels_of(server)["free text"]), [1])
        gone = server.call("delete_label", srv.DeleteLabel, MAP.uuid, "tree_2").cluster
        self.assertEqual((gone.label, list(gone.face_indices)), ("tree_2", [1]))
        expected = {"bench_left": [3, 4, 5], "free text": [1], "tree_1": [4]}
        self.assertEqual(self.labels_of(server), expected)

    def test_a_label_that_was_seen_survives_a_kill(self):
        MapFile.write(self.path, MAP)
        server = self.serve()
        for number in range(5):
            self.store_label(server, labeled("car_%d" % number, [number]))
        server.stop(signal.SIGKILL)
        labels = self.labels_of(self.serve())
        for number in range(5):
            self.assertEqual(labels["car_%d" % number], [number])
        self.assertEqual(labels["tree_1"], [0, 2])

    def test_a_second_server_forwards_labels_until_it_is_the_only_one(self):
        MapFile.write(self.path, MAP)
        first = self.serve(space="/first")
        second = self.serve(space="/second")
        line = second.wait_for("its labels belong to /store/")
        self.assertIn(first.namespace + "/hdf5_map_server", line)
        stored = self.store_label(second, labeled("tree_1", [8], override=False), "/second")
        self.assertEqual(list(stored.face_indices), [0, 2, 8])
        gone = second.call("delete_label", srv.DeleteLabel, "", "tree_2").cluster
        self.assertEqual(list(gone.face_indices), [1])
        expected = {"bench_left": [3, 4, 5], "tree_1": [0, 2, 8]}
        for server in (first, second):
            self.assertEqual(self.labels_of(server), expected)
        self.send("store/vertex_costs", layer("a", np.zeros(12)), "/second")
        second.wait_for("store it there")
        first.stop(signal.SIGKILL)
        self.store_label(second, labeled("tree_1", [7]), "/second")
        self.send("store/vertex_costs", layer("b", np.ones(12)), "/second")
        topic = second.namespace + "/mesh/vertex_costs"
        received(topic, arrays.MeshVertexCostsStamped, 3)
        self.assertEqual(second.stop(), 0)
        file = MapFile(self.path)
        self.assertEqual(file.label("tree_1").faces.tolist(), [7])
        self.assertEqual(file.layer_names(), ["b", "height_diff", "roughness"])
        self.assertEqual(os.listdir(self.folder), ["a.h5"])

    def test_a_mesh_of_another_format_is_stored_beside_it(self):
        path = os.path.join(self.folder, "b.ply")
        with open(path, "wb") as stream:
            stream.write(ply(xyz(MAP.vertices), MAP.faces))
        argument = "_inputFile:=" + path
        server = self.serve(argument, "_save_delay:=0.1")
        self.store_label(server, labeled("tree_1", [3]))
        self.send("store/vertex_costs", layer("slope", np.arange(12)))
        stored = os.path.join(self.folder, "b.h5")
        wait_until(lambda: os.path.exists(stored), stored)
        self.assertEqual(server.stop(), 0)
        server = self.serve(argument)
        server.wait_for("is served from " + stored)
        self.assertEqual(self.labels_of(server), {"tree_1": [3]})
        topic = server.namespace + "/mesh/vertex_costs"
        (found,) = received(topic, arrays.MeshVertexCostsStamped, 1)
        np.testing.assert_array_equal(found.mesh_vertex_costs.costs, np.arange(12))
        self.assertEqual(server.call("get_uuid", srv.GetUUID).uuid, MAP.uuid)

    def test_hostile_values_are_one_warning_each(self):
        MapFile.write(self.path, MAP)
        before = os.stat(self.path).st_mtime_ns
        server = self.serve("_save_delay:=0.1")
        colors = arrays.MeshVertexColorsStamped(uuid=MAP.uuid)
        colors.mesh_vertex_colors.vertex_colors = np.full((12, 4), np.nan)
        sparse = arrays.MeshVertexCostsSparseStamped(uuid="mesh", type="roughness")
        sparse.mesh_vertex_costs = arrays.MeshVertexCostsSparse([2**32 - 1], [0.0], 0.0)
        faces = arrays.MeshFaceCostsStamped(uuid=MAP.uuid, type="../../etc")
        faces.mesh_face_costs.costs = np.zeros(FACES)
        materials = arrays.MeshMaterialsStamped(uuid=MAP.uuid)
        materials.mesh_materials.clusters = [arrays.MeshFaceCluster([0], "")]
        materials.mesh_materials.cluster_materials = [2**32 - 1]
        texture = msg.MeshTexture(uuid=MAP.uuid)
        texture.image.height = texture.image.width = 2**32 - 1
        texture.image.encoding = "rgb8"
        feature = msg.Feature()
        feature.location.x = float("nan")
        bad = [
            ("store/vertex_costs", layer("a/b", np.zeros(12))),
            ("store/vertex_costs", layer("a", np.zeros(12), "another")),
            ("store/vertex_costs_update", sparse),
            ("store/face_costs", faces),
            ("store/vertex_colors", colors),
            ("store/materials", materials),
            ("store/texture", texture),
            ("store/features", msg.MeshFeatures(map_uuid=MAP.uuid, features=[feature])),
            ("cluster_label", labeled("a/b", [0])),
            ("cluster_label", labeled("tree_1", [FACES])),
            ("cluster_label", labeled("tree_1", [0], uuid="")),
        ]
        for _ in range(2):
            for topic, message in bad[:-1]:
                self.send(topic, message)
        self.send(*bad[-1])  # the last one is good
        wait_until(lambda: self.labels_of(server)["tree_1"] == [0], "the good one")
        wait_until(lambda: len(server.logged("refused")) >= len(bad) - 1, "all warnings")
        lines = server.logged("refused")
        self.assertEqual(len(lines), len(bad) - 1)  # though each was sent twice
        for topic, _ in bad[:-1]:
            self.assertTrue([line for line in lines if "[WARN]" in line and topic in line], topic)
        self.assertEqual(server.call("save_map", Trigger).success, True)
        self.assertNotEqual(os.stat(self.path).st_mtime_ns, before)  # the label
        self.assertEqual(MapFile(self.path).layer_names(), ["height_diff", "roughness"])

    def test_read_only(self):
        MapFile.write(self.path, MAP)
        before = os.stat(self.path)
        server = self.serve("_read_only:=true")
        self.send("store/vertex_costs", layer("a", np.zeros(12)))
        self.send("cluster_label", labeled("tree_1", [0]))
        server.wait_for("store/vertex_costs: refused")
        server.wait_for("cluster_label: refused")
        with self.assertRaisesRegex(rospy.ServiceException, "read"):
            server.call("delete_label", srv.DeleteLabel, "", "tree_1")
        self.assertEqual(self.labels_of(server)["tree_1"], [0, 2])
        self.assertEqual(server.stop(), 0)
        self.assertEqual(os.stat(self.path), before)
        self.assertEqual(os.listdir(self.folder), ["a.h5"])

    def test_a_replaced_file_is_not_loaded_while_changes_wait(self):
        MapFile.write(self.path, MAP)
        server = self.serve("_save_delay:=1000")
        MapFile(self.path).write_layers({"new": (np.ones(12, np.float32), None)})
        layers = server.call("get_vertex_cost_layers", srv.GetVertexCostLayers, "").layers
        self.assertEqual(layers, ["height_diff", "new", "roughness"])
        self.send("store/vertex_costs", layer("mine", np.zeros(12)))
        received(server.namespace + "/mesh/vertex_costs", arrays.MeshVertexCostsStamped, 3)
        MapFile.write(self.path, everything(2))
        server.wait_for("replaced the mesh, but what was stored in the old one is not saved")
        with self.assertRaisesRegex(rospy.ServiceException, "replaced the mesh"):
            server.call("get_geometry", srv.GetGeometry, "")
        answer = server.call("save_map", Trigger)
        self.assertFalse(answer.success)
        self.assertIn("replaced the mesh", answer.message)
        server.stop()
        self.assertEqual(MapFile(self.path).uuid, everything(2).uuid)
        self.assertEqual(MapFile(self.path).layer_names(), ["height_diff", "roughness"])

    def test_a_layer_that_another_program_adds_is_published(self):
        MapFile.write(self.path, MAP)
        server = self.serve("_save_delay:=0.2")
        said, diagnostics = [], HeardDiagnostics()
        rospy.Subscriber(server.namespace + "/progress", String, lambda m: said.append(m.data))
        self.send("store/vertex_costs", layer("mine", np.zeros(12)))
        server.wait_for("saved 1 layer")
        time.sleep(1.5)
        self.assertEqual(server.logged("changed by another program"), [])  # that was the server
        MapFile(self.path).write_layers({"new": (np.ones(12, np.float32), None)})
        server.wait_for("changed by another program: now serving")
        topic = server.namespace + "/mesh/vertex_costs"
        found = received(topic, arrays.MeshVertexCostsStamped, 4)
        self.assertEqual([m.type for m in found], ["height_diff", "mine", "new", "roughness"])
        with open(self.path, "wb") as stream:
            stream.write(b"half a file")
        wait_until(lambda: "failed: " in said[-1], "the reason on progress")
        name = server.namespace.lstrip("/") + "/hdf5_map_server: maps"
        diagnostics.expected(name, ERROR, "not an HDF5 file")
        self.assertRegex(said[-1], "ready: serving .*new.*\n.*failed: .*not an HDF5 file")
        self.assertEqual(len(server.logged("changed by another program")), 1)

    def test_a_file_that_is_replaced_under_the_server_is_loaded(self):
        MapFile.write(self.path, MAP)
        server = self.serve("_save_delay:=0.2")
        self.store_label(server, labeled("old_1", [0]))
        self.assertTrue(server.call("save_map", Trigger).success)
        new = everything(2)
        MapFile.write(self.path + ".new", new)
        MapFile(self.path + ".new").write_layers({"mine": (np.ones(12, np.float32), None)})
        with open(self.path, "wb") as stream:  # as cp does it, with time to be looked at
            stream.write(b"half a file")
        server.wait_for("the new file is not served: ")
        os.rename(self.path + ".new", self.path)
        server.wait_for("replaced the mesh: now serving")
        self.assertEqual(server.call("get_uuids", srv.GetUUIDs).uuids, [new.uuid])
        geometry = server.call("get_geometry", srv.GetGeometry, "").mesh_geometry_stamped
        self.assertEqual((geometry.uuid, geometry.header.frame_id), (new.uuid, "floor"))
        topic = server.namespace + "/mesh/vertex_costs"
        found = received(topic, arrays.MeshVertexCostsStamped, 3)
        self.assertEqual([m.type for m in found], ["height_diff", "mine", "roughness"])
        self.assertEqual({m.uuid for m in found}, {new.uuid})
        for name, kind in (
            ("geometry", msg.MeshGeometryStamped),
            ("vertex_colors", msg.MeshVertexColorsStamped),
            ("face_costs", msg.MeshFaceCostsStamped),
        ):
            found = received("%s/mesh/%s" % (server.namespace, name), kind, 1)
            self.assertEqual([m.uuid for m in found], [new.uuid])
        self.assertEqual(sorted(self.labels_of(server)), sorted(new.labels))
        self.store_label(server, labeled("new_1", [0], uuid=new.uuid))
        self.send("store/vertex_costs", layer("late", np.zeros(12), new.uuid))
        received(topic, arrays.MeshVertexCostsStamped, 4)
        self.assertEqual(server.stop(), 0)
        self.assertEqual(len(server.logged("replaced the mesh")), 1)
        self.assertIn("late", MapFile(self.path).layer_names())
        self.assertEqual(sorted(MapFile(self.path).labels()), sorted([*new.labels, "new_1"]))
        self.assertEqual(os.listdir(self.folder), ["a.h5"])


class _Members:
    """A Mesh for MapMessages."""

    def __init__(self, mesh):
        self.frame_id = mesh.frame_id
        self.vertex_colors, self.materials = mesh.vertex_colors, mesh.materials
        self.texture_coordinates, self.features = mesh.texture_coordinates, mesh.features
        self.vertex_costs = mesh.vertex_costs.get
        self.face_attribute = mesh.face_attributes.get
        self.texture = mesh.textures.get


if __name__ == "__main__":
    rospy.init_node("store_in_a_map")
    rostest.rosrun("mesh_msgs_hdf5", "store_in_a_map", StoreInAMap)
