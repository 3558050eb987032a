#pragma once

#include <mesh_map/bvh/tree/bvh.h>

#include <cstdint>
#include <vector>

#include "base/run.h"
#include "base/vector3.h"

namespace mesh_map {

/// What is filled: the inside of solids (see solids.h) that are not hollow, but for the insides of
/// hollow ones. Where solids overlap, all of both is filled.
///
/// A solid that lies wholly in another one and meets no solid is what is hollow in it; one in that
/// is filled again, and so on: so a building of an outer and an inner surface is filled between the
/// two, whichever way their faces are turned. One that lies in another one and meets a third (an
/// inner surface with a partition wall in it, and that wall) is hollow where it is turned the other
/// way than the outermost one around it, else filled.
class Material
{
 public:
  /// `solids`: per face of the mesh. Both have to stay. Throws Canceled.
  Material(const Bvh& bvh, const MeshView& mesh, ArrayView<std::uint32_t> solids, const Run& run,
           unsigned threads);

  bool empty() const { return extents_.empty(); }

  /// Whether there is material at a point, which is on no face. `inside` is room for what it finds.
  bool at(const Vector3& point, std::vector<std::uint32_t>& inside) const;

 private:
  struct Extent
  {
    Vector3 lower, upper;
    double volume = 0.0;  // six times that of what is inside; its sign says how faces are turned
  };
  struct Nesting;

  /// The solids that a point is inside of, in any order.
  void solidsAround(const Vector3& point, std::vector<std::uint32_t>& inside) const;

  void setSigns(const Run& run, unsigned threads);
  void findMeetings(std::size_t face, Nesting& nesting) const;

  const Bvh& bvh_;
  const MeshView mesh_;
  const ArrayView<std::uint32_t> solids_;
  std::vector<Extent> extents_;  // of each solid
  Extent all_;
  std::vector<int> signs_;  // of each solid: 1 is filled, -1 is hollow
};

}  // namespace mesh_map
