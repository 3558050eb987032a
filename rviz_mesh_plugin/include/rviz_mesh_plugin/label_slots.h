#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rviz_mesh_plugin {

/// In which place of an index buffer each face of a label is: faces that stay keep their places, so
/// that only what has changed needs to be uploaded.
class LabelSlots
{
 public:
  /// Places from begin to before end.
  struct Range
  {
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  /// Replaces the faces (any order, each once); returns the places that have changed, ascending.
  /// Neighboring changes are joined, with few unchanged places between them.
  std::vector<Range> assign(const std::vector<std::uint32_t>& faces);

  /// By place.
  const std::vector<std::uint32_t>& faces() const { return faces_; }

 private:
  std::vector<std::uint32_t> faces_;
};

/// Sorts, joins those that are near to each other, and cuts off what is beyond @a end.
std::vector<LabelSlots::Range> joined(std::vector<LabelSlots::Range> ranges, std::size_t end);

}  // namespace rviz_mesh_plugin
