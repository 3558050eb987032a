#include <malloc.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include "conversion/mesh_conversion.h"
#include "incoming/mesh_loader.h"
#include "support/layout_checks.h"
#include "support/meshes.h"
#include "support/no_threads.h"

using namespace rviz_mesh_plugin;
using Message = mesh_msgs::MeshGeometryStamped;

namespace {

Message::ConstPtr terrain(std::uint32_t cells, const std::string& uuid = "mesh",
                          double height = 0.0)
{
  auto message = boost::make_shared<Message>(
      test_meshes::terrain(cells, [height](double x, double y) { return height + x * y; }));
  message->uuid = uuid;
  return message;
}

/// Refused.
Message::ConstPtr wrongTerrain(std::uint32_t cells)
{
  auto message = boost::make_shared<Message>(*terrain(cells));
  message->mesh_geometry.faces[7].vertex_indices[0] = 4000000000;
  return message;
}

/// Takes from a loader and adds up, until there is nothing more to wait for.
struct Receiver
{
  explicit Receiver(bool with_layouts = true) : loader(with_layouts) {}

  MeshLoader loader;
  std::vector<MeshDataConstPtr> meshes;
  std::vector<MeshLayoutConstPtr> layouts;
  Reception reception;
  std::string working;

  void take()
  {
    const auto content = loader.take();
    meshes.insert(meshes.end(), content.meshes.begin(), content.meshes.end());
    layouts.insert(layouts.end(), content.layouts.begin(), content.layouts.end());
    reception = content.reception;
    working = content.working;
  }

  bool waitFor(const std::function<bool()>& condition)
  {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(40);
    for (take(); !condition(); take()) {
      if (std::chrono::steady_clock::now() > end) {
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  /// A full layout of a mesh with so many faces.
  bool waitForLayout(std::size_t faces)
  {
    return waitFor([this, faces]() {
      return !layouts.empty() && !layouts.back()->preview &&
             layouts.back()->mesh->faceCount() == faces;
    });
  }
};

}  // namespace

TEST(Loader, hands_over_mesh_and_layout)
{
  Receiver receiver;
  receiver.loader.receive(terrain(20));
  ASSERT_TRUE(receiver.waitForLayout(800));
  ASSERT_EQ(receiver.meshes.size(), 1u);
  EXPECT_EQ(receiver.meshes[0]->uuid, "mesh");
  EXPECT_EQ(receiver.layouts[0]->mesh, receiver.meshes[0]);
  layout_checks::expectSound(*receiver.layouts[0]);
  EXPECT_EQ(receiver.reception.accepted, 1u);
  EXPECT_EQ(receiver.reception.refused, 0u);
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.working.empty(); }));
}

TEST(Loader, without_layouts_hands_over_meshes_alone)
{
  Receiver receiver(false);
  receiver.loader.receive(terrain(20, "a"));
  receiver.loader.receive(terrain(20, "b"));
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.meshes.size() == 2; }));
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.working.empty(); }));
  EXPECT_TRUE(receiver.layouts.empty());
}

TEST(Loader, refuses_with_a_sentence_and_goes_on)
{
  Receiver receiver;
  auto bad = test_meshes::square();
  bad.mesh_geometry.faces[1].vertex_indices[0] = 4;
  receiver.loader.receive(boost::make_shared<Message>(bad));
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.reception.refused == 1; }));
  EXPECT_NE(receiver.reception.refusal.find("refers to vertex 4"), std::string::npos)
      << receiver.reception.refusal;
  EXPECT_TRUE(receiver.meshes.empty());
  receiver.loader.receive(terrain(5));
  ASSERT_TRUE(receiver.waitForLayout(50));
  EXPECT_EQ(receiver.reception.accepted, 1u);
  EXPECT_EQ(receiver.reception.refused, 1u);
  EXPECT_EQ(receiver.reception.refusal, "");
  EXPECT_NE(receiver.reception.last_refusal.find("refers to vertex 4"), std::string::npos);
}

TEST(Loader, says_where_no_thread_can_be_started_and_begins_later)
{
  Receiver receiver;
  {
    const NoThreads none;
    receiver.loader.receive(terrain(5));
  }
  receiver.take();
  EXPECT_EQ(receiver.reception.refused, 1u);
  EXPECT_NE(receiver.reception.refusal.find("the mesh cannot be loaded: "), std::string::npos)
      << receiver.reception.refusal;
  receiver.loader.receive(terrain(5));
  ASSERT_TRUE(receiver.waitForLayout(50));
}

