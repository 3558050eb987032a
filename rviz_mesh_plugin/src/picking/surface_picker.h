#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#ifndef Q_MOC_RUN
#include "base/mesh_data.h"
#include "mesh_view/shown_mesh.h"
#include "picking/view_geometry.h"
#include "spatial/spatial_queries.h"
#endif

namespace rviz {
class DisplayContext;
class ViewportMouseEvent;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// Where a ray meets a mesh. Lengths in meters; coordinates are those of the mesh.
struct SurfaceHit : ShownMesh
{
  std::shared_ptr<const SpatialQueries> queries;
  std::uint32_t face = 0;
  std::array<double, 3> barycentric{};  ///< weights of the corners
  std::array<double, 3> point{};
  double distance = 0.0;           ///< from the origin of the ray
  std::array<double, 3> normal{};  ///< of the face, to the side from which it is counterclockwise
};

struct Pick
{
  std::optional<SurfaceHit> hit;
  std::string reason;  ///< why there is none, and the way out; else empty
};

/// Finds what is clicked at: the nearest face of all meshes that TexturedMesh displays show,
/// wherever they lie in the tree of displays, as far as they are in their sections and not hidden.
/// GUI thread only.
class SurfacePicker
{
 public:
  /// @param context outlives the picker
  explicit SurfacePicker(rviz::DisplayContext* context);

  /// Of all displays.
  std::vector<ShownMesh> meshes() const;

  /// Whether a display has this mesh, shown or not.
  bool exists(const MeshDataConstPtr& mesh) const;

  struct Search
  {
    std::vector<MeshDataConstPtr> meshes;  ///< of that name, shown or not
    bool others_expected = false;          ///< a display has none yet
  };
  /// The meshes of a name that displays have.
  Search search(const std::string& uuid) const;

  /// Begins to prepare all meshes that are shown, so that the first click finds them prepared.
  void prepare() const;

  /// The nearest hit. Where a mesh that is not prepared yet may be nearer, there is none.
  /// @param ray in the fixed frame, the direction of length 1
  /// @param back_faces false: faces seen from behind are looked through
  Pick pick(const mesh_map::Ray& ray, bool back_faces = true) const;
  /// What is under the cursor: what is drawn in the middle of that pixel.
  Pick pick(const rviz::ViewportMouseEvent& event, bool back_faces = true) const
  {
    return pick(cursorRay(event), back_faces);
  }

 private:
  rviz::DisplayContext* context_;
  std::shared_ptr<void> user_;  ///< of the SurfaceIndex
};

}  // namespace rviz_mesh_plugin
