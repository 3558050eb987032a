#ifndef MESH_MAP_FRONT_H
#define MESH_MAP_FRONT_H

#include <mesh_map/front_mesh.h>

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace mesh_map {

/// What SurfaceFront::solve is asked. Views have to outlive the call.
struct FrontQuery
{
  ArrayView<std::uint32_t> sources;
  ArrayView<float> source_distances;  ///< one per source, finite and >= 0

  /// What lies beyond is not reached.
  float max_distance = std::numeric_limits<float>::infinity();

  /// Time that a meter takes, per vertex, or empty for 1 everywhere. Vertices with +inf or NaN are
  /// never reached, not even as a source.
  ArrayView<float> slowness;

  const std::atomic<bool>* cancel = nullptr;
};

struct FrontField
{
  std::vector<float> distance;  ///< +inf where not reached
  bool cancelled = false;       ///< then the field is incomplete and of no use
};

/// Fast marching over the surface of any triangle soup: a front from points, across faces. In each
/// triangle it is a circle around the point where the source lies when what is between is unfolded,
/// as follows from two distances. Where the corner of a triangle that it comes to is obtuse, the
/// triangles beyond the opposite side are unfolded, up to a vertex that divides that corner into
/// acute ones. Where no circle fits, it goes along the edges.
///
/// Exact on planes for a single source, up to rounding, within the limits of the unfolding. Fronts
/// of several sources that meet, such as those of an extended obstacle, are better off with
/// ObstacleDistance.
///
/// Immutable, so several threads may solve at once.
class SurfaceFront
{
 public:
  explicit SurfaceFront(std::shared_ptr<const FrontMesh> mesh, unsigned threads = 0);

  /// Throws std::invalid_argument for a query outside of the ranges above.
  FrontField solve(const FrontQuery& query) const;

  const FrontMesh& mesh() const { return *mesh_; }

 private:
  /// A triangle that is unfolded across an obtuse corner, as one of the two ends of its base sees
  /// it.
  struct Stencil
  {
    std::uint32_t target, partner;
    float base, to_target, partner_to_target;
  };
  class Run;

  static void findStencils(const FrontMesh& mesh, std::uint32_t v,
                           std::vector<std::pair<std::uint32_t, Stencil>>& found);

  std::shared_ptr<const FrontMesh> mesh_;
  std::vector<std::uint32_t> stencil_offsets_;
  std::vector<Stencil> stencils_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_FRONT_H
