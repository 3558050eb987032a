#include "picking/view_zoom.h"

#include <algorithm>
#include <cmath>

#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include "picking/view_geometry.h"
#include "support/tool_fixture.h"

using rviz_mesh_plugin::Bounds;

class ViewZoomTest : public ToolFixture
{
 protected:
  void TearDown() override
  {
    view().subProp("Target Frame")->setValue("<Fixed Frame>");  // views of other tests inherit it
    ToolFixture::TearDown();
  }

  static rviz::ViewController& view() { return *manager()->getViewManager()->getCurrent(); }

  /// The corners of a box in the picture, from -1 to 1; the farthest one from its middle.
  static double farthest(const Bounds& bounds, const rviz_mesh_plugin::ShownMesh& mesh)
  {
    const auto m = rviz_mesh_plugin::meshToClip(*view().getCamera(), mesh);
    double most = 0.0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      std::array<double, 4> point{0, 0, 0, 1};
      for (unsigned axis = 0; axis < 3; ++axis) {
        point.at(axis) = (corner >> axis & 1) != 0 ? bounds.upper[axis] : bounds.lower[axis];
      }
      std::array<double, 4> clip{};
      for (unsigned row = 0; row < 4; ++row) {
        for (unsigned i = 0; i < 4; ++i) {
          clip.at(row) += m.at(4 * row + i) * point.at(i);
        }
      }
      if (clip[3] <= 0.0) {
        return 1e9;  // behind the camera
      }
      most = std::max({most, std::abs(clip[0] / clip[3]), std::abs(clip[1] / clip[3])});
    }
    return most;
  }
};

TEST_F(ViewZoomTest, every_view_sees_all_of_the_box_and_little_else)
{
  rviz_mesh_plugin::ShownMesh mesh;
  mesh.position = Ogre::Vector3(3, -2, 5);
  mesh.orientation = Ogre::Quaternion(Ogre::Radian(0.6f), Ogre::Vector3(0.6f, 0, 0.8f));
  putFrame("robot", {{1, 2, 0}, {0.9, 0, 0, 0.4}});
  const Bounds small{{-0.1f, -0.2f, 0.0f}, {0.1f, 0.1f, 0.05f}};
  const Bounds large{{-40, -20, 0}, {30, 60, 12}};
  for (const char* type : {"rviz/Orbit", "rviz/XYOrbit", "rviz/TopDownOrtho", "rviz/FPS",
                           "rviz/ThirdPersonFollower"}) {
    for (const char* frame : {"<Fixed Frame>", "robot"}) {
      for (const Bounds& bounds : {large, small}) {
        SCOPED_TRACE(std::string(type) + " " + frame + " " + std::to_string(bounds.upper[0]));
        manager()->getViewManager()->setCurrentViewControllerType(type);
        view().subProp("Target Frame")->setValue(frame);
        spinFrames(3);
        const auto before = view().getCamera()->getDerivedDirection();
        const auto up = view().getCamera()->getDerivedUp();
        EXPECT_TRUE(
            rviz_mesh_plugin::zoomTo(view(), rviz_mesh_plugin::boxInFixedFrame(bounds, mesh)));
        spinFrames(3);
        const double seen = farthest(bounds, mesh);
        EXPECT_LT(seen, 1.0) << "all of it";
        EXPECT_GT(seen, 0.15) << "and little else";
        EXPECT_GT(before.dotProduct(view().getCamera()->getDerivedDirection()), 0.999f)
            << "in the same direction";
        EXPECT_GT(up.dotProduct(view().getCamera()->getDerivedUp()), 0.999f) << "upright";
      }
    }
  }
  manager()->getViewManager()->setCurrentViewControllerType("rviz/TopDownOrtho");
  mesh.position.z = 840;  // its camera is at 500
  EXPECT_FALSE(rviz_mesh_plugin::zoomTo(view(), rviz_mesh_plugin::boxInFixedFrame(small, mesh)));
  mesh.position.z = 5;
  manager()->getViewManager()->setCurrentViewControllerType("rviz/ThirdPersonFollower");
  // What has no size.
  rviz_mesh_plugin::zoomTo(view(), rviz_mesh_plugin::boxInFixedFrame(Bounds{}, mesh));
  spinFrames(2);
  EXPECT_LT(farthest(Bounds{}, mesh), 1.0);
}
