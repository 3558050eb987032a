#include "level_of_detail/mesh_layout.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/vectors.h"
#include "level_of_detail/layout_split.h"
#include "level_of_detail/mesh_region.h"
#include "level_of_detail/simplification.h"
#include "level_of_detail/sorted_mesh.h"
#include "level_of_detail/vertex_clusters.h"

namespace rviz_mesh_plugin {
namespace {

/// A preview has at most so many cells along its longest side.
constexpr int PREVIEW_CELLS = 160;

/// Faces are cut in blocks of at most so many.
constexpr std::size_t BLOCK_FACES = 128;

/// So many times as far as usual is far; the usual one of so many steps from face to face.
constexpr double LEAP = 16.0;
constexpr std::size_t SAMPLES = 20000;

/// A cut that leaves less than this part of the cost parts strays from the rest.
constexpr float STRAY_GAIN = 0.25f;

/// Grows with the chance that a camera sees the box; not 0 for flat ones.
float sizeOf(const Bounds& box)
{
  const auto sides = box.sides();
  return sides[0] + sides[1] + sides[2];
}

/// Cuts faces that are ordered in space into parts of one material that have small boxes.
class Cutter
{
 public:
  Cutter(const SplitFaces& faces, const std::vector<MeshVertex>& vertices)
      : faces_(faces), vertices_(vertices), count_(faces.indices.size() / 3)
  {
  }

  /// The first face of each part, and the end.
  std::vector<std::size_t> cut()
  {
    makeBlocks();
    for (std::size_t first = 0; first < boxes_.size();) {
      std::size_t last = first + 1;
      while (last < boxes_.size() && material(last) == material(first)) {
        ++last;
      }
      cutBlocks(first, last);
      first = last;
    }
    cuts_.push_back(count_);
    return cuts_;
  }

 private:
  std::uint32_t material(std::size_t block) const
  {
    return faces_.materials.empty() ? NONE : faces_.materials[begins_[block]];
  }

  const std::array<float, 3>& position(std::size_t index) const
  {
    return vertices_[faces_.indices[index]].position;
  }

  /// How far a face is from the one before.
  double step(std::size_t face) const
  {
    return distance(position(3 * face - 3), position(3 * face));
  }

  /// Blocks end where the material changes, and where the next face is many times as far as usual,
  /// too: a block that leaps would make the box of its part large.
  void makeBlocks()
  {
    std::vector<double> steps;
    for (std::size_t face = 1; face < count_; face += std::max<std::size_t>(1, count_ / SAMPLES)) {
      steps.push_back(step(face));
    }
    const auto usual = steps.begin() + steps.size() / 2;
    std::nth_element(steps.begin(), usual, steps.end());
    const double far = steps.empty() ? 0.0 : LEAP * *usual;
    const auto& materials = faces_.materials;
    for (std::size_t face = 0; face < count_; ++face) {
      if (face == 0 || face - begins_.back() == BLOCK_FACES ||
          (!materials.empty() && materials[face] != materials[face - 1]) || step(face) > far) {
        begins_.push_back(face);
      }
    }
    begins_.push_back(count_);
    boxes_.resize(begins_.size() - 1);
    mesh_map::parallelEach(boxes_.size(), BLOCK_FACES, 0, [this](std::size_t block) {
      Bounds box = Bounds::none();
      for (std::size_t i = 3 * begins_[block]; i < 3 * begins_[block + 1]; ++i) {
        box.enclose(position(i));
      }
      boxes_[block] = box;
    });
  }

  std::size_t facesOf(std::size_t first, std::size_t last) const
  {
    return begins_[last] - begins_[first];
  }

  /// Halves the blocks [first, last) where that makes the smallest boxes, until they are few.
  void cutBlocks(std::size_t first, std::size_t last)
  {
    const std::size_t count = last - first;
    std::vector<float> costs(count, 0.0f);  // of a cut before each block
    Bounds box = Bounds::none();
    for (std::size_t i = count; i-- > 1;) {
      box.enclose(boxes_[first + i]);
      costs[i] = sizeOf(box) * static_cast<float>(facesOf(first + i, last));
    }
    box = Bounds::none();
    for (std::size_t i = 1; i < count; ++i) {
      box.enclose(boxes_[first + i - 1]);
      costs[i] += sizeOf(box) * static_cast<float>(facesOf(first, first + i));
    }
    box.enclose(boxes_[last - 1]);
    const float whole = sizeOf(box) * static_cast<float>(facesOf(first, last));
    std::size_t best = bestCut(costs, 1, count);
    if (count == 1 || !(costs[best] < STRAY_GAIN * whole)) {
      if (facesOf(first, last) <= PART_FACES) {
        cuts_.push_back(begins_[first]);
        return;
      }
      best = bestCut(costs, (count + 7) / 8, count - count / 8);
    }
    cutBlocks(first, first + best);
    cutBlocks(first + best, last);
  }

