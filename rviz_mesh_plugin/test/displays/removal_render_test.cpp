#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/GetGeometry.h>
#include <mesh_msgs/GetLabeledClusters.h>
#include <mesh_msgs/GetMaterials.h>
#include <mesh_msgs/GetUUIDs.h>
#include <mesh_msgs/GetVertexColors.h>
#include <mesh_msgs/GetVertexCostLayers.h>
#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <rviz/display_group.h>
#include <rviz/visualization_manager.h>

#include "displays/cluster_label_display.h"
#include "support/display_fixture.h"
#include "support/service_servers.h"

namespace {

constexpr std::uint32_t CELLS = 100;
constexpr std::size_t PREVIEW_FACES = 500000;
constexpr std::uint32_t MANY_CELLS = 600;  // more than PREVIEW_FACES

mesh_msgs::MeshGeometryStampedPtr grid(std::uint32_t cells)
{
  return boost::make_shared<mesh_msgs::MeshGeometryStamped>(
      test_meshes::terrain(cells, [](double x, double y) { return 0.1 * x * y; }));
}

/// How far a display has got when it is removed.
enum class Moment
{
  CREATED,
  SERVICES_HANG,    ///< that were asked for the mesh
  SENT,             ///< the mesh is on its way, or being laid out
  KNOWN,            ///< its data are there, nothing is drawn
  PREVIEWED,        ///< the mesh is still being laid out
  ATTRIBUTES_HANG,  ///< the mesh is drawn, services were asked for more of it
  LAID_OUT_ANEW,    ///< for costs of faces
};
const std::vector<Moment> MOMENTS{
    Moment::CREATED,   Moment::SERVICES_HANG,   Moment::SENT,         Moment::KNOWN,
    Moment::PREVIEWED, Moment::ATTRIBUTES_HANG, Moment::LAID_OUT_ANEW};

}  // namespace

class RemovalTest : public DisplayFixture
{
 protected:
  void SetUp() override
  {
    DisplayFixture::SetUp();
    rviz_mesh_plugin::preview_threshold = PREVIEW_FACES;
    space_ = geometry_topic + "_services";
    // What is shared by all meshes exists before anything is counted.
    auto* display = createMeshDisplay();
    geometry.publish(small_);
    EXPECT_TRUE(spinUntil([&] { return drawn(display); }));
    delete display;
    delete createDisplay("rviz_mesh_plugin/ClusterLabel");
    spinFrames();
    empty_ = counts();
  }

  void TearDown() override
  {
    gate()->open();
    hanging_.clear();
    DisplayFixture::TearDown();
  }

  /// Services that do not answer before the end of the test.
  void hang()
  {
    hang<mesh_msgs::GetUUIDs>("get_uuids");
    hang<mesh_msgs::GetGeometry>("get_geometry");
    hang<mesh_msgs::GetMaterials>("get_materials");
    hang<mesh_msgs::GetVertexColors>("get_vertex_colors");
    hang<mesh_msgs::GetVertexCostLayers>("get_vertex_cost_layers");
    hang<mesh_msgs::GetLabeledClusters>("get_labeled_clusters");
  }

  /// A new display on a topic of its own, brought to a moment of its life.
  Display* displayAt(Moment moment)
  {
    static int number = 0;
    rviz_mesh_plugin::MeshSource source;
    source.geometry_topic = geometry_topic + std::to_string(++number);
    source.face_costs_topic = source.geometry_topic + "/face_costs";
    source.service_namespace = space_;
    face_costs_ = node.advertise<mesh_msgs::MeshFaceCostsStamped>(source.face_costs_topic, 1, true);
    geometry = node.advertise<mesh_msgs::MeshGeometryStamped>(source.geometry_topic, 1, true);
    auto* display = createMeshDisplay();
    display->setSource(source);
    if (moment == Moment::CREATED) {
      return display;
    }
    if (moment == Moment::SERVICES_HANG) {  // asked since the topic is silent
      EXPECT_TRUE(spinUntil([&] { return gate()->reached > 0; }));
      return display;
    }
    spinFrames(1);
    const bool many = moment == Moment::SENT || moment == Moment::PREVIEWED;
    geometry.publish(many ? large_ : small_);
    if (moment == Moment::SENT) {
      spin(5);
      return display;
    }
    EXPECT_TRUE(spinUntil([&] { return display->mesh() != nullptr; }));
    if (moment == Moment::KNOWN) {
      return display;
    }
    EXPECT_TRUE(spinUntil([&] { return display->visual() != nullptr; }));
    if (moment == Moment::PREVIEWED) {
      return display;
    }
    EXPECT_TRUE(spinUntil([&] { return drawn(display); }));
    if (moment == Moment::LAID_OUT_ANEW) {
      mesh_msgs::MeshFaceCostsStamped costs;
      costs.header.frame_id = "map";
      costs.uuid = "mesh";
      costs.type = "faces";
      costs.mesh_face_costs.costs.resize(small_->mesh_geometry.faces.size(), 1.0f);
      set(display, {"Display Type"}, "Vertex Costs");
      set(display, {"Display Type", "Vertex Costs Type"}, "faces");
      face_costs_.publish(costs);
      EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'faces'"));
    } else {
      set(display, {"Display Type"}, "Textures");
      EXPECT_TRUE(spinUntil([&] { return gate()->reached > 0; }));
    }
    return display;
  }

