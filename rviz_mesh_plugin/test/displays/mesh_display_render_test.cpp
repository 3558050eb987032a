#include <atomic>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/GetGeometry.h>
#include <mesh_msgs/GetUUIDs.h>
#include <mesh_msgs/GetVertexColors.h>
#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include "support/display_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;

namespace {

const Rgb BACKGROUND{48, 48, 48};
const Rgb GREEN{0, 255, 0};
const Rgb RED{255, 0, 0};
const Rgb BLUE{0, 0, 255};

mesh_msgs::MeshGeometryStamped shiftedSquare(const std::string& uuid, double x)
{
  auto message = test_meshes::square();
  message.uuid = uuid;
  for (auto& vertex : message.mesh_geometry.vertices) {
    vertex.x += x;
  }
  return message;
}

template <class Service>
ros::ServiceServer serve(ros::NodeHandle& node, const char* name,
                         const std::function<void(typename Service::Response&)>& answer)
{
  using Request = typename Service::Request;
  using Response = typename Service::Response;
  const boost::function<bool(Request&, Response&)> callback = [answer](Request&,
                                                                       Response& response) {
    answer(response);
    return true;
  };
  return node.advertiseService(name, callback);
}

}  // namespace

/// From above at 100 pixels per meter, in the middle of which is the origin: (x, y) in meters is in
/// column 320 + 100 x and row 240 - 100 y.
class MeshDisplayTest : public DisplayFixture
{
 protected:
  static Image picture()
  {
    viewFromAbove(0.0, 0.0, 100.0);
    spinFrames(3);
    return grab();
  }

  static Rgb at(const Image& image, double x, double y)
  {
    return image.at(static_cast<int>(320 + 100 * x), static_cast<int>(240 - 100 * y));
  }

  /// Waits until a point of the picture has a color.
  static testing::AssertionResult shows(double x, double y, const Rgb& color, int tolerance = 2)
  {
    Rgb found;
    for (int i = 0; i < 100; ++i) {
      found = at(picture(), x, y);
      if (isNear(found, color, tolerance)) {
        return testing::AssertionSuccess();
      }
    }
    return testing::AssertionFailure() << "(" << x << ", " << y << ") is " << found;
  }
};

TEST_F(MeshDisplayTest, the_newest_meshes_are_seen_up_to_the_buffer_size)
{
  auto* display = createMeshDisplay();
  set(display, {"Buffer Size"}, 2);
  ASSERT_TRUE(show(display, shiftedSquare("left", -2.1)));
  ASSERT_TRUE(show(display, shiftedSquare("right", 2.1)));
  EXPECT_TRUE(shows(-2.1, 0, GREEN));
  EXPECT_TRUE(shows(2.1, 0, GREEN));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "1 older mesh is shown too"));
  ASSERT_EQ(display->shownMeshes().size(), 2u);
  EXPECT_EQ(display->shownMeshes()[0].mesh->uuid, "right");
  ASSERT_TRUE(show(display, shiftedSquare("middle", 0.0)));
  EXPECT_TRUE(shows(0, 0, GREEN));
  EXPECT_TRUE(shows(-2.1, 0, BACKGROUND)) << "the oldest has made room";
  EXPECT_TRUE(shows(2.1, 0, GREEN));
  // Costs by uuid; one scale for both.
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Color Scale"}, "Red Green");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  costs.publish(test_meshes::costs("a", {0, 0, 0, 0}, "middle"));
  costs.publish(test_meshes::costs("a", {8, 8, 8, 8}, "right"));
  EXPECT_TRUE(shows(0, 0, GREEN));
  EXPECT_TRUE(shows(2.1, 0, RED));
  set(display, {"Display Type"}, "Fixed Color");
  set(display, {"Buffer Size"}, 1);
  EXPECT_TRUE(shows(2.1, 0, BACKGROUND));
  EXPECT_TRUE(shows(0, 0, GREEN));
  ASSERT_TRUE(show(display, shiftedSquare("middle", 2.1)));
  EXPECT_TRUE(shows(0, 0, BACKGROUND)) << "the same uuid replaces";
}

