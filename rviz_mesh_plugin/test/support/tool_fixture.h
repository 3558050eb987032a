#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include <OgreCamera.h>
#include <OgreViewport.h>
#include <geometry_msgs/TransformStamped.h>
#include <gtest/gtest.h>
#include <rviz/frame_manager.h>
#include <rviz/render_panel.h>
#include <rviz/viewport_mouse_event.h>
#include <rviz/visualization_manager.h>
#include <tf2_ros/buffer.h>
#include <QMouseEvent>

#include "display_fixture.h"
#include "picking/surface_index.h"
#include "picking/surface_picker.h"

/// A display, a picker, frames that lie anywhere, and the mouse.
class ToolFixture : public DisplayFixture
{
 protected:
  using Vector = std::array<double, 3>;

  struct FixedPose
  {
    Vector position{};
    std::array<double, 4> orientation{1, 0, 0, 0};  ///< w, x, y, z; of any length

    /// In the fixed frame.
    Vector operator()(const Vector& v) const
    {
      const double n = std::sqrt(orientation[0] * orientation[0] + orientation[1] * orientation[1] +
                                 orientation[2] * orientation[2] + orientation[3] * orientation[3]);
      const double w = orientation[0] / n;
      const Vector u{orientation[1] / n, orientation[2] / n, orientation[3] / n};
      const Vector t = cross(u, v);
      const Vector s = cross(u, {t[0] + w * v[0], t[1] + w * v[1], t[2] + w * v[2]});
      return {v[0] + 2 * s[0] + position[0], v[1] + 2 * s[1] + position[1],
              v[2] + 2 * s[2] + position[2]};
    }
  };

  static Vector cross(const Vector& a, const Vector& b)
  {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static double dot(const Vector& a, const Vector& b)
  {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  static Vector minus(const Vector& a, const Vector& b)
  {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }

  /// Where a frame lies in "map" from now on.
  static void putFrame(const std::string& frame, const FixedPose& pose)
  {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "map";
    transform.header.stamp = ros::Time::now();
    transform.child_frame_id = frame;
    transform.transform.translation.x = pose.position[0];
    transform.transform.translation.y = pose.position[1];
    transform.transform.translation.z = pose.position[2];
    double length = 0.0;
    for (const double part : pose.orientation) {
      length += part * part;
    }
    length = std::sqrt(length);
    transform.transform.rotation.w = pose.orientation[0] / length;
    transform.transform.rotation.x = pose.orientation[1] / length;
    transform.transform.rotation.y = pose.orientation[2] / length;
    transform.transform.rotation.z = pose.orientation[3] / length;
    manager()->getFrameManager()->getTF2BufferPtr()->setTransform(transform, "test", true);
    spinFrames();
  }

  static Ogre::Viewport* viewport() { return panel()->getViewport(); }
  static Ogre::Camera* camera() { return panel()->getViewport()->getCamera(); }

  /// The mouse at this pixel.
  static rviz::ViewportMouseEvent mouse(int x, int y, QEvent::Type type = QEvent::MouseMove,
                                        Qt::MouseButton button = Qt::NoButton)
  {
    const QPointF at(x, y);  // on the screen too: else Qt asks the X server where the mouse is
    QMouseEvent event(type, at, at, at, button, button, Qt::NoModifier);
    return rviz::ViewportMouseEvent(panel(), viewport(), &event, x, y);
  }

  /// Waits until all meshes that are shown can be picked.
  void waitUntilPrepared()
  {
    EXPECT_TRUE(spinUntil([&] {
      for (const auto& mesh : picker.meshes()) {
        if (!rviz_mesh_plugin::SurfaceIndex::instance().find(mesh.mesh).queries) {
          return false;
        }
      }
      return true;
    }));
  }

  rviz_mesh_plugin::SurfacePicker picker{manager()};
};
