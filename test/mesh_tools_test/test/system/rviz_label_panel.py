#!/usr/bin/python3
"""The real RViz, with mouse and keyboard: all buttons, menus, lists and dialogs of the panel of
labels, and what others see of it: the owner of the labels, the map, files, the picture."""
import numpy as np
import rospy
import rostest
from mesh_msgs.msg import MeshVertexCostsStamped
from mesh_msgs.srv import GetLabelColors
from mesh_msgs_hdf5.labels.label_tables import read_labels
from mesh_msgs_hdf5.map_file import MapFile

from mesh_tools_test.demo.processes import end_process, wait_until
from mesh_tools_test.screen.labelling import (
    BOX,
    GREEN,
    SERVED,
    SERVER,
    LabellingCase,
    flat_world,
    touching,
)
from mesh_tools_test.screen.widgets import Widgets

OTHER_BOX = np.array([[-3.85, -3.35], [-2.65, -2.15]])  # as BOX
THIRD_BOX = np.array([[-1.85, -3.85], [-0.65, -3.15]])
STEP = 2.75  # meters: where the ground rises, so that heights differ
BACKGROUND = (48, 48, 48)

# Of which nothing is seen.
COSTS = f"""
    - Class: rviz_mesh_plugin/TexturedMesh
      Name: Costs
      Enabled: true
      Value: true
      Geometry Topic: {SERVER}/mesh/geometry
      Display Type:
        Value: Vertex Costs
        Vertex Costs Topic: /costs
        Vertex Costs Type: ground
        Alpha: 0
        Legend: false
      Show Normals: {{Value: false}}
      Show Wireframe: {{Value: false}}
"""

LABELS = "rviz_mesh_plugin--ClusterLabelPanel"
BUTTONS = (
    "Label Cluster",
    "Reset Faces",
    "Select By",
    "Hide",
    "Isolate",
    "Show All",
    "Zoom To",
    "New",
    "Assign",
    "Add",
    "Take Away",
    "Select Faces",
    "Rename",
    "Merge",
    "Delete",
    "Color",
    "Class Color",
    "Import",
    "Export",
    "Save",
    "Send Again",
    "Give Up",
)
DIALOG_BUTTONS = (
    "OK",
    "Cancel",
    "Delete",
    "Import",
    "Save",
    "Open",
    "of Class",
    "Select",
    "Close",
)
LABEL_WIDGETS = Widgets(
    {
        **{text: f'{LABELS} > QPushButton[text^="{text}"]:enabled' for text in BUTTONS},
        "name": f"{LABELS} > QLineEdit",
        "list": f"{LABELS} > QTableView",
        "shown": f"{LABELS} > QTableView::indicator:checked",
        "hidden": f"{LABELS} > QTableView::indicator:unchecked",
        "class": f'{LABELS} > QDialog > QComboBox[editable="true"]',
        "instance": f"{LABELS} > QDialog > QLineEdit",
        "into": f"{LABELS} > QInputDialog QComboBox",
        "config: Discard": 'QMessageBox QPushButton[text*="Discard"]',
        "html": "QColorShower > QLineEdit, QtPrivate--QColorShower > QLineEdit",
        "file": "QFileDialog #fileNameEdit",
        "type": "QFileDialog #fileTypeCombo",
        **{
            f"dialog: {text}": f'{LABELS} > QDialog QPushButton[text*="{text}"]:enabled'
            for text in DIALOG_BUTTONS
        },
        **{
            f"by: {name}": f"{LABELS} > QDialog QComboBox#{name}"
            for name in ("kind", "combination", "layer", "values", "corners", "label")
        },
        **{
            f"{name}: {limit}": f"{LABELS} > QDialog #{name} QLineEdit#{limit}"
            for name in ("costs", "heights", "slopes")
            for limit in ("lower", "upper")
        },
    }
)
LAYER, HEIGHT, SLOPE, LABEL = 0, 1, 2, 3  # kinds of Select By
REPLACE, ADD, TAKE_AWAY, KEEP = 0, 1, 2, 3
ONE_CORNER = 1


