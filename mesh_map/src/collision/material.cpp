#include "collision/material.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>

#include "bvh/rays/ray_test.h"
#include "bvh/tree/bvh_box_search.h"
#include "collision/plan_triangle.h"

namespace mesh_map {

namespace {

constexpr double FAR_AWAY = std::numeric_limits<double>::infinity();
constexpr std::size_t CHUNK = 1024;

/// Whether an edge of one triangle (9 floats) meets the other.
bool edgesMeet(const float* edges, const float* triangle)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 from = pointOf(edges + 3 * k), to = pointOf(edges + 3 * ((k + 1) % 3));
    const RayTest ray({from, to - from, distance(from, to)});
    double at;
    std::array<double, 3> weights;
    if (ray.valid() && meets(ray, triangle, true, &at, &weights)) {
      return true;
    }
  }
  return false;
}

}  // namespace

Material::Material(const Bvh& bvh, const MeshView& mesh, ArrayView<std::uint32_t> solids,
                   const Run& run, unsigned threads)
    : bvh_(bvh),
      mesh_(mesh),
      solids_(solids),
      all_{{FAR_AWAY, FAR_AWAY, FAR_AWAY}, {-FAR_AWAY, -FAR_AWAY, -FAR_AWAY}}
{
  const Extent nothing = all_;
  const Vector3 center = pointOf(bvh.center().data());
  const auto add = [](Extent& box, const Vector3& point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lower[axis] = std::min(box.lower[axis], point[axis]);
      box.upper[axis] = std::max(box.upper[axis], point[axis]);
    }
  };
  for (std::size_t face = 0; face < solids.size(); ++face) {
    if (solids[face] != NO_INDEX) {
      extents_.resize(std::max<std::size_t>(extents_.size(), solids[face] + 1), nothing);
      Extent& extent = extents_[solids[face]];
      for (std::size_t k = 0; k < 3; ++k) {
        add(extent, pointOf(mesh.corner(face, k)));
        add(all_, pointOf(mesh.corner(face, k)));
      }
      // From the middle of the mesh on: far from the origin, it would be a difference of large
      // ones.
      const float* const a = mesh.corner(face, 0);
      extent.volume +=
          dot(pointOf(a) - center, triangleNormal(a, mesh.corner(face, 1), mesh.corner(face, 2)));
    }
  }
  setSigns(run, threads);
}

void Material::solidsAround(const Vector3& point, std::vector<std::uint32_t>& inside) const
{
  inside.clear();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(point[axis] >= all_.lower[axis] && point[axis] <= all_.upper[axis])) {
      return;
    }
  }
  const Vector3 end = {point[0], point[1], all_.upper[2]};
  searchBox(bvh_, point, end, [&](std::size_t i) {
    const std::uint32_t solid = solids_[bvh_.faces()[i]];
    double height;
    if (solid != NO_INDEX && crossesLine(bvh_.corners().data() + 9 * i, point, &height) &&
        height > point[2]) {
      const auto found = std::find(inside.begin(), inside.end(), solid);
      if (found == inside.end()) {
        inside.push_back(solid);
      } else {
        inside.erase(found);
      }
    }
    return false;
  });
}

bool Material::at(const Vector3& point, std::vector<std::uint32_t>& inside) const
{
  solidsAround(point, inside);
  int sum = 0;
  for (const std::uint32_t solid : inside) {
    sum += signs_[solid];
  }
  return sum > 0;
}

/// A solid that may lie in others: those of which one of its corners is inside, and whether a face
/// of it was found to meet one of theirs, or of any solid.
struct Material::Nesting
{
  std::vector<std::uint32_t> around;
  std::unique_ptr<std::atomic<bool>[]> meets;
  std::atomic<bool> meets_any{false};
};

void Material::setSigns(const Run& run, unsigned threads)
{
  std::vector<Nesting> nestings(extents_.size());
  std::vector<bool> seen(extents_.size(), false);
  const auto boxContains = [this](std::uint32_t outer, std::uint32_t inner) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(extents_[outer].lower[axis] < extents_[inner].lower[axis] &&
            extents_[inner].upper[axis] < extents_[outer].upper[axis])) {
        return false;
      }
    }
    return true;
  };
  std::vector<std::size_t> nested_faces;
  for (std::size_t face = 0; face < solids_.size(); ++face) {
    const std::uint32_t solid = solids_[face];
    if (solid == NO_INDEX) {
      continue;
    }
    Nesting& nesting = nestings[solid];
    if (!seen[solid]) {
      seen[solid] = true;
      run.check();
      std::vector<std::uint32_t> found;
      solidsAround(pointOf(mesh_.corner(face, 0)), found);
      std::copy_if(found.begin(), found.end(), std::back_inserter(nesting.around),
                   [&](auto outer) { return outer != solid && boxContains(outer, solid); });
      nesting.meets = std::make_unique<std::atomic<bool>[]>(nesting.around.size());
    }
    if (!nesting.around.empty()) {
      nested_faces.push_back(face);
    }
  }
  parallelEach(nested_faces.size(), CHUNK, threads, [&](std::size_t index) {
    findMeetings(nested_faces[index], nestings[solids_[nested_faces[index]]]);
  });
  run.check();
  for (std::uint32_t solid = 0; solid < nestings.size(); ++solid) {
    const Nesting& nesting = nestings[solid];
    std::size_t depth = 0;
    std::uint32_t outermost = solid;
    for (std::size_t i = 0; i < nesting.around.size(); ++i) {
      if (!nesting.meets[i]) {
        ++depth;
        outermost = boxContains(nesting.around[i], outermost) ? nesting.around[i] : outermost;
      }
    }
    const bool turned = extents_[solid].volume * extents_[outermost].volume < 0.0;
    const bool hollow = nesting.meets_any ? turned : depth % 2 == 1;
    signs_.push_back(hollow ? -1 : 1);
  }
}

void Material::findMeetings(std::size_t face, Nesting& nesting) const
{
  float corners[9];
  Vector3 lower = pointOf(mesh_.corner(face, 0)), upper = lower;
  for (std::size_t k = 0; k < 9; ++k) {
    corners[k] = mesh_.corner(face, k / 3)[k % 3];
    lower[k % 3] = std::min(lower[k % 3], double{corners[k]});
    upper[k % 3] = std::max(upper[k % 3], double{corners[k]});
  }
  searchBox(bvh_, lower, upper, [&](std::size_t i) {
    const std::uint32_t solid = solids_[bvh_.faces()[i]];
    const auto outer = std::find(nesting.around.begin(), nesting.around.end(), solid);
    const bool is_around = outer != nesting.around.end();
    std::atomic<bool>& meets =
        is_around ? nesting.meets[outer - nesting.around.begin()] : nesting.meets_any;
    if (solid != NO_INDEX && solid != solids_[face] && !meets) {
      const float* const other = bvh_.corners().data() + 9 * i;
      if (edgesMeet(corners, other) || edgesMeet(other, corners)) {
        meets = true;
        nesting.meets_any = true;
      }
    }
    return false;
  });
}

}  // namespace mesh_map
