// The dialog that selects by layer, height, slope and label.
#include <cmath>
#include <limits>
#include <string>

#include <geometry_msgs/TransformStamped.h>
#include <mesh_msgs/LayerInfoArray.h>
#include <ros/names.h>
#include <rviz/frame_manager.h>
#include <rviz/visualization_manager.h>
#include <tf2_ros/buffer.h>
#include <QComboBox>
#include <QLineEdit>

#include <gtest/gtest.h>

#include "base/hidden_faces.h"
#include "label_panel_fixture.h"

class SelectByDialogTest : public LabelPanelFixture
{
 protected:
  void openDialog()
  {
    start();
    openNow();
  }

  void openNow()
  {
    ASSERT_TRUE(spinUntil([&] { return button("Select By…")->isEnabled(); }));
    click("Select By…");
    asked = dialog<QDialog>();
    ASSERT_TRUE(asked);
  }

  QComboBox* box(const char* name) { return asked->findChild<QComboBox*>(name); }

  void pick(const char* name, int item)
  {
    ASSERT_LT(item, box(name)->count()) << name;
    box(name)->setCurrentIndex(item);
  }

  void range(const char* fields, const QString& lower, const QString& upper)
  {
    auto* widget = asked->findChild<QWidget*>(fields);
    widget->findChild<QLineEdit*>("lower")->setText(lower);
    widget->findChild<QLineEdit*>("upper")->setText(upper);
  }

  void pressSelect()
  {
    for (auto* button : asked->findChildren<QPushButton*>()) {
      if (button->text().remove('&') == "Select") {
        button->click();
      }
    }
  }

  Faces selectedNow()
  {
    pressSelect();
    EXPECT_TRUE(spinUntil([&] { return !tool->busy(); }));
    return tool->selection().faces();
  }

  void publishCosts()
  {
    // Rows of vertices, from 0 to 1; the last but one is lethal, the last one unknown.
    std::vector<float> values;
    for (int i = 0; i < 121; ++i) {
      const int row = i / 11;
      values.push_back(row == 9    ? std::numeric_limits<float>::infinity()
                       : row == 10 ? std::numeric_limits<float>::quiet_NaN()
                                   : 0.1f * row);
    }
    costs.publish(test_meshes::costs("slope", values));
    info = node.advertise<mesh_msgs::LayerInfoArray>(
        ros::names::parentNamespace(geometry_topic) + "/layer_info", 1, true);
    mesh_msgs::LayerInfoArray message;
    message.uuid = "mesh";
    message.layers.resize(1);
    message.layers[0].name = "slope";
    message.layers[0].layer_type = "mesh_layers/SteepnessLayer";
    message.layers[0].unit = "rad";
    message.layers[0].infinity = "lethal";
    message.layers[0].comparison = mesh_msgs::LayerInfo::ABOVE;
    message.layers[0].threshold = 0.65f;
    info.publish(message);
    ASSERT_TRUE(spinUntil([&] { return box("values")->itemText(1).contains("0.65 rad"); }))
        << box("values")->itemText(1).toStdString() << text();
  }

  QDialog* asked = nullptr;
  ros::Publisher info;
};

TEST_F(SelectByDialogTest, selects_by_the_values_of_a_layer)
{
  openDialog();
  EXPECT_TRUE(shows("No cost layer of the mesh has arrived"));
  EXPECT_TRUE(selectedNow().empty());
  EXPECT_TRUE(shows("No cost layer of the mesh has arrived.")) << "said also when pressed";
  publishCosts();
  EXPECT_TRUE(shows("121 values: 99 finite, 11 +inf, 11 unknown."));
  range("costs", "0.15", "0.45");
  // Vertices of rows 2 to 4: the faces of rows 2 and 3 have all corners there.
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 2, 4));
  EXPECT_TRUE(shows("40 of 200 faces are selected"));
  keep(asked, "select_by_layer");
  pick("corners", 1);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 1, 5));
  range("costs", "", "0.05");
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 0, 1));
  pick("values", 1);  // above 0.65: rows 7 to 9
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 6, 10));
  pick("corners", 0);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 7, 9));
  pick("values", 2);
  EXPECT_TRUE(selectedNow().empty()) << "no face is unknown at all corners";
  EXPECT_TRUE(shows("the mesh has no such faces"));
  pick("corners", 1);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 9, 10));
  pick("values", 0);
  range("costs", "much", "");
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 9, 10)) << "as before";
  EXPECT_TRUE(shows("'much' is no number"));
  range("costs", "2", "1");
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 9, 10));
  EXPECT_TRUE(shows("turn them round"));
}

