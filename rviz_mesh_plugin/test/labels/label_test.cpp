#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "coloring/color_scale.h"
#include "conversion/attribute_conversion.h"
#include "labels/label_colors.h"
#include "labels/label_faces.h"
#include "labels/label_name.h"
#include "labels/shown_labels.h"
#include "rendering/labels/index_slots.h"
#include "rendering/labels/label_layers.h"

using rviz_mesh_plugin::IndexSlots;
using rviz_mesh_plugin::LabelCluster;
using rviz_mesh_plugin::LabelClusterConstPtr;
using rviz_mesh_plugin::LabelColors;
using rviz_mesh_plugin::LabelLayers;
using rviz_mesh_plugin::LabelLess;
using rviz_mesh_plugin::LabelSet;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::OwnColors;
using rviz_mesh_plugin::Rgba8;
using rviz_mesh_plugin::ShownLabels;

namespace {

int distance(const Rgba8& a, const Rgba8& b)
{
  return std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue);
}

/// An index buffer that only gets what has changed.
class Copy
{
 public:
  /// Returns how many places of the buffer it took.
  /// @param slice faces that are looked at in one go
  std::size_t update(std::vector<std::uint32_t> faces, std::size_t slice)
  {
    std::sort(faces.begin(), faces.end());
    slots_.assign(std::make_shared<IndexSlots::Faces>(faces));
    while (!slots_.isSettled()) {
      const std::size_t looked = slots_.work(slice);
      EXPECT_GT(looked, 0u);
      EXPECT_LE(looked, slice + 4) << "faces and steps";
    }
    EXPECT_EQ(slots_.work(slice), 0u);
    buffer_.resize(slots_.faces().size());
    std::size_t changed = 0;
    std::size_t before = 0;
    for (const auto& range : slots_.takeChanged()) {
      EXPECT_LE(before, range.begin);
      EXPECT_LT(range.begin, range.end);
      EXPECT_LE(range.end, buffer_.size());
      std::copy(slots_.faces().begin() + range.begin, slots_.faces().begin() + range.end,
                buffer_.begin() + range.begin);
      changed += range.end - range.begin;
      before = range.end;
    }
    return changed;
  }

  std::vector<std::uint32_t> sorted() const
  {
    auto result = buffer_;
    std::sort(result.begin(), result.end());
    return result;
  }

 private:
  IndexSlots slots_;
  std::vector<std::uint32_t> buffer_;
};

LabelClusterConstPtr cluster(const std::string& label, const std::vector<std::uint32_t>& faces)
{
  return std::make_shared<LabelCluster>(LabelCluster{label, faces});
}

/// The layers of labels on a mesh of 10 faces, in their order.
std::vector<unsigned short> layersOf(const LabelLayers::Labels& labels, std::size_t slice)
{
  std::vector<unsigned short> found;
  LabelLayers layers;
  layers.start(10, labels);
  while (!layers.isDone()) {
    const std::size_t looked =
        layers.work(slice, [&](const LabelCluster& label, unsigned short layer) {
          EXPECT_EQ(label.label, labels.at(found.size())->label);
          found.push_back(layer);
        });
    EXPECT_GT(looked, 0u);
    EXPECT_LE(looked, slice + 1);
  }
  return found;
}

std::vector<std::uint32_t> range(std::uint32_t first, std::uint32_t count)
{
  std::vector<std::uint32_t> result(count);
  std::iota(result.begin(), result.end(), first);
  return result;
}

}  // namespace

TEST(LabelColorsTest, the_class_is_the_text_before_the_first_underscore)
{
  for (const auto& [label, expected] : std::vector<std::pair<std::string, std::string>>{
           {"tree_1", "tree"}, {"tree_old_1", "tree"}, {"free", "free"}, {"_1", ""}, {"", ""}}) {
    EXPECT_EQ(rviz_mesh_plugin::labelClass(label), expected) << label;
  }
}

