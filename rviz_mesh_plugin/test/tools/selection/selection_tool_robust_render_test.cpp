#include <rviz/config.h>
#include <rviz/tool_manager.h>

#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"
#include "support/label_display_fixture.h"

using rviz_mesh_plugin::ClusterLabelTool;
using rviz_mesh_plugin::FaceSelection;
using rviz_mesh_plugin::SurfaceIndex;

class SelectionToolRobustTest : public SelectionToolFixture
{
 protected:
  void useAll()
  {
    for (const int mode : {Qt::Key_1, Qt::Key_2, Qt::Key_3, Qt::Key_4}) {
      key(mode);
      click({320, 240});
      drag({{250, 180}, {390, 180}, {390, 300}});
      drag({{250, 180}, {390, 300}}, Qt::RightButton);
      drag({{250, 180}, {390, 300}}, Qt::LeftButton, Qt::ControlModifier);
      drag({{250, 180}, {390, 300}}, Qt::RightButton, Qt::ControlModifier);
    }
    key(Qt::Key_1);
    for (const int code : {Qt::Key_Plus, Qt::Key_Minus, Qt::Key_Delete, Qt::Key_Return}) {
      key(code);
    }
    for (const int code : {Qt::Key_A, Qt::Key_I, Qt::Key_Z, Qt::Key_Y, Qt::Key_T, Qt::Key_B}) {
      key(code, Qt::ControlModifier);
    }
    key(Qt::Key_T, Qt::ControlModifier);
    key(Qt::Key_B, Qt::ControlModifier);
  }

  void look()
  {
    lookAt({3, -2, 2.5}, {0.3, -0.2, 0.4});
    spinFrames();
  }

  const Pixel A{250, 180}, B{390, 300};
};

TEST_F(SelectionToolRobustTest, without_a_mesh_it_says_so)
{
  look();
  const auto refuses = [&] {
    click({320, 240});
    EXPECT_TRUE(says("No mesh is shown")) << said.toStdString();
    drag({A, B});
    EXPECT_TRUE(says("No mesh is shown")) << said.toStdString();
    drag({A, B}, Qt::LeftButton, Qt::ControlModifier);
    EXPECT_TRUE(says("No mesh is shown")) << said.toStdString();
    key(Qt::Key_A, Qt::ControlModifier);
    EXPECT_TRUE(says("Nothing has been selected yet")) << said.toStdString();
    useAll();
    EXPECT_EQ(tool->mesh(), nullptr);
    EXPECT_TRUE(tool->selection().empty());
  };
  refuses();
  createMeshDisplay();
  refuses();
  EXPECT_NE(tool->select(nullptr, {1}), "");
  EXPECT_NE(tool->select(std::make_shared<rviz_mesh_plugin::MeshData>(), {1}), "");
  tool->clearSelection();
  auto event = mouse(320, 240, QEvent::MouseButtonPress, Qt::LeftButton);
  event.viewport = nullptr;
  EXPECT_EQ(tool->processMouseEvent(event), 0);
  EXPECT_EQ(tool->processKeyEvent(nullptr, nullptr), 0);
}

TEST_F(SelectionToolRobustTest, a_mesh_that_is_not_prepared)
{
  look();
  Display* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(250, [](double x, double) { return 0.1 * x; })));
  SurfaceIndex::instance().clear();
  press({320, 240});
  release({320, 240});
  EXPECT_TRUE(says("is being prepared")) << said.toStdString();
  SurfaceIndex::instance().clear();
  drag({A, B});
  EXPECT_TRUE(says("is being prepared")) << said.toStdString();
  waitUntilPrepared();
  key(Qt::Key_3);
  SurfaceIndex::instance().clear();
  waitUntilPrepared();
  click({320, 240});
  EXPECT_TRUE(says("try again") || tool->busy()) << said.toStdString();
  key(Qt::Key_Escape);
  key(Qt::Key_1);
  click({320, 240});
  EXPECT_EQ(selected().size(), 1u);
  EXPECT_TRUE(says("1 face is selected")) << said.toStdString();
}

TEST_F(SelectionToolRobustTest, a_mesh_replaced_or_deleted_while_dragging)
{
  Display* display = showTerrain();
  look();
  for (const bool deleted : {false, true}) {
    drag({A, B});
    ASSERT_FALSE(selected().empty());
    int changes = 0;
    const auto connection =
        QObject::connect(tool.get(), &ClusterLabelTool::selectionChanged, [&] { ++changes; });
    press({300, 240}, Qt::LeftButton, Qt::ControlModifier);
    move({310, 245}, Qt::ControlModifier);
    changes = 0;
    if (deleted) {
      delete display;
    } else {
      ASSERT_TRUE(show(display, test_meshes::terrain(7, [](double, double) { return 0.2; })));
      waitUntilPrepared();
    }
    EXPECT_NO_FATAL_FAILURE(move({320, 250}, Qt::ControlModifier));
    spinFrames();
    EXPECT_EQ(tool->mesh(), nullptr);
    EXPECT_TRUE(tool->selection().empty());
    EXPECT_GT(changes, 0) << "who follows the selection is told";
    EXPECT_TRUE(says("The mesh is gone of which")) << said.toStdString();
    move({330, 250}, Qt::ControlModifier);
    release({330, 250}, Qt::ControlModifier);
    EXPECT_TRUE(tool->selection().empty()) << "the rest of the stroke is ignored";
    EXPECT_FALSE(tool->visual()->mesh());
    QObject::disconnect(connection);
    useAll();
    ASSERT_TRUE(settle());
  }
}

