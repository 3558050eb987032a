#include "labels/face_parents.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace rviz_mesh_plugin {

std::vector<std::uint32_t> wholeFaces(const std::vector<std::uint32_t>& faces,
                                      const FaceParents& parents)
{
  std::vector<std::uint32_t> chosen;  // faces of the parent
  for (const std::uint32_t face : faces) {
    if (face < parents.size()) {
      chosen.push_back(parents[face]);
    }
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  std::vector<std::uint32_t> whole;
  for (std::size_t face = 0; face < parents.size(); ++face) {
    if (std::binary_search(chosen.begin(), chosen.end(), parents[face])) {
      whole.push_back(static_cast<std::uint32_t>(face));
    }
  }
  std::copy_if(faces.begin(), faces.end(), std::back_inserter(whole),
               [&](std::uint32_t face) { return face >= parents.size(); });
  return whole;
}

}  // namespace rviz_mesh_plugin
