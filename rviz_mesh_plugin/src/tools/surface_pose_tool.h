#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include <OgreColourValue.h>
#include <geometry_msgs/PoseStamped.h>

#include "properties/published_topic.h"
#include "tools/goal_follower.h"
#include "tools/surface_pose.h"
#include "tools/surface_tool.h"

namespace rviz {
class Arrow;
class BoolProperty;
class EnumProperty;
class FloatProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// Puts a pose on a surface and publishes it: the left button is pressed at the position and
/// released where the pose shall look to. The right button or Esc gives it up.
class SurfacePoseTool : public SurfaceTool
{
 public:
  ~SurfacePoseTool() override;

 protected:
  struct Kind
  {
    char key;
    std::string what;  ///< at the beginning of a sentence
    const char* topic;
    Ogre::ColourValue color;
    PublishedTopic::Advertise advertise;
  };
  explicit SurfacePoseTool(const Kind& kind);

  /// @return what PublishedTopic says
  virtual std::string publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose) = 0;

  const std::string& what() const { return kind_.what; }

  void initializeTool() override;
  void begin() override;
  void end() override;
  int mouse(rviz::ViewportMouseEvent& event) override;
  bool isDragging() const override { return drag_.has_value(); }

 private:
  /// The mesh may go meanwhile.
  struct Drag
  {
    SurfacePoseDrag pose;  ///< in the fixed frame
    ShownMesh mesh;        ///< where it lies; the mesh itself is not kept
    std::string fixed_frame;
    std::string mesh_frame;
    int x = 0;  ///< of the cursor, in pixels
    int y = 0;
  };

  int press(const rviz::ViewportMouseEvent& event);
  void turn(const rviz::ViewportMouseEvent& event);
  void showArrow();
  void hideArrow();
  geometry_msgs::PoseStamped message() const;

  Kind kind_;
  PublishedTopic topic_;
  rviz::EnumProperty* frame_;
  rviz::BoolProperty* switched_;
  rviz::EnumProperty* z_axis_;
  rviz::FloatProperty* arrow_length_;
  std::unique_ptr<rviz::Arrow> arrow_;
  std::optional<Drag> drag_;
};

/// Publishes a goal on a surface as geometry_msgs/PoseStamped, and tells what becomes of it.
class MeshGoalTool : public SurfacePoseTool
{
 public:
  MeshGoalTool();

 protected:
  std::string publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose) override;
  void begin() override;
  void end() override;

 private:
  GoalFollower follower_;
};

/// Publishes where a robot is on a surface as geometry_msgs/PoseWithCovarianceStamped.
class MeshPoseEstimateTool : public SurfacePoseTool
{
 public:
  MeshPoseEstimateTool();

 protected:
  std::string publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose) override;

 private:
  /// x, y, z in m², and about these axes of the frame of the pose in rad².
  std::array<rviz::FloatProperty*, 6> covariance_{};
};

}  // namespace rviz_mesh_plugin