TEST_F(SelectionToolRobustTest, gives_up_what_is_looked_for_when_the_mesh_is_replaced)
{
  Display* display = showTerrain(100);
  look();
  choose("Selection", "Visible Only");
  drag({{100, 60}, {540, 420}});
  ASSERT_TRUE(tool->busy());
  press(A);
  EXPECT_TRUE(says("Looking which faces are seen")) << said.toStdString();
  release(B);
  key(Qt::Key_Escape);
  EXPECT_FALSE(tool->busy());
  EXPECT_TRUE(says("Given up")) << said.toStdString();
  drag({{100, 60}, {540, 420}});
  delete display;
  ASSERT_TRUE(settle());
  spinFrames();
  EXPECT_EQ(tool->mesh(), nullptr);
  EXPECT_TRUE(says("The mesh is gone")) << said.toStdString();
  drag({{100, 60}, {540, 420}}, Qt::LeftButton, Qt::ControlModifier);
  tool.reset();  // in the middle of anything
}

TEST_F(SelectionToolRobustTest, the_selection_and_its_undo_outlive_reset_and_time_that_jumps_back)
{
  Display* display = showTerrain();
  look();
  drag({A, B});
  const Faces first = selected();
  drag({{350, 200}, {450, 330}});
  const Faces second = selected();
  key(Qt::Key_Delete);
  key(Qt::Key_Z, Qt::ControlModifier);
  ASSERT_GT(second.size(), first.size());
  for (const bool time_jumps : {false, true}) {
    if (time_jumps) {
      manager()->resetTime();
    } else {
      display->reset();
    }
    EXPECT_FALSE(display->mesh()) << "it is gone, for now";
    ASSERT_TRUE(spinUntil([&] {
      return display->mesh() && tool->mesh() == display->mesh() && selected() == second;
    })) << selected().size()
        << " of " << second.size() << ": " << said.toStdString();
    EXPECT_EQ(tool->visual()->mesh(), display->mesh());
    key(Qt::Key_Z, Qt::ControlModifier);
    EXPECT_EQ(selected(), first);
    key(Qt::Key_Y, Qt::ControlModifier);
    EXPECT_EQ(selected(), second);
    EXPECT_TRUE(tool->selection().canRedo()) << "that all of it was deselected";
  }
  auto other = test_meshes::terrain(20, [](double, double) { return 0.1; });
  ASSERT_TRUE(show(display, other)) << "of the same name, with as many faces";
  ASSERT_TRUE(spinUntil([&] { return selected().empty(); }));
  EXPECT_FALSE(tool->selection().canUndo());
  delete display;
  spinFrames();
  EXPECT_EQ(tool->mesh(), nullptr) << "nothing is waited for, nor kept in memory";
}

TEST_F(SelectionToolRobustTest, the_selection_outlives_other_tools_and_hiding)
{
  Display* display = showTerrain();
  look();
  tool->update(0.03f, 0.03f);
  EXPECT_EQ(tool->visual()->mesh(), shown().mesh) << "so that the first click shows at once";
  drag({A, B});
  const Faces before = selected();
  press({320, 240});
  move({420, 340});
  tool->deactivate();
  said.clear();
  spinFrames();
  EXPECT_TRUE(said.isEmpty()) << "the status bar is the other tool's";
  release({420, 340});
  display->setEnabled(false);
  spinFrames();
  EXPECT_EQ(selected(), before);
  tool->activate();
  drag({A, B}, Qt::RightButton);
  EXPECT_TRUE(says("is not shown")) << said.toStdString();
  display->setEnabled(true);
  spinFrames();
  drag({A, B}, Qt::RightButton);
  EXPECT_TRUE(tool->selection().empty());
  EXPECT_EQ(tool->select(picker.meshes().at(0).mesh, {3, 1}), "");
  EXPECT_EQ(selected(), (Faces{1, 3}));
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(tool->selection().empty());
}

TEST_F(SelectionToolRobustTest, another_mesh_gets_a_selection_of_its_own)
{
  showTerrain();
  drag({A, B});
  auto other = test_meshes::terrain(4, [](double, double) { return 2.0; });
  other.uuid = "other";
  geometry_topic += "_other";
  geometry = node.advertise<mesh_msgs::MeshGeometryStamped>(geometry_topic, 10, true);
  ASSERT_TRUE(show(createMeshDisplay(), other));
  waitUntilPrepared();
  click({320, 240});
  ASSERT_TRUE(tool->mesh());
  EXPECT_EQ(tool->mesh()->uuid, "other") << "it is above the first";
  EXPECT_TRUE(says("This is another mesh")) << said.toStdString();
  EXPECT_EQ(selected().size(), 1u);
}

