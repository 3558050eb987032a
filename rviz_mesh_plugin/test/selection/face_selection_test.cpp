#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "rendering/labels/index_slots.h"
#include "selection/face_selection.h"

using rviz_mesh_plugin::Combination;
using rviz_mesh_plugin::FaceBits;
using rviz_mesh_plugin::FaceSelection;
using rviz_mesh_plugin::IndexSlots;
using Faces = FaceSelection::Faces;
using Set = std::set<std::uint32_t>;

namespace {

Faces difference(const Set& a, const Set& b)
{
  Faces faces;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(faces));
  return faces;
}

Faces listOf(const Set& set)
{
  return Faces(set.begin(), set.end());
}

/// What a FaceSelection has to do, with sets that are kept whole.
struct Reference
{
  std::size_t size;
  Set now;
  std::vector<Set> done, undone;
  bool in_stroke = false;
  Set before;  ///< the stroke

  void become(const Set& wanted)
  {
    if (wanted == now) {
      return;
    }
    if (!in_stroke) {
      done.push_back(now);
    }
    undone.clear();
    now = wanted;
  }

  void begin()
  {
    if (!in_stroke) {
      in_stroke = true;
      before = now;
    }
  }

  void end()
  {
    if (in_stroke && before != now) {
      done.push_back(before);
    }
    in_stroke = false;
  }

  void move(std::vector<Set>& from, std::vector<Set>& to)
  {
    end();
    if (!from.empty()) {
      to.push_back(now);
      now = from.back();
      from.pop_back();
    }
  }
};

/// Some faces: in any order, perhaps repeated, perhaps beyond the mesh.
Faces someFaces(std::mt19937& random, std::size_t size)
{
  Faces faces;
  const std::uint32_t limit = static_cast<std::uint32_t>(size) + 3;
  if (random() % 2 == 0) {
    const std::uint32_t begin = random() % limit;
    for (std::uint32_t face = begin; face < begin + random() % 200; ++face) {
      faces.push_back(face);
    }
  }
  for (std::uint32_t i = random() % 30; i > 0; --i) {
    faces.push_back(random() % limit);
  }
  return faces;
}

TEST(Strokes, that_are_given_up_leave_nothing)
{
  FaceSelection selection(200);
  selection.select({3, 70});
  const auto before = selection.faces();
  selection.beginStroke();
  selection.deselect({3});
  selection.select({100, 199});
  const auto& change = selection.giveUpStroke();
  EXPECT_EQ(change.added(), FaceSelection::Faces{3});
  EXPECT_EQ(change.removed(), (FaceSelection::Faces{100, 199}));
  EXPECT_EQ(selection.faces(), before);
  EXPECT_EQ(selection.count(), 2u);
  EXPECT_FALSE(selection.inStroke() || selection.canRedo());
  EXPECT_TRUE(selection.giveUpStroke().empty()) << "without a stroke nothing changes";
  EXPECT_EQ(selection.undo().removed(), before);
  EXPECT_TRUE(selection.empty());
}

}  // namespace

