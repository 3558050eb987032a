// Against the definitions: triangles sampled densely, rays walked in small steps.
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "base/vectors.h"
#include "mesh_view/selectable_faces.h"
#include "threads/cancellation.h"

using rviz_mesh_plugin::FaceBits;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::rayInSection;
using rviz_mesh_plugin::Section;
using rviz_mesh_plugin::SelectableFaces;
using rviz_mesh_plugin::ShownMesh;
using Point = std::array<double, 3>;

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();

Section box(const std::array<float, 3>& lower, const std::array<float, 3>& upper)
{
  Section section;
  section.lower = lower;
  section.upper = upper;
  return section;
}

ShownMesh shownSoup(std::size_t faces, std::mt19937& random, const Section& section)
{
  std::uniform_real_distribution<float> place(-3.0f, 3.0f);
  auto mesh = std::make_shared<MeshData>();
  mesh->vertices.resize(3 * faces);
  for (std::uint32_t i = 0; i < 3 * faces; ++i) {
    mesh->vertices[i].position = {place(random), place(random), place(random)};
    mesh->indices.push_back(i);
  }
  mesh->lower.fill(-3.0f);
  mesh->upper.fill(3.0f);
  ShownMesh shown;
  shown.mesh = mesh;
  shown.section = section;
  return shown;
}

/// How near the face comes to the box, in meters along an axis; 0: a point of it is in it.
double gap(const MeshData& mesh, std::uint32_t face, const Section& section)
{
  constexpr int STEPS = 150;
  double least = 1e9;
  for (int i = 0; i <= STEPS; ++i) {
    for (int j = 0; i + j <= STEPS; ++j) {
      const double u = double(i) / STEPS, v = double(j) / STEPS;
      double outside = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double p = (1 - u - v) * rviz_mesh_plugin::cornerOf(mesh, face, 0)[axis] +
                         u * rviz_mesh_plugin::cornerOf(mesh, face, 1)[axis] +
                         v * rviz_mesh_plugin::cornerOf(mesh, face, 2)[axis];
        outside = std::max({outside, section.lower[axis] - p, p - section.upper[axis]});
      }
      least = std::min(least, outside);
    }
  }
  return least;
}

}  // namespace

TEST(Section, is_no_limit_at_first_and_contains_its_border)
{
  Section section;
  EXPECT_FALSE(section.cuts());
  EXPECT_TRUE(section.contains(Point{1e30, -1e30, 0.0}));
  section.upper[2] = 2.5f;
  EXPECT_TRUE(section.cuts());
  EXPECT_TRUE(section.contains(Point{0.0, 0.0, 2.5}));
  EXPECT_FALSE(section.contains(Point{0.0, 0.0, 2.50001}));
  rviz_mesh_plugin::Bounds bounds{{0, 0, 2.5f}, {1, 1, 4}};
  EXPECT_TRUE(section.touches(bounds));
  bounds.lower[2] = 2.6f;
  EXPECT_FALSE(section.touches(bounds));
  EXPECT_TRUE(section == section);
  EXPECT_TRUE(section != Section());
}

TEST(SelectableFaces, are_those_of_which_a_point_is_in_the_section)
{
  std::mt19937 random(5);
  for (const Section& section :
       {box({-1, -1, -1}, {1, 1, 1}), box({-INF, -INF, 0.5f}, {INF, INF, 1.0f}),
        box({-INF, -INF, -INF}, {INF, INF, -2.0f}), box({2, 2, 2}, {INF, INF, INF})}) {
    const ShownMesh shown = shownSoup(130, random, section);
    const SelectableFaces selectable(shown);
    EXPECT_FALSE(selectable.all());
    const FaceBits bits = selectable.bits();
    int inside = 0, outside = 0;
    for (std::uint32_t face = 0; face < 130; ++face) {
      const double outside_by = gap(*shown.mesh, face, section);
      if (outside_by == 0.0) {
        EXPECT_TRUE(bits.contains(face)) << face;
        ++inside;
      } else if (outside_by > 0.1) {  // the samples are not so far apart
        EXPECT_FALSE(bits.contains(face)) << face << ": " << outside_by;
        ++outside;
      }
      EXPECT_EQ(selectable.contains(face), bits.contains(face));
    }
    EXPECT_GT(inside, 1);
    EXPECT_GT(outside, 10);
    std::vector<std::uint32_t> listed;
    for (std::uint32_t face = 0; face < 130; face += 3) {
      listed.push_back(face);
    }
    FaceBits some(130, listed);
    selectable.keep(some);
    selectable.keep(listed);
    EXPECT_EQ(some.faces(), listed);
    for (std::uint32_t face = 0; face < 130; ++face) {
      EXPECT_EQ(some.contains(face), face % 3 == 0 && bits.contains(face));
    }
  }
}

