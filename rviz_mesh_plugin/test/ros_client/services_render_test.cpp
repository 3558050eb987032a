#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/GetGeometry.h>
#include <mesh_msgs/GetLabeledClusters.h>
#include <mesh_msgs/GetMaterials.h>
#include <mesh_msgs/GetTexture.h>
#include <mesh_msgs/GetUUID.h>
#include <mesh_msgs/GetUUIDs.h>
#include <mesh_msgs/GetVertexColors.h>
#include <mesh_msgs/GetVertexCostLayers.h>
#include <mesh_msgs/GetVertexCosts.h>

#include "ros_client/map_service_client.h"
#include "support/meshes.h"
#include "support/raw_messages.h"
#include "support/service_servers.h"

namespace ros {
namespace service_traits {

template <>
struct MD5Sum<RawBytes>
{
  static const char* value() { return MD5Sum<mesh_msgs::GetVertexColors>::value(); }
};

template <>
struct DataType<RawBytes>
{
  static const char* value() { return DataType<mesh_msgs::GetVertexColors>::value(); }
};

}  // namespace service_traits
}  // namespace ros

using namespace mesh_msgs;
using rviz_mesh_plugin::AttributeQueue;
using rviz_mesh_plugin::MapServiceClient;
using rviz_mesh_plugin::MeshLoader;
using rviz_mesh_plugin::QueuedAttributes;
using service_servers::DyingServer;
using service_servers::Gate;
using service_servers::waitFor;
using State = rviz_mesh_plugin::ServiceReport::State;

namespace {

/// get_vertex_colors with any bytes as the answer.
struct RawService
{
  using Request = RawBytes;
  using Response = RawBytes;
};

class Services : public testing::Test
{
 public:
  Services()
  {
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    space = "/" + test;
    names.service_namespace = space;
    services->setNames(names);
  }

  /// A server that says where it is, by its color.
  ros::ServiceServer serveColors(const std::string& name, float red, const std::string& uuid = "")
  {
    return servers.serve<GetVertexColors>(
        name,
        [this, red, uuid](GetVertexColors::Request& request, GetVertexColors::Response& response) {
          ++color_calls;
          response.mesh_vertex_colors_stamped = test_meshes::colors(
              {test_meshes::color(red, 0, 0)}, uuid.empty() ? request.uuid : uuid);
          return true;
        });
  }

  /// The red of the colors that have arrived, -1 if none do.
  int receivedRed()
  {
    QueuedAttributes content;
    waitFor([&]() {
      content = queue->take();
      return !content.colors.empty();
    });
    return content.colors.empty() ? -1 : content.colors[0]->colors[0].red;
  }

  bool reaches(State state, const std::string& part)
  {
    const bool reached = waitFor([&]() {
      const auto report = services->report();
      return report.worst == state && report.text.find(part) != std::string::npos;
    });
    EXPECT_TRUE(reached) << services->report().text;
    return reached;
  }

  service_servers::Servers servers;
  std::shared_ptr<AttributeQueue> queue = std::make_shared<AttributeQueue>();
  std::shared_ptr<MeshLoader> loader = std::make_shared<MeshLoader>(false);
  std::unique_ptr<MapServiceClient> services = std::make_unique<MapServiceClient>(queue, loader);
  rviz_mesh_plugin::ServiceNames names;
  std::string space;
  std::atomic<int> color_calls{0};
};

}  // namespace