TEST(Loader, takes_nothing_that_nobody_wants_any_more)
{
  Receiver receiver;
  const rviz_mesh_plugin::Origin::Flag dropped{true};
  receiver.loader.receive(terrain(5, "dropped"), &dropped);
  receiver.loader.refuse("dropped", &dropped);
  receiver.loader.receive(terrain(5, "wanted"));
  ASSERT_TRUE(receiver.waitForLayout(50));
  ASSERT_EQ(receiver.meshes.size(), 1u);
  EXPECT_EQ(receiver.meshes[0]->uuid, "wanted");
  EXPECT_EQ(receiver.reception.received(), 1u);
}

TEST(Loader, tells_that_materials_belong_to_another_mesh)
{
  Receiver receiver;
  receiver.loader.receive(terrain(5));
  ASSERT_TRUE(receiver.waitForLayout(50));
  auto materials = std::make_shared<Materials>();
  materials->texture_coordinates.resize(3);
  receiver.loader.layOut(receiver.meshes[0], Split::BY_MATERIAL, materials);
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.reception.refused == 1; }));
  EXPECT_NE(receiver.reception.refusal.find("3 texture coordinates for 36 vertices"),
            std::string::npos)
      << receiver.reception.refusal;
}

TEST(Loader, shares_meshes_and_layouts_of_the_same_content_while_they_are_in_use)
{
  Receiver first;
  Receiver second;
  first.loader.receive(terrain(20));
  ASSERT_TRUE(first.waitForLayout(800));
  const std::size_t before = conversions;
  second.loader.receive(terrain(20));
  ASSERT_TRUE(second.waitForLayout(800));
  EXPECT_EQ(conversions, before);
  EXPECT_EQ(second.meshes[0], first.meshes[0]);
  EXPECT_EQ(second.layouts[0], first.layouts[0]);

  auto other_frame = boost::make_shared<Message>(*terrain(20));
  other_frame->header.frame_id = "odom";
  auto other_normals = boost::make_shared<Message>(*terrain(20));
  other_normals->mesh_geometry.vertex_normals.resize(441, test_meshes::point(1, 0, 0));
  for (const Message::ConstPtr& message :
       {Message::ConstPtr(other_frame), terrain(20, "other"), terrain(20, "mesh", 1.0),
        Message::ConstPtr(other_normals)}) {
    second.layouts.clear();
    second.loader.receive(message);
    ASSERT_TRUE(second.waitForLayout(800));
    EXPECT_NE(second.meshes.back(), first.meshes[0]);
  }

  const std::weak_ptr<const MeshData> mesh = first.meshes[0];
  const std::weak_ptr<const MeshLayout> layout = first.layouts[0];
  first.meshes.clear();
  first.layouts.clear();
  second.meshes.clear();
  second.layouts.clear();
  ASSERT_TRUE(first.waitFor([&]() { return mesh.expired() && layout.expired(); }))
      << "something keeps them alive";
}

TEST(Loader, converts_once_what_several_get_at_the_same_time)
{
  std::array<Receiver, 4> receivers;
  const std::size_t before = conversions;
  for (int round = 0; round < 10; ++round) {
    for (Receiver& receiver : receivers) {
      receiver.layouts.clear();
      receiver.loader.receive(terrain(100, "mesh", round));
    }
    for (Receiver& receiver : receivers) {
      ASSERT_TRUE(receiver.waitForLayout(20000));
      ASSERT_EQ(receiver.meshes.back(), receivers[0].meshes.back());
    }
    EXPECT_EQ(conversions - before, round + 1u);
  }
  auto bad = boost::make_shared<Message>(test_meshes::square());
  bad->mesh_geometry.faces[1].vertex_indices[0] = 4;
  for (Receiver& receiver : receivers) {
    receiver.loader.receive(bad);
  }
  for (Receiver& receiver : receivers) {
    ASSERT_TRUE(receiver.waitFor([&]() { return receiver.reception.refused == 1; }));
    EXPECT_NE(receiver.reception.refusal.find("refers to vertex 4"), std::string::npos);
  }
}

