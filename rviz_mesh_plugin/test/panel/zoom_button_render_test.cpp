#include "panel/zoom_button.h"

#include <rviz/properties/vector_property.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <QMenu>

#include "base/hidden_faces.h"
#include "label_panel_fixture.h"

using rviz_mesh_plugin::ZoomButton;

class ZoomButtonTest : public LabelPanelFixture
{
 protected:
  void zoom(int what) { panel->findChild<ZoomButton*>()->menu()->actions().at(what)->trigger(); }
  static Ogre::Vector3 focus()
  {
    const auto* view = manager()->getViewManager()->getCurrent();
    return static_cast<rviz::VectorProperty*>(
               const_cast<rviz::ViewController*>(view)->subProp("Focal Point"))
        ->getVector();
  }
  static float away()
  {
    return const_cast<rviz::ViewController*>(manager()->getViewManager()->getCurrent())
        ->subProp("Distance")
        ->getValue()
        .toFloat();
  }
  testing::AssertionResult looksAt(double x, double y)
  {
    const bool done = spinUntil(
        [&] { return (focus() - Ogre::Vector3(float(x), float(y), 0)).length() < 1e-4f; });
    return done ? testing::AssertionSuccess()
                : testing::AssertionFailure() << focus().x << " " << focus().y << " " << focus().z;
  }
};

TEST_F(ZoomButtonTest, moves_the_camera_to_labels_the_selection_and_the_mesh)
{
  start();
  std::string said;
  QObject guard;
  QObject::connect(manager(), &rviz::VisualizationManager::statusUpdate, &guard,
                   [&](const QString& text) { said = text.toStdString(); });
  refresh();
  EXPECT_TRUE(panel->findChild<ZoomButton*>()->isEnabled());
  lookAt({5, -4, 9}, {3, 3, 0});
  spinFrames();
  const float before = away();
  zoom(1);
  EXPECT_EQ(said, "No label is chosen in the list: choose one to zoom to it");
  zoom(2);
  EXPECT_EQ(said, "No face of this mesh is selected: select some to zoom to them");
  EXPECT_EQ(away(), before);
  list()->selectRow(2);  // wall_1: the third of ten rows of the square [-1, 1]²
  zoom(1);
  EXPECT_EQ(away(), before) << "its faces are looked through on a thread";
  EXPECT_TRUE(looksAt(0.0, -0.5));
  const float near = away();
  zoom(0);
  EXPECT_TRUE(looksAt(0.0, 0.0));
  EXPECT_GT(away(), near);
  EXPECT_LT(away(), 6.0f);
}

TEST_F(ZoomButtonTest, moves_the_camera_to_what_is_not_hidden)
{
  start();
  std::string said;
  QObject guard;
  QObject::connect(manager(), &rviz::VisualizationManager::statusUpdate, &guard,
                   [&](const QString& text) { said = text.toStdString(); });
  lookAt({5, -4, 9}, {3, 3, 0});
  const auto mesh = display->mesh();
  const auto hide = [&](const Faces& faces) {
    rviz_mesh_plugin::setHiddenFaces(*mesh,
                                     std::make_shared<const rviz_mesh_plugin::HiddenFaces>(
                                         rviz_mesh_plugin::FaceBits(mesh->faceCount(), faces)));
  };
  hide(test_labels::rows(10, 2, 10));
  zoom(0);
  EXPECT_TRUE(looksAt(0.0, -0.8)) << "the first two of ten rows";
  list()->selectRow(2);  // wall_1: the third
  zoom(1);
  EXPECT_TRUE(spinUntil([&] { return said == "None of it is shown: there is nothing to zoom to"; }))
      << said;
  hide(test_labels::rows(10, 0, 2));
  list()->selectRow(2);
  zoom(1);
  EXPECT_TRUE(looksAt(0.0, -0.5));
  hide({});
}