TEST_F(MeshDisplayTest, disabling_hides_and_keeps_everything)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::square()));
  EXPECT_TRUE(shows(0, 0, GREEN));
  const std::size_t uploads = display->visual()->geometryUploads();
  display->setEnabled(false);
  EXPECT_TRUE(shows(0, 0, BACKGROUND));
  display->setEnabled(true);
  EXPECT_TRUE(shows(0, 0, GREEN));
  spin(300);  // the latched message comes again
  EXPECT_EQ(display->visual()->geometryUploads(), uploads);
}

TEST_F(MeshDisplayTest, updates_change_only_the_vertices_that_they_name)
{
  ros::Publisher updates =
      node.advertise<mesh_msgs::MeshVertexCostsSparseStamped>(costs_topic + "/updates", 100, true);
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Color Scale"}, "Red Green");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  const auto grid = test_meshes::terrain(4, [](double, double) { return 0.0; });
  ASSERT_TRUE(show(display, grid));
  mesh_msgs::MeshVertexCostsSparseStamped update;
  update.header.frame_id = "map";
  update.uuid = "mesh";
  update.type = "a";
  update.mesh_vertex_costs.vertices = {0, 1, 5, 6};  // the corner at (-1, -1)
  update.mesh_vertex_costs.costs = {1, 1, 1, 1};
  update.header.stamp = ros::Time(2, 0);
  updates.publish(update);  // waits for its layer, which is older
  std::vector<float> values(25, 0.0f);
  values[24] = 1.0f;
  spin(200);
  auto layer = test_meshes::costs("a", values);
  layer.header.stamp = ros::Time(1, 0);
  costs.publish(layer);
  EXPECT_TRUE(shows(-0.75, -0.75, RED));
  EXPECT_TRUE(shows(0, 0, GREEN));
  const std::size_t uploads = display->visual()->geometryUploads();
  update.mesh_vertex_costs.costs = {0, 0, 0, 0};
  updates.publish(update);
  EXPECT_TRUE(shows(-0.75, -0.75, GREEN));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 25 costs from 0 to 1"));
  update.mesh_vertex_costs.vertices = {12};
  update.mesh_vertex_costs.costs = {INFINITY};
  updates.publish(update);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "24 costs from 0 to 1, 1 lethal"));
  EXPECT_TRUE(shows(-0.75, -0.75, GREEN));
  update.mesh_vertex_costs.vertices = {25};
  updates.publish(update);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Error", "entry 0 refers to vertex 25"));
  EXPECT_EQ(display->visual()->geometryUploads(), uploads);
}

TEST_F(MeshDisplayTest, updates_of_other_layers_upload_nothing)
{
  ros::Publisher updates =
      node.advertise<mesh_msgs::MeshVertexCostsSparseStamped>(costs_topic + "/updates", 100, true);
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Color Scale"}, "Red Green");
  set(display, {"Display Type", "Vertex Costs Type"}, "shown");
  set(display, {"Display Type", "Visualization Update Rate"}, 1.0f);
  ASSERT_TRUE(show(display, test_meshes::terrain(100, [](double, double) { return 0.0; })));
  std::vector<float> values(101 * 101, 0.0f);
  values.back() = 1.0f;
  for (const char* type : {"also", "shown", "zero"}) {
    costs.publish(test_meshes::costs(type, values));
  }
  EXPECT_TRUE(shows(-0.5, -0.5, GREEN));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'shown': 10201 costs"));
  mesh_msgs::MeshVertexCostsSparseStamped update;
  update.header.frame_id = "map";
  update.uuid = "mesh";
  const auto publish = [&](const std::string& type, std::vector<std::uint32_t> vertices) {
    update.type = type;
    update.mesh_vertex_costs.costs.assign(vertices.size(), 1.0f);
    update.mesh_vertex_costs.vertices = std::move(vertices);
    updates.publish(update);
  };
  publish("shown", {0});  // at once: the next ones after a second
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'shown': 10201 costs"));
  const auto corner = [&] { return shows(-0.99, -0.99, RED); };
  publish("shown", {1, 101, 102});
  EXPECT_TRUE(corner());
  const std::size_t uploads = display->visual()->colorUploads();
  for (const char* type : {"zero", "also", "shown"}) {
    publish(type, {2550, 2551, 2651, 2652});
  }
  publish("shown", {10201});  // they have all come once this is refused
  ASSERT_TRUE(waitForStatus(display, "Costs", "Error", "entry 0 refers to vertex 10201"));
  EXPECT_TRUE(shows(-0.49, -0.49, RED));
  EXPECT_EQ(display->visual()->colorUploads(), uploads) << "of a few blocks, not all of them";
}

