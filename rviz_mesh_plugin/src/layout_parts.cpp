#include "rviz_mesh_plugin/layout_parts.h"

#include <mesh_map/parallel.h>

#include <algorithm>
#include <array>

#include "rviz_mesh_plugin/part_cuts.h"

namespace rviz_mesh_plugin {

LayoutParts::LayoutParts(const SplitFaces& faces, MeshLayout& layout)
    : faces_(faces), layout_(layout), begins_(cutIntoParts(faces, layout.vertices))
{
  fillParts();
}

void LayoutParts::fillParts()
{
  layout_.parts.assign(begins_.size() - 1, MeshPart{});
  vertex_begins_.assign(begins_.size() - 1, 0);
  mesh_map::parallelFor(layout_.parts.size(), 1, 0, [this]() -> mesh_map::RangeBody {
    return [this](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        MeshPart& part = layout_.parts[i];
        part.material = faces_.materials.empty() ? NONE : faces_.materials[begins_[i]];
        part.lower = part.upper = layout_.vertices[faces_.indices[3 * begins_[i]]].position;
        std::uint32_t greatest = 0;
        for (std::size_t k = 3 * begins_[i]; k < 3 * begins_[i + 1]; ++k) {
          enclose(part, faces_.indices[k]);
          greatest = std::max(greatest, faces_.indices[k]);
        }
        // Vertices are numbered by first use.
        if (i + 1 < vertex_begins_.size()) {
          vertex_begins_[i + 1] = greatest + 1;
        }
      }
    };
  });
  for (std::size_t i = 1; i < vertex_begins_.size(); ++i) {
    vertex_begins_[i] = std::max(vertex_begins_[i], vertex_begins_[i - 1]);
  }
}

void LayoutParts::enclose(MeshPart& part, std::uint32_t vertex) const
{
  const auto& position = layout_.vertices[vertex].position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.lower[axis] = std::min(part.lower[axis], position[axis]);
    part.upper[axis] = std::max(part.upper[axis], position[axis]);
  }
}

void LayoutParts::write(const std::vector<SimplifiedLevel>& levels, LayoutSplit& split)
{
  std::vector<std::vector<std::uint32_t>> coarse;
  std::vector<std::vector<IndexRange>> ranges(levels.size());
  layout_.cell_sizes = {0.0f};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    coarse.push_back(placeFaces(levels[i], split, ranges[i]));
    layout_.cell_sizes.push_back(levels[i].cell_size);
  }
  std::size_t total = faces_.indices.size();
  for (const auto& indices : coarse) {
    total += indices.size();
  }
  layout_.indices.reserve(total);
  for (std::size_t i = levels.size(); i-- > 0;) {
    for (IndexRange& range : ranges[i]) {
      range.start += static_cast<std::uint32_t>(layout_.indices.size());
    }
    layout_.indices.insert(layout_.indices.end(), coarse[i].begin(), coarse[i].end());
  }
  const std::size_t full = layout_.indices.size();
  layout_.indices.insert(layout_.indices.end(), faces_.indices.begin(), faces_.indices.end());
  for (std::size_t i = 0; i < layout_.parts.size(); ++i) {
    MeshPart& part = layout_.parts[i];
    part.levels.push_back({static_cast<std::uint32_t>(full + 3 * begins_[i]),
                           static_cast<std::uint32_t>(3 * (begins_[i + 1] - begins_[i]))});
    for (const auto& level : ranges) {
      part.levels.push_back(level[i]);
    }
  }
}

/// The indices, part after part, and the range of each part in them.
std::vector<std::uint32_t> LayoutParts::placeFaces(const SimplifiedLevel& level, LayoutSplit& split,
                                                   std::vector<IndexRange>& ranges)
{
  const std::size_t count = level.indices.size() / 3;
  std::vector<std::array<std::uint32_t, 3>> faces(count);
  std::vector<std::uint32_t> parts(count);
  ranges.assign(layout_.parts.size(), IndexRange{});
  for (std::size_t i = 0; i < count; ++i) {
    faces[i] = split.corners(&level.indices[3 * i], layout_);
    const auto behind = std::upper_bound(vertex_begins_.begin(), vertex_begins_.end(), faces[i][0]);
    parts[i] = static_cast<std::uint32_t>(behind - vertex_begins_.begin() - 1);
    for (const std::uint32_t vertex : faces[i]) {
      enclose(layout_.parts[parts[i]], vertex);
    }
    ranges[parts[i]].count += 3;
  }
  std::vector<std::uint32_t> next(ranges.size());
  std::uint32_t start = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i].start = next[i] = start;
    start += ranges[i].count;
  }
  std::vector<std::uint32_t> indices(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    std::copy(faces[i].begin(), faces[i].end(), indices.begin() + next[parts[i]]);
    next[parts[i]] += 3;
  }
  return indices;
}

}  // namespace rviz_mesh_plugin
