#include "level_of_detail/layout_split.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "base/vectors.h"
#include "level_of_detail/mesh_border.h"

namespace rviz_mesh_plugin {
namespace {

class NoSplit : public LayoutSplit
{
 public:
  SplitFaces split(const SortedMesh& mesh, MeshLayout& layout) override
  {
    layout.vertices = mesh.vertices;
    layout.sources = mesh.sources;
    return {mesh.indices, {}};
  }

  std::array<std::uint32_t, 3> corners(const std::uint32_t* face, MeshLayout& /*layout*/) override
  {
    return {face[0], face[1], face[2]};
  }
};

/// Each face gets a corner of its own, which is its last: one that no face has got yet, or else a
/// copy. There are about twice as many faces as vertices, and so in the end about as many vertices
/// as faces.
class FaceSplit : public LayoutSplit
{
 public:
  SplitFaces split(const SortedMesh& mesh, MeshLayout& layout) override
  {
    places_.assign(mesh.vertices.size(), NONE);
    std::vector<bool> owned(mesh.vertices.size(), false);
    SplitFaces faces;
    faces.indices.reserve(mesh.indices.size());
    layout.vertices.reserve(mesh.faces.size() + mesh.vertices.size() / 8);
    layout.sources.reserve(mesh.faces.size() + mesh.vertices.size() / 8);
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      const std::uint32_t face = mesh.faces[i];
      const std::uint32_t* corners = &mesh.indices[3 * i];
      for (std::size_t corner = 0; corner < 3; ++corner) {
        std::uint32_t& place = places_[corners[corner]];
        if (place == NONE) {
          place = add(mesh.vertices[corners[corner]], face, layout);
        }
      }
      const std::size_t last = freeCorner(corners, owned);
      std::uint32_t own = places_[corners[last]];
      if (owned[corners[last]]) {
        own = add(mesh.vertices[corners[last]], face, layout);
      }
      owned[corners[last]] = true;
      layout.sources[own] = face;
      faces.indices.insert(faces.indices.end(), {places_[corners[(last + 1) % 3]],
                                                 places_[corners[(last + 2) % 3]], own});
    }
    return faces;
  }

  std::array<std::uint32_t, 3> corners(const std::uint32_t* face, MeshLayout& /*layout*/) override
  {
    return {places_[face[0]], places_[face[1]], places_[face[2]]};
  }

 private:
  static std::uint32_t add(const MeshVertex& vertex, std::uint32_t face, MeshLayout& layout)
  {
    layout.vertices.push_back(vertex);
    layout.sources.push_back(face);
    return static_cast<std::uint32_t>(layout.vertices.size() - 1);
  }

  /// The last corner where all are owned.
  static std::size_t freeCorner(const std::uint32_t* corners, const std::vector<bool>& owned)
  {
    for (const std::size_t corner : {2, 0, 1}) {
      if (!owned[corners[corner]]) {
        return corner;
      }
    }
    return 2;
  }

  std::vector<std::uint32_t> places_;  ///< the first of each vertex in the layout
};

using TexturePoint = std::array<float, 2>;

/// A simplified face over which the texture runs so much faster than over the faces at its corners
/// joins vertices from both sides of a seam in the texture.
constexpr float SEAM_FACTOR = 2.0f;

/// More vertices in one place make several rings: all of a ring are looked at for each face.
constexpr std::size_t MOST_IN_RING = 64;

/// Faces of different materials share no vertex. Simplified faces are made of the vertices of all
/// materials, so that no cracks open between materials. Where such a face has a corner from another
/// material, or from the other side of a seam, it takes a vertex in the same place that fits; where
/// there is none, the corner is copied for it, with the texture coordinates of its first corner.
class MaterialSplit : public LayoutSplit
{
 public:
  explicit MaterialSplit(const Materials& materials) : materials_(materials) {}