TEST(Loader, lays_out_as_asked_for_and_so_again_when_the_same_mesh_comes_again)
{
  Receiver receiver;
  receiver.loader.receive(terrain(20));
  ASSERT_TRUE(receiver.waitForLayout(800));
  const MeshDataConstPtr mesh = receiver.meshes[0];
  const auto layout_by = [&](Split split) {
    return receiver.waitFor(
        [&]() { return !receiver.layouts.empty() && receiver.layouts.back()->split == split; });
  };
  receiver.loader.layOut(mesh, Split::BY_FACE, nullptr);
  ASSERT_TRUE(layout_by(Split::BY_FACE));
  const MeshLayoutConstPtr by_face = receiver.layouts.back();
  receiver.layouts.clear();
  receiver.loader.receive(terrain(20));
  ASSERT_TRUE(receiver.waitForLayout(800));
  EXPECT_EQ(receiver.meshes.back(), mesh);
  EXPECT_EQ(receiver.layouts.back(), by_face);
  const auto materials = std::make_shared<Materials>();
  receiver.loader.layOut(mesh, Split::BY_MATERIAL, materials);
  ASSERT_TRUE(layout_by(Split::BY_MATERIAL));
  EXPECT_EQ(receiver.layouts.back()->materials, materials);
  receiver.loader.receive(terrain(20, "mesh", 1.0));
  ASSERT_TRUE(layout_by(Split::NONE)) << "another mesh is laid out as any new one";
}

TEST(Loader, lays_out_after_all_where_the_message_it_gave_way_to_is_refused)
{
  Receiver receiver;
  receiver.loader.receive(terrain(300));
  ASSERT_TRUE(receiver.waitForLayout(180000));
  const MeshDataConstPtr mesh = receiver.meshes[0];
  const auto wrong = wrongTerrain(300);
  for (int i = 0; i < 5; ++i) {
    receiver.layouts.clear();
    const Split split = i % 2 == 0 ? Split::BY_FACE : Split::NONE;
    receiver.loader.layOut(mesh, split, nullptr);
    ASSERT_TRUE(receiver.waitFor([&] { return !receiver.working.empty(); }));
    receiver.loader.receive(wrong);
    EXPECT_TRUE(receiver.waitFor([&] {
      return !receiver.layouts.empty() && receiver.layouts.back()->split == split;
    })) << i;
  }
  EXPECT_EQ(receiver.reception.refused, 5u);
}

TEST(Loader, lays_out_after_all_though_another_mesh_comes_before_that_message)
{
  Receiver receiver;
  receiver.loader.receive(terrain(300));
  ASSERT_TRUE(receiver.waitForLayout(180000));
  const MeshDataConstPtr mesh = receiver.meshes[0];
  const auto wrong = wrongTerrain(300);
  const auto other = terrain(5, "other");
  receiver.layouts.clear();
  receiver.loader.layOut(mesh, Split::BY_FACE, nullptr);
  ASSERT_TRUE(receiver.waitFor([&] { return !receiver.working.empty(); }));
  receiver.loader.receive(other);
  receiver.loader.receive(wrong);
  ASSERT_TRUE(receiver.waitFor([&] { return receiver.reception.refused == 1; }));
  EXPECT_EQ(receiver.meshes.back()->uuid, "other");
  EXPECT_TRUE(receiver.waitFor([&] {
    return std::any_of(receiver.layouts.begin(), receiver.layouts.end(),
                       [](const auto& layout) { return layout->split == Split::BY_FACE; });
  }));
}

TEST(Loader, never_hands_over_a_preview_after_the_layout)
{
  const std::size_t usual = rviz_mesh_plugin::preview_threshold.exchange(500000);
  Receiver receiver;
  receiver.loader.receive(terrain(510));
  const bool laid_out = receiver.waitForLayout(520200);
  rviz_mesh_plugin::preview_threshold = usual;
  ASSERT_TRUE(laid_out);
  ASSERT_LE(receiver.layouts.size(), 2u);
  if (receiver.layouts.size() == 2) {
    EXPECT_TRUE(receiver.layouts[0]->preview);
  }
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.working.empty(); }));
  EXPECT_LE(receiver.layouts.size(), 2u);
}

TEST(Loader, shows_the_last_of_a_storm_of_messages)
{
  Receiver receiver;
  for (std::uint32_t i = 0; i < 200; ++i) {
    receiver.loader.receive(terrain(1 + i * 37 % 100));
  }
  receiver.loader.receive(terrain(101));
  ASSERT_TRUE(receiver.waitForLayout(2 * 101 * 101));
  EXPECT_LE(receiver.reception.accepted, 201u);
  EXPECT_EQ(receiver.reception.refused, 0u);
}

