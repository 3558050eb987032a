#include "rviz_mesh_plugin/layout_parts.h"

#include <mesh_map/parallel.h>

#include <algorithm>
#include <utility>

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
  std::vector<std::uint32_t> vertex_ends(layout_.parts.size());
  mesh_map::parallelFor(layout_.parts.size(), 1, 0, [&]() -> mesh_map::RangeBody {
    return [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        MeshPart part;
        part.material = faces_.materials.empty() ? NONE : faces_.materials[begins_[i]];
        part.lower = part.upper = layout_.vertices[faces_.indices[3 * begins_[i]]].position;
        std::uint32_t greatest = 0;
        for (std::size_t k = 3 * begins_[i]; k < 3 * begins_[i + 1]; ++k) {
          enclose(part, faces_.indices[k]);
          greatest = std::max(greatest, faces_.indices[k]);
        }
        vertex_ends[i] = greatest + 1;
        layout_.parts[i] = std::move(part);
      }
    };
  });
  // Vertices are numbered by first use.
  part_of_vertex_.reserve(layout_.vertices.size());
  for (std::size_t i = 0; i < vertex_ends.size(); ++i) {
    part_of_vertex_.resize(std::max<std::size_t>(part_of_vertex_.size(), vertex_ends[i]),
                           static_cast<std::uint32_t>(i));
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
  layout_.cell_sizes = {0.0f};
  std::size_t total = faces_.indices.size();
  for (const SimplifiedLevel& level : levels) {
    layout_.cell_sizes.push_back(level.cell_size);
    total += level.indices.size() + level.indices.size() / 2;  // with seams
  }
  layout_.indices.reserve(total);
  std::vector<std::vector<IndexRange>> ranges(levels.size());
  for (std::size_t i = levels.size(); i-- > 0;) {
    ranges[i] = placeFaces(levels[i], split);
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

/// Whether a vertex of a face lies in another part of the same material. Copies of vertices, which
/// are none of any part, stand behind all others.
bool LayoutParts::isAbroad(std::uint32_t vertex, std::uint32_t part) const
{
  return vertex < part_of_vertex_.size() && part_of_vertex_[vertex] != part &&
         sameMaterial(part_of_vertex_[vertex], part);
}

bool LayoutParts::sameMaterial(std::uint32_t a, std::uint32_t b) const
{
  return layout_.parts[a].material == layout_.parts[b].material;
}

/// Each vertex of the faces that join parts, with each of these parts, in ascending order.
std::vector<LayoutParts::Meeting> LayoutParts::meetings(const std::vector<Face>& faces) const
{
  std::vector<Meeting> meetings;
  for (const Face& face : faces) {
    const std::uint32_t own = part_of_vertex_[face[0]];
    if (!isAbroad(face[1], own) && !isAbroad(face[2], own)) {
      continue;
    }
    for (const std::uint32_t corner : face) {
      if (corner == face[0] || isAbroad(corner, own)) {
        for (const std::uint32_t vertex : face) {
          meetings.push_back(Meeting{vertex} << 32 | part_of_vertex_[corner]);
        }
      }
    }
  }
  std::sort(meetings.begin(), meetings.end());
  meetings.erase(std::unique(meetings.begin(), meetings.end()), meetings.end());
  return meetings;
}

/// The parts that draw a face beside its own, with the face: those that it touches, and those that
/// a face beside it touches, since vertices of these parts may have been merged into its corners.
std::vector<LayoutParts::FaceBeside> LayoutParts::facesBeside(const std::vector<Face>& faces) const
{
  const std::vector<Meeting> met = meetings(faces);
  std::vector<std::uint32_t> first(layout_.vertices.size(), NONE);  // of each vertex in met
  for (std::size_t i = met.size(); i-- > 0;) {
    first[met[i] >> 32] = static_cast<std::uint32_t>(i);
  }
  std::vector<FaceBeside> beside;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const std::size_t others = beside.size();
    const std::uint32_t own = part_of_vertex_[faces[i][0]];
    for (const std::uint32_t vertex : faces[i]) {
      for (std::size_t k = first[vertex]; k < met.size() && met[k] >> 32 == vertex; ++k) {
        const FaceBeside other{static_cast<std::uint32_t>(met[k]), static_cast<std::uint32_t>(i)};
        if (other.first != own && sameMaterial(other.first, own) &&
            std::find(beside.begin() + others, beside.end(), other) == beside.end()) {
          beside.push_back(other);
        }
      }
    }
  }
  return beside;
}

/// Appends the faces, part after part; returns the range of each part.
std::vector<IndexRange> LayoutParts::placeFaces(const SimplifiedLevel& level, LayoutSplit& split)
{
  std::vector<Face> faces;
  faces.reserve(level.indices.size() / 3);
  std::vector<IndexRange> ranges(layout_.parts.size());
  for (std::size_t i = 0; i < level.indices.size(); i += 3) {
    faces.push_back(split.corners(&level.indices[i], layout_));
    const std::uint32_t own = part_of_vertex_[faces.back()[0]];
    ranges[own].count += 3;
    for (const std::uint32_t vertex : faces.back()) {
      if (vertex >= part_of_vertex_.size() || part_of_vertex_[vertex] != own) {
        enclose(layout_.parts[own], vertex);
      }
    }
  }
  const std::vector<FaceBeside> beside = facesBeside(faces);
  for (const FaceBeside& other : beside) {
    ranges[other.first].seam_count += 3;
  }
  std::vector<std::size_t> next_own(ranges.size());
  std::vector<std::size_t> next_beside(ranges.size());
  std::size_t end = layout_.indices.size();
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i].start = static_cast<std::uint32_t>(end);
    next_own[i] = end;
    next_beside[i] = end + ranges[i].count;
    end = ranges[i].end();
  }
  layout_.indices.resize(end);
  const auto write = [this](const Face& face, std::size_t& place) {
    std::copy(face.begin(), face.end(), layout_.indices.begin() + place);
    place += face.size();
  };
  for (const Face& face : faces) {
    write(face, next_own[part_of_vertex_[face[0]]]);
  }
  for (const FaceBeside& other : beside) {
    write(faces[other.second], next_beside[other.first]);
  }
  return ranges;
}

}  // namespace rviz_mesh_plugin