TEST(LabelColorsTest, instances_share_the_color_of_their_class_unless_they_have_their_own)
{
  LabelColors colors;
  const Rgba8 tree = colors.color("tree_1");
  EXPECT_EQ(colors.color("tree_2"), tree);
  EXPECT_EQ(colors.classColor("tree"), tree);
  const Rgba8 own{1, 2, 3, 255};
  using Labels = std::vector<std::string>;
  const auto set = [&](const OwnColors& all) {
    return colors.setOwn(std::make_shared<OwnColors>(all));
  };
  EXPECT_EQ(set({{"tree_2", own}, {"tree_3", tree}, {"wall_1", own}}),
            (Labels{"tree_2", "wall_1"}));
  EXPECT_EQ(colors.color("tree_2"), own);
  EXPECT_EQ(colors.color("tree_1"), tree);
  EXPECT_EQ(set({{"tree_2", {1, 2, 4, 255}}, {"wall_1", own}}), Labels{"tree_2"});
  EXPECT_EQ(set({{"wall_1", own}}), Labels{"tree_2"});
  EXPECT_EQ(colors.color("tree_2"), tree);
  EXPECT_EQ(colors.color("wall_1"), own);
  EXPECT_EQ(colors.setOwn(nullptr), Labels{"wall_1"});
  EXPECT_EQ(colors.color("wall_1"), colors.classColor("wall"));
}

TEST(LabelColorsTest, the_color_of_a_class_is_that_of_its_name_in_every_process)
{
  // What users have seen must not change with a new version.
  const Rgba8 expected[] = {{148, 201, 255, 255}, {148, 81, 15, 255}};
  EXPECT_EQ(LabelColors().classColor("tree"), expected[0]);
  LabelColors other;
  EXPECT_EQ(other.classColor("wall"), expected[1]);
  EXPECT_EQ(other.classColor("tree"), expected[0]);
  EXPECT_FALSE(expected[0] == expected[1]);
}

TEST(LabelColorsTest, classes_are_well_apart_as_long_as_there_are_colors)
{
  LabelColors colors;
  std::vector<Rgba8> seen;
  for (std::size_t i = 0; i < LabelColors::PALETTE_SIZE; ++i) {
    const Rgba8 color = colors.classColor("class" + std::to_string(i));
    EXPECT_EQ(color.alpha, 255);
    for (const Rgba8& other : seen) {
      EXPECT_GE(distance(color, other), 40) << i;
    }
    // Neither RViz's background nor black.
    EXPECT_GE(distance(color, {48, 48, 48, 255}), 100) << i;
    EXPECT_GE(distance(color, rviz_mesh_plugin::LETHAL_COST_COLOR), 50) << i;
    EXPECT_GE(distance(color, rviz_mesh_plugin::UNKNOWN_COST_COLOR), 50) << i;
    seen.push_back(color);
  }
  const Rgba8 shared = colors.classColor("one more");
  EXPECT_TRUE(std::find(seen.begin(), seen.end(), shared) != seen.end());
}

TEST(LabelColorsTest, a_class_keeps_its_color_when_others_come)
{
  LabelColors colors;
  const Rgba8 first = colors.classColor("first");
  for (int i = 0; i < 100; ++i) {
    colors.classColor(std::to_string(i));
  }
  EXPECT_EQ(colors.classColor("first"), first);
}

TEST(LabelLessTest, numbers_are_compared_as_numbers)
{
  const std::vector<std::string> sorted = {"",       "10",      "tree",     "tree_1",  "tree_2",
                                           "tree_9", "tree_10", "tree_010", "tree_11", "treehouse"};
  std::vector<std::string> expected = sorted;
  std::swap(expected[6], expected[7]);  // equal but for the zero: by their characters
  auto shuffled = sorted;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(1));
  std::sort(shuffled.begin(), shuffled.end(), LabelLess());
  EXPECT_EQ(shuffled, expected);
}

TEST(LabelLessTest, is_a_strict_order_of_all_texts)
{
  std::vector<std::string> texts;
  for (const char* a : {"", "0", "00", "1", "01", "a", "9", "10", "a1", "a01", "\xc3\xa4", "_"}) {
    for (const char* b : {"", "0", "1", "01", "a", "_2"}) {
      texts.push_back(std::string(a) + b);
    }
  }
  std::sort(texts.begin(), texts.end());
  texts.erase(std::unique(texts.begin(), texts.end()), texts.end());
  const LabelLess less;
  for (const auto& a : texts) {
    EXPECT_FALSE(less(a, a)) << a;
    for (const auto& b : texts) {
      EXPECT_TRUE(a == b || less(a, b) != less(b, a)) << a << " " << b;
      for (const auto& c : texts) {
        EXPECT_FALSE(less(a, b) && less(b, c) && !less(a, c)) << a << " " << b << " " << c;
      }
    }
  }
}

