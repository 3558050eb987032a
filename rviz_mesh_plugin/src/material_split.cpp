#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <stdexcept>

#include "rviz_mesh_plugin/layout_split.h"

namespace rviz_mesh_plugin {
namespace {

using TexturePoint = std::array<float, 2>;

/// A simplified face over which the texture runs so much faster than over the material's faces on
/// average joins vertices from both sides of a seam in the texture.
constexpr float SEAM_FACTOR = 8.0f;

float distance(const std::array<float, 3>& a, const std::array<float, 3>& b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

float distance(const TexturePoint& a, const TexturePoint& b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1]);
}

/// Faces of different materials share no vertex. Simplified faces are made of the vertices of all
/// materials, so that no cracks open between materials; the corners that such a face has from
/// another material, or from the other side of a seam, are copied for it, with the texture
/// coordinates of its first corner.
class MaterialSplit : public LayoutSplit
{
 public:
  explicit MaterialSplit(const Materials& materials) : materials_(materials) {}

  SplitFaces split(const SortedMesh& mesh, MeshLayout& layout) override
  {
    const std::vector<std::uint32_t> of_face = facesToMaterials(mesh.faces.size());
    const std::vector<std::uint32_t> order = orderByMaterial(mesh, of_face);
    const std::size_t kinds = materials_.materials.size() + 1;
    std::vector<double> texture_lengths(kinds, 0.0);
    std::vector<double> lengths(kinds, 0.0);
    textured_ = !materials_.texture_coordinates.empty();
    last_copy_.assign(mesh.vertices.size(), NONE);
    SplitFaces faces;
    faces.indices.reserve(mesh.indices.size());
    faces.materials.reserve(mesh.faces.size());
    for (const std::uint32_t i : order) {
      const std::uint32_t material = of_face[mesh.faces[i]];
      faces.materials.push_back(material);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        faces.indices.push_back(
            use(mesh, mesh.indices[3 * std::size_t(i) + corner], material, layout));
      }
      if (textured_) {
        const std::uint32_t* last = &faces.indices[faces.indices.size() - 3];
        lengths[kind(material)] += edge(last[0], last[1], layout) + edge(last[1], last[2], layout);
        texture_lengths[kind(material)] +=
            textureEdge(last[0], last[1], layout) + textureEdge(last[1], last[2], layout);
      }
    }
    seam_densities_.resize(kinds);
    for (std::size_t i = 0; i < kinds; ++i) {
      seam_densities_[i] = lengths[i] > 0.0
                               ? static_cast<float>(SEAM_FACTOR * texture_lengths[i] / lengths[i])
                               : 0.0f;
    }
    return faces;
  }

