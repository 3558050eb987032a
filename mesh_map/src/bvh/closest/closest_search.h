#pragma once

#include <mesh_map/bvh/closest/bvh_closest.h>

#include "bvh/closest/normal_filter.h"

namespace mesh_map {

/// How many points so many numbers are. Throws std::invalid_argument for no multiple of 3.
std::size_t pointCount(ArrayView<double> points);

/// Looks for the closest point of one query after another. What it found for the last one is where
/// it starts with the next, which changes the time it takes but not the answer.
class ClosestSearch
{
 public:
  ClosestSearch(const Bvh& bvh, const ClosestOptions& options) : bvh_(bvh), options_(options) {}

  /// `normal` has 3 numbers or is null.
  SurfaceHit operator()(const double* point, const double* normal);

 private:
  struct NearQuery;
  struct FarTask;

  /// Asks TrianglePoint for a triangle and, if it is better, the filters whether it counts.
  void offer(std::size_t triangle);
  bool counts(std::size_t triangle) const;

  /// Looks with floats: where the mesh is large, seen from the point.
  void searchNear();
  void searchLeaf(NearQuery& query, std::size_t first, unsigned count);

  /// Looks with doubles: where the mesh is so far away that floats would hardly tell faces apart.
  void searchFar();
  bool allAsNear(const FarTask& task);

  bool isFar() const;
  const float* corners(std::size_t triangle) const { return bvh_.corners().data() + 9 * triangle; }

  const Bvh& bvh_;
  const ClosestOptions& options_;
  const double* point_ = nullptr;
  NormalFilter normals_;
  double distance_ = 0.0;                         // of the best, or the maximum
  std::uint32_t face_ = NO_INDEX;                 // the best
  std::size_t triangle_ = NO_TRIANGLE;            // the best, or that of the last query
  std::array<double, 2> beta_gamma_{{0.0, 0.0}};  // weights of its second and third corner

  static constexpr std::size_t NO_TRIANGLE = static_cast<std::size_t>(-1);
};

}  // namespace mesh_map
