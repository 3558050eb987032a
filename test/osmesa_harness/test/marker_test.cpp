// Data that arrives over a topic.
#include <osmesa_harness/render_fixture.h>

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <rviz/display.h>
#include <rviz/properties/property.h>
#include <visualization_msgs/Marker.h>

using osmesa_harness::Image;
using osmesa_harness::Rgb;

namespace {

const Rgb BACKGROUND{48, 48, 48};

class Markers : public osmesa_harness::RenderFixture
{
 protected:
  Markers() : publisher_(node_.advertise<visualization_msgs::Marker>("test_marker", 1, true)) {}

  static visualization_msgs::Marker marker(int type)
  {
    visualization_msgs::Marker message;
    message.header.frame_id = "map";
    message.type = type;
    message.pose.orientation.w = 1.0;
    return message;
  }

  static void addPoint(visualization_msgs::Marker* message, double x, double y, const Rgb& color)
  {
    geometry_msgs::Point point;
    point.x = x;
    point.y = y;
    std_msgs::ColorRGBA rgba;
    rgba.r = static_cast<float>(color.red) / 255.0F;
    rgba.g = static_cast<float>(color.green) / 255.0F;
    rgba.b = static_cast<float>(color.blue) / 255.0F;
    rgba.a = 1.0F;
    message->points.push_back(point);
    message->colors.push_back(rgba);
  }

  // Publishes the marker and draws until the pixel has another color than the background.
  Image shown(const visualization_msgs::Marker& message, int x, int y)
  {
    publisher_.publish(message);
    createDisplay("rviz/Marker")->subProp("Marker Topic")->setValue("test_marker");
    Image image;
    spinUntil([&] {
      image = grab();
      return image.at(x, y) != BACKGROUND;
    });
    return image;
  }

  ros::NodeHandle node_;
  ros::Publisher publisher_;
};

TEST_F(Markers, points_have_their_colors_and_places)
{
  const Rgb colors[] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 0}};
  auto message = marker(visualization_msgs::Marker::POINTS);
  message.scale.x = message.scale.y = 0.5;
  addPoint(&message, -1.0, 1.0, colors[0]);
  addPoint(&message, 1.0, 1.0, colors[1]);
  addPoint(&message, -1.0, -1.0, colors[2]);
  addPoint(&message, 1.0, -1.0, colors[3]);

  const Image image = shown(message, 220, 140);
  EXPECT_EQ(image.at(220, 140), colors[0]);
  EXPECT_EQ(image.at(420, 140), colors[1]);
  EXPECT_EQ(image.at(220, 340), colors[2]);
  EXPECT_EQ(image.at(420, 340), colors[3]);
  EXPECT_EQ(image.center(), BACKGROUND);
  for (const Rgb& color : colors) {
    // RViz's points of 50 cm are squares somewhat smaller than 50 pixels.
    EXPECT_EQ(image.count(color), image.count(colors[0])) << color;
    EXPECT_NEAR(double(image.count(color)), 48.0 * 48.0, 4.0 * 48.0) << color;
  }
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("points", image));
}

TEST_F(Markers, triangles_are_interpolated)
{
  auto message = marker(visualization_msgs::Marker::TRIANGLE_LIST);
  message.scale.x = message.scale.y = message.scale.z = 1.0;
  message.color.a = 1.0F;
  addPoint(&message, -2.0, -2.0, {255, 0, 0});
  addPoint(&message, 2.0, -2.0, {255, 0, 0});
  addPoint(&message, 0.0, 2.0, {0, 255, 0});

  const Image image = shown(message, 320, 240);
  const Rgb bottom = image.at(320, 430);
  const Rgb top = image.at(320, 60);
  EXPECT_GT(bottom.red, bottom.green);
  EXPECT_GT(top.green, top.red);
  EXPECT_NEAR(image.center().red, image.center().green, 3);
  EXPECT_EQ(image.at(100, 100), BACKGROUND);
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("triangle", image));
}

}  // namespace