  SplitFaces split(const SortedMesh& mesh, MeshLayout& layout) override
  {
    const std::vector<std::uint32_t> of_face = facesToMaterials(layout.mesh->faceCount());
    const std::vector<std::uint32_t> order = orderByMaterial(mesh, of_face);
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
        noteDensities(&faces.indices[faces.indices.size() - 3], layout);
      }
    }
    linkPlaces(mesh);
    return faces;
  }

  std::array<std::uint32_t, 3> corners(const std::uint32_t* face, MeshLayout& layout) override
  {
    const std::uint32_t material = commonMaterial(face);
    std::array<std::uint32_t, 3> result{NONE, NONE, NONE};
    std::size_t first = 0;
    std::pair<int, float> best(3, 0.0f);  // corners that do not fit, way over the texture
    for (std::size_t corner = 0; corner < 3 && best.first > 0; ++corner) {
      forEachCopy(face[corner], [&](std::uint32_t copy) {
        if (copy_materials_[copy] == material) {
          const std::uint32_t second = findFitting(face[(corner + 1) % 3], copy, layout);
          const std::uint32_t third = findFitting(face[(corner + 2) % 3], copy, layout);
          std::pair<int, float> fit(0, 0.0f);
          for (const std::uint32_t other : {second, third}) {
            fit.first += other == NONE ? 1 : 0;
            fit.second += other == NONE ? 0.0f : textureEdge(copy, other, layout);
          }
          if (fit < best) {
            best = fit;
            first = corner;
            result = {copy, second, third};
          }
        }
      });
    }
    for (const std::size_t corner : {1, 2}) {
      if (result[corner] == NONE) {
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
    for (const std::uint32_t face : mesh.faces) {
      ++starts[kind(of_face[face]) + 1];
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

  /// Of texture per meter at each vertex of the layout: the greatest one.
  void noteDensities(const std::uint32_t* face, const MeshLayout& layout)
  {
    densities_.resize(layout.vertices.size(), 0.0f);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t a = face[corner];
      const std::uint32_t b = face[(corner + 1) % 3];
      const float length = edge(a, b, layout);
      const float density = length > 0.0f ? textureEdge(a, b, layout) / length : 0.0f;
      densities_[a] = std::max(densities_[a], density);
      densities_[b] = std::max(densities_[b], density);
    }
  }

  /// Vertices in one place, which is how meshes have seams in their textures, make a ring.
  void linkPlaces(const SortedMesh& mesh)
  {
    next_in_place_.resize(mesh.vertices.size());
    std::iota(next_in_place_.begin(), next_in_place_.end(), 0);
    if (!textured_) {
      return;
    }
    // By hash: faster than by coordinates.
    std::vector<std::pair<std::uint64_t, std::uint32_t>> seams;
    for (const std::uint32_t vertex : borderVertices(mesh.indices, mesh.vertices.size())) {
      seams.emplace_back(hashOf(mesh.vertices[vertex].position), vertex);
    }
    std::sort(seams.begin(), seams.end());
    std::size_t linked = 1;
    for (std::size_t i = 1; i < seams.size(); ++i) {
      const std::uint32_t a = seams[i - 1].second;
      const std::uint32_t b = seams[i].second;
      const bool same = mesh.vertices[a].position == mesh.vertices[b].position;
      linked = same && linked < MOST_IN_RING ? linked + 1 : 1;
      if (linked > 1) {
        std::swap(next_in_place_[a], next_in_place_[b]);
      }
    }
  }

  /// Calls @a visit with each copy of the vertex and of those in the same place.
  template <class Visit>
  void forEachCopy(std::uint32_t vertex, const Visit& visit) const
  {
    std::uint32_t other = vertex;
    do {
      for (std::uint32_t copy = last_copy_[other]; copy != NONE; copy = earlier_copies_[copy]) {
        visit(copy);
      }
      other = next_in_place_[other];
    } while (other != vertex);
  }

  bool hasCopy(std::uint32_t vertex, std::uint32_t material) const
  {
    bool found = false;
    forEachCopy(vertex,
                [&](std::uint32_t copy) { found = found || copy_materials_[copy] == material; });
    return found;
  }

  /// The copy of a vertex for the material of another one that is nearest to that on the texture;
  /// NONE where it lies on the other side of a seam.
  std::uint32_t findFitting(std::uint32_t vertex, std::uint32_t to, const MeshLayout& layout) const
  {
    std::uint32_t nearest = NONE;
    forEachCopy(vertex, [&](std::uint32_t copy) {
      if (copy_materials_[copy] == copy_materials_[to] &&
          (nearest == NONE || textureEdge(to, copy, layout) < textureEdge(to, nearest, layout))) {
        nearest = copy;
      }
    });
    return nearest == NONE || acrossSeam(to, nearest, layout) ? NONE : nearest;
  }

  /// A material of as many corners as possible.
  std::uint32_t commonMaterial(const std::uint32_t* face) const
  {
    std::uint32_t best = NONE;
    int most = 0;
    for (std::size_t corner = 0; corner < 3 && most < 3 - static_cast<int>(corner); ++corner) {
      forEachCopy(face[corner], [&](std::uint32_t copy) {
        const std::uint32_t material = copy_materials_[copy];
        int count = 0;
        for (std::size_t other = 0; other < 3; ++other) {
          count += hasCopy(face[other], material) ? 1 : 0;
        }
        if (count > most) {
          most = count;
          best = material;
        }
      });
    }
    return best;
  }

  static float edge(std::uint32_t a, std::uint32_t b, const MeshLayout& layout)
  {
    return static_cast<float>(distance(layout.vertices[a].position, layout.vertices[b].position));
  }

  float textureEdge(std::uint32_t a, std::uint32_t b, const MeshLayout& layout) const
  {
    if (!textured_) {
      return 0.0f;
    }
    const TexturePoint &p = layout.texture_coordinates[a], &q = layout.texture_coordinates[b];
    return std::hypot(p[0] - q[0], p[1] - q[1]);
  }

  bool acrossSeam(std::uint32_t a, std::uint32_t b, const MeshLayout& layout) const
  {
    return textured_ && textureEdge(a, b, layout) > SEAM_FACTOR *
                                                        std::max(densities_[a], densities_[b]) *
                                                        edge(a, b, layout);
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
  std::vector<float> densities_;               ///< of each vertex of the layout: texture per meter
  std::vector<std::uint32_t> last_copy_;       ///< of each vertex of the sorted mesh
  std::vector<std::uint32_t> earlier_copies_;  ///< of each copy: another one of the same vertex
  std::vector<std::uint32_t> copy_materials_;
  std::vector<std::uint32_t> next_in_place_;  ///< of each vertex of the sorted mesh
};

}  // namespace

std::unique_ptr<LayoutSplit> makeSplit(Split split, const Materials* materials)
{
  if (split == Split::BY_FACE) {
    return std::make_unique<FaceSplit>();
  }
  if (split == Split::BY_MATERIAL) {
    if (materials == nullptr) {
      throw std::invalid_argument("a layout by material needs materials");
    }
    return std::make_unique<MaterialSplit>(*materials);
  }
  return std::make_unique<NoSplit>();
}

}  // namespace rviz_mesh_plugin
