#include "rviz_mesh_plugin/layout_split.h"

#include <cstddef>
#include <stdexcept>

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
    return makeMaterialSplit(*materials);
  }
  return std::make_unique<NoSplit>();
}

}  // namespace rviz_mesh_plugin