TEST_F(Services, bring_colors_layers_and_labels)
{
  const auto colors = serveColors(space + "/get_vertex_colors", 1.0f);
  const auto layers = servers.serve<GetVertexCostLayers>(
      space + "/get_vertex_cost_layers",
      [](GetVertexCostLayers::Request&, GetVertexCostLayers::Response& response) {
        response.layers = {"slope", "border"};
        return true;
      });
  const auto costs = servers.serve<GetVertexCosts>(
      space + "/get_vertex_costs",
      [](GetVertexCosts::Request& request, GetVertexCosts::Response& response) {
        response.mesh_vertex_costs_stamped = test_meshes::costs(request.layer, {1.0f, 2.0f});
        return true;
      });
  const auto labels = servers.serve<GetLabeledClusters>(
      space + "/get_labeled_clusters",
      [](GetLabeledClusters::Request&, GetLabeledClusters::Response& response) {
        response.clusters.resize(1);
        response.clusters[0].label = "tree_1";
        response.clusters[0].face_indices = {3};
        return true;
      });
  EXPECT_EQ(services->report().text, "");
  for (int i = 0; i < 3; ++i) {  // each is asked once
    services->requestColors("mesh");
    services->requestCosts("mesh");
    services->requestLayer("mesh", "border");
    services->requestLabels("mesh");
  }
  ASSERT_TRUE(reaches(State::ANSWERED, "2 cost layers"));
  ASSERT_TRUE(reaches(State::ANSWERED, "1 labels"));
  EXPECT_EQ(services->layers("mesh"), (std::vector<std::string>{"slope", "border"}));
  EXPECT_TRUE(services->layers("other").empty());
  const auto content = queue->take();
  ASSERT_EQ(content.colors.size(), 1u);
  ASSERT_EQ(content.costs.size(), 1u);
  EXPECT_EQ(content.costs[0]->type, "border");
  ASSERT_EQ(content.labels.size(), 1u);
  EXPECT_TRUE(content.labels[0]->all);
  EXPECT_EQ(content.labels[0]->uuid, "mesh");
  EXPECT_EQ(color_calls, 1);
  services->cancel();
  services->requestColors("mesh");
  EXPECT_EQ(receivedRed(), 255);
  EXPECT_EQ(color_calls, 2) << "cancel() forgets what was asked";
}

TEST_F(Services, bring_materials_and_each_of_fifty_textures_once)
{
  std::mutex mutex;
  std::map<std::uint32_t, int> asked;
  const auto materials = servers.serve<GetMaterials>(
      space + "/get_materials",
      [](GetMaterials::Request& request, GetMaterials::Response& response) {
        auto& stamped = response.mesh_materials_stamped;
        stamped.header.frame_id = "map";
        stamped.uuid = request.uuid;
        stamped.mesh_materials.vertex_tex_coords.resize(4);
        stamped.mesh_materials.materials.resize(102);
        for (std::uint32_t i = 0; i < 102; ++i) {
          auto& material = stamped.mesh_materials.materials[i];
          material.has_texture = i != 0;
          material.texture_index = i == 0 ? 999 : i == 101 ? 0xFFFFFFFF : (i - 1) / 2;
        }
        return true;
      });
  const auto textures = servers.serve<GetTexture>(
      space + "/get_texture", [&](GetTexture::Request& request, GetTexture::Response& response) {
        const std::lock_guard<std::mutex> lock(mutex);
        ++asked[request.texture_index];
        auto& image = response.texture.image;
        response.texture.texture_index = request.texture_index + (request.texture_index == 17);
        image.encoding = request.texture_index == 9 ? "jpeg" : "mono8";
        image.width = image.height = image.step = 1;
        image.data = {static_cast<std::uint8_t>(request.texture_index)};
        return request.texture_index != 30;
      });
  EXPECT_FALSE(services->missesTextures("mesh"));
  services->requestMaterials("mesh");
  services->requestMaterials("mesh");
  ASSERT_TRUE(reaches(State::FAILED, "(47 of 50 textures, 3 refused)"));
  EXPECT_TRUE(waitFor([&] { return services->missesTextures("mesh"); }));
  EXPECT_NE(services->report().text.find("answers with what cannot be shown"), std::string::npos)
      << "the first of the three: " << services->report().text;
  const auto content = queue->take();
  EXPECT_EQ(content.materials.size(), 1u);
  ASSERT_EQ(content.textures.size(), 47u);
  EXPECT_EQ(content.textures[3]->index, 3u);
  EXPECT_EQ(content.textures[3]->uuid, "mesh") << "though the server names none";
  EXPECT_EQ(content.textures[3]->pixels[0].red, 3);
  const std::lock_guard<std::mutex> lock(mutex);
  EXPECT_EQ(asked.size(), 50u);
  for (const auto& one : asked) {
    EXPECT_EQ(one.second, 1) << one.first;
  }
}

TEST_F(Services, are_waited_for)
{
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::SEARCHING, "there is no " + space + "/get_vertex_colors"));
  const auto server = serveColors(space + "/get_vertex_colors", 1.0f);
  EXPECT_EQ(receivedRed(), 255);
  ASSERT_TRUE(reaches(State::ANSWERED, space + "/get_vertex_colors has answered"));
}

