#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include <mesh_map/bvh/selection/region.h>

#include "base/face_bits.h"
#include "mesh_view/shown_mesh.h"

namespace rviz_mesh_plugin {

/// Which faces of a mesh can be selected as it is shown: those of which a point is in its section,
/// but not the hidden ones.
/// For any thread.
class SelectableFaces
{
 public:
  explicit SelectableFaces(const ShownMesh& shown);

  /// No face is left out.
  bool all() const { return !section_ && !none_ && !hidden_; }
  /// A section, not only hidden faces, leaves faces out, or parts of them.
  bool cut() const { return section_ || none_; }
  bool contains(std::uint32_t face) const;

  /// Looks at each face, for a thread. @throw Canceled (cancellation.h), std::bad_alloc
  FaceBits bits(const std::atomic<bool>* cancel = nullptr) const;

  /// Takes out all others. @throw Canceled, std::bad_alloc
  void keep(std::vector<std::uint32_t>& faces, const std::atomic<bool>* cancel = nullptr) const;
  void keep(FaceBits& faces, const std::atomic<bool>* cancel = nullptr) const;

  /// The part of a region in which something can be seen: exactly that of a convex one, of others
  /// the part of what encloses them. @param region a SphereRegion, ConvexRegion or LassoRegion
  std::optional<mesh_map::ConvexRegion> seenPart(const mesh_map::Region& region) const;

 private:
  MeshDataConstPtr mesh_;
  bool none_ = false;                              ///< can be
  std::optional<mesh_map::ConvexRegion> section_;  ///< none: there is no limit
  HiddenFacesConstPtr hidden_;                     ///< null: none
};

/// The part of a ray, given in the coordinates of a mesh, that is in its section; none where it
/// passes that by. `skipped` is what was taken off its beginning, in meters.
struct SectionRay
{
  std::array<double, 3> origin{};
  double max_distance = 0.0;
  double skipped = 0.0;
};
/// @param direction of length 1
std::optional<SectionRay> rayInSection(const std::array<double, 3>& origin,
                                       const std::array<double, 3>& direction, double max_distance,
                                       const Section& section);

}  // namespace rviz_mesh_plugin