TEST(IndexSlotsTest, what_grows_or_shrinks_by_some_faces_changes_some_places)
{
  for (const std::size_t slice : {1u, 7u, 1000000u}) {
    Copy copy;
    EXPECT_EQ(copy.update(range(0, 10000), slice), 10000u);
    EXPECT_EQ(copy.update(range(0, 10010), slice), 10u);
    EXPECT_EQ(copy.sorted(), range(0, 10010));
    auto more = range(0, 10010);
    more.insert(more.end(), {20000, 20001, 20002});
    EXPECT_EQ(copy.update(more, slice), 3u);
    EXPECT_EQ(copy.update(range(10, 10000), slice), 10u) << "three holes at the end";
    EXPECT_EQ(copy.sorted(), range(10, 10000));
    EXPECT_EQ(copy.update(range(10, 10000), slice), 0u) << "the same again";
    EXPECT_EQ(copy.update({}, slice), 0u);
    EXPECT_TRUE(copy.sorted().empty());
  }
}

TEST(IndexSlotsTest, random_edits_leave_what_was_assigned)
{
  std::mt19937 random(2);
  Copy copy;
  for (int round = 0; round < 500; ++round) {
    std::set<std::uint32_t> wanted;
    const std::uint32_t universe = 1 + random() % 3000;
    const std::uint32_t count = random() % 2000;
    for (std::uint32_t i = 0; i < count; ++i) {
      wanted.insert(random() % universe);
    }
    const std::vector<std::uint32_t> faces(wanted.begin(), wanted.end());
    copy.update(faces, 1 + random() % 1000);
    ASSERT_EQ(copy.sorted(), faces);
  }
}

TEST(IndexSlotsTest, changes_near_to_each_other_are_taken_together)
{
  IndexSlots slots;
  const auto assign = [&](const std::vector<std::uint32_t>& faces) {
    slots.assign(std::make_shared<IndexSlots::Faces>(faces));
    slots.work(1000000);
    return slots.takeChanged();
  };
  assign(range(0, 1000));
  auto faces = range(0, 1000);
  for (const std::uint32_t face : {900, 550, 500}) {  // three places; 50 and 350 apart
    faces.erase(faces.begin() + face);
  }
  faces.insert(faces.end(), {2000, 2001, 2002});
  const auto changed = assign(faces);
  ASSERT_EQ(changed.size(), 2u);
  EXPECT_EQ(changed[0].begin, 500u);
  EXPECT_EQ(changed[0].end, 551u);
  EXPECT_EQ(changed[1].begin, 900u);
  EXPECT_EQ(changed[1].end, 901u);
}

TEST(LabelLayersTest, labels_that_share_faces_lie_on_each_other_in_their_order)
{
  const auto a = cluster("a", {0, 1, 2}), b = cluster("b", {3, 4}), c = cluster("c", {2, 3}),
             d = cluster("d", {4}), e = cluster("e", {9});
  for (const std::size_t slice : {1u, 2u, 1000u}) {
    EXPECT_EQ(layersOf({a, b}, slice), (std::vector<unsigned short>{0, 0}));
    EXPECT_EQ(layersOf({a, b, c, d, e}, slice), (std::vector<unsigned short>{0, 0, 1, 1, 0}));
    EXPECT_EQ(layersOf({e, d, c, b, a}, slice), (std::vector<unsigned short>{0, 0, 0, 1, 1}));
  }
  EXPECT_TRUE(layersOf({}, 1).empty());
}

TEST(LabelLayersTest, there_are_never_many_layers)
{
  const auto layers = layersOf(LabelLayers::Labels(1000, cluster("a", {0})), 100);
  EXPECT_TRUE(std::is_sorted(layers.begin(), layers.end()));
  EXPECT_EQ(layers.back(), LabelLayers::COUNT - 1);
}

TEST(LabelFacesTest, clusters_that_arrive_have_each_face_once_in_ascending_order)
{
  mesh_msgs::MeshFaceCluster message;
  message.label = "tree_1";
  message.face_indices = {7, 3, 7, 0, 4294967295u, 3};
  const std::vector<std::uint32_t> expected{0, 3, 7, 4294967295u};
  EXPECT_EQ(rviz_mesh_plugin::convert(message)->clusters.at(0).faces, expected);
  std::string left_out;
  auto second = message;
  second.face_indices = {5, 4, 7};
  const auto joined = rviz_mesh_plugin::convertLabels("mesh", {message, second}, true, left_out);
  ASSERT_EQ(joined->clusters.size(), 1u);
  EXPECT_EQ(joined->clusters[0].faces, (std::vector<std::uint32_t>{0, 3, 4, 5, 7, 4294967295u}));
}

