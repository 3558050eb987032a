#pragma once

#include <mesh_map/paths/field_trace.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "bvh/closest/triangle_point.h"
#include "core/support/front_checks.h"

/// A point of a face.
struct FacePoint
{
  std::uint32_t face;
  std::array<double, 3> position;
};

/// A field on a mesh that owns its arrays. Labels are distances along edges.
struct FieldSample
{
  FrontSample sample;
  std::vector<double> labels;
  std::vector<float> slowness;
  mesh_map::SurfaceField field;

  explicit FieldSample(TestMesh mesh) : sample(std::move(mesh)) {}

  mesh_map::TraceMesh trace() const
  {
    return {sample.mesh.view(),
            {sample.topology.vertex_face_offsets, sample.topology.vertex_faces},
            sample.topology.face_flags};
  }

  std::uint32_t corner(std::size_t face, std::size_t k) const
  {
    return sample.mesh.faces[3 * face + k];
  }
  bool isOpen(std::uint32_t v) const { return slowness.empty() || std::isfinite(slowness[v]); }
  double slow(std::uint32_t v) const { return slowness.empty() ? 1.0 : double{slowness[v]}; }

  FacePoint point(std::uint32_t face, double b, double c) const
  {
    FacePoint result{face, {}};
    for (std::size_t i = 0; i < 3; ++i) {
      result.position[i] = (1.0 - b - c) * sample.mesh.corner(face, 0)[i] +
                           b * sample.mesh.corner(face, 1)[i] + c * sample.mesh.corner(face, 2)[i];
    }
    return result;
  }
  /// Inside of a face, on an edge, or a corner.
  FacePoint randomPoint(std::mt19937& random, std::uint32_t face) const
  {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const double b = share(random), c = share(random);
    switch (random() % 4) {
      case 0:
        return point(face, b, 0.0);
      case 1:
        return point(face, random() % 2 == 0 ? 1.0 : 0.0, 0.0);
      default:
        return b + c < 1.0 ? point(face, b, c) : point(face, 1.0 - b, 1.0 - c);
    }
  }