TEST_F(Services, that_refuse_are_not_asked_at_once_and_their_reason_is_told)
{
  std::atomic<int> calls{0};
  const auto server = servers.serve<GetVertexColors>(
      space + "/get_vertex_colors", [&](GetVertexColors::Request&, GetVertexColors::Response&) {
        ++calls;
        if (calls == 2) {
          throw std::runtime_error("there are no\ncolors in garden.h5");
        }
        return false;
      });
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::FAILED, "/get_vertex_colors refuses: it gives no reason"));
  services->requestColors("mesh");
  services->cancel();
  EXPECT_EQ(services->report().text, "");
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::FAILED, "refuses: there are no colors in garden.h5"));
  EXPECT_EQ(calls, 2);
}

TEST_F(Services, that_refuse_or_have_nothing_are_asked_again_while_it_is_wanted)
{
  services = std::make_unique<MapServiceClient>(queue, loader, std::chrono::milliseconds(5),
                                                std::chrono::milliseconds(20));
  services->setNames(names);
  std::atomic<bool> loaded{false};
  std::atomic<int> layer_calls{0};
  const auto layers = servers.serve<GetVertexCostLayers>(
      space + "/get_vertex_cost_layers",
      [&](GetVertexCostLayers::Request&, GetVertexCostLayers::Response& response) {
        response.layers.resize(++layer_calls > 2 ? 1 : 0, "late");
        return true;
      });
  std::atomic<int> cost_calls{0};
  const auto costs = servers.serve<GetVertexCosts>(
      space + "/get_vertex_costs",
      [&](GetVertexCosts::Request& request, GetVertexCosts::Response& response) {
        response.mesh_vertex_costs_stamped = test_meshes::costs(request.layer, {1.0f});
        return ++cost_calls > 3;
      });
  const auto geometry = servers.serve<GetGeometry>(
      space + "/get_geometry", [&](GetGeometry::Request& request, GetGeometry::Response& response) {
        response.mesh_geometry_stamped = test_meshes::square();
        response.mesh_geometry_stamped.uuid = request.uuid;
        return loaded.load();
      });
  services->requestMesh("mesh");
  ASSERT_TRUE(
      reaches(State::FAILED, "get_geometry refuses: it gives no reason; it is asked again"));
  loaded = true;
  ASSERT_TRUE(waitFor([&] {
    services->requestMesh("mesh");
    return !loader->take().meshes.empty();
  }));
  ASSERT_TRUE(waitFor([&] {
    services->requestCosts("mesh");
    return !services->layers("mesh").empty();
  }));
  EXPECT_EQ(services->layers("mesh"), std::vector<std::string>{"late"});
  ASSERT_TRUE(waitFor([&] {
    services->requestLayer("mesh", "late");
    return cost_calls == 4;
  }));
  ASSERT_TRUE(reaches(State::ANSWERED, "(1 of 1 layers)")) << "a refusal of before counts no more";
  for (int i = 0; i < 100; ++i) {
    services->requestLayer("mesh", "late");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(cost_calls, 4) << "what has come is not asked for again";
}

TEST_F(Services, whose_answer_lies_about_its_length_are_refused)
{
  const auto liar =
      servers.serve<RawService>(space + "/get_vertex_colors", [](RawBytes&, RawBytes& response) {
        response.bytes = raw_messages::bytesOf(GetVertexColors::Response());
        const std::uint32_t huge = 0x20000000;
        std::memcpy(response.bytes.data() + response.bytes.size() - 4, &huge, sizeof(huge));
        return true;
      });
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::FAILED,
                      "gives an answer that cannot be read: an array of 536870912 "
                      "std_msgs/ColorRGBA needs 8589934592 bytes"));
}

TEST_F(Services, that_have_nothing_of_a_mesh_say_so_and_bring_nothing)
{
  const auto colors = servers.serve<GetVertexColors>(
      space + "/get_vertex_colors",
      [](GetVertexColors::Request&, GetVertexColors::Response&) { return true; });
  const auto materials = servers.serve<GetMaterials>(
      space + "/get_materials", [](GetMaterials::Request& request, GetMaterials::Response& answer) {
        answer.mesh_materials_stamped.uuid = request.uuid;
        return true;
      });
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::ANSWERED, "has answered: the mesh has no vertex colors"));
  services->requestMaterials("mesh");
  ASSERT_TRUE(reaches(State::ANSWERED, "has answered: the mesh has no materials"));
  const QueuedAttributes content = queue->take();
  EXPECT_TRUE(content.colors.empty());
  EXPECT_TRUE(content.materials.empty());
}