def world_with_a_step():
    """Seen from above it is the flat one."""
    vertices, faces = flat_world()
    vertices[:, 2] = np.where(vertices[:, 0] > STEP, 1.0, 0.0)
    return vertices, faces


def extent(mask):
    """Columns and rows of the first and last pixel; None without any."""
    rows, columns = np.nonzero(mask)
    if len(rows) == 0:
        return None
    return np.array([[columns.min(), rows.min()], [columns.max() + 1, rows.max() + 1]])


def have(picture, color):
    """Pixels of this color."""
    return np.all(picture == color, axis=2)


def highlighted(picture):
    """Pixels of ground that is selected: between orange and the green below it."""
    red, green, blue = np.moveaxis(picture, 2, 0)
    return (150 < red) & (red < 200) & (150 < green) & (green < 200) & (blue < 20)


def fills(mask):
    """Whether what is there is seen wholly, in the middle, and with little around it."""
    corners, size = extent(mask), np.array(mask.shape[::-1])
    if corners is None or np.any(corners[0] == 0) or np.any(corners[1] == size):
        return False
    beside = np.abs(corners.mean(axis=0) - size / 2) / size
    return np.max((corners[1] - corners[0]) / size) > 0.6 and np.all(beside < 0.05)


class RvizLabelPanel(LabellingCase):
    """Panel ClusterLabel."""

    world = staticmethod(world_with_a_step)

    @classmethod
    def setUpClass(cls):
        rospy.init_node("rviz_label_panel")

    def setUp(self):
        super().setUp()
        self.labels = {}  # that are expected

    def touched(self, *boxes):
        """Faces that touch any of these."""
        found = [touching(self.vertices, self.faces, box) for box in boxes]
        return sorted(set().union(*found))

    def has(self, screen, **changed):
        """Waits until the owner of the labels has the ones expected, with these changes.

        :param changed: label -> faces, or None of one that is gone
        """
        for label, faces in changed.items():
            self.labels[label] = faces
            if faces is None:
                del self.labels[label]
        self.until_labels(screen, self.labels)

    def rows(self, screen):
        """Label -> where its row of the list is, once all are there."""
        rows = []

        def complete():
            rows[:] = screen.rows("shown", "hidden")
            return len(rows) == len(self.labels)

        wait_until(complete, 60, f"a list of {sorted(self.labels)}", [screen.child])
        return dict(zip(sorted(self.labels), rows))

    def in_list(self, screen, *labels, clicks=1):
        """Clicks at these: at the first alone, at more of them with Ctrl."""
        rows = self.rows(screen)
        column = screen.find("list").middle[0]
        for i, label in enumerate(labels):
            click = ["click", "--repeat", clicks, "--delay", 50, 1]
            if i:
                click = ["keydown", "ctrl", *click, "keyup", "ctrl"]
            place = column, rows[label].middle[1]
            screen.do("mousemove", *place, "sleep", 0.1, *click)

    def select(self, screen, box):
        """Adds the faces that touch it to the selection."""
        screen.drag(*self.pixels(screen, [(box[0, 0], box[1, 1]), (box[1, 0], box[0, 1])]))

    def select_by(self, screen, kind, combination=REPLACE, label=None, corners=None, **fields):
        """By the dialog, which is opened and closed."""
        screen.click("Select By")
        screen.choose("by: kind", kind)
        for name, text in fields.items():
            screen.fill(name, text)
        if label:
            screen.choose("by: label", sorted(self.labels).index(label))
        if corners is not None:
            screen.choose("by: values", 0)
            screen.choose("by: layer", 0)
            screen.choose("by: corners", corners)
        screen.choose("by: combination", combination)
        screen.click("dialog: Select")
        screen.click("dialog: Close")
        screen.wait_gone("dialog: Close")

    def name_it(self, screen, label):
        """In the dialog that asks for class and instance."""
        label_class, instance = label.split("_")
        screen.fill("class", label_class)
        screen.fill("instance", instance)
        screen.click_away("dialog: OK")

    def new(self, screen, label, faces):
        """Made by the button, of what is selected."""
        screen.click("New")
        self.name_it(screen, label)
        self.has(screen, **{label: faces})

    def colors(self):
        """Label -> color of its own, as the owner of the labels tells it."""
        answer = rospy.ServiceProxy(SERVER + "/get_label_colors", GetLabelColors)("")
        return {
            label: (round(255 * c.r), round(255 * c.g), round(255 * c.b))
            for label, c in zip(answer.labels, answer.colors)
        }

    def in_file(self):
        """Label -> faces, as the map has them."""
        return {text: one.faces.tolist() for text, one in MapFile(self.file).labels().items()}

    def test_every_button(self):
        """In the order in which somebody might need them."""
        server = self.serve()
        self.publish_costs("/costs")
        with self.rviz("panel", SERVED + COSTS, widgets=LABEL_WIDGETS) as screen:
            self.make(screen)
            self.select_by_criteria(screen)
            self.change(screen)
            self.rename_merge_and_delete(screen)
            self.color_and_zoom(screen)
            self.hide_and_isolate(screen)
            self.export_and_import(screen)
            self.work_without_server(screen, server)
            self.close_with_edits(screen)

    def publish_costs(self, topic):
        """A layer that is 1 on the higher ground, and 0 on the lower one."""
        costs = MeshVertexCostsStamped(uuid=MapFile(self.file).uuid, type="ground")
        costs.header.frame_id = "map"
        costs.mesh_vertex_costs.costs = self.vertices[:, 2]
        publisher = rospy.Publisher(topic, MeshVertexCostsStamped, queue_size=1, latch=True)
        self.stack.callback(publisher.unregister)
        publisher.publish(costs)

    def make(self, screen):
        """Label Cluster, Reset Faces, New."""
        self.until(
            screen,
            lambda: self.select(screen, BOX),
            lambda: screen.is_there("Reset Faces"),
            "selected faces",
        )
        screen.fill("name", "tree_1")
        screen.click("Label Cluster")
        self.has(screen, tree_1=self.touched(BOX))
        screen.click("Reset Faces")
        screen.wait_gone("Reset Faces")
        self.select(screen, OTHER_BOX)
        self.new(screen, "tree_2", self.touched(OTHER_BOX))

    def select_by_criteria(self, screen):
        """Select By..., in all ways to combine what is found with what is selected."""
        height = self.vertices[self.faces][:, :, 2].mean(axis=1)
        slanted = np.ptp(self.vertices[self.faces][:, :, 2], axis=1) > 0
        self.select_by(screen, HEIGHT, **{"heights: lower": "0.5", "heights: upper": ""})
        self.new(screen, "high_1", np.flatnonzero(height > 0.5).tolist())
        slopes = {"slopes: lower": "10", "slopes: upper": "80"}
        self.select_by(screen, SLOPE, **slopes)
        self.select_by(screen, HEIGHT, KEEP, **{"heights: lower": "", "heights: upper": "0.5"})
        self.new(screen, "slope_1", np.flatnonzero(slanted & (height < 0.5)).tolist())
        ground = {"costs: lower": "0.5", "costs: upper": "1"}
        self.select_by(screen, LAYER, corners=ONE_CORNER, **ground)
        slope = {"slopes: lower": "10", "slopes: upper": ""}
        self.select_by(screen, SLOPE, TAKE_AWAY, **slope)
        self.new(screen, "flat_1", np.flatnonzero(~slanted & (height > 0.5)).tolist())
        screen.do("mousemove", *screen.middle().astype(int), "key", "ctrl+z")
        self.has(screen, flat_1=None)
        screen.click("Reset Faces")
        self.select_by(screen, LABEL, label="tree_1")
        self.select_by(screen, LABEL, ADD, label="tree_2")
        self.select_by(screen, LABEL, ADD, label="high_1")
        self.select_by(screen, LABEL, TAKE_AWAY, label="high_1")
        self.new(screen, "tree_3", self.touched(BOX, OTHER_BOX))

    def change(self, screen):
        """Add, Take Away, Assign, Select Faces, the keys of undo and redo, and the list."""
        both = self.touched(BOX, OTHER_BOX)
        self.select(screen, THIRD_BOX)
        self.in_list(screen, "tree_3")
        screen.click("Add")
        self.has(screen, tree_3=self.touched(BOX, OTHER_BOX, THIRD_BOX))
        screen.click("Take Away")
        self.has(screen, tree_3=both)
        screen.click("Assign")
        self.has(screen, tree_3=self.touched(THIRD_BOX))
        self.in_list(screen, "tree_3")
        screen.do("key", "ctrl+z")
        self.has(screen, tree_3=both)
        screen.do("key", "ctrl+y")
        self.has(screen, tree_3=self.touched(THIRD_BOX))
        screen.do("key", "ctrl+z")
        self.has(screen, tree_3=both)
        screen.do("key", "ctrl+shift+z")
        self.has(screen, tree_3=self.touched(THIRD_BOX))
        screen.click("Reset Faces")
        self.in_list(screen, "tree_1")
        screen.click("Select Faces")
        self.in_list(screen, "tree_2")
        screen.click("Add")
        self.has(screen, tree_2=both)
        screen.click("Reset Faces")
        self.in_list(screen, "slope_1", clicks=2)  # selects its faces
        self.in_list(screen, "tree_3")
        screen.click("Assign")
        self.has(screen, tree_3=self.labels["slope_1"])

    def rename_merge_and_delete(self, screen):
        """Each by its dialog, of which one is also given up."""
        self.in_list(screen, "tree_1")
        screen.click("Rename")
        self.name_it(screen, "bush_7")
        self.has(screen, tree_1=None, bush_7=self.touched(BOX))
        screen.wait_gone("Rename")  # the list has followed
        self.in_list(screen, "bush_7", "tree_3")
        screen.click("Merge")
        screen.choose("into", 1)
        screen.click_away("dialog: OK")
        merged = sorted({*self.labels["bush_7"], *self.labels["tree_3"]})
        self.has(screen, bush_7=None, tree_3=merged)
        self.in_list(screen, "slope_1")
        screen.click("Delete")
        screen.click_away("dialog: Cancel")
        screen.wait_gone("dialog: Cancel")
        screen.click("Delete")
        screen.click("dialog: Delete")
        self.has(screen, slope_1=None)

    def color_it(self, screen, button, color, expected):
        """By one of the two buttons. A color, or that of the class."""
        screen.click(button)
        if color:
            screen.fill("html", color)
            screen.click_away("dialog: OK")
        else:
            screen.click("dialog: of Class")
        wait_until(lambda: self.colors() == expected, 60, f"the colors {expected}", [screen.child])

    def seen(self, screen, condition, what):
        """Waits until the picture of the map is as the condition says."""
        wait_until(lambda: any(map(condition, screen.pictures())), 60, what, [screen.child])

    def color_and_zoom(self, screen):
        """Color, Class Color, the boxes of the list, Zoom To."""
        blue = (0, 0, 255)
        screen.click("Reset Faces")
        self.select(screen, THIRD_BOX)
        self.in_list(screen, "tree_3")
        self.color_it(screen, "Class Color", "#0000ff", {"tree_2": blue, "tree_3": blue})
        self.color_it(screen, "Color", None, {"tree_2": blue})
        self.seen(screen, lambda picture: have(picture, blue).any(), "a blue label")
        rows = self.rows(screen)
        screen.do("mousemove", *rows["tree_2"].middle, "click", 1)
        self.seen(screen, lambda p: have(p, GREEN).any() and not have(p, blue).any(), "it hidden")
        screen.do("click", 1)
        self.seen(screen, lambda picture: have(picture, blue).any(), "it shown")
        screen.do("mousemove", *rows["tree_3"].middle, "click", 1)  # lies over the other one

        self.in_list(screen, "tree_2")
        screen.choose_in_menu("Zoom To", "l")
        self.seen(screen, lambda picture: fills(have(picture, blue)), "all of it")
        screen.choose_in_menu("Zoom To", "m")
        self.seen(screen, lambda p: fills(~have(p, BACKGROUND)), "the whole mesh")
        screen.choose_in_menu("Zoom To", "s")
        self.seen(screen, lambda picture: fills(highlighted(picture)), "the selection")

    def hide_and_isolate(self, screen):
        """Isolate, Hide, Show All, and Ctrl+Z, of the selection that the view is on."""
        screen.click("Isolate")
        self.seen(screen, lambda p: fills(highlighted(p)) and not have(p, GREEN).any(), "it alone")
        screen.click("Show All")
        self.seen(screen, lambda p: have(p, GREEN).any(), "what is around it")
        screen.click("Hide")
        self.seen(screen, lambda p: fills(have(p, BACKGROUND)), "a hole")
        screen.click("Show All")
        self.seen(screen, lambda p: not have(p, BACKGROUND).any(), "no hole")
        screen.do("key", "ctrl+z", "ctrl+z")
        self.seen(screen, lambda picture: fills(highlighted(picture)), "the selection as before")

    def export_and_import(self, screen):
        """Export, Import, Save."""
        as_json, as_csv = self.folder / "labels.json", self.folder / "labels.csv"
        for index, path in enumerate((as_json, as_csv)):
            screen.click("Export")
            screen.choose("type", index)
            screen.fill("file", path.with_suffix(""))  # that comes from the type
            screen.click_away("dialog: Save")
            wait_until(path.exists, 60, str(path), [screen.child])
            screen.wait_gone("file")
        for path in (as_json, as_csv):
            _, exported = read_labels(path, len(self.faces))
            told = {label: one.faces.tolist() for label, one in exported.items()}
            self.assertEqual(told, self.labels)
            self.assertEqual(exported["tree_2"].color, (0, 0, 255))
        before = dict(self.labels)
        self.in_list(screen, "tree_2")
        screen.click("Delete")
        screen.click("dialog: Delete")
        self.has(screen, tree_2=None)
        self.in_list(screen, "tree_3")
        screen.click("Add")
        self.has(screen, tree_3=sorted({*before["tree_3"], *self.touched(THIRD_BOX)}))
        screen.click("Import")
        screen.fill("file", as_json)
        screen.click_away("dialog: Open")
        screen.click("dialog: Import")  # it replaces a label
        self.has(screen, **before)
        screen.click("Save")
        wait_until(lambda: self.in_file() == before, 60, "labels in the map", [screen.child])

    def work_without_server(self, screen, server):
        """Give Up, Send Again."""
        before = dict(self.labels)
        end_process(server[1])
        self.in_list(screen, "tree_2")
        screen.click("Add")
        screen.click("Give Up")
        screen.wait_gone("Give Up")
        self.in_list(screen, "tree_3")
        screen.click("Add")
        screen.find("Send Again")
        self.serve()
        self.has(screen)
        # Again, as long as RViz is not connected to the new server.
        self.labels["tree_3"] = sorted({*before["tree_3"], *self.touched(THIRD_BOX)})
        self.until(
            screen,
            lambda: screen.is_there("Send Again") and screen.click("Send Again"),
            lambda: self.clusters() == self.labels,
            "stored faces",
        )

    def close_with_edits(self, screen):
        """Ctrl+Q, Save; RViz itself asks about its configuration. What the last step has stored may
        not have come back yet: the new server may not be connected to RViz in both ways."""
        screen.do("key", "ctrl+q")
        screen.click_away("dialog: Save")
        screen.click("config: Discard")
        self.assertEqual(screen.child[1].wait(timeout=60), 0)
        self.assertEqual(self.in_file(), self.labels)


if __name__ == "__main__":
    rostest.rosrun("mesh_tools_test", "rviz_label_panel", RvizLabelPanel)
