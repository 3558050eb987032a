#include "rviz_mesh_plugin/layout_parts.h"

#include <mesh_map/parallel.h>

#include <algorithm>
#include <utility>

#include "rviz_mesh_plugin/part_cuts.h"

namespace rviz_mesh_plugin {

LayoutParts::LayoutParts(const SplitFaces& faces, MeshLayout& layout)
    : faces_(faces),
      layout_(layout),
      vertex_count_(layout.vertices.size()),
      begins_(cutIntoParts(faces, layout.vertices))
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

/// The parts that the corners of a face belong to, that of the first one, which is the face's own,
/// first.
std::vector<std::uint32_t> LayoutParts::partsOf(const Face& face) const
{
  std::vector<std::uint32_t> parts;
  for (const std::uint32_t vertex : face) {
    const auto behind = std::upper_bound(vertex_begins_.begin(), vertex_begins_.end(), vertex);
    const auto part = static_cast<std::uint32_t>(behind - vertex_begins_.begin() - 1);
    // Copies of vertices, which are none of any part, stand behind all others.
    const bool counts = parts.empty() || (vertex < vertex_count_ && sameMaterial(part, parts[0]));
    if (counts && std::find(parts.begin(), parts.end(), part) == parts.end()) {
      parts.push_back(part);
    }
  }
  return parts;
}

bool LayoutParts::sameMaterial(std::uint32_t a, std::uint32_t b) const
{
  return layout_.parts[a].material == layout_.parts[b].material;
}

/// Of each face the parts that draw it, its own first: also those that a face beside it touches,
/// since vertices of these parts may have been merged into its corners.
std::vector<std::vector<std::uint32_t>> LayoutParts::partsOfAll(
    const std::vector<Face>& faces) const
{
  std::vector<std::vector<std::uint32_t>> parts(faces.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> met;  // vertices and parts
  for (std::size_t i = 0; i < faces.size(); ++i) {
    parts[i] = partsOf(faces[i]);
    if (parts[i].size() > 1) {
      for (const std::uint32_t vertex : faces[i]) {
        for (const std::uint32_t part : parts[i]) {
          met.emplace_back(vertex, part);
        }
      }
    }
  }
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
  std::vector<bool> meets(layout_.vertices.size(), false);
  for (const auto& pair : met) {
    meets[pair.first] = true;
  }
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (const std::uint32_t vertex : faces[i]) {
      if (!meets[vertex]) {
        continue;
      }
      auto pair = std::lower_bound(met.begin(), met.end(), std::make_pair(vertex, 0u));
      for (; pair != met.end() && pair->first == vertex; ++pair) {
        if (sameMaterial(pair->second, parts[i][0]) &&
            std::find(parts[i].begin(), parts[i].end(), pair->second) == parts[i].end()) {
          parts[i].push_back(pair->second);
        }
      }
    }
  }
  return parts;
}

/// The indices, part after part, and the range of each part in them.
std::vector<std::uint32_t> LayoutParts::placeFaces(const SimplifiedLevel& level, LayoutSplit& split,
                                                   std::vector<IndexRange>& ranges)
{
  std::vector<Face> faces;
  for (std::size_t i = 0; i < level.indices.size(); i += 3) {
    faces.push_back(split.corners(&level.indices[i], layout_));
  }
  const auto parts = partsOfAll(faces);
  std::vector<std::vector<Face>> own(layout_.parts.size());
  std::vector<std::vector<Face>> beside(layout_.parts.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (const std::uint32_t part : parts[i]) {
      (part == parts[i][0] ? own : beside)[part].push_back(faces[i]);
    }
    for (const std::uint32_t vertex : faces[i]) {
      enclose(layout_.parts[parts[i][0]], vertex);
    }
  }
  std::vector<std::uint32_t> indices;
  ranges.assign(layout_.parts.size(), IndexRange{});
  for (std::size_t part = 0; part < ranges.size(); ++part) {
    ranges[part].start = static_cast<std::uint32_t>(indices.size());
    ranges[part].count = static_cast<std::uint32_t>(3 * own[part].size());
    ranges[part].seam_count = static_cast<std::uint32_t>(3 * beside[part].size());
    for (const auto* drawn : {&own[part], &beside[part]}) {
      for (const Face& face : *drawn) {
        indices.insert(indices.end(), face.begin(), face.end());
      }
    }
  }
  return indices;
}

}  // namespace rviz_mesh_plugin