TEST_F(MeshDisplayTest, costs_of_faces_are_shown_face_by_face)
{
  const std::string topic = geometry_topic + "/face_costs";
  ros::Publisher face_costs = node.advertise<mesh_msgs::MeshFaceCostsStamped>(topic, 10, true);
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Color Scale"}, "Red Green");
  set(display, {"Display Type", "Face Costs Topic"}, topic.c_str());
  set(display, {"Display Type", "Vertex Costs Type"}, "f");
  ASSERT_TRUE(show(display, test_meshes::square()));
  mesh_msgs::MeshFaceCostsStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  message.type = "f";
  message.mesh_face_costs.costs = {0, 5};
  face_costs.publish(message);
  // The first face lies below the diagonal from (-1, -1) to (1, 1).
  EXPECT_TRUE(shows(0.05, -0.05, GREEN));
  EXPECT_TRUE(shows(-0.05, 0.05, RED)) << "no blending across the edge";
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'f': 2 costs from 0 to 5"));
  message.mesh_face_costs.costs = {5, 0};
  face_costs.publish(message);
  EXPECT_TRUE(shows(0.9, -0.9, RED));
  EXPECT_TRUE(shows(-0.9, 0.9, GREEN));
  set(display, {"Display Type"}, "Fixed Color");
  EXPECT_TRUE(shows(0.9, -0.9, GREEN));
  message.mesh_face_costs.costs = {1, 2, 3};
  face_costs.publish(message);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Error", "there are 3 costs for 2 faces"));
}

TEST_F(MeshDisplayTest, materials_and_textures_come_by_topic)
{
  ros::Publisher materials_publisher =
      node.advertise<mesh_msgs::MeshMaterialsStamped>(geometry_topic + "/materials", 10, true);
  ros::Publisher textures =
      node.advertise<mesh_msgs::MeshTexture>(geometry_topic + "/textures", 10, true);
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Textures");
  set(display, {"Display Type", "Materials Topic"}, (geometry_topic + "/materials").c_str());
  set(display, {"Display Type", "Textures Topic"}, (geometry_topic + "/textures").c_str());
  ASSERT_TRUE(show(display, test_meshes::square()));
  const auto without = counts();
  mesh_msgs::MeshMaterialsStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  auto& materials = message.mesh_materials;
  materials.materials.resize(2);
  materials.materials[0].color = test_meshes::color(1, 0, 0);
  materials.materials[1].color = test_meshes::color(1, 1, 0);
  materials.materials[1].has_texture = true;
  materials.materials[1].texture_index = 3;
  materials.clusters.resize(2);
  materials.clusters[0].face_indices = {0};
  materials.clusters[1].face_indices = {1};
  materials.cluster_materials = {0, 1};
  materials.vertex_tex_coords.resize(4);
  materials_publisher.publish(message);
  EXPECT_TRUE(shows(0.5, -0.5, RED));
  EXPECT_TRUE(shows(-0.5, 0.5, Rgb{255, 255, 0})) << "its color until the image comes";
  EXPECT_TRUE(waitForStatus(display, "Textures", "Warn", "0 of 1 texture received"));
  mesh_msgs::MeshTexture texture;
  texture.uuid = "mesh";
  texture.texture_index = 3;
  texture.image.width = 2;
  texture.image.height = 2;
  texture.image.step = 6;
  texture.image.encoding = "rgb8";
  texture.image.data = {0, 0, 255, 0, 0, 255, 0, 0, 255, 0, 0, 255};
  textures.publish(texture);
  EXPECT_TRUE(shows(-0.5, 0.5, BLUE));
  EXPECT_TRUE(shows(0.5, -0.5, RED));
  EXPECT_TRUE(waitForStatus(display, "Textures", "Ok", "1 of 1 texture received"));
  EXPECT_EQ(counts().textures, without.textures + 1);
  set(display, {"Display Type"}, "Fixed Color");
  EXPECT_TRUE(shows(0.5, -0.5, GREEN));
  EXPECT_EQ(counts().textures, without.textures + 1) << "nowhere else are its pixels";
  set(display, {"Display Type"}, "Textures");
  EXPECT_TRUE(shows(-0.5, 0.5, BLUE));
  delete display;
  spinFrames();
  EXPECT_LE(counts().textures, without.textures);
}