  static bool drawn(const Display* display)
  {
    const auto* visual = display->visual();
    return visual && visual->layout() && !visual->layout()->preview && visual->progress() >= 1.0f;
  }

  /// Where calls hang from now on; the earlier ones are refused.
  void hangAnew()
  {
    const auto last = gate();
    std::atomic_store(&gate_, std::make_shared<service_servers::Gate>());
    last->open();
  }

  std::shared_ptr<service_servers::Gate> gate() const { return std::atomic_load(&gate_); }

  const osmesa_harness::SceneCounts& empty() const { return empty_; }
  const std::string& serviceNamespace() const { return space_; }

 private:
  template <class Service>
  void hang(const std::string& name)
  {
    hanging_.push_back(servers_.serve<Service>(
        space_ + "/" + name, [this](typename Service::Request&, typename Service::Response&) {
          gate()->pass();
          return false;
        }));
  }

  std::shared_ptr<service_servers::Gate> gate_ = std::make_shared<service_servers::Gate>();
  service_servers::Servers servers_;
  std::vector<ros::ServiceServer> hanging_;
  const mesh_msgs::MeshGeometryStampedPtr small_ = grid(CELLS);
  const mesh_msgs::MeshGeometryStampedPtr large_ = grid(MANY_CELLS);
  ros::Publisher face_costs_;
  std::string space_;
  osmesa_harness::SceneCounts empty_;
};

TEST_F(RemovalTest, of_a_mesh_at_every_moment_in_every_way)
{
  const std::vector<std::function<void(Display*)>> ways{
      [](Display* display) { delete display; },
      [](Display*) { manager()->removeAllDisplays(); },
      [](Display* display) {
        display->setEnabled(false);
        delete display;
      },
      [](Display* display) {
        display->reset();
        delete display;
      },
      [](Display* display) {
        display->setEnabled(false);
        display->reset();
        display->setEnabled(true);
        spinFrames(1);
        delete display;
      },
      [](Display* display) {
        display->setSource({});
        spinFrames(1);
        delete display;
      },
      [](Display* display) {
        set(display, {"Display Type"}, "Hide Faces");
        set(display, {"Show Normals"}, true);
        spinFrames(1);
        delete display;
      }};
  hang();
  for (const Moment moment : MOMENTS) {
    for (std::size_t way = 0; way < ways.size(); ++way) {
      hangAnew();
      ways[way](displayAt(moment));
      EXPECT_EQ(manager()->getRootDisplayGroup()->numDisplays(), 0);
      spinFrames(1);
      ASSERT_EQ(counts(), empty()) << "moment " << static_cast<int>(moment) << ", way " << way;
    }
  }
}

TEST_F(RemovalTest, of_labels_whose_services_hang)
{
  using Labels = rviz_mesh_plugin::ClusterLabelDisplay;
  hang();
  for (int i = 0; i < 6; ++i) {
    hangAnew();
    rviz_mesh_plugin::MeshSource source;
    source.geometry_topic = geometry_topic;
    source.labels_topic = serviceNamespace() + "/new_cluster_label";
    source.service_namespace = serviceNamespace();
    auto* display = createDisplayAs<Labels>("rviz_mesh_plugin/ClusterLabel");
    display->setSource(source);
    EXPECT_TRUE(spinUntil([&] { return i < 2 || gate()->reached > 0; }));
    if (i % 2 == 1) {
      display->reset();
      spinFrames(i - 1);
    }
    delete display;
    spinFrames(1);
    ASSERT_EQ(counts(), empty()) << i;
  }
}

TEST_F(RemovalTest, of_everything_that_is_drawn_and_back)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Hide Faces");  // before there is a mesh
  geometry.publish(test_meshes::square());
  ASSERT_TRUE(waitForStatus(display, "Geometry", "Ok", "4 vertices, 2 faces"));
  const auto isDrawn = [] { return !(grab().center() == osmesa_harness::Rgb{48, 48, 48}); };
  EXPECT_FALSE(isDrawn());
  for (int i = 0; i < 20; ++i) {
    set(display, {"Display Type"}, "Fixed Color");
    EXPECT_TRUE(spinUntil(isDrawn)) << i;  // once it was uploaded: the first frame may be too late
    set(display, {"Display Type"}, "Hide Faces");
    EXPECT_FALSE(isDrawn()) << i;
    if (i % 4 == 0) {
      display->reset();
      geometry.publish(test_meshes::square());
      ASSERT_TRUE(waitForStatus(display, "Geometry", "Ok", "4 vertices, 2 faces"));
      EXPECT_FALSE(isDrawn()) << i;
    } else if (i % 4 == 1) {
      display->setEnabled(false);
      display->setEnabled(true);
    }
  }
  delete display;
  spinFrames();
  EXPECT_EQ(counts(), empty());
}

TEST_F(RemovalTest, of_data_a_thousand_times_while_they_come)
{
  auto* display = createMeshDisplay();
  for (int i = 0; i < 1000; ++i) {
    if (i % 10 == 0) {
      geometry.publish(test_meshes::terrain(i % 50 + 2, [](double, double) { return 0.0; }));
      spin(i % 7);
    }
    display->reset();
  }
  geometry.publish(test_meshes::square());
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "4 vertices, 2 faces"));
  display->reset();
  EXPECT_EQ(display->visual(), nullptr);
  delete display;
  spinFrames();
  EXPECT_EQ(counts(), empty());
}