TEST_F(Services, that_hang_hold_up_nothing_else)
{
  Gate gate;
  const auto hanging = servers.serve<GetMaterials>(
      space + "/get_materials", [&](GetMaterials::Request&, GetMaterials::Response& response) {
        gate.pass();
        response.mesh_materials_stamped.header.frame_id = "map";
        return true;
      });
  const auto colors = serveColors(space + "/get_vertex_colors", 1.0f);
  services->requestMaterials("mesh");
  ASSERT_TRUE(waitFor([&]() { return gate.reached == 1; }));
  services->requestColors("mesh");
  EXPECT_EQ(receivedRed(), 255);
  ASSERT_TRUE(reaches(State::WAITING, "/get_materials was asked"));
  services->cancel();  // would wait for the gate forever
  services->requestMaterials("mesh");
  ASSERT_TRUE(waitFor([&]() { return gate.reached == 2; }));
  services.reset();
  gate.open();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_TRUE(queue->take().materials.empty()) << "nothing arrives after the end";
  EXPECT_EQ(queue.use_count(), 1) << "the threads have ended";
}

TEST_F(Services, of_another_type_are_named_and_the_right_one_is_waited_for)
{
  auto wrong =
      servers.serve<GetTexture>(space + "/get_vertex_colors",
                                [](GetTexture::Request&, GetTexture::Response&) { return true; });
  services->requestColors("mesh");
  ASSERT_TRUE(
      reaches(State::FAILED,
              "it is of the type mesh_msgs/GetTexture and not of mesh_msgs/GetVertexColors"));
  wrong.shutdown();
  const auto right = serveColors(space + "/get_vertex_colors", 1.0f);
  EXPECT_EQ(receivedRed(), 255);
}

TEST_F(Services, that_die_while_they_answer_are_asked_again)
{
  std::unique_ptr<DyingServer> dying(
      DyingServer::of<GetVertexColors>(space + "/get_vertex_colors"));
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::SEARCHING, "closed the connection in the middle of its answer"));
  ASSERT_TRUE(waitFor([&]() { return dying->calls >= 2; }));
  dying.reset();
  const auto server = serveColors(space + "/get_vertex_colors", 1.0f);
  EXPECT_EQ(receivedRed(), 255);
}

TEST_F(Services, of_a_dead_process_are_waited_for)
{
  {
    std::unique_ptr<DyingServer> dead(
        DyingServer::of<GetVertexColors>(space + "/get_vertex_colors"));
    XmlRpc::XmlRpcValue request, response, payload;  // what a killed process leaves behind
    request[0] = "/dead";
    request[1] = space + "/get_labeled_clusters";
    request[2] = "rosrpc://127.0.0.1:1";
    request[3] = "http://127.0.0.1:1/";
    ros::master::execute("registerService", request, response, payload, false);
  }
  services->requestLabels("mesh");
  ASSERT_TRUE(reaches(State::SEARCHING, "nobody accepts connections at 127.0.0.1:1"));
}

TEST_F(Services, have_names_beside_the_topic_and_one_level_above_it)
{
  using Names = std::vector<std::string>;
  const auto candidates = [&](const std::string& topic, const std::string& name = "get_geometry") {
    rviz_mesh_plugin::ServiceNames of;
    of.geometry_topic = topic;
    return rviz_mesh_plugin::serviceCandidates(name, of);
  };
  EXPECT_EQ(candidates("/robot_2/mesh/geometry"),
            (Names{"/robot_2/mesh/get_geometry", "/robot_2/get_geometry"}));
  EXPECT_EQ(candidates("/mesh/geometry"), (Names{"/mesh/get_geometry", "/get_geometry"}));
  EXPECT_EQ(candidates("/geometry"), (Names{"/get_geometry"}));
  EXPECT_EQ(candidates("/a/b/c/d/e"), (Names{"/a/b/c/d/get_geometry", "/a/b/c/get_geometry"}));
  EXPECT_EQ(candidates("/a/b/c/d/e", "maps/get"), (Names{"/a/b/c/d/maps/get", "/a/b/c/maps/get"}));
  EXPECT_EQ(candidates("/a/b/c/d/e", "/get_geometry"), (Names{"/get_geometry"}));
  EXPECT_EQ(candidates(""), (Names{"/get_geometry"})) << "RViz's own, where no topic is named";
  EXPECT_EQ(candidates("no name"), Names()) << "it is not looked for elsewhere";
}

