#include "base/hidden_faces.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <iterator>
#include <mutex>
#include <stdexcept>
#include <tuple>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {
namespace {

struct Registry
{
  std::mutex mutex;
  std::deque<std::pair<MeshKey, HiddenFacesConstPtr>> entries;  ///< the last changed last
  std::atomic<std::uint64_t> revision{0};
};

/// Never destroyed: threads may still use it while the process ends.
Registry& registry()
{
  static Registry& instance = *new Registry;
  return instance;
}

}  // namespace

HiddenFaces::HiddenFaces(FaceBits faces)
    : bits_(std::move(faces)), count_(bits_.count()), mask_(bits_.size(), 1)
{
  bits_.visit([this](std::uint32_t face) { mask_[face] = 0; });
}

bool operator==(const MeshKey& a, const MeshKey& b)
{
  return std::tie(a.vertex_count, a.face_count, a.uuid) ==
         std::tie(b.vertex_count, b.face_count, b.uuid);
}

HiddenFacesConstPtr hiddenFaces(const MeshKey& mesh)
{
  Registry& all = registry();
  const std::lock_guard<std::mutex> lock(all.mutex);
  const auto found = std::find_if(all.entries.begin(), all.entries.end(),
                                  [&](const auto& entry) { return entry.first == mesh; });
  return found == all.entries.end() ? nullptr : found->second;
}

void setHiddenFaces(const MeshKey& mesh, HiddenFacesConstPtr hidden)
{
  if (hidden && hidden->bits().size() != mesh.face_count) {
    throw std::invalid_argument("faces of a mesh of " + std::to_string(hidden->bits().size()) +
                                " cannot be hidden in one of " + std::to_string(mesh.face_count));
  }
  Registry& all = registry();
  const std::lock_guard<std::mutex> lock(all.mutex);
  eraseIf(all.entries, [&](const auto& entry) { return entry.first == mesh; });
  if (hidden && hidden->count() > 0) {
    all.entries.emplace_back(mesh, std::move(hidden));
    if (all.entries.size() > MOST_MESHES_WITH_HIDDEN_FACES) {
      all.entries.pop_front();
    }
  }
  ++all.revision;
}

std::uint64_t hiddenFacesRevision()
{
  return registry().revision;
}

std::shared_ptr<const FaceBits::Faces> withoutHidden(
    const std::shared_ptr<const FaceBits::Faces>& faces, const HiddenFacesConstPtr& hidden)
{
  if (!hidden) {
    return faces;
  }
  auto shown = std::make_shared<FaceBits::Faces>();
  shown->reserve(faces->size());
  std::copy_if(faces->begin(), faces->end(), std::back_inserter(*shown),
               [&](std::uint32_t face) { return !hidden->contains(face); });
  return shown;
}

}  // namespace rviz_mesh_plugin