TEST(FaceSelectionTest, a_thousand_random_operations_do_what_they_do_to_sets)
{
  for (const std::size_t size : {0, 1, 63, 64, 65, 200, 1000}) {
    std::mt19937 random(static_cast<unsigned>(size));
    FaceSelection selection(size);
    Reference reference{size, {}, {}, {}, false, {}};
    for (int i = 0; i < 1000; ++i) {
      const Set before = reference.now;
      Set wanted = before;
      const Faces faces = someFaces(random, size);
      Set inside;
      for (const std::uint32_t face : faces) {
        if (face < size) {
          inside.insert(face);
        }
      }
      FaceSelection::Change change;
      const unsigned operation = random() % 14;
      switch (operation) {
        case 0:
        case 1:
        case 2:
          wanted.insert(inside.begin(), inside.end());
          change = selection.select(faces);
          break;
        case 3:
        case 4: {
          const Faces rest = difference(before, inside);
          wanted = Set(rest.begin(), rest.end());
          change = selection.deselect(faces);
          break;
        }
        case 5: {
          const auto how = static_cast<Combination>(random() % 4);
          wanted = inside;
          if (how == Combination::ADD) {
            wanted.insert(before.begin(), before.end());
          } else if (how != Combination::REPLACE) {
            const bool keep = how == Combination::INTERSECT;
            wanted.clear();
            std::copy_if(before.begin(), before.end(), std::inserter(wanted, wanted.end()),
                         [&](std::uint32_t face) { return (inside.count(face) != 0) == keep; });
          }
          change = selection.combineBits(FaceBits(size, faces), how);
          break;
        }
        case 6:
          wanted.clear();
          for (std::uint32_t face = 0; face < size; ++face) {
            if (before.count(face) == 0) {
              wanted.insert(face);
            }
          }
          change = selection.invert();
          break;
        case 7:
          wanted.clear();
          change = random() % 2 == 0 ? selection.clear() : selection.selectAll();
          for (std::uint32_t face = 0; !selection.empty() && face < size; ++face) {
            wanted.insert(face);
          }
          break;
        case 8:
          reference.begin();
          selection.beginStroke();
          break;
        case 9:
          reference.end();
          selection.endStroke();
          break;
        case 10:
        case 11:
        case 12:
          reference.move(reference.done, reference.undone);
          change = selection.undo();
          break;
        default:
          reference.move(reference.undone, reference.done);
          change = selection.redo();
      }
      if (operation < 8) {
        reference.become(wanted);
      }
      ASSERT_EQ(selection.faces(), listOf(reference.now)) << size << ": " << i;
      ASSERT_EQ(selection.count(), reference.now.size());
      ASSERT_EQ(change.added(), difference(reference.now, before)) << operation;
      ASSERT_EQ(change.removed(), difference(before, reference.now)) << operation;
      ASSERT_EQ(selection.canRedo(), !reference.undone.empty());
      ASSERT_EQ(
          selection.canUndo(),
          !reference.done.empty() || (reference.in_stroke && reference.before != reference.now));
      for (std::uint32_t face = 0; face < size + 3; ++face) {
        ASSERT_EQ(selection.contains(face), reference.now.count(face) != 0);
      }
    }
    while (selection.canUndo()) {
      selection.undo();
    }
    EXPECT_TRUE(selection.empty());
  }
}

TEST(FaceSelectionTest, a_stroke_is_one_step)
{
  FaceSelection selection(100);
  selection.select({1, 2});
  selection.beginStroke();
  for (std::uint32_t face = 10; face < 20; ++face) {
    EXPECT_EQ(selection.select({face, face + 1}).addedCount(), face == 10 ? 2u : 1u);
  }
  selection.deselect({1});
  selection.endStroke();
  const FaceSelection::Change undone = selection.undo();
  EXPECT_EQ(undone.added(), (Faces{1}));
  EXPECT_EQ(undone.removedCount(), 11u);
  EXPECT_EQ(selection.faces(), (Faces{1, 2}));
  EXPECT_EQ(selection.redo().removed(), (Faces{1}));
  selection.beginStroke();
  selection.select({50});
  selection.deselect({50});
  selection.endStroke();
  EXPECT_FALSE(selection.canRedo());
  selection.undo();
  EXPECT_EQ(selection.faces(), (Faces{1, 2})) << "a stroke that leaves nothing is no step";
}

TEST(FaceSelectionTest, what_it_returned_may_be_given_back)
{
  FaceSelection selection(100);
  const Faces added = selection.select({5, 7, 9}).added();
  EXPECT_EQ(selection.deselect(added).removed(), (Faces{5, 7, 9}));
  EXPECT_TRUE(selection.empty());
}

TEST(FaceSelectionTest, another_mesh_begins_anew)
{
  FaceSelection selection(100);
  selection.select({1, 99});
  selection.undo();
  selection.beginStroke();
  selection.select({3});
  selection.reset(50);
  EXPECT_EQ(selection.size(), 50u);
  EXPECT_TRUE(selection.empty());
  EXPECT_FALSE(selection.canUndo() || selection.canRedo() || selection.inStroke());
  EXPECT_EQ(selection.historyBytes(), 0u);
  EXPECT_TRUE(selection.select({99}).empty());
}

