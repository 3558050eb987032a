#include "selection/face_criterion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "base/vectors.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// So many words are made between two looks at whether that is still wanted.
constexpr std::size_t WORDS_AT_ONCE = 4096;

template <class Meets>
FaceBits facesWhere(const Meets& meets, std::size_t face_count, const std::atomic<bool>* cancel)
{
  FaceBits faces(face_count);
  for (std::size_t place = 0; place < faces.wordCount(); ++place) {
    if (place % WORDS_AT_ONCE == 0) {
      throwIfCanceled(cancel);
    }
    const std::size_t begin = FaceBits::BITS * place;
    const std::size_t end = std::min<std::size_t>(begin + FaceBits::BITS, face_count);
    FaceBits::Word word = 0;
    for (std::size_t face = begin; face < end; ++face) {
      word |= FaceBits::Word{meets(static_cast<std::uint32_t>(face)) ? 1u : 0u} << (face - begin);
    }
    faces.toggle(place, word);
  }
  return faces;
}

bool isMeant(float value, const LayerCriterion& criterion)
{
  switch (criterion.values) {
    case LayerCriterion::LETHAL:
      return criterion.info.isLethal(value);
    case LayerCriterion::UNKNOWN:
      return std::isnan(value);
    default:
      return std::isfinite(value) && criterion.range.contains(value);
  }
}

struct Finder
{
  const MeshData& mesh;
  const std::atomic<bool>* cancel;

  FaceBits operator()(const LayerCriterion& criterion) const
  {
    const CostLayer& layer = *criterion.layer;
    const std::size_t size = layer.on_faces ? mesh.faceCount() : mesh.vertexCount();
    if (layer.costs.size() != size) {
      throw std::invalid_argument("the layer '" + layer.type + "' has " +
                                  std::to_string(layer.costs.size()) + " values instead of " +
                                  std::to_string(size));
    }
    const auto at = [&](std::size_t place) { return isMeant(layer.costs[place], criterion); };
    const auto meets = [&](std::uint32_t face) {
      if (layer.on_faces) {
        return at(face);
      }
      const std::uint32_t* const corners = &mesh.indices[3 * std::size_t{face}];
      return criterion.all_corners ? std::all_of(corners, corners + 3, at)
                                   : std::any_of(corners, corners + 3, at);
    };
    return facesWhere(meets, mesh.faceCount(), cancel);
  }

  FaceBits operator()(const HeightCriterion& criterion) const
  {
    const Eigen::Vector3d up = vectorOf(criterion.up);
    const auto meets = [&](std::uint32_t face) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t corner = 0; corner < 3; ++corner) {
        sum += vectorOf(cornerOf(mesh, face, corner));
      }
      return criterion.range.contains(up.dot(sum) / 3.0 + criterion.offset);
    };
    return facesWhere(meets, mesh.faceCount(), cancel);
  }

  FaceBits operator()(const SlopeCriterion& criterion) const
  {
    const Eigen::Vector3d up = vectorOf(criterion.up);
    const auto meets = [&](std::uint32_t face) {
      const Eigen::Vector3d normal = normalOf(mesh, face);
      const double across = normal.cross(up).norm(), along = normal.dot(up);
      return (across > 0.0 || along != 0.0) && criterion.range.contains(std::atan2(across, along));
    };
    return facesWhere(meets, mesh.faceCount(), cancel);
  }

  FaceBits operator()(const ListCriterion& criterion) const
  {
    return FaceBits(mesh.faceCount(), *criterion.faces);
  }
};

}  // namespace

FaceBits facesThatMeet(const FaceCriterion& criterion, const MeshData& mesh,
                       const std::atomic<bool>* cancel)
{
  return std::visit(Finder{mesh, cancel}, criterion);
}

}  // namespace rviz_mesh_plugin
