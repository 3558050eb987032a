#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/hidden_faces.h"
#include "level_of_detail/mesh_layout.h"

namespace rviz_mesh_plugin {

/// What is drawn of a part of a layout, some of whose faces are hidden.
struct PartMask
{
  std::size_t part = 0;
  std::vector<std::uint32_t> indices;  ///< three vertices of the layout per face that is seen
};

/// How a layout is drawn without faces that it was laid out with, until the mesh is laid out
/// without them.
struct PartMasks
{
  std::vector<PartMask> masks;
  /// Parts next to these: their simplified levels have faces over hidden ones. They and what is
  /// masked are drawn in full.
  std::vector<std::size_t> in_full;
};

/// Takes about 20 ms per million faces. None for a layout without LayoutOutline::faces, and for
/// hidden faces of another mesh. @param hidden null: none
/// @throw Canceled, std::bad_alloc
PartMasks maskParts(const LayoutOutline& layout, const HiddenFacesConstPtr& hidden,
                    const std::atomic<bool>& canceled);

}  // namespace rviz_mesh_plugin
