#!/usr/bin/python3
"""What a map publishes and serves while it changes, and to those that come late."""

import os
import shutil
import tempfile
import threading
import time
import unittest
from functools import partial
from unittest import mock

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Point
from map_node import WAIT, Subscriber, end_node, start_node
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.io.markers import sphere_marker
from mesh_map.ros import MeshMapServer
from mesh_msgs import array_services, arrays, zoo
from mesh_msgs.testing import wait_until
from mesh_msgs.identity import geometry_uuid
from mesh_msgs.msg import LayerInfo, LayerInfoArray
from mesh_msgs.srv import GetUUIDs, GetVertexCostLayers
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from std_msgs.msg import String
from visualization_msgs.msg import Marker

GRID = zoo.grid()
COUNT = len(GRID.vertices)
UUID = geometry_uuid(GRID.vertices, GRID.faces)
FACE_COSTS = np.arange(len(GRID.faces), dtype=np.float32)
STRANGE = [{"name": "flag_%d" % number, "type": "strange/FlagLayer"} for number in range(10)]


class MapTopicsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        self.path = os.path.join(folder, "map.h5")
        attributes = {"slope": FACE_COSTS, "kind": np.arange(len(GRID.faces), dtype=np.uint32)}
        colors = (np.arange(3 * COUNT) % 256).astype(np.uint8).reshape(-1, 3)
        mesh = Mesh(GRID.vertices, GRID.faces, vertex_colors=colors, face_attributes=attributes)
        MapFile.write(self.path, mesh)
        self.colors = colors

    def start(self, name, **parameters):
        """A node whose adapters listen to their topics."""
        node = start_node(self, name, mesh_file=self.path, **parameters)
        self.name = name
        progress = self.subscribe("progress", String)
        self.assertTrue(wait_until(lambda: "ready" in str(progress.messages[-1:])))
        return node

    def subscribe(self, topic, kind):
        queue_size = 4 if topic == "vertex_costs" else None
        subscriber = Subscriber("/%s/%s" % (self.name, topic), kind, queue_size)
        self.addCleanup(subscriber.unregister)
        self.assertTrue(subscriber.connected(), topic)
        return subscriber

    def flag(self, layer):
        """A function that moves the flag of a layer."""
        topic = "/%s/%s/flag" % (self.name, layer)
        publisher = rospy.Publisher(topic, Point, queue_size=100)
        self.addCleanup(publisher.unregister)
        self.assertTrue(wait_until(lambda: publisher.get_num_connections() > 0))
        return lambda vertex, cost: publisher.publish(Point(x=vertex, y=cost))

    def test_updates_are_the_differences(self):
        self.start("updates", layers=STRANGE[:2], flag_0={"height": 1.0, "factor": 0.5})
        whole = self.subscribe("vertex_costs", arrays.MeshVertexCostsStamped)
        updates = self.subscribe("vertex_costs/updates", arrays.MeshVertexCostsSparseStamped)
        self.assertTrue(wait_until(lambda: len(whole.newest) == 3))
        followed = {name: m.mesh_vertex_costs.costs.copy() for name, m in whole.newest.items()}
        move = self.flag("flag_0")
        for vertex, cost, height_changed in ((5, 2.0, False), (7, 3.0, True), (7, 10.0, False)):
            known = len(updates.messages)
            move(vertex, cost)
            self.assertTrue(wait_until(lambda: len(updates.messages) == known + 2))
            for message in updates.messages[known:]:
                self.assertEqual(message.uuid, UUID)
                sparse = message.mesh_vertex_costs
                self.assertTrue((np.diff(sparse.vertices.astype(int)) > 0).all())
                self.assertTrue((followed[message.type][sparse.vertices] != sparse.costs).all())
                followed[message.type][sparse.vertices] = sparse.costs
            types = [message.type for message in updates.messages[known:]]
            self.assertEqual(types, ["flag_0", COMBINED_COSTS])
            expected = np.zeros(COUNT, np.float32)
            expected[vertex] = cost
            np.testing.assert_array_equal(followed["flag_0"], expected)
            expected[vertex] = np.inf if cost > 9 else cost / 2
            np.testing.assert_array_equal(followed[COMBINED_COSTS], expected)

        def the_same():
            found = {name: m.mesh_vertex_costs.costs for name, m in whole.newest.items()}
            return all(np.array_equal(found[name], followed[name]) for name in followed)

        self.assertTrue(wait_until(the_same))
        known = len(updates.messages)
        move(7, 10.0)  # nothing new
        move(7, 0.0)
        self.assertTrue(wait_until(lambda: len(updates.messages) == known + 2))

    def test_what_costs_mean_is_told_and_follows_changes(self):
        steepness = {"name": "steepness", "type": "mesh_layers/SteepnessLayer"}
        self.start("told", layers=[*STRANGE[:1], steepness], steepness={"threshold": 3.0})
        info = self.subscribe("layer_info", LayerInfoArray)
        self.assertTrue(wait_until(lambda: info.messages))
        self.assertEqual({message.uuid for message in info.messages}, {UUID})

        def told(name):
            return next(one for one in info.messages[-1].layers if one.name == name)

        self.assertEqual(
            [one.name for one in info.messages[-1].layers], ["flag_0", "steepness", COMBINED_COSTS]
        )
        found = told("steepness")
        self.assertEqual((found.unit, found.comparison), ("rad", LayerInfo.ABOVE))
        self.assertEqual((found.threshold, found.lethal), (3.0, 0))
        self.flag("flag_0")(7, 10.0)  # which is lethal there
        self.assertTrue(wait_until(lambda: told(COMBINED_COSTS).lethal == 1))
        self.assertEqual(told("flag_0").lethal, 1)
        client = Client("/told/steepness", timeout=WAIT)
        client.update_configuration({"threshold": 1.5})
        self.assertTrue(wait_until(lambda: told("steepness").threshold == 1.5))
        late = self.subscribe("layer_info", LayerInfoArray)
        self.assertTrue(wait_until(lambda: late.messages))
        self.assertEqual(late.messages[-1], info.messages[-1])

    def test_whole_layers_are_not_sent_at_every_change(self):
        self.start("paced", layers=STRANGE[:1], costs_period=1.0)
        whole = self.subscribe("vertex_costs", arrays.MeshVertexCostsStamped)
        updates = self.subscribe("vertex_costs/updates", arrays.MeshVertexCostsSparseStamped)
        self.assertTrue(wait_until(lambda: len(whole.newest) == 2))
        move = self.flag("flag_0")
        time.sleep(1.0)  # a change after a pause is sent at once
        known, begin = len(whole.messages), time.monotonic()
        for cost in range(1, 31):
            move(3, cost / 16)
            time.sleep(0.02)
        self.assertTrue(wait_until(lambda: len(updates.messages) == 60))
        newest = lambda: whole.newest["flag_0"].mesh_vertex_costs.costs[3]  # noqa: E731
        self.assertTrue(wait_until(lambda: newest() == 3.75))
        seconds = time.monotonic() - begin
        of_flag = [m for m in whole.messages[known:] if m.type == "flag_0"]
        self.assertEqual(of_flag[0].mesh_vertex_costs.costs[3], 0.125)
        self.assertLessEqual(len(of_flag), 2 + int(seconds))

    def test_late_subscribers_get_the_newest_of_ten_layers(self):
        self.start("late", layers=STRANGE, costs_period=3600.0)
        moves = [self.flag(layer["name"]) for layer in STRANGE]
        updates = self.subscribe("vertex_costs/updates", arrays.MeshVertexCostsSparseStamped)
        for _ in range(2):
            for number, move in enumerate(moves):
                move(number, 0.25 + number / 4)
        followed = {layer["name"]: np.zeros(COUNT) for layer in STRANGE}
        followed[COMBINED_COSTS] = np.zeros(COUNT)

        def all_told():
            for message in updates.messages:
                sparse = message.mesh_vertex_costs
                followed[message.type][sparse.vertices] = sparse.costs
            expected = [0.5 + number / 2 for number in range(10)]
            own = [followed[layer["name"]][number] for number, layer in enumerate(STRANGE)]
            return own == expected and followed[COMBINED_COSTS][:10].tolist() == expected

        self.assertTrue(wait_until(all_told))  # also of changes at the same time
        late = self.subscribe("vertex_costs", arrays.MeshVertexCostsStamped)
        self.assertTrue(wait_until(lambda: len(late.newest) == 11))
        for number, layer in enumerate(STRANGE):
            costs = late.newest[layer["name"]].mesh_vertex_costs.costs
            self.assertEqual(np.flatnonzero(costs).tolist(), [number])
            self.assertEqual(costs[number], 0.5 + number / 2)
        combined = late.newest[COMBINED_COSTS].mesh_vertex_costs.costs
        self.assertEqual(np.flatnonzero(combined).tolist(), list(range(10)))

    def test_vectors_and_face_costs(self):
        self.start("vectors", layers=STRANGE[:2], flag_1={"arrows": False}, costs_period=0.0)
        self.flag("flag_0")(4, 1.0)
        fields = self.subscribe("vector_field", Marker)
        self.assertTrue(wait_until(lambda: "inflation" in fields.newest))

        def line():
            points = fields.newest["inflation"].points
            return [[point.x, point.y] for point in points]

        place = GRID.vertices[4, :2].tolist()
        self.assertTrue(wait_until(lambda: line() == [place, place]))
        client = Client("/vectors/flag_0", timeout=WAIT)
        client.update_configuration({"arrows": False})
        self.assertTrue(wait_until(lambda: fields.newest["inflation"].action == Marker.DELETE))
        client.close()
        faces = self.subscribe("face_costs", arrays.MeshFaceCostsStamped)
        self.assertTrue(wait_until(lambda: "slope" in faces.newest))
        found = faces.newest["slope"]
        np.testing.assert_array_equal(found.mesh_face_costs.costs, FACE_COSTS)
        self.assertEqual((found.uuid, set(faces.newest)), (UUID, {"slope"}))

    def test_adapters_with_faults_harm_no_other(self):
        layers = [
            {"name": "deaf", "type": "strange/DeafLayer", "required": False},
            {"name": "odd", "type": "strange/OddLayer", "required": False},
            {"name": "flag", "type": "strange/FlagLayer"},
        ]
        node = self.start("faults", layers=layers)
        costs = self.subscribe("vertex_costs", arrays.MeshVertexCostsStamped)
        self.flag("flag")(2, 1.0)
        newest = lambda: costs.newest[COMBINED_COSTS].mesh_vertex_costs.costs[2]  # noqa: E731
        self.assertTrue(wait_until(lambda: COMBINED_COSTS in costs.newest and newest() == 2.0))
        output = end_node(node)
        self.assertIn("layer deaf: it gets no data from topics: OSError: no sensor", output)
        self.assertIn("FlagLayer is no mesh_map.ros.ros_adapter.RosAdapter", output)

    def test_services(self):
        self.start("serving", layers=STRANGE[:1])

        def ask(name, kind, **request):
            rospy.wait_for_service("/serving/" + name, WAIT)
            return rospy.ServiceProxy("/serving/" + name, kind)(**request)

        self.assertEqual(ask("get_uuids", GetUUIDs).uuids, [UUID])
        for uuid in ("", "mesh", UUID):
            answer = ask("get_geometry", array_services.GetGeometry, uuid=uuid)
            geometry = answer.mesh_geometry_stamped
            np.testing.assert_array_equal(geometry.mesh_geometry.vertices, GRID.vertices)
            np.testing.assert_array_equal(geometry.mesh_geometry.faces, GRID.faces)
            self.assertEqual((geometry.uuid, geometry.header.frame_id), (UUID, "map"))
            layers = ask("get_vertex_cost_layers", GetVertexCostLayers, uuid=uuid).layers
            self.assertEqual(layers, ["flag_0", COMBINED_COSTS])
        colors = ask("get_vertex_colors", array_services.GetVertexColors, uuid="")
        rgba = colors.mesh_vertex_colors_stamped.mesh_vertex_colors.vertex_colors
        np.testing.assert_allclose(rgba[:, :3], self.colors / 255, atol=1e-6)
        for layer in ("flag_0", COMBINED_COSTS):
            costs = ask("get_vertex_costs", array_services.GetVertexCosts, uuid="", layer=layer)
            stamped = costs.mesh_vertex_costs_stamped
            self.assertEqual((stamped.type, stamped.uuid), (layer, UUID))
            self.assertEqual(stamped.mesh_vertex_costs.costs.shape, (COUNT,))
        for name, kind, request, words in (
            ("get_geometry", array_services.GetGeometry, {"uuid": "x"}, "known: " + UUID),
            ("get_vertex_costs", array_services.GetVertexCosts, {"layer": "x"}, "Combined Costs"),
        ):
            with self.assertRaisesRegex(rospy.ServiceException, words):
                ask(name, kind, **request)

    def test_diagnostics_name_layers_whose_inputs_are_newer(self):
        heard = []
        diagnostics = rospy.Subscriber("/diagnostics", DiagnosticArray, heard.append)
        self.addCleanup(diagnostics.unregister)

        def said():
            parts = [status for message in heard for status in message.status]
            values = [{one.key: one.value for one in part.values} for part in parts]
            return [part["layer inflation"] for part in values if "layer inflation" in part][-1:]

        layers = [
            {"name": "border", "type": "mesh_layers/BorderLayer"},
            {"name": "inflation", "type": "mesh_layers/InflationLayer"},
        ]
        rospy.set_param("~stale", {"mesh_file": self.path, "layers": layers})
        server = MeshMapServer("~stale")
        self.addCleanup(server.shutdown)
        inflation = server.load().layers["inflation"]
        wait_until(lambda: said() == ["stands"], "its status")
        go_on, update = threading.Event(), inflation.update

        def slow(*arguments):
            go_on.wait(60)
            return update(*arguments)

        inflation.update = slow
        change = threading.Thread(
            target=server.map.set_layer_parameters, args=("border", {"border_cost": 0.5})
        )
        change.start()
        try:
            wait_until(lambda: said() == ["stands, but its inputs are newer"], "its status")
        finally:
            go_on.set()
            change.join()
        wait_until(lambda: said() == ["stands"], "its status")

    def test_embedded(self):
        rospy.set_param("~embedded", {"mesh_file": self.path})
        server = MeshMapServer("~embedded")
        self.addCleanup(server.shutdown)
        self.name = rospy.get_name()[1:] + "/embedded"
        with self.assertRaisesRegex(rospy.ServiceException, "no map is loaded"):
            rospy.ServiceProxy("/%s/get_uuids" % self.name, GetUUIDs)()
        server.load()
        server.publish_vector_field("vector_field", np.eye(COUNT, 3), np.arange(COUNT))
        server.publish_costs("Potential", np.arange(COUNT))
        layers = rospy.ServiceProxy(
            "/%s/get_vertex_cost_layers" % self.name, GetVertexCostLayers
        )().layers
        self.assertEqual(layers, [COMBINED_COSTS, "Potential"])
        stamp = rospy.Time.now()
        for number in (1, 2):
            place = [number, 2, 3]
            server.publish_marker("a", lambda place=place: sphere_marker("a", place, "map", stamp))
        never = []
        server.publish_marker(
            "a", lambda: never.append(1) or sphere_marker("a", [3, 2, 3], "map", stamp)
        )
        time.sleep(0.5)
        self.assertEqual(never, [])
        markers = self.subscribe("marker", Marker)
        fields = self.subscribe("vector_field", Marker)
        faces = self.subscribe("face_costs", arrays.MeshFaceCostsStamped)
        self.assertTrue(wait_until(lambda: markers.newest and fields.newest))
        self.assertEqual(markers.newest["a"].pose.position.x, 3)
        self.assertEqual(len(fields.newest["vector_field"].points), 6)
        self.assertTrue(wait_until(lambda: set(faces.newest) == {"slope"}))
        of_faces = partial(server.publish_vector_field, of_faces=True)
        for publish, arguments, words in (
            (server.publish_vector_field, (np.eye(3), np.zeros(COUNT)), "vectors for 121 vert"),
            (server.publish_vector_field, (np.eye(COUNT, 3), np.zeros(3)), "costs for 121 vert"),
            (of_faces, (np.eye(3), np.zeros(COUNT)), "vectors for 200 faces"),
            (of_faces, (np.eye(200, 3), np.zeros(3)), "costs for 121 vert"),
        ):
            with self.assertRaisesRegex(Exception, words):
                publish("x", *arguments)
        of_faces("face_vectors", np.eye(200, 3), np.arange(COUNT))
        self.assertTrue(wait_until(lambda: "face_vectors" in fields.newest))
        self.assertEqual(len(fields.newest["face_vectors"].points), 6)
        for name in ("face_vectors", "never"):
            server.remove_vectors(name)
        is_gone = lambda: fields.newest["face_vectors"].action == Marker.DELETE  # noqa: E731
        self.assertTrue(wait_until(is_gone))
        self.assertEqual(set(fields.newest), {"vector_field", "face_vectors"})

    def test_loaded_again(self):
        layers = [
            {"name": "border", "type": "mesh_layers/BorderLayer"},
            {"name": "inflation", "type": "mesh_layers/InflationLayer"},
        ]
        inflation = {"inflation_radius": 2.0}
        values = {"mesh_file": self.path, "layers": layers, "inflation": inflation}
        rospy.set_param("~again", dict(values, costs_period=3600.0))
        server = MeshMapServer("~again")
        self.addCleanup(server.shutdown)
        self.name = rospy.get_name()[1:] + "/again"
        before = server.load()
        fields = self.subscribe("vector_field", Marker)
        costs = self.subscribe("vertex_costs", arrays.MeshVertexCostsStamped)
        self.assertTrue(wait_until(lambda: "inflation" in fields.newest and len(costs.newest) == 3))
        before.set_layer_parameters("inflation", {"repulsive_field": False})
        before.set_layer_parameters("inflation", {"repulsive_field": True})

        listeners = []
        with mock.patch.object(before, "remove_listener", listeners.append):  # is just being called
            rospy.set_param("~again/global_frame", "hall")
            server.load()
        self.assertEqual(len(listeners), 1)
        frames = lambda: {marker.header.frame_id for marker in fields.newest.values()}  # noqa: E731
        self.assertTrue(wait_until(lambda: frames() == {"hall"}))
        name = "/%s/get_vertex_costs" % self.name
        asked = lambda: rospy.ServiceProxy(name, array_services.GetVertexCosts)(  # noqa: E731
            uuid="", layer="inflation"
        )
        now = asked().mesh_vertex_costs_stamped.mesh_vertex_costs.costs.copy()
        updates = self.subscribe("vertex_costs/updates", arrays.MeshVertexCostsSparseStamped)
        before.set_layer_parameters("inflation", {"lethal_value": 5.0, "inflation_radius": 0.5})
        server.map.set_layer_parameters("inflation", {"factor": 0.5})
        self.assertTrue(wait_until(lambda: updates.messages))
        self.assertEqual([m.type for m in updates.messages], [COMBINED_COSTS])
        found = asked().mesh_vertex_costs_stamped
        self.assertEqual(found.header.frame_id, "hall")
        np.testing.assert_array_equal(found.mesh_vertex_costs.costs, now)


if __name__ == "__main__":
    rospy.init_node("map_topics_check")
    rostest.rosrun("mesh_map", "map_topics_check", MapTopicsTest)
