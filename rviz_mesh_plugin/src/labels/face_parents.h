#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace rviz_mesh_plugin {

/// Of a mesh that was made of another one, its parent: for each face the face of the parent that it
/// is a part of. Labels belong to the parent: all parts of a face have them, or none has.
using FaceParents = std::vector<std::uint32_t>;
using FaceParentsConstPtr = std::shared_ptr<const FaceParents>;

/// Faces with all other parts of their parents' faces, ascending, each once.
/// @param faces ascending, each once; those that there are no parents for stay as they are
std::vector<std::uint32_t> wholeFaces(const std::vector<std::uint32_t>& faces,
                                      const FaceParents& parents);

}  // namespace rviz_mesh_plugin
