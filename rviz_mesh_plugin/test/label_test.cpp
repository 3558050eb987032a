#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rviz_mesh_plugin/label_colors.h"
#include "rviz_mesh_plugin/label_layers.h"
#include "rviz_mesh_plugin/label_order.h"
#include "rviz_mesh_plugin/label_slots.h"

using rviz_mesh_plugin::joined;
using rviz_mesh_plugin::LabelColors;
using rviz_mesh_plugin::LabelLayers;
using rviz_mesh_plugin::LabelLess;
using rviz_mesh_plugin::LabelSlots;
using rviz_mesh_plugin::Rgba8;

namespace {

int distance(const Rgba8& a, const Rgba8& b)
{
  return std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue);
}

std::size_t length(const std::vector<LabelSlots::Range>& ranges)
{
  std::size_t sum = 0;
  for (const auto& range : ranges) {
    sum += range.end - range.begin;
  }
  return sum;
}

/// An index buffer that only gets what has changed.
class Copy
{
 public:
  std::size_t update(const LabelSlots& slots, const std::vector<LabelSlots::Range>& changed)
  {
    faces_.resize(slots.faces().size());
    for (const auto& range : changed) {
      EXPECT_LT(range.begin, range.end);
      EXPECT_LE(range.end, faces_.size());
      std::copy(slots.faces().begin() + range.begin, slots.faces().begin() + range.end,
                faces_.begin() + range.begin);
    }
    return length(changed);
  }

  std::vector<std::uint32_t> sorted() const
  {
    auto result = faces_;
    std::sort(result.begin(), result.end());
    return result;
  }

 private:
  std::vector<std::uint32_t> faces_;
};

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
  colors.setOwn("tree_2", own);
  EXPECT_EQ(colors.color("tree_2"), own);
  EXPECT_TRUE(colors.hasOwn("tree_2"));
  EXPECT_EQ(colors.color("tree_1"), tree);
  colors.removeOwn("tree_2");
  EXPECT_EQ(colors.color("tree_2"), tree);
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

TEST(LabelSlotsTest, what_grows_or_shrinks_by_some_faces_changes_some_places)
{
  LabelSlots slots;
  Copy copy;
  EXPECT_EQ(copy.update(slots, slots.assign(range(0, 10000))), 10000u);
  EXPECT_EQ(copy.update(slots, slots.assign(range(0, 10010))), 10u);
  EXPECT_EQ(copy.sorted(), range(0, 10010));
  auto more = range(0, 10010);
  more.insert(more.begin(), {20000, 20001, 20002});
  EXPECT_EQ(copy.update(slots, slots.assign(more)), 3u) << "in any order";
  EXPECT_EQ(copy.update(slots, slots.assign(range(10, 10000))), 10u) << "three holes at the end";
  EXPECT_EQ(copy.sorted(), range(10, 10000));
  EXPECT_EQ(copy.update(slots, slots.assign(range(10, 10000))), 0u) << "the same again";
  EXPECT_EQ(copy.update(slots, slots.assign({})), 0u);
  EXPECT_TRUE(slots.faces().empty());
}

TEST(LabelSlotsTest, random_edits_leave_what_was_assigned)
{
  std::mt19937 random(2);
  LabelSlots slots;
  Copy copy;
  for (int round = 0; round < 500; ++round) {
    std::set<std::uint32_t> wanted;
    const std::uint32_t universe = 1 + random() % 300;
    const std::uint32_t count = random() % 200;
    for (std::uint32_t i = 0; i < count; ++i) {
      wanted.insert(random() % universe);
    }
    std::vector<std::uint32_t> faces(wanted.begin(), wanted.end());
    std::shuffle(faces.begin(), faces.end(), random);
    copy.update(slots, slots.assign(faces));
    ASSERT_EQ(copy.sorted(), std::vector<std::uint32_t>(wanted.begin(), wanted.end()));
  }
}

TEST(LabelSlotsTest, ranges_are_joined_where_they_are_near_and_cut_at_the_end)
{
  const auto result = joined({{500, 510}, {0, 1}, {30, 40}, {505, 900}, {2000, 2001}}, 600);
  ASSERT_EQ(result.size(), 2u);
  EXPECT_EQ(result[0].begin, 0u);
  EXPECT_EQ(result[0].end, 40u);
  EXPECT_EQ(result[1].begin, 500u);
  EXPECT_EQ(result[1].end, 600u);
  EXPECT_TRUE(joined({{3, 3}, {7, 9}}, 7).empty());
}

TEST(LabelLayersTest, labels_that_share_faces_lie_on_each_other_in_their_order)
{
  const LabelLayers::Faces a{0, 1, 2}, b{3, 4}, c{2, 3}, d{4}, e{9};
  LabelLayers layers;
  layers.reset(10);
  layers.add(a);
  layers.add(b);
  EXPECT_FALSE(layers.overlap());
  EXPECT_EQ(layers.layers({&a, &b}), (std::vector<unsigned short>{0, 0}));
  layers.add(c);
  layers.add(d);
  layers.add(e);
  EXPECT_TRUE(layers.overlap());
  EXPECT_EQ(layers.layers({&a, &b, &c, &d, &e}), (std::vector<unsigned short>{0, 0, 1, 1, 0}));
  EXPECT_EQ(layers.layers({&e, &d, &c, &b, &a}), (std::vector<unsigned short>{0, 0, 0, 1, 1}));
  layers.remove(c);
  EXPECT_TRUE(layers.overlap()) << "b and d";
  layers.remove(d);
  EXPECT_FALSE(layers.overlap());
}

TEST(LabelLayersTest, there_are_never_many_layers)
{
  const LabelLayers::Faces face{0};
  LabelLayers layers;
  layers.reset(1);
  std::vector<const LabelLayers::Faces*> labels;
  for (int i = 0; i < 1000; ++i) {
    layers.add(face);
    labels.push_back(&face);
  }
  const auto result = layers.layers(labels);
  EXPECT_TRUE(std::is_sorted(result.begin(), result.end()));
  EXPECT_EQ(result.back(), LabelLayers::COUNT - 1);
  for (int i = 0; i < 1000; ++i) {
    layers.remove(face);
  }
  EXPECT_TRUE(layers.overlap()) << "more than can be counted: for ever";
  layers.reset(1);
  EXPECT_FALSE(layers.overlap());
}