TEST_F(SelectionToolRobustTest, takes_the_faces_of_a_label)
{
  LabelServer server("/robust_labels");
  auto* labels =
      createDisplayAs<rviz_mesh_plugin::ClusterLabelDisplay>("rviz_mesh_plugin/ClusterLabel");
  set(labels, {"Geometry Topic"}, geometry_topic.c_str());
  set(labels, {"Labels Topic"}, "/robust_labels/new_cluster_label");
  showTerrain();
  look();
  const auto hit = picker.pick(mouse(320, 240)).hit;
  ASSERT_TRUE(hit);
  const auto mesh = shown().mesh;
  Faces wall{2, hit->face, 5};
  std::sort(wall.begin(), wall.end());
  // Else what the server says it has, which is nothing, may come after them.
  ASSERT_TRUE(spinUntil([&] { return labels->labelsComplete(); }));
  server.labels.publish(LabelServer::cluster("wall_1", wall));
  server.labels.publish(LabelServer::cluster("roof_1", {7, 8}));
  ASSERT_TRUE(spinUntil([&] { return labels->labels().size() == 2u; }));
  key(Qt::Key_4);
  click({320, 240});
  EXPECT_EQ(selected(), wall);
  click({320, 240}, Qt::RightButton);
  EXPECT_TRUE(selected().empty());
  set(labels, {"Brush Size"}, 0.25);
  spinFrames();
  tool->update(0.0f, 0.0f);
  auto* radius = tool->getPropertyContainer()->subProp("Brush Radius");
  EXPECT_EQ(radius->getValue().toDouble(), 0.25) << "the brush is also a property of the display";
  radius->setValue(0.5);
  tool->update(0.0f, 0.0f);
  EXPECT_EQ(radius->getValue().toDouble(), 0.5) << "where only the tool's has changed";
  labels->setEnabled(false);
  click({320, 240});
  EXPECT_TRUE(says("This face has no label")) << said.toStdString();
}

TEST_F(SelectionToolRobustTest, camera_keys_and_configuration)
{
  showTerrain();
  look();
  const auto moves = [&](const std::function<void()>& act) {
    const Ogre::Vector3 before = camera()->getDerivedPosition();
    const Ogre::Quaternion turned = camera()->getDerivedOrientation();
    act();
    spinFrames();
    return camera()->getDerivedPosition() != before || camera()->getDerivedOrientation() != turned;
  };
  EXPECT_FALSE(moves([&] { drag({A, B}); }));
  const Faces before = selected();
  EXPECT_TRUE(moves([&] { drag({A, B}, Qt::MiddleButton); }));
  EXPECT_TRUE(moves([&] { wheel(A, 120, Qt::NoModifier); }));
  const Ogre::Quaternion turned = camera()->getDerivedOrientation();
  EXPECT_TRUE(moves([&] { drag({A, B}, Qt::LeftButton, Qt::ShiftModifier); }));
  EXPECT_NE(camera()->getDerivedOrientation(), turned) << "as left alone does in Interact";
  EXPECT_FALSE(moves([&] { wheel(A, 240, Qt::ControlModifier); }));
  EXPECT_EQ(selected(), before);
  choose("Mode", "Flood");
  rviz::Config config;
  tool->save(config);
  ClusterLabelTool other;
  other.load(config);
  EXPECT_EQ(other.getPropertyContainer()->subProp("Mode")->getValue().toString(), "Flood");
  EXPECT_NEAR(other.getPropertyContainer()->subProp("Brush Radius")->getValue().toDouble(), 1.21,
              1e-5);

  int requested = 0;
  QObject::connect(tool.get(), &ClusterLabelTool::labelRequested, [&] { ++requested; });
  key(Qt::Key_Return);
  key(Qt::Key_Delete);
  key(Qt::Key_Enter);
  EXPECT_EQ(requested, 1) << "not without faces";
  auto* tools = manager()->getToolManager();
  rviz::Tool* before_keys = tools->getCurrentTool();
  ASSERT_TRUE(before_keys);
  tools->setCurrentTool(tools->getTool(0));
  const Faces all_others = selected();
  key(Qt::Key_I, Qt::ControlModifier);
  EXPECT_EQ(tools->getCurrentTool(), tools->getTool(0));
  EXPECT_EQ(selected().size(), shown().mesh->faceCount() - all_others.size());
  key(Qt::Key_I);
  EXPECT_EQ(tools->getCurrentTool()->getClassId(), "rviz/Interact");
  rviz::Tool* goal = tools->addTool("rviz_mesh_plugin/MeshGoal");
  ASSERT_TRUE(goal);
  key(Qt::Key_M);
  EXPECT_EQ(tools->getCurrentTool(), goal) << "of several tools with one key, the last one";
  tools->setCurrentTool(before_keys);
  tools->removeTool(tools->numTools() - 1);
}
