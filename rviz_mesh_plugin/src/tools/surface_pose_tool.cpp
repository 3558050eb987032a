#include "tools/surface_pose_tool.h"

#include <cmath>

#include <OgreCamera.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/time.h>
#include <rviz/display_context.h>
#include <rviz/ogre_helpers/arrow.h>
#include <rviz/tool_manager.h>
#include <rviz/viewport_mouse_event.h>

#include "picking/view_geometry.h"
#include "properties/property_maker.h"

namespace rviz_mesh_plugin {
namespace {

/// Less far from where the button was pressed, the cursor gives no direction.
constexpr double NO_DRAG_PIXELS = 5.0;

constexpr float SHAFT_LENGTH = 2.0f, SHAFT_DIAMETER = 0.2f;
constexpr float HEAD_LENGTH = 0.5f, HEAD_DIAMETER = 0.35f;

enum Frame
{
  FIXED_FRAME,
  MESH_FRAME
};

std::array<double, 3> coordinatesOf(const Ogre::Vector3& v)
{
  return {v.x, v.y, v.z};
}

ViewAxes viewOf(const rviz::ViewportMouseEvent& event)
{
  const Ogre::Camera* camera = event.viewport ? event.viewport->getCamera() : nullptr;
  return camera ? ViewAxes{coordinatesOf(camera->getDerivedDirection()),
                           coordinatesOf(camera->getDerivedUp())}
                : ViewAxes();
}

SurfacePose inMesh(const SurfacePose& pose, const ShownMesh& mesh)
{
  SurfacePose result;
  const auto x = rayInMesh({pose.position, pose.x}, mesh);
  result.position = x.origin;
  result.x = x.direction;
  result.y = rayInMesh({pose.position, pose.y}, mesh).direction;
  result.z = rayInMesh({pose.position, pose.z}, mesh).direction;
  return result;
}

struct Variance
{
  const char* name;
  float value;
  const char* description;
};

constexpr float FIFTEEN_DEGREES = 0.2617993878f;

/// Of the estimate.
constexpr Variance VARIANCES[6] = {
    {"Covariance x", 0.25f, "Of the position along x of the frame, in m²."},
    {"Covariance y", 0.25f, "Of the position along y of the frame, in m²."},
    {"Covariance z", 0.01f, "Of the position along z of the frame, in m²."},
    {"Covariance roll", 0.01f, "Of the rotation about x of the frame, in rad²."},
    {"Covariance pitch", 0.01f, "Of the rotation about y of the frame, in rad²."},
    {"Covariance yaw", FIFTEEN_DEGREES* FIFTEEN_DEGREES,
     "Of the rotation about z of the frame, in rad²."}};

}  // namespace

SurfacePoseTool::SurfacePoseTool(const Kind& kind)
    : kind_(kind),
      topic_(getPropertyContainer(), kind.topic, "The topic on which to publish the pose.",
             kind.advertise)
{
  shortcut_key_ = kind.key;
  auto* const parent = getPropertyContainer();
  const PropertyMaker make(this, [] {});  // they are read where they are needed
  frame_ = make.choice("Frame", "Fixed Frame",
                       "In which frame to publish: that of RViz, or that of the mesh.", parent,
                       {"Fixed Frame", "Mesh Frame"});
  switched_ =
      make.box("Switch Bottom/Top", false,
               "Turn the z and y axes of the pose over. (In the released plugin z pointed into the "
               "ground without this; here it points out of it.)",
               parent);
  z_axis_ = make.choice("Z Axis", "Viewer",
                        "To which side of the surface the z axis shows: to the one that is seen, "
                        "or to the upper one in the fixed frame.",
                        parent, {"Viewer", "Up"});
  arrow_length_ = make.number("Arrow Length", SHAFT_LENGTH + HEAD_LENGTH,
                              "Of the arrow that is shown, in meters.", parent, 0.001f);
}

SurfacePoseTool::~SurfacePoseTool() = default;

void SurfacePoseTool::initializeTool()
{
  topic_.connect();
  arrow_ = std::make_unique<rviz::Arrow>(scene_manager_, nullptr, SHAFT_LENGTH, SHAFT_DIAMETER,
                                         HEAD_LENGTH, HEAD_DIAMETER);
  arrow_->setColor(kind_.color);
  hideArrow();
}

void SurfacePoseTool::begin()
{
  say(topic_.problem().empty()
          ? "Press the left button at the position and drag to where the pose shall look. Right "
            "button or Esc while dragging: give it up. Otherwise right, middle and Shift + left "
            "button and wheel move the camera."
          : "Nothing can be published: " + topic_.problem());
}

void SurfacePoseTool::end()
{
  if (drag_) {
    say("The pose was given up: nothing was published.");
  }
  drag_.reset();
  hideArrow();
}

int SurfacePoseTool::mouse(rviz::ViewportMouseEvent& event)
{
  if (!drag_) {
    return event.leftDown() ? press(event) : 0;
  }
  // Where the button is up, its release went elsewhere.
  const bool released_elsewhere =
      event.leftDown() || (event.type == QEvent::MouseMove && !event.left());
  if (event.rightDown() || released_elsewhere) {
    end();
    return Render;
  }
  turn(event);
  if (!event.leftUp()) {
    return Render;
  }
  const geometry_msgs::PoseStamped pose = message();
  drag_.reset();  // whatever happens now
  say(publish(topic_, pose));
  return Render | Finished;
}

int SurfacePoseTool::press(const rviz::ViewportMouseEvent& event)
{
  const Pick pick = picker().pick(event);
  if (!pick.hit) {
    say("There can be no pose: " + pick.reason);
    return 0;
  }
  const SurfaceHit& hit = *pick.hit;
  const SurfaceSide side{static_cast<SurfaceSide::Of>(z_axis_->getOptionInt()),
                         switched_->getBool()};
  const SurfacePoseDrag pose(pointInFixedFrame(hit.point, hit),
                             directionInFixedFrame(hit.normal, hit), cursorRay(event),
                             viewOf(event), side);
  Drag drag{pose,    hit,    context_->getFixedFrame().toStdString(), hit.mesh->frame_id,
            event.x, event.y};
  drag.mesh.mesh = nullptr;
  if (!hit.source.frame.empty()) {
    drag.mesh_frame = hit.source.frame;
  }
  drag_ = drag;
  showArrow();
  say("Drag to where the pose shall look, and release. Right button or Esc: give it up.");
  return Render;
}

void SurfacePoseTool::turn(const rviz::ViewportMouseEvent& event)
{
  if (std::hypot(event.x - drag_->x, event.y - drag_->y) < NO_DRAG_PIXELS) {
    drag_->pose.turnAlong(viewOf(event));
  } else {
    drag_->pose.turnTowards(cursorRay(event), viewOf(event));
  }
  showArrow();
}

void SurfacePoseTool::showArrow()
{
  const SurfacePose& pose = drag_->pose.pose();
  arrow_->setScale(Ogre::Vector3(arrow_length_->getFloat() / (SHAFT_LENGTH + HEAD_LENGTH)));
  arrow_->setPosition(ogreVector(pose.position));
  arrow_->setDirection(ogreVector(pose.x));
  arrow_->getSceneNode()->setVisible(true);
}

void SurfacePoseTool::hideArrow()
{
  if (arrow_) {
    arrow_->getSceneNode()->setVisible(false);
  }
}

geometry_msgs::PoseStamped SurfacePoseTool::message() const
{
  geometry_msgs::PoseStamped message;
  const bool mesh_frame = frame_->getOptionInt() == MESH_FRAME && !drag_->mesh_frame.empty();
  const SurfacePose& fixed = drag_->pose.pose();
  const SurfacePose pose = mesh_frame ? inMesh(fixed, drag_->mesh) : fixed;
  message.header.frame_id = mesh_frame ? drag_->mesh_frame : drag_->fixed_frame;
  message.header.stamp = ros::Time::now();
  message.pose.position.x = pose.position[0];
  message.pose.position.y = pose.position[1];
  message.pose.position.z = pose.position[2];
  const auto q = quaternionOf(pose);
  message.pose.orientation.x = q[0];
  message.pose.orientation.y = q[1];
  message.pose.orientation.z = q[2];
  message.pose.orientation.w = q[3];
  return message;
}

MeshGoalTool::MeshGoalTool()
    : SurfacePoseTool({'m', "The goal", "goal", Ogre::ColourValue::Green,
                       PublishedTopic::advertise<geometry_msgs::PoseStamped>}),
      follower_([this](const std::string& text) { say(text); },
                [this] {
                  // Only the tool that RViz falls back to leaves the status bar to others.
                  rviz::ToolManager* tools = context_ ? context_->getToolManager() : nullptr;
                  return tools && (!tools->getCurrentTool() ||
                                   tools->getCurrentTool() == tools->getDefaultTool());
                })
{
}

void MeshGoalTool::begin()
{
  SurfacePoseTool::begin();
  follower_.prepare();
}

void MeshGoalTool::end()
{
  SurfacePoseTool::end();
  follower_.release();
}

std::string MeshGoalTool::publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose)
{
  if (!topic.name().empty()) {
    follower_.follow(pose, topic.name());
  }
  return topic.publish(what(), pose);
}

MeshPoseEstimateTool::MeshPoseEstimateTool()
    : SurfacePoseTool({'e', "The pose estimate", "initialpose", Ogre::ColourValue::Red,
                       PublishedTopic::advertise<geometry_msgs::PoseWithCovarianceStamped>})
{
  const PropertyMaker make(this, [] {});
  for (unsigned i = 0; i < 6; ++i) {
    covariance_[i] = make.number(VARIANCES[i].name, VARIANCES[i].value, VARIANCES[i].description,
                                 getPropertyContainer(), 0.0f);
  }
}

std::string MeshPoseEstimateTool::publish(PublishedTopic& topic,
                                          const geometry_msgs::PoseStamped& pose)
{
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = pose.header;
  message.pose.pose = pose.pose;
  for (unsigned i = 0; i < 6; ++i) {
    message.pose.covariance[7 * i] = covariance_[i]->getFloat();
  }
  return topic.publish(what(), message);
}

}  // namespace rviz_mesh_plugin