  std::array<std::uint32_t, 3> corners(const std::uint32_t* face, MeshLayout& layout) override
  {
    const std::uint32_t material = commonMaterial(face);
    std::array<std::uint32_t, 3> copies;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      copies[corner] = findCopy(face[corner], material);
    }
    const std::size_t first = copies[0] != NONE ? 0 : copies[1] != NONE ? 1 : 2;
    std::array<std::uint32_t, 3> result{copies[first], copies[(first + 1) % 3],
                                        copies[(first + 2) % 3]};
    for (const std::size_t corner : {1, 2}) {
      if (result[corner] == NONE || acrossSeam(result[0], result[corner], material, layout)) {
        const std::uint32_t any = last_copy_[face[(first + corner) % 3]];
        result[corner] = addCopy(any, result[0], layout);
      }
    }
    return result;
  }

 private:
  std::size_t kind(std::uint32_t material) const
  {
    return std::min<std::size_t>(material, materials_.materials.size());
  }

  std::vector<std::uint32_t> facesToMaterials(std::size_t face_count) const
  {
    std::vector<std::uint32_t> of_face(face_count, NONE);
    for (std::size_t i = 0; i < materials_.faces.size(); ++i) {
      if (materials_.faces[i] >= face_count ||
          materials_.face_materials[i] >= materials_.materials.size()) {
        throw std::invalid_argument("the materials belong to another mesh");
      }
      of_face[materials_.faces[i]] = materials_.face_materials[i];
    }
    return of_face;
  }

  /// Places of the faces; those of one material keep their order.
  std::vector<std::uint32_t> orderByMaterial(const SortedMesh& mesh,
                                             const std::vector<std::uint32_t>& of_face) const
  {
    std::vector<std::uint32_t> starts(materials_.materials.size() + 2, 0);
    for (const std::uint32_t material : of_face) {
      ++starts[kind(material) + 1];
    }
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::uint32_t> order(mesh.faces.size());
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      order[starts[kind(of_face[mesh.faces[i]])]++] = static_cast<std::uint32_t>(i);
    }
    return order;
  }

  /// The copy of a vertex for a material; materials come one after the other.
  std::uint32_t use(const SortedMesh& mesh, std::uint32_t vertex, std::uint32_t material,
                    MeshLayout& layout)
  {
    std::uint32_t& last = last_copy_[vertex];
    if (last != NONE && copy_materials_[last] == material) {
      return last;
    }
    layout.vertices.push_back(mesh.vertices[vertex]);
    layout.sources.push_back(mesh.sources[vertex]);
    if (textured_) {
      layout.texture_coordinates.push_back(materials_.texture_coordinates[mesh.sources[vertex]]);
    }
    copy_materials_.push_back(material);
    earlier_copies_.push_back(last);
    last = static_cast<std::uint32_t>(layout.vertices.size() - 1);
    return last;
  }

  std::uint32_t findCopy(std::uint32_t vertex, std::uint32_t material) const
  {
    std::uint32_t copy = last_copy_[vertex];
    while (copy != NONE && copy_materials_[copy] != material) {
      copy = earlier_copies_[copy];
    }
    return copy;
  }

  /// A material of as many corners as possible.
  std::uint32_t commonMaterial(const std::uint32_t* face) const
  {
    std::uint32_t best = NONE;
    int most = 0;
    for (std::size_t corner = 0; corner < 3 && most < 3 - static_cast<int>(corner); ++corner) {
      for (std::uint32_t copy = last_copy_[face[corner]]; copy != NONE && most < 3;
           copy = earlier_copies_[copy]) {
        const std::uint32_t material = copy_materials_[copy];
        int count = 0;
        for (std::size_t other = 0; other < 3; ++other) {
          count += findCopy(face[other], material) != NONE ? 1 : 0;
        }
        if (count > most) {
          most = count;
          best = material;
        }
      }
    }
    return best;
  }

  static float edge(std::uint32_t a, std::uint32_t b, const MeshLayout& layout)
  {
    return distance(layout.vertices[a].position, layout.vertices[b].position);
  }

  static float textureEdge(std::uint32_t a, std::uint32_t b, const MeshLayout& layout)
  {
    return distance(layout.texture_coordinates[a], layout.texture_coordinates[b]);
  }

  bool acrossSeam(std::uint32_t a, std::uint32_t b, std::uint32_t material,
                  const MeshLayout& layout) const
  {
    return textured_ &&
           textureEdge(a, b, layout) > seam_densities_[kind(material)] * edge(a, b, layout);
  }

  std::uint32_t addCopy(std::uint32_t vertex, std::uint32_t first, MeshLayout& layout) const
  {
    layout.vertices.push_back(MeshVertex(layout.vertices[vertex]));
    layout.sources.push_back(std::uint32_t(layout.sources[vertex]));
    if (textured_) {
      layout.texture_coordinates.push_back(TexturePoint(layout.texture_coordinates[first]));
    }
    return static_cast<std::uint32_t>(layout.vertices.size() - 1);
  }

  const Materials& materials_;
  bool textured_ = false;
  std::vector<float> seam_densities_;          ///< by kind: texture per meter
  std::vector<std::uint32_t> last_copy_;       ///< of each vertex of the sorted mesh
  std::vector<std::uint32_t> earlier_copies_;  ///< of each copy: another one of the same vertex
  std::vector<std::uint32_t> copy_materials_;
};

}  // namespace

std::unique_ptr<LayoutSplit> makeMaterialSplit(const Materials& materials)
{
  return std::make_unique<MaterialSplit>(materials);
}

}  // namespace rviz_mesh_plugin