  /// Of equal ones the one next to the middle.
  static std::size_t bestCut(const std::vector<float>& costs, std::size_t begin, std::size_t end)
  {
    const std::size_t middle = costs.size() / 2;
    std::size_t best = middle;
    for (std::size_t i = begin; i < end; ++i) {
      best = costs[i] < costs[best] ? i : best;
    }
    return best;
  }

  const SplitFaces& faces_;
  const std::vector<MeshVertex>& vertices_;
  std::size_t count_;
  std::vector<std::size_t> begins_;  ///< first face of each block, and the end
  std::vector<Bounds> boxes_;
  std::vector<std::size_t> cuts_;
};

/// Cuts the faces of a layout, whose vertices are there, into parts and fills in parts, indices and
/// cell sizes.
class LayoutParts
{
 public:
  LayoutParts(const SplitFaces& faces, MeshLayout& layout)
      : faces_(faces), layout_(layout), begins_(Cutter(faces, layout.vertices).cut())
  {
    fillParts();
  }

  /// From fine to coarse; writes the layout's indices.
  void write(const std::vector<SimplifiedLevel>& levels, LayoutSplit& split)
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

 private:
  using Face = std::array<std::uint32_t, 3>;
  using Meeting = std::uint64_t;  ///< a vertex, and in the lower half a part
  using FaceBeside = std::pair<std::uint32_t, std::uint32_t>;  ///< a part, a face

  void fillParts()
  {
    layout_.parts.assign(begins_.size() - 1, MeshPart{});
    std::vector<std::uint32_t> vertex_ends(layout_.parts.size());
    mesh_map::parallelEach(
        layout_.parts.size(), 1, 0, [this, ends = vertex_ends.data()](std::size_t i) {
          MeshPart& part = layout_.parts[i];
          part.material = faces_.materials.empty() ? NONE : faces_.materials[begins_[i]];
          Bounds box = Bounds::none();
          std::uint32_t end = 0;
          for (std::size_t k = 3 * begins_[i]; k < 3 * begins_[i + 1]; ++k) {
            box.enclose(layout_.vertices[faces_.indices[k]].position);
            end = std::max(end, faces_.indices[k] + 1);
          }
          static_cast<Bounds&>(part) = box;
          ends[i] = end;
        });
    // Vertices are numbered by first use.
    part_of_vertex_.reserve(layout_.vertices.size());
    for (std::size_t i = 0; i < vertex_ends.size(); ++i) {
      part_of_vertex_.resize(std::max<std::size_t>(part_of_vertex_.size(), vertex_ends[i]),
                             static_cast<std::uint32_t>(i));
    }
  }

  /// Whether a vertex of a face lies in another part of the same material. Copies of vertices,
  /// which are none of any part, stand behind all others.
  bool isAbroad(std::uint32_t vertex, std::uint32_t part) const
  {
    return vertex < part_of_vertex_.size() && part_of_vertex_[vertex] != part &&
           sameMaterial(part_of_vertex_[vertex], part);
  }

  bool sameMaterial(std::uint32_t a, std::uint32_t b) const
  {
    return layout_.parts[a].material == layout_.parts[b].material;
  }

  /// Each vertex of the faces that join parts, with each of these parts, in ascending order.
  std::vector<Meeting> meetings(const std::vector<Face>& faces) const
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

  /// The parts that draw a face beside its own, with the face: those that it touches, and those
  /// that a face beside it touches, since vertices of these parts may have been merged into its
  /// corners.
  std::vector<FaceBeside> facesBeside(const std::vector<Face>& faces) const
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
  std::vector<IndexRange> placeFaces(const SimplifiedLevel& level, LayoutSplit& split)
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
          layout_.parts[own].enclose(layout_.vertices[vertex].position);
        }
      }
    }
    const std::vector<FaceBeside> beside = facesBeside(faces);
    for (const FaceBeside& other : beside) {
      ranges[other.first].seam_count += 3;
      const std::uint32_t own = part_of_vertex_[faces[other.second][0]];
      std::vector<std::uint32_t>& drawn_beside = layout_.parts[own].drawn_beside;
      if (std::find(drawn_beside.begin(), drawn_beside.end(), other.first) == drawn_beside.end()) {
        drawn_beside.push_back(other.first);
      }
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

  const SplitFaces& faces_;
  MeshLayout& layout_;
  std::vector<std::size_t> begins_;  ///< first face of each part, and the end
  /// The first one to use it, without copies that levels need.
  std::vector<std::uint32_t> part_of_vertex_;
};