TEST_F(SelectByDialogTest, selects_by_height_and_slope)
{
  server->addLabel("tree_1", test_labels::rows(10, 0, 1));
  createMeshDisplay();
  display = createLabels();
  // A floor, a ramp of 45 degrees that begins at y = 0, by rows.
  geometry.publish(test_meshes::terrain(10, [](double, double y) { return std::max(0.0, y); }));
  createPanel();
  openNow();
  pick("kind", 1);
  range("heights", "-0.1", "0.01");
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 0, 5));
  keep(asked, "select_by_height");
  pick("kind", 2);
  range("slopes", "40", "50");
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 5, 10));
  pick("kind", 1);
  range("heights", "", "0.4");
  pick("combination", 3);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 5, 7)) << "the lower part of the ramp";
  pick("combination", 1);
  range("heights", "0.8", "");
  EXPECT_EQ(selectedNow().size(), 60u);
  pick("combination", 2);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 5, 7));
}

TEST_F(SelectByDialogTest, heights_are_those_in_the_fixed_frame)
{
  // On its side, and 2 m up: what is y in the mesh points up.
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "map";
  transform.header.stamp = ros::Time::now();
  transform.child_frame_id = "lifted";
  transform.transform.translation.z = 2.0;
  transform.transform.rotation.x = transform.transform.rotation.w = std::sqrt(0.5);
  manager()->getFrameManager()->getTF2BufferPtr()->setTransform(transform, "test", true);
  server->addLabel("tree_1", test_labels::rows(10, 0, 1));
  createMeshDisplay();
  display = createLabels();
  mesh_msgs::MeshGeometryStamped mesh = test_meshes::terrain(10, [](double, double) { return 0; });
  mesh.header.frame_id = "lifted";
  geometry.publish(mesh);
  createPanel();
  openNow();
  pick("kind", 1);
  range("heights", "2", "");  // y from 0
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 5, 10));
  range("heights", "", "1.41");  // y up to -0.59 m
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 0, 2));
}

TEST_F(SelectByDialogTest, selects_by_label_and_follows_the_labels)
{
  openDialog();
  pick("kind", 3);
  ASSERT_TRUE(spinUntil([&] { return box("label")->count() == 3; }));
  pick("label", 1);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 1, 2));
  pick("combination", 1);
  pick("label", 2);
  EXPECT_EQ(selectedNow(), test_labels::rows(10, 1, 3));
  server->labels.publish(LabelServer::cluster("bush_1", {150}));
  ASSERT_TRUE(spinUntil([&] { return box("label")->count() == 4; }));
  EXPECT_EQ(box("label")->currentText(), "wall_1") << "what is chosen stays";
  keep(asked, "select_by_label");
  keep(panel, "label_panel_select_by");
  ASSERT_TRUE(showGarden());
  EXPECT_TRUE(spinUntil([&] { return box("label")->count() == 0; }));
  EXPECT_TRUE(shows("The mesh has no labels"));
}

TEST_F(SelectByDialogTest, outlives_its_tool_and_goes_with_the_panel)
{
  openDialog();
  tool.reset();
  EXPECT_TRUE(shows("The tool ClusterLabel is gone"));
  pressSelect();
  window.reset();
  spinFrames();
}

TEST_F(SelectByDialogTest, buttons_beside_it_hide_isolate_and_show)
{
  start();
  const auto mesh = display->mesh();
  const auto hidden = [&] {
    const auto faces = rviz_mesh_plugin::hiddenFaces(*mesh);
    return faces ? faces->bits().faces() : Faces();
  };
  ASSERT_TRUE(spinUntil([&] {
    refresh();
    return button("Show All")->toolTip().contains("no face is hidden");
  }));
  for (const char* name : {"Hide", "Isolate"}) {
    EXPECT_FALSE(button(name)->isEnabled());
    EXPECT_TRUE(button(name)->toolTip().contains("nothing is selected"));
  }
  EXPECT_FALSE(button("Show All")->isEnabled());
  ASSERT_TRUE(select(test_labels::rows(10, 3, 5)));
  click("Hide");
  ASSERT_TRUE(spinUntil([&] { return !hidden().empty(); }));
  EXPECT_EQ(hidden(), test_labels::rows(10, 3, 5));
  EXPECT_TRUE(tool->selection().empty());
  refresh();
  click("Show All");
  EXPECT_TRUE(spinUntil([&] { return hidden().empty(); }));
  ASSERT_TRUE(select(test_labels::rows(10, 0, 1)));
  click("Isolate");
  ASSERT_TRUE(spinUntil([&] { return !hidden().empty(); }));
  EXPECT_EQ(hidden(), test_labels::rows(10, 1, 10));
  EXPECT_EQ(tool->selection().faces(), test_labels::rows(10, 0, 1));
  // All of a label, so that nothing of it is lost where it is assigned again.
  refresh();
  EXPECT_TRUE(shows("180 faces are hidden")) << text();
  choose({2});  // wall_1: the third row, which is hidden
  click("Select Faces");
  ASSERT_TRUE(spinUntil([&] { return !tool->busy(); }));
  EXPECT_EQ(tool->selection().faces(), test_labels::rows(10, 2, 3));
  keep(window.get(), "panel_hidden");
  click("Show All");
  EXPECT_TRUE(spinUntil([&] { return hidden().empty(); }));
}
