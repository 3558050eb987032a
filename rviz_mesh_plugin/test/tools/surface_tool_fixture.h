#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <ros/subscriber.h>
#include <rviz/tool.h>
#include <QColor>
#include <QKeyEvent>

#include "support/tool_fixture.h"

/// A tool, what it says in the status bar, and what it publishes.
template <class Tool, class Message>
class SurfaceToolFixture : public ToolFixture
{
 protected:
  void SetUp() override
  {
    ToolFixture::SetUp();
    topic = "/" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
            "/published";
    QObject::connect(manager(), &rviz::VisualizationManager::statusUpdate, &guard_,
                     [this](const QString& text) { said = text.toStdString(); });
    listen(topic);
    tool = std::make_unique<Tool>();
    set({"Topic"}, topic.c_str());
    tool->initialize(manager());
    tool->activate();
    // Connected from this side, and so from the other: both are in this process.
    ASSERT_TRUE(spinUntil([this] { return subscriber.getNumPublishers() == 1; }));
  }

  void TearDown() override
  {
    tool.reset();
    ToolFixture::TearDown();
  }

  void listen(const std::string& name)
  {
    subscriber = node.subscribe<Message>(
        name, 10, [this](const auto& message) { received.push_back(*message); });
  }

  void set(const std::vector<const char*>& path, const QVariant& value)
  {
    find(tool->getPropertyContainer(), path)->setValue(value);
  }

  int send(int x, int y, QEvent::Type type, Qt::MouseButton button = Qt::LeftButton)
  {
    auto event = mouse(x, y, type, button);
    return tool->processMouseEvent(event);
  }
  int press(int x, int y, Qt::MouseButton button = Qt::LeftButton)
  {
    return send(x, y, QEvent::MouseButtonPress, button);
  }
  int move(int x, int y, Qt::MouseButton button = Qt::LeftButton)
  {
    return send(x, y, QEvent::MouseMove, button);
  }
  int release(int x, int y, Qt::MouseButton button = Qt::LeftButton)
  {
    return send(x, y, QEvent::MouseButtonRelease, button);
  }
  int pressEscape()
  {
    QKeyEvent event(QEvent::KeyPress, Qt::Key_Escape, Qt::NoModifier);
    return tool->processKeyEvent(&event, panel());
  }

  /// The next message that arrives.
  Message next()
  {
    EXPECT_TRUE(spinUntil([this] { return !received.empty(); })) << said;
    Message message;
    if (!received.empty()) {
      message = received.front();
      received.erase(received.begin());
    }
    return message;
  }

  /// Pixels in which one channel (0: red, 1: green) is far above the others.
  static std::size_t countColored(const osmesa_harness::Image& picture, unsigned channel)
  {
    std::size_t found = 0;
    for (int i = 0; i < picture.width() * picture.height(); ++i) {
      const std::uint8_t* const pixel = picture.data() + 3 * i;
      const int others = std::max(pixel[(channel + 1) % 3], pixel[(channel + 2) % 3]);
      found += pixel[channel] > others + 50 ? 1 : 0;
    }
    return found;
  }

  bool says(const std::string& text) const { return said.find(text) != std::string::npos; }

  struct View
  {
    Vector eye;
    Vector target;
  };

  void look(const View& from)
  {
    view = from;
    lookAt({view.eye[0], view.eye[1], view.eye[2]},
           {view.target[0], view.target[1], view.target[2]});
    spinFrames();
  }

  static Vector plus(const Vector& a, double factor, const Vector& b)
  {
    return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
  }
  static Vector unit(const Vector& v) { return plus({0, 0, 0}, 1.0 / std::sqrt(dot(v, v)), v); }

  Vector forward() const { return unit(minus(view.target, view.eye)); }
  Vector upward() const { return cross(unit(cross(forward(), {0, 0, 1})), forward()); }

  /// Where the middle of a pixel looks to: 45 degrees vertically, z up.
  Vector sight(int x, int y) const
  {
    const double scale = std::tan(M_PI / 8.0) * 2.0 / DEFAULT_HEIGHT;
    const Vector right = unit(cross(forward(), {0, 0, 1}));
    return plus(plus(forward(), scale * (x + 0.5 - 0.5 * DEFAULT_WIDTH), right),
                scale * (0.5 * DEFAULT_HEIGHT - y - 0.5), upward());
  }

  /// Where it meets a plane.
  Vector onPlane(int x, int y, const Vector& point, const Vector& normal) const
  {
    const Vector along = sight(x, y);
    const double distance = dot(minus(point, view.eye), normal) / dot(along, normal);
    EXPECT_GT(distance, 0.0) << "the ray does not meet the plane";
    return plus(view.eye, distance, along);
  }

  /// A square of 2 m in a frame of its own, and that it is ready.
  Display* showSquare(const FixedPose& pose, const std::string& frame)
  {
    auto* display = createMeshDisplay();
    DisplayFixture::set(display, {"Display Type", "Faces Color"}, QColor(120, 130, 160));
    auto message = test_meshes::square();
    message.header.frame_id = frame;
    putFrame(frame, pose);
    EXPECT_TRUE(show(display, message));
    EXPECT_TRUE(spinUntil([&] { return display->shownMeshes().size() == 1; }));
    waitUntilPrepared();
    return display;
  }

  std::string topic;
  std::unique_ptr<Tool> tool;
  std::string said;
  ros::Subscriber subscriber;
  std::vector<Message> received;
  View view{};

 private:
  QObject guard_;
};
