#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "label_editing/pending_edits.h"
#include "panel/label_list_model.h"

using namespace std::chrono_literals;
using rviz_mesh_plugin::LabelAreas;
using rviz_mesh_plugin::LabelCluster;
using rviz_mesh_plugin::LabelClusters;
using rviz_mesh_plugin::LabelEdit;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::PendingEdits;
using rviz_mesh_plugin::Rgba8;

namespace {

LabelEdit facesOf(const std::string& label, const std::vector<std::uint32_t>& faces,
                  const std::string& after = "")
{
  LabelEdit edit;
  edit.mesh = {"mesh", 0};
  edit.label = label;
  edit.faces = std::make_shared<std::vector<std::uint32_t>>(faces);
  edit.after = after;
  return edit;
}

LabelEdit colorOf(const std::string& label)
{
  LabelEdit edit = facesOf(label, {});
  edit.faces = nullptr;
  edit.color = Rgba8{1, 2, 3, 255};
  return edit;
}

using Names = std::vector<std::string>;

/// Stores what it is told to.
struct Owner
{
  PendingEdits edits{10s};
  PendingEdits::Clock::time_point now;
  std::vector<std::string> sent;
  std::set<std::string> stored;
  Names asked;
  std::string refusal;

  static std::string nameOf(const LabelEdit& edit)
  {
    return edit.faces ? edit.label : edit.label + " color";
  }

  std::size_t work()
  {
    return edits
        .work(
            now, [this](const LabelEdit& edit) { return stored.count(nameOf(edit)) != 0; },
            [this](const LabelEdit& edit) {
              sent.push_back(nameOf(edit));
              return refusal;
            },
            [this](const LabelEdit& edit) { asked.push_back(nameOf(edit)); })
        .size();
  }
};

}  // namespace

TEST(PendingEdits, are_sent_once_and_end_when_they_are_stored)
{
  Owner owner;
  owner.edits.add(facesOf("a", {1}));
  owner.edits.add(facesOf("b", {2}));
  EXPECT_EQ(owner.work(), 0u);
  EXPECT_EQ(owner.work(), 0u);
  EXPECT_EQ(owner.sent, (Names{"a", "b"}));
  owner.stored = {"a"};
  EXPECT_EQ(owner.work(), 1u);
  EXPECT_FALSE(owner.edits.isPending({"mesh", 0}, "a"));
  EXPECT_TRUE(owner.edits.isPending({"mesh", 0}, "b"));
  EXPECT_FALSE(owner.edits.isPending({"other", 0}, "b"));
  EXPECT_EQ(*owner.edits.find({"mesh", 0}, "b")->faces, (std::vector<std::uint32_t>{2}));
  EXPECT_EQ(owner.edits.labels({"mesh", 0}), Names{"b"});
}

TEST(PendingEdits, wait_for_those_that_come_before_them)
{
  Owner owner;
  owner.edits.add(colorOf("new"));
  owner.edits.add(facesOf("a", {}, "new"));
  owner.edits.add(facesOf("new", {1}));
  owner.work();
  EXPECT_EQ(owner.sent, Names{"new"});
  owner.stored = {"new"};
  owner.work();
  EXPECT_EQ(owner.sent, (Names{"new", "new color"}));
  owner.stored.insert("new color");
  owner.work();
  EXPECT_EQ(owner.sent, (Names{"new", "new color", "a"}));
}

TEST(PendingEdits, do_not_wait_for_each_other_the_one_with_faces_goes_first)
{
  Owner owner;
  owner.edits.add(facesOf("b", {1}));
  owner.edits.add(facesOf("a", {}, "b"));
  owner.edits.add(facesOf("c", {1}));
  owner.edits.add(facesOf("b", {}, "c"));
  owner.edits.add(facesOf("a", {1}, "b"));  // as it was to be cleared before
  owner.edits.add(facesOf("c", {}, "a"));
  owner.work();
  EXPECT_EQ(owner.sent, Names{"a"});
  owner.stored = {"a"};
  owner.work();
  EXPECT_EQ(owner.sent, (Names{"a", "c"}));
  owner.stored.insert("c");
  owner.work();
  EXPECT_EQ(owner.sent, (Names{"a", "c", "b"}));
}

TEST(PendingEdits, of_a_color_go_with_their_label)
{
  Owner owner;
  owner.edits.add(facesOf("a", {1}));
  owner.edits.add(colorOf("a"));
  owner.edits.add(facesOf("a", {}));
  EXPECT_EQ(owner.edits.count(), 1u);
  owner.stored = {"a"};
  owner.work();
  owner.work();
  EXPECT_EQ(owner.sent, Names{"a"}) << "who stores labels has none to color";
}

