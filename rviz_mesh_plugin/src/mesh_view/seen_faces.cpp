#include "mesh_view/seen_faces.h"

#include <cstdint>
#include <utility>

#include "mesh_view/selectable_faces.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// So many faces are looked at between two looks at the cancel flag.
constexpr std::uint32_t SEEN_STRETCH = 1 << 16;

bool hasSeen(const ShownMesh& shown, const Cancellation& cancellation)
{
  const SelectableFaces seen(shown);
  for (std::uint32_t face = 0; face < shown.mesh->faceCount(); ++face) {
    if (face % SEEN_STRETCH == 0) {
      throwIfCanceled(&cancellation.flag());
    }
    if (seen.contains(face)) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool SeenFaces::any(const MeshDataConstPtr& mesh, const Section& section,
                    const HiddenFacesConstPtr& hidden)
{
  if (!mesh || (!section.cuts() && !hidden)) {
    task_.drop();
    mesh_.reset();
    any_ = true;
    return true;
  }
  if (mesh_.lock() != mesh || section != section_ || hidden != hidden_) {
    mesh_ = mesh;
    section_ = section;
    hidden_ = hidden;
    any_ = true;
    ShownMesh shown;
    shown.mesh = mesh;
    shown.section = section;
    shown.hidden = hidden;
    task_.start([shown = std::move(shown)](const Cancellation& cancellation) {
      return hasSeen(shown, cancellation);
    });
  }
  if (const auto outcome = task_.take()) {
    any_ = outcome->result.value_or(true);
  }
  return any_;
}

}  // namespace rviz_mesh_plugin