  double distanceTo(std::uint32_t v, const FacePoint& goal) const
  {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double d = sample.mesh.positions[3 * v + i] - goal.position[i];
      sum += d * d;
    }
    return std::sqrt(sum);
  }

  void use()
  {
    field.labels = labels;
    field.limit = std::numeric_limits<double>::infinity();
    field.slowness = slowness;
  }

  /// From a point of a face to its corners, and from there along edges.
  void spreadFrom(const FacePoint& goal)
  {
    std::vector<std::pair<std::uint32_t, double>> seeds;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = corner(goal.face, k);
      if (isOpen(v)) {
        seeds.emplace_back(v, distanceTo(v, goal) * slow(v));
      }
    }
    spread(seeds);
    field.goal_face = goal.face;
    field.goal = goal.position;
  }

  void spread(const std::vector<std::pair<std::uint32_t, double>>& seeds)
  {
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
    labels.assign(sample.size(), std::numeric_limits<double>::infinity());
    const auto offer = [&](std::uint32_t v, double label) {
      if (isOpen(v) && label < labels[v]) {
        labels[v] = label;
        queue.emplace(label, v);
      }
    };
    for (const auto& [v, label] : seeds) {
      offer(v, label);
    }
    while (!queue.empty()) {
      const auto [here, v] = queue.top();
      queue.pop();
      const auto& rows = sample.topology.neighbor_offsets;
      for (std::size_t i = rows[v]; here == labels[v] && i < rows[v + 1]; ++i) {
        const std::uint32_t w = sample.topology.neighbors[i];
        offer(w, here + 0.5 * (slow(v) + slow(w)) * between(sample.mesh, v, w));
      }
    }
    use();
    field.goal_face = mesh_map::NO_INDEX;
  }

  double longestSide(std::uint32_t face) const
  {
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, between(sample.mesh, corner(face, k), corner(face, (k + 1) % 3)));
    }
    return longest;
  }

  /// How far a point of a path is from a face, as a part of the face and the coordinates.
  double offFace(std::uint32_t face, const double* point) const
  {
    double far = 0.0;
    for (std::size_t k = 0; k < 9; ++k) {
      far = std::max(far, std::abs(double{sample.mesh.corner(face, k / 3)[k % 3]}));
    }
    return mesh_map::TrianglePoint(sample.mesh.corner(face, 0), sample.mesh.corner(face, 1),
                                   sample.mesh.corner(face, 2), point)
               .distance() /
           (longestSide(face) + 1e-6 * far + 1e-30);
  }

  bool isFaceOpen(std::uint32_t face) const
  {
    return isOpen(corner(face, 0)) && isOpen(corner(face, 1)) && isOpen(corner(face, 2));
  }

  /// Is a segment of a closed face only along an edge between two open corners?
  bool isOnOpenEdge(std::uint32_t face, const double* from, const double* to) const
  {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corner(face, k), b = corner(face, (k + 1) % 3);
      const float* const p = &sample.mesh.positions[3 * std::size_t{a}];
      const float* const q = &sample.mesh.positions[3 * std::size_t{b}];
      const double near = 1e-7 * longestSide(face);
      if (isOpen(a) && isOpen(b) && mesh_map::TrianglePoint(p, q, q, from).distance() <= near &&
          mesh_map::TrianglePoint(p, q, q, to).distance() <= near) {
        return true;
      }
    }
    return false;
  }

  bool isSame(std::uint32_t face, std::uint32_t other) const
  {
    std::array<std::uint32_t, 3> corners[2] = {};
    for (std::size_t k = 0; k < 6 && other != mesh_map::NO_INDEX; ++k) {
      corners[k / 3][k % 3] = corner(k < 3 ? face : other, k % 3);
    }
    std::sort(corners[0].begin(), corners[0].end());
    std::sort(corners[1].begin(), corners[1].end());
    return other != mesh_map::NO_INDEX && corners[0] == corners[1];
  }

  /// Everything that has to be true of a path.
  void check(const mesh_map::FieldPath& path, const FacePoint& start,
             bool may_be_zero = false) const
  {
    const std::size_t count = path.potentials.size();
    ASSERT_EQ(path.points.size(), 3 * count);
    ASSERT_EQ(path.faces.size() + 1, count);
    for (std::size_t i = 0; i < 3; ++i) {
      if (count > 1) {
        ASSERT_EQ(path.points[i], start.position[i]);
      }
      if (field.goal_face != mesh_map::NO_INDEX) {
        ASSERT_EQ(path.points[3 * (count - 1) + i], field.goal[i]);
      }
    }
    for (std::size_t i = 0; i + 1 < count; ++i) {
      const double *const from = &path.points[3 * i], *const to = from + 3;
      ASSERT_TRUE(path.potentials[i + 1] < path.potentials[i] ||
                  (may_be_zero && path.potentials[i + 1] == 0.0 && path.potentials[i] == 0.0))
          << i << " of " << count << ": " << path.potentials[i];
      ASSERT_LT(offFace(path.faces[i], from), 3e-9) << i << " of " << count;
      ASSERT_LT(offFace(path.faces[i], to), 3e-9) << i << " of " << count;
      const bool is_end_face =
          isSame(path.faces[i], field.goal_face) || isSame(path.faces[i], start.face);
      ASSERT_TRUE(isFaceOpen(path.faces[i]) || is_end_face || isOnOpenEdge(path.faces[i], from, to))
          << i << " of " << count;
    }
  }
};

inline double pathLength(const mesh_map::FieldPath& path)
{
  double length = 0.0;
  for (std::size_t i = 3; i < path.points.size(); i += 3) {
    const double* const p = &path.points[i];
    length += std::sqrt((p[0] - p[-3]) * (p[0] - p[-3]) + (p[1] - p[-2]) * (p[1] - p[-2]) +
                        (p[2] - p[-1]) * (p[2] - p[-1]));
  }
  return length;
}