TEST_F(MeshDisplayTest, labels_lie_over_the_mesh)
{
  const std::string topic = geometry_topic + "/labels";
  ros::Publisher labels = node.advertise<mesh_msgs::MeshFaceCluster>(topic, 10, true);
  auto* display = createMeshDisplay();
  set(display, {"Show Labels", "Labels Topic"}, topic.c_str());
  ASSERT_TRUE(show(display, test_meshes::square()));
  spinFrames();
  const auto before = counts();
  mesh_msgs::MeshFaceCluster label;
  label.label = "tree_1";
  label.face_indices = {0};
  labels.publish(label);
  set(display, {"Show Labels"}, true);
  ASSERT_TRUE(waitForStatus(display, "Labels", "Ok", "1 label"));
  const Image image = picture();
  EXPECT_FALSE(isNear(at(image, 0.5, -0.5), GREEN, 20)) << at(image, 0.5, -0.5);
  EXPECT_FALSE(isNear(at(image, 0.5, -0.5), BACKGROUND, 20));
  EXPECT_EQ(at(image, -0.5, 0.5), GREEN);
  set(display, {"Show Labels"}, false);
  EXPECT_TRUE(shows(0.5, -0.5, GREEN));
  spinFrames();
  EXPECT_EQ(counts(), before);
}

TEST_F(MeshDisplayTest, services_bring_what_no_topic_does)
{
  ros::CallbackQueue queue;
  ros::NodeHandle servers(geometry_topic + "_services");
  servers.setCallbackQueue(&queue);
  const auto uuids = serve<mesh_msgs::GetUUIDs>(
      servers, "get_uuids", [](mesh_msgs::GetUUIDs::Response& answer) { answer.uuids = {"mesh"}; });
  const auto meshes = serve<mesh_msgs::GetGeometry>(
      servers, "get_geometry", [](mesh_msgs::GetGeometry::Response& answer) {
        answer.mesh_geometry_stamped = test_meshes::square();
      });
  std::atomic<int> asked{0};
  const auto colors_server = serve<mesh_msgs::GetVertexColors>(
      servers, "get_vertex_colors", [&asked](mesh_msgs::GetVertexColors::Response& answer) {
        ++asked;
        answer.mesh_vertex_colors_stamped =
            test_meshes::colors(std::vector<std_msgs::ColorRGBA>(4, test_meshes::color(0, 0, 1)));
      });
  ros::AsyncSpinner spinner(1, &queue);
  spinner.start();
  auto* display = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
  set(display, {"Show Wireframe"}, false);
  set(display, {"Show Normals"}, false);
  rviz_mesh_plugin::MeshSource source;
  source.geometry_topic = geometry_topic + "_nobody";
  source.service_namespace = geometry_topic + "_services";
  display->setSource(source);
  ASSERT_TRUE(spinUntil([&] { return display->mesh() != nullptr; })) << status(display, "Services");
  set(display, {"Display Type"}, "Vertex Color");
  EXPECT_TRUE(shows(0, 0, BLUE)) << status(display, "Services");
  EXPECT_TRUE(spinUntil([&] { return !status(display, "Services").empty(); }));
  spin(300);
  EXPECT_EQ(asked, 1);
  delete display;
  spinner.stop();
}