TEST(Loader, shows_meshes_while_a_storm_lasts)
{
  Receiver receiver;
  std::vector<Message::ConstPtr> storm;
  for (int i = 0; i < 4; ++i) {
    storm.push_back(terrain(300, "mesh", i));
  }
  std::size_t sent = 0;
  // Many arrive while one is laid out.
  ASSERT_TRUE(receiver.waitFor([&]() {
    receiver.loader.receive(storm[sent++ % storm.size()]);
    return receiver.layouts.size() >= 3;
  }));
  EXPECT_GT(sent, 10 * receiver.layouts.size());
}

TEST(Loader, drops_the_oldest_of_too_many_meshes_with_a_sentence)
{
  Receiver receiver;
  for (int i = 0; i < 60; ++i) {
    receiver.loader.receive(terrain(60, "mesh " + std::to_string(i)));
  }
  ASSERT_TRUE(receiver.waitFor([&]() { return receiver.reception.received() == 60; }));
  EXPECT_EQ(receiver.meshes.back()->uuid, "mesh 59");
  EXPECT_GE(receiver.reception.accepted, 16u);
  EXPECT_EQ(receiver.meshes.size(), receiver.reception.accepted);
}

TEST(Loader, forgets_everything_when_cleared)
{
  Receiver receiver;
  for (std::uint32_t round = 0; round < 20; ++round) {
    receiver.loader.receive(terrain(150 + round, "old"));
    if (round % 3 == 1) {
      ASSERT_TRUE(receiver.waitFor([&]() { return receiver.reception.accepted > 0; }));
    } else if (round % 3 == 2) {
      ASSERT_TRUE(receiver.waitFor(
          [&]() { return !receiver.working.empty() || receiver.reception.accepted > 0; }));
    }
    receiver.loader.clear();
    const auto content = receiver.loader.take();
    EXPECT_TRUE(content.meshes.empty());
    EXPECT_TRUE(content.layouts.empty());
    EXPECT_EQ(content.reception.received(), 0u);
    EXPECT_EQ(content.working, "");
  }
  receiver.meshes.clear();
  receiver.layouts.clear();
  receiver.loader.receive(terrain(10, "new"));
  ASSERT_TRUE(receiver.waitForLayout(200));
  ASSERT_EQ(receiver.meshes.size(), 1u);
  EXPECT_EQ(receiver.meshes[0]->uuid, "new");
  EXPECT_EQ(receiver.reception.accepted, 1u);
}

TEST(Loader, may_be_destroyed_at_any_time)
{
  const auto message = terrain(300);
  for (int i = 0; i < 20; ++i) {
    MeshLoader loader(i % 4 != 0);
    loader.receive(message);
    std::this_thread::sleep_for(std::chrono::milliseconds(i));
    if (i % 3 == 0) {
      loader.clear();
    }
  }
}

// A sanitizer has a malloc() of its own.
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
TEST(MeshLoader, large_arrays_go_back_to_the_system_however_large_those_before_were)
{
  const MeshLoader loader;
  const auto mapped = [] { return mallinfo2().hblkhd; };  // bytes of blocks of their own
  constexpr std::size_t BYTES = std::size_t{20} << 20;
  for (int round = 0; round < 3; ++round) {
    std::thread([] { const std::vector<char> freed(BYTES + (std::size_t{1} << 20)); }).join();
    const std::size_t before = mapped();
    const auto kept = std::make_unique<std::vector<char>>(BYTES);
    EXPECT_GE(mapped(), before + BYTES) << round;
  }
}

// All of RViz shares malloc() with the plugin.
TEST(MeshLoader, blocks_of_a_few_megabytes_and_some_free_space_stay_in_the_process)
{
  const MeshLoader loader;
  const std::size_t mapped = mallinfo2().hblkhd;
  const auto middling = std::make_unique<std::vector<char>>(std::size_t{3} << 20);
  EXPECT_EQ(mallinfo2().hblkhd, mapped);
  std::vector<std::vector<char>> kept(200);  // far more than lies free from before
  for (auto& block : kept) {
    block.resize(std::size_t{1} << 18);
  }
  const std::size_t held = mallinfo2().arena;
  for (std::size_t i = 1; i <= 32; ++i) {
    kept[kept.size() - i] = std::vector<char>();
  }
  EXPECT_EQ(mallinfo2().arena, held);
}
#endif