TEST_F(Services, are_looked_for_around_the_geometry_topic)
{
  names.service_namespace.clear();
  names.geometry_topic = space + "/robot/map/mesh";
  services->setNames(names);
  const auto of_another = serveColors(space + "/get_vertex_colors", 0.1f);
  auto above = serveColors(space + "/robot/get_vertex_colors", 0.2f);
  services->requestColors("mesh");
  EXPECT_EQ(receivedRed(), 51) << "above the topic";
  services->cancel();
  const auto beside = serveColors(space + "/robot/map/get_vertex_colors", 0.4f);
  services->requestColors("mesh");
  EXPECT_EQ(receivedRed(), 102) << "beside the topic, which is nearer";
  names.colors = space + "/robot/get_vertex_colors";
  services->setNames(names);
  services->requestColors("mesh");
  EXPECT_EQ(receivedRed(), 51) << "an absolute name is taken";
  above.shutdown();
  names.colors = "get_vertex_colors";
  names.geometry_topic = space + "/robot/other_map/mesh";
  services->setNames(names);
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::SEARCHING, "there is no " + space +
                                            "/robot/other_map/get_vertex_colors and " + space +
                                            "/robot/get_vertex_colors;"));
  EXPECT_EQ(queue->take().colors.size(), 0u) << "of another robot's map";
  names.colors = "not a name";
  services->setNames(names);
  services->requestColors("mesh");
  ASSERT_TRUE(reaches(State::FAILED, "is no name of a service"));
  names.colors.clear();
  services->setNames(names);
  services->requestColors("mesh");
  EXPECT_EQ(services->report().text, "") << "without a name nothing is asked";
}

TEST_F(Services, of_another_map_are_told_apart)
{
  const auto server = serveColors(space + "/get_vertex_colors", 1.0f, "garden");
  services->requestColors("quarry");
  ASSERT_TRUE(reaches(State::FAILED, "answers for the mesh 'garden', but 'quarry' is shown"));
  EXPECT_TRUE(queue->take().colors.empty());
  services->requestColors("mesh");  // the only one
  EXPECT_EQ(receivedRed(), 255);
}

TEST_F(Services, bring_the_mesh_under_every_name_of_its_identity)
{
  std::mutex mutex;
  std::string asked;
  const auto geometry = servers.serve<GetGeometry>(
      space + "/get_geometry", [&](GetGeometry::Request& request, GetGeometry::Response& response) {
        const std::lock_guard<std::mutex> lock(mutex);
        asked = request.uuid;
        response.mesh_geometry_stamped = test_meshes::square(double(request.uuid.size()));
        response.mesh_geometry_stamped.uuid = request.uuid;
        return true;
      });
  const auto mesh_of = [&](const std::string& uuid) {
    services->cancel();
    services->requestMesh(uuid);
    std::string found = "none";
    waitFor([&]() {
      const auto content = loader->take();
      found = content.meshes.empty() ? found : content.meshes.back()->uuid;
      return found != "none";
    });
    return found;
  };
  EXPECT_EQ(mesh_of("asked_for"), "asked_for");
  EXPECT_EQ(mesh_of(""), "") << "get_geometry alone";
  {
    const auto single = servers.serve<GetUUID>(space + "/get_uuid",
                                               [](GetUUID::Request&, GetUUID::Response& response) {
                                                 response.uuid = "single";
                                                 return true;
                                               });
    EXPECT_EQ(mesh_of(""), "single") << "release 1.0";
  }
  {
    auto all = std::make_shared<std::vector<std::string>>();
    const auto listed = servers.serve<GetUUIDs>(
        space + "/get_uuid", [all](GetUUIDs::Request&, GetUUIDs::Response& response) {
          response.uuids = *all;
          if (all->empty()) {
            all->push_back("late");
          }
          return true;
        });
    EXPECT_EQ(mesh_of(""), "late") << "as release 1.1 asks, from a server that loads its map first";
  }
  const auto listed = servers.serve<GetUUIDs>(space + "/get_uuids",
                                              [](GetUUIDs::Request&, GetUUIDs::Response& response) {
                                                response.uuids = {"first", "second"};
                                                return true;
                                              });
  EXPECT_EQ(mesh_of(""), "first") << "as release 1.1 serves";
}
