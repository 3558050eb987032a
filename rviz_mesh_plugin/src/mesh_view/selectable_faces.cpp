#include "mesh_view/selectable_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/erase_if.h"
#include "base/vectors.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// So many words of faces are looked at between two looks at whether that is still wanted.
constexpr std::size_t WORDS_TESTED_AT_ONCE = 1024;

using Planes = std::vector<mesh_map::Plane>;

void addPlanes(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
               Planes& planes)
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    mesh_map::Plane plane{};
    if (std::isfinite(lower[axis])) {
      plane[axis] = 1.0;
      plane[3] = -lower[axis];
      planes.push_back(plane);
    }
    if (std::isfinite(upper[axis])) {
      plane[axis] = -1.0;
      plane[3] = upper[axis];
      planes.push_back(plane);
    }
  }
}

std::array<double, 3> widened(const std::array<float, 3>& corner)
{
  return {corner[0], corner[1], corner[2]};
}

bool isEmpty(const Section& section)
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(section.lower[axis] <= section.upper[axis])) {
      return true;
    }
  }
  return false;
}

/// Of a convex region, those around a lasso, or of a box around a ball.
Planes planesAround(const mesh_map::Region& region)
{
  if (const auto* convex = dynamic_cast<const mesh_map::ConvexRegion*>(&region)) {
    return convex->planes();
  }
  if (const auto* lasso = dynamic_cast<const mesh_map::LassoRegion*>(&region)) {
    return lasso->frustum().planes();
  }
  Planes planes;
  if (const auto* ball = dynamic_cast<const mesh_map::SphereRegion*>(&region)) {
    const Eigen::Vector3d center = vectorOf(ball->center());
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(ball->radius());
    addPlanes(arrayOf(center - reach), arrayOf(center + reach), planes);
  }
  return planes;
}

}  // namespace

SelectableFaces::SelectableFaces(const ShownMesh& shown)
    : mesh_(shown.mesh), none_(isEmpty(shown.section)), hidden_(shown.hidden)
{
  if (shown.section.cuts() && !none_ && !shown.section.contains(*mesh_)) {
    Planes planes;
    addPlanes(widened(shown.section.lower), widened(shown.section.upper), planes);
    section_.emplace(planes);
  }
}

bool SelectableFaces::contains(std::uint32_t face) const
{
  if (none_ || face >= mesh_->faceCount() || (hidden_ && hidden_->contains(face))) {
    return false;
  }
  if (!section_) {
    return true;
  }
  std::array<float, 9> corners;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const auto& position = cornerOf(*mesh_, face, corner);
    std::copy(position.begin(), position.end(), corners.begin() + 3 * corner);
  }
  return section_->triangle(corners.data()) != mesh_map::Side::OUTSIDE;
}

FaceBits SelectableFaces::bits(const std::atomic<bool>* cancel) const
{
  FaceBits faces(mesh_->faceCount());
  faces.addAll();
  keep(faces, cancel);
  return faces;
}

void SelectableFaces::keep(std::vector<std::uint32_t>& faces, const std::atomic<bool>* cancel) const
{
  if (all()) {
    return;
  }
  std::size_t looked = 0;
  eraseIf(faces, [&](std::uint32_t face) {
    if (looked++ % (FaceBits::BITS * WORDS_TESTED_AT_ONCE) == 0) {
      throwIfCanceled(cancel);
    }
    return !contains(face);
  });
}

void SelectableFaces::keep(FaceBits& faces, const std::atomic<bool>* cancel) const
{
  if (hidden_) {
    faces.remove(hidden_->bits());
  }
  for (std::size_t place = 0; (section_ || none_) && place < faces.wordCount(); ++place) {
    if (place % WORDS_TESTED_AT_ONCE == 0) {
      throwIfCanceled(cancel);
    }
    const auto first = static_cast<std::uint32_t>(FaceBits::BITS * place);
    FaceBits::Word others = 0;
    FaceBits::visitBits(faces.word(place), first, [&](std::uint32_t face) {
      others |= FaceBits::Word{contains(face) ? 0u : 1u} << (face - first);
    });
    faces.toggle(place, others);
  }
}

std::optional<mesh_map::ConvexRegion> SelectableFaces::seenPart(
    const mesh_map::Region& region) const
{
  Planes planes = planesAround(region);
  if (section_) {
    planes.insert(planes.end(), section_->planes().begin(), section_->planes().end());
  }
  if (none_ || planes.empty() || !region.valid()) {
    return std::nullopt;
  }
  return mesh_map::ConvexRegion(planes);
}

std::optional<SectionRay> rayInSection(const std::array<double, 3>& origin,
                                       const std::array<double, 3>& direction, double max_distance,
                                       const Section& section)
{
  const Bounds seen = section.widened();
  double first = 0.0, last = max_distance;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lower = seen.lower[axis], upper = seen.upper[axis];
    if (direction[axis] == 0.0) {
      if (!(lower <= origin[axis] && origin[axis] <= upper)) {
        return std::nullopt;
      }
      continue;
    }
    double enter = (lower - origin[axis]) / direction[axis];
    double leave = (upper - origin[axis]) / direction[axis];
    if (direction[axis] < 0.0) {
      std::swap(enter, leave);
    }
    first = std::max(first, enter);
    last = std::min(last, leave);
  }
  if (!(first <= last)) {
    return std::nullopt;
  }
  const Eigen::Vector3d begin = vectorOf(origin) + first * vectorOf(direction);
  return SectionRay{arrayOf(begin), last - first, first};
}

}  // namespace rviz_mesh_plugin