TEST(PendingEdits, that_fail_are_kept_and_can_be_sent_again)
{
  Owner owner;
  owner.refusal = "nobody listens";
  owner.edits.add(facesOf("a", {1}));
  owner.edits.add(facesOf("b", {}, "a"));
  owner.work();
  owner.work();
  EXPECT_EQ(owner.sent, Names{"a"});
  EXPECT_EQ(owner.edits.failed(), 1u);
  EXPECT_EQ(owner.edits.failure(), "label 'a' is not stored: nobody listens");
  owner.refusal.clear();
  owner.edits.sendAgain();
  owner.work();
  EXPECT_EQ(owner.edits.failed(), 0u);
  owner.now += 10s;
  owner.work();
  EXPECT_EQ(owner.edits.failed(), 0u) << "not late yet";
  owner.now += 1ms;
  owner.work();
  EXPECT_NE(owner.edits.failure().find("has not come back"), std::string::npos);
  EXPECT_EQ(owner.edits.status()->text, owner.edits.failure());
  EXPECT_EQ(owner.sent, (Names{"a", "a"}));
  owner.stored = {"a"};
  EXPECT_EQ(owner.work(), 1u) << "late, but stored";
  EXPECT_EQ(owner.sent, (Names{"a", "a", "b"}));
  owner.edits.giveUp();
  EXPECT_EQ(owner.edits.count(), 0u);
}

TEST(PendingEdits, are_asked_for_once_where_they_do_not_come_back)
{
  Owner owner;
  owner.edits.add(facesOf("a", {1}));
  owner.edits.add(facesOf("b", {2}, "a"));
  owner.work();
  owner.now += 5s;
  owner.work();
  EXPECT_EQ(owner.asked, Names{});
  owner.now += 1ms;
  owner.work();
  owner.work();
  EXPECT_EQ(owner.asked, Names{"a"}) << "the other one has not been sent";
  owner.now += 10s;
  owner.work();
  ASSERT_EQ(owner.edits.failed(), 1u);
  owner.edits.sendAgain();
  owner.work();
  owner.now += 6s;
  owner.work();
  EXPECT_EQ(owner.asked, (Names{"a", "a"})) << "of the second time";
}

TEST(PendingEdits, the_newest_of_a_label_counts)
{
  Owner owner;
  owner.edits.add(facesOf("a", {1}));
  owner.work();
  owner.edits.add(facesOf("a", {2}));
  EXPECT_EQ(owner.edits.count(), 1u);
  owner.work();
  EXPECT_EQ(owner.sent, (Names{"a", "a"}));
  EXPECT_EQ(*owner.edits.find({"mesh", 0}, "a")->faces, (std::vector<std::uint32_t>{2}));
}

TEST(PendingEdits, of_meshes_with_one_uuid_are_kept_apart)
{
  Owner owner;
  LabelEdit small = facesOf("a", {1});
  small.mesh.second = 2;
  LabelEdit large = facesOf("a", {1, 2});
  large.mesh.second = 200;
  owner.edits.add(small);
  owner.edits.add(large);
  EXPECT_EQ(owner.edits.count(), 2u);
  EXPECT_EQ(*owner.edits.find({"mesh", 2}, "a")->faces, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(*owner.edits.find({"mesh", 200}, "a")->faces, (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(owner.edits.find({"mesh", 3}, "a"), nullptr);
  EXPECT_FALSE(owner.edits.isPending({"mesh", 3}, "a"));
  EXPECT_TRUE(owner.edits.labels({"mesh", 3}).empty());
}

TEST(PendingEdits, only_so_many_are_under_way)
{
  Owner owner;
  for (char name = 'a'; name <= 'z'; ++name) {
    owner.edits.add(facesOf(std::string(1, name), {1}));
  }
  owner.work();
  EXPECT_EQ(owner.sent.size(), PendingEdits::AT_ONCE);
  owner.stored = {"a", "b"};
  owner.work();
  EXPECT_EQ(owner.sent.size(), PendingEdits::AT_ONCE + 2);
}

TEST(LabelAreas, are_those_of_the_faces)
{
  auto mesh = std::make_shared<MeshData>();
  mesh->vertices.resize(4);
  mesh->vertices[1].position = {3, 0, 0};
  mesh->vertices[2].position = {0, 4, 0};
  mesh->vertices[3].position = {0, 0, 2};
  mesh->indices = {0, 1, 2, 0, 1, 3, 1, 2, 3, 0, 0, 1};
  const auto label = [](const std::vector<std::uint32_t>& faces) {
    auto cluster = std::make_shared<LabelCluster>();
    cluster->faces = faces;
    return cluster;
  };
  LabelClusters labels = {{"a", label({0})}, {"b", label({0, 1, 3})}, {"c", label({2})}};
  LabelAreas areas;
  const auto knows = [&](const char* name) {
    for (int i = 0; i < 60000 && !areas.area(name); ++i) {
      areas.follow(mesh, labels);
      std::this_thread::sleep_for(1ms);
    }
    return areas.area(name).has_value();
  };
  EXPECT_FALSE(areas.area("a"));
  ASSERT_TRUE(knows("a"));
  EXPECT_DOUBLE_EQ(*areas.area("a"), 6.0);
  EXPECT_DOUBLE_EQ(*areas.area("b"), 9.0);
  EXPECT_DOUBLE_EQ(*areas.area("c"), std::sqrt(6.0 * 6.0 + 4.0 * 4.0 + 3.0 * 3.0));
  labels["a"] = label({1});
  labels.erase("b");
  areas.follow(mesh, labels);
  EXPECT_FALSE(areas.area("a")) << "it is of other faces";
  ASSERT_TRUE(knows("a"));
  EXPECT_DOUBLE_EQ(*areas.area("a"), 3.0);
  EXPECT_FALSE(areas.area("b"));
  areas.follow(nullptr, labels);
  EXPECT_FALSE(areas.area("a"));
}