TEST(FaceSelectionTest, the_oldest_steps_are_forgotten_where_there_are_too_many)
{
  constexpr std::size_t LIMIT = 100000;
  std::mt19937 random(1);
  FaceSelection selection(5000, LIMIT);
  std::vector<Faces> states;
  for (int i = 0; i < 500; ++i) {
    states.push_back(selection.faces());
    Faces faces;
    for (std::uint32_t face = random() % 7; face < 5000; face += 1 + random() % 50) {
      faces.push_back(face);
    }
    selection.replace(faces);
    ASSERT_LE(selection.historyBytes(), LIMIT);
  }
  std::size_t steps = 0;
  while (selection.canUndo()) {
    selection.undo();
    ++steps;
    ASSERT_EQ(selection.faces(), states[states.size() - steps]);
    ASSERT_LE(selection.historyBytes(), LIMIT);
  }
  EXPECT_GT(steps, 20u);
  EXPECT_LT(steps, 200u);
  FaceSelection tiny(5000, 100);
  Faces every_other;
  for (std::uint32_t face = 0; face < 5000; face += 2) {
    every_other.push_back(face);
  }
  tiny.select({1});
  tiny.select(every_other);
  EXPECT_FALSE(tiny.canUndo()) << "a step that is too large is not kept, nor are those before it";
  EXPECT_EQ(tiny.count(), 2501u);
}

TEST(FaceSelectionTest, large_changes_cost_few_bytes_to_remember)
{
  constexpr std::uint32_t COUNT = 2600000;
  FaceSelection selection(COUNT);
  EXPECT_EQ(selection.selectAll().addedCount(), COUNT);
  EXPECT_EQ(selection.invert().removedCount(), COUNT);
  EXPECT_EQ(selection.undo().addedCount(), COUNT);
  EXPECT_EQ(selection.count(), COUNT);
  EXPECT_LT(selection.historyBytes(), 200u);
  selection.beginStroke();
  for (std::uint32_t face = 0; face < 1000; ++face) {
    selection.deselect({face * 2, face * 2 + 1});
  }
  selection.endStroke();
  EXPECT_LT(selection.historyBytes(), 200u) << "the faces lie beside each other";
  EXPECT_EQ(selection.undo().addedCount(), 2000u);
}

TEST(IndexSlotsTest, changes_give_and_take_places_and_touch_as_many_only)
{
  std::mt19937 random(7);
  IndexSlots slots;
  Set reference;
  Faces drawn;  ///< what has been uploaded
  for (int i = 0; i < 2000; ++i) {
    Faces added, removed;
    for (std::uint32_t n = random() % (i % 100 == 0 ? 3000 : 30); n > 0; --n) {
      const std::uint32_t face = random() % 5000;
      (random() % 2 == 0 ? added : removed).push_back(face);
    }
    std::sort(added.begin(), added.end());
    added.erase(std::unique(added.begin(), added.end()), added.end());
    removed = difference(Set(removed.begin(), removed.end()), Set(added.begin(), added.end()));
    slots.change(added, removed);
    for (const std::uint32_t face : removed) {
      reference.erase(face);
    }
    reference.insert(added.begin(), added.end());
    Faces faces = slots.faces();
    drawn.resize(faces.size());
    std::size_t touched = 0, last = 0;
    for (const IndexSlots::Range& range : slots.takeChanged()) {
      ASSERT_LE(last, range.begin);
      ASSERT_LT(range.begin, range.end);
      last = range.end;
      touched += range.end - range.begin;
      std::copy(&faces[range.begin], &faces[range.begin] + (range.end - range.begin),
                &drawn[range.begin]);
    }
    ASSERT_EQ(drawn, faces) << i << ": all that has changed is told";
    ASSERT_LE(touched, 65 * (added.size() + removed.size()));
    std::sort(faces.begin(), faces.end());
    ASSERT_EQ(faces, listOf(reference)) << i;
    if (i % 500 == 499) {  // and as a whole in between
      slots.change({}, listOf(reference));
      ASSERT_TRUE(slots.faces().empty() && slots.takeChanged().empty());
      slots.change({1, 2, 4999}, {1, 7});
      ASSERT_EQ(slots.takeChanged().size(), 1u);
      ASSERT_EQ(slots.faces(), (Faces{1, 2, 4999}));
      reference = {1, 2, 3, 4000};
      slots.assign(std::make_shared<Faces>(listOf(reference)));
      while (slots.work(100) > 0) {
      }
      slots.takeChanged();
      drawn = slots.faces();
    }
  }
}