TEST(SelectableFaces, are_all_where_nothing_is_cut_and_none_between_turned_limits)
{
  std::mt19937 random(6);
  EXPECT_TRUE(SelectableFaces(shownSoup(10, random, Section())).all());
  EXPECT_TRUE(SelectableFaces(shownSoup(10, random, box({-4, -4, -4}, {4, 4, 4}))).all());
  const SelectableFaces none(shownSoup(10, random, box({0, 0, 1}, {1, 1, 0})));
  EXPECT_FALSE(none.all());
  EXPECT_EQ(none.bits().count(), 0u);
  EXPECT_FALSE(none.contains(3));
}

TEST(SelectableFaces, can_be_given_up)
{
  std::mt19937 random(7);
  const SelectableFaces selectable(shownSoup(100, random, box({-1, -1, -1}, {1, 1, 1})));
  const std::atomic<bool> canceled{true};
  EXPECT_THROW(selectable.bits(&canceled), rviz_mesh_plugin::Canceled);
}

TEST(RayInSection, begins_before_what_lies_in_the_plane_of_a_limit)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (const float limit : {0.0f, 2.7f, 3.0f, 12.35f, 103.1f}) {
    const Section section = box({-INF, -INF, -INF}, {INF, INF, limit});
    for (int i = 0; i < 200; ++i) {
      const Point direction = rviz_mesh_plugin::arrayOf(
          Eigen::Vector3d(place(random), place(random), -0.5).normalized());
      const auto part =
          rayInSection({place(random), place(random), limit + 20.0}, direction, INF, section);
      ASSERT_TRUE(part);
      EXPECT_GT(part->origin[2], static_cast<double>(limit)) << i;
    }
  }
}

TEST(RayInSection, is_the_part_of_the_ray_in_the_box)
{
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-3.0, 3.0);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    Point origin{place(random), place(random), place(random)};
    Eigen::Vector3d way(place(random), place(random), place(random));
    if (i % 5 == 0) {
      way[i % 3] = 0.0;
    }
    const Point direction = rviz_mesh_plugin::arrayOf(way.normalized());
    const double farthest = i % 3 == 0 ? 2.0 : std::numeric_limits<double>::infinity();
    const Section section =
        i % 2 == 0 ? box({-1, -1, -1}, {1, 1, 1}) : box({-INF, -INF, 0.25f}, {INF, 0.5f, 2.0f});
    double first = -1.0, last = -1.0;
    for (double t = 0.0; t <= std::min(farthest, 20.0); t += 1e-3) {
      Point at;
      for (int axis = 0; axis < 3; ++axis) {
        at[axis] = origin[axis] + t * direction[axis];
      }
      if (section.contains(at)) {
        first = first < 0.0 ? t : first;
        last = t;
      }
    }
    const auto part = rayInSection(origin, direction, farthest, section);
    if (first < 0.0) {
      EXPECT_TRUE(!part || part->max_distance < 2e-3 || part->skipped > 19.9) << i;
      continue;
    }
    ++hits;
    ASSERT_TRUE(part) << i;
    EXPECT_NEAR(part->skipped, first, 2e-3);
    if (last < 19.9) {
      EXPECT_NEAR(part->skipped + part->max_distance, last, 2e-3);
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(part->origin[axis], origin[axis] + part->skipped * direction[axis], 1e-9);
    }
  }
  EXPECT_GT(hits, 50);
}

TEST(SelectableFaces, are_not_the_hidden_ones)
{
  std::mt19937 random(7);
  for (const bool cut : {false, true}) {
    ShownMesh shown = shownSoup(200, random, cut ? box({-1, -1, -1}, {1, 1, 1}) : Section());
    const SelectableFaces whole(shown);
    FaceBits hidden(200);
    for (std::uint32_t face = 0; face < 200; face += 3) {
      hidden.add(FaceBits::Faces{face});
    }
    shown.hidden = std::make_shared<const rviz_mesh_plugin::HiddenFaces>(hidden);
    const SelectableFaces selectable(shown);
    EXPECT_FALSE(selectable.all());
    FaceBits expected = whole.bits();
    EXPECT_LT(cut ? 0u : 199u, expected.count());
    expected.remove(hidden);
    EXPECT_EQ(selectable.bits(), expected);
    auto listed = whole.bits().faces();
    selectable.keep(listed);
    EXPECT_EQ(listed, expected.faces());
    for (std::uint32_t face = 0; face < 200; ++face) {
      EXPECT_EQ(selectable.contains(face), expected.contains(face));
    }
    const mesh_map::SphereRegion ball({0, 0, 0}, 1.0);
    EXPECT_TRUE(selectable.seenPart(ball)) << "part of it may be shown";
  }
}