/// Without the faces that are hidden.
SortedMesh sortShown(const MeshData& mesh, const MeshRegion& region, const HiddenFaces* hidden)
{
  if (hidden == nullptr) {
    return sortInSpace(mesh.vertices, mesh.indices, region);
  }
  std::vector<std::uint32_t> shown;  // faces
  shown.reserve(mesh.faceCount() - hidden->count());
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * (mesh.faceCount() - hidden->count()));
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    if (!hidden->contains(face)) {
      shown.push_back(face);
      const auto corners = mesh.indices.begin() + 3 * std::ptrdiff_t{face};
      indices.insert(indices.end(), corners, corners + 3);
    }
  }
  SortedMesh sorted = sortInSpace(mesh.vertices, indices, region);
  for (std::uint32_t& face : sorted.faces) {
    face = shown[face];
  }
  return sorted;
}

void refuseWrongMaterials(const MeshData& mesh, const Materials* materials)
{
  if (materials != nullptr && !materials->texture_coordinates.empty() &&
      materials->texture_coordinates.size() != mesh.vertexCount()) {
    throw std::invalid_argument(
        "there are " + std::to_string(materials->texture_coordinates.size()) +
        " texture coordinates for " + std::to_string(mesh.vertexCount()) + " vertices");
  }
}

}  // namespace

std::atomic<std::size_t> preview_threshold{2500000};

MeshLayoutConstPtr layOut(const MeshDataConstPtr& mesh, Split split,
                          const MaterialsConstPtr& materials, const std::atomic<bool>& canceled,
                          const HiddenFacesConstPtr& hidden)
{
  refuseWrongMaterials(*mesh, materials.get());
  if (canceled) {
    return nullptr;
  }
  const auto splitter = makeSplit(split, materials.get());
  const MeshRegion region = mainRegion(*mesh);
  SortedMesh sorted = sortShown(*mesh, region, hidden.get());
  if (canceled) {
    return nullptr;
  }
  auto layout = std::make_shared<MeshLayout>();
  layout->mesh = mesh;
  layout->materials = split == Split::BY_MATERIAL ? materials : nullptr;
  layout->split = split;
  layout->hidden = hidden;
  std::vector<SimplifiedLevel> levels;
  SplitFaces faces;
  std::unique_ptr<LayoutParts> parts;
  mesh_map::parallelJobs({[&]() {
                            levels = simplifyInLevels(sorted.vertices, sorted.indices, region,
                                                      typicalEdge(*mesh), canceled);
                          },
                          [&]() {
                            faces = splitter->split(sorted, *layout);
                            parts = std::make_unique<LayoutParts>(faces, *layout);
                          }},
                         2);
  if (canceled) {
    return nullptr;
  }
  parts->write(levels, *splitter);
  if (split == Split::NONE) {
    layout->faces = std::make_shared<const std::vector<std::uint32_t>>(std::move(sorted.faces));
  }
  layout->vertices.shrink_to_fit();
  layout->sources.shrink_to_fit();
  layout->texture_coordinates.shrink_to_fit();
  return layout;
}

MeshLayoutConstPtr layOutPreview(const MeshDataConstPtr& mesh)
{
  const MeshRegion region = mainRegion(*mesh);
  if (!region.hasExtent()) {
    return nullptr;
  }
  const auto indices = clusterVertices(*mesh, region, PREVIEW_CELLS);
  if (indices.empty() || 2 * indices.size() > mesh->indices.size()) {
    return nullptr;
  }
  const SortedMesh sorted = sortInSpace(mesh->vertices, indices, region);
  const auto splitter = makeSplit(Split::NONE, nullptr);
  auto layout = std::make_shared<MeshLayout>();
  layout->mesh = mesh;
  layout->preview = true;
  const SplitFaces faces = splitter->split(sorted, *layout);
  LayoutParts(faces, *layout).write({}, *splitter);
  layout->cell_sizes = {region.extent() / PREVIEW_CELLS};
  return layout;
}

}  // namespace rviz_mesh_plugin