TEST(LabelFacesTest, what_a_mesh_does_not_have_is_left_out_and_nothing_else_copied)
{
  const auto label = cluster("a", {0, 5, 9});
  EXPECT_EQ(rviz_mesh_plugin::withinMesh(label, 10), label);
  EXPECT_EQ(rviz_mesh_plugin::withinMesh(label, 9)->faces, (std::vector<std::uint32_t>{0, 5}));
  EXPECT_EQ(rviz_mesh_plugin::withinMesh(label, 9)->label, "a");
  EXPECT_TRUE(rviz_mesh_plugin::withinMesh(label, 0)->faces.empty());
}

TEST(ShownLabelsTest, labels_are_shared_with_the_set_that_brought_them)
{
  auto mesh = std::make_shared<MeshData>();
  mesh->uuid = "mesh";
  mesh->indices.resize(30);
  ShownLabels store;
  store.setMesh(mesh);
  const auto set = std::make_shared<LabelSet>(
      LabelSet{"mesh", true, {{"a", {1, 2}}, {"b", {3, 9, 10, 11}}, {"c", {10}}}});
  store.add(set);
  ASSERT_EQ(store.labels().size(), 2u);
  EXPECT_EQ(store.labels().at("a").get(), &set->clusters[0]);
  EXPECT_EQ(store.labels().at("b")->faces, (std::vector<std::uint32_t>{3, 9}));
  EXPECT_EQ(store.facesBeyond(), 3u);
  EXPECT_EQ(store.faceCount(), 4u);
  EXPECT_EQ(store.takeChanged(), (std::set<std::string>{"a", "b"}));
  store.add(std::make_shared<LabelSet>(LabelSet{"mesh", true, {{"a", {1, 2}}}}));
  EXPECT_EQ(store.takeChanged(), (std::set<std::string>{"b"})) << "a is as before";
}

/// It is asked for when the mesh is there, and may come after labels that are newer.
TEST(ShownLabelsTest, a_complete_set_that_is_expected_takes_back_nothing_that_has_come_since)
{
  auto mesh = std::make_shared<MeshData>();
  mesh->uuid = "mesh";
  mesh->indices.resize(30);
  using Faces = std::vector<std::uint32_t>;
  const auto add = [](ShownLabels& store, bool all,
                      const std::vector<rviz_mesh_plugin::LabelCluster>& labels) {
    store.add(std::make_shared<LabelSet>(LabelSet{"mesh", all, labels}));
  };
  ShownLabels store;
  add(store, false, {{"early", {1}}, {"old", {2}}});  // before it is asked for
  store.setMesh(mesh);
  add(store, false, {{"new", {3}}, {"changed", {4}}, {"gone", {}}});
  add(store, true, {{"early", {5}}, {"changed", {6}}, {"gone", {7}}, {"stored", {8}}});
  EXPECT_TRUE(store.isComplete());
  ASSERT_EQ(store.labels().size(), 4u);
  EXPECT_EQ(store.labels().at("early")->faces, Faces{5});
  EXPECT_EQ(store.labels().at("new")->faces, Faces{3});
  EXPECT_EQ(store.labels().at("changed")->faces, Faces{4});
  EXPECT_EQ(store.labels().at("stored")->faces, Faces{8});
  // The next one is of another server, say, and counts.
  add(store, false, {{"new", {9}}});
  add(store, true, {{"changed", {6}}});
  ASSERT_EQ(store.labels().size(), 1u);
  EXPECT_EQ(store.labels().at("changed")->faces, Faces{6});
  // But for one that is asked for.
  store.expectAll();
  EXPECT_TRUE(store.isComplete()) << "what was known is known";
  add(store, false, {{"new", {9}}});
  add(store, true, {{"new", {1}}, {"changed", {2}}});
  EXPECT_EQ(store.labels().at("new")->faces, Faces{9});
  EXPECT_EQ(store.labels().at("changed")->faces, Faces{2});
}
