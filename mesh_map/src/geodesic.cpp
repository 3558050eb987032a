#include <mesh_map/geodesic.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "geodesic_input.h"
#include "geodesic_taut.h"

namespace mesh_map {
namespace {

/// Of the length of a path: what is shorter is nothing.
constexpr double NOTHING = 1e-12;

double lengthOf(const WalkTrace& path)
{
  double sum = 0.0;
  for (std::size_t i = 0; i < path.faces.size(); ++i) {
    const Vector3 step = pointAt(path, i + 1) - pointAt(path, i);
    sum += std::sqrt(dot(step, step));
  }
  return sum;
}

/// A path without segments that are nothing; its ends stay.
WalkTrace cleaned(const WalkTrace& path, double length)
{
  const auto isNothing = [&](const Vector3& a, const Vector3& b) {
    return dot(b - a, b - a) <= NOTHING * NOTHING * length * length;
  };
  WalkTrace result;
  const auto append = [&](std::size_t i) {
    result.points.insert(result.points.end(), path.points.data() + 3 * i,
                         path.points.data() + 3 * i + 3);
  };
  const Vector3 end = pointAt(path, path.faces.size());
  std::size_t last = path.faces.size();  // from this point on, there is nothing but the end
  while (last > 0 && isNothing(pointAt(path, last - 1), end)) {
    --last;
  }
  append(0);
  for (std::size_t i = 0; i < last; ++i) {
    const bool is_end = i + 1 == last;
    if (is_end || !isNothing(pointAt(result, result.faces.size()), pointAt(path, i + 1))) {
      result.faces.push_back(path.faces[i]);
      append(is_end ? path.faces.size() : i + 1);
    }
  }
  return result;
}

}  // namespace

Geodesic shortenPath(const WalkMesh& mesh, const WalkTrace& path, const GeodesicOptions& options)
{
  checkPath(mesh, path, options.mask);
  Geodesic result;
  result.path = path;
  result.length = lengthOf(path);
  if (path.faces.empty()) {
    return result;
  }
  const FaceChoice choice{mesh, options.mask};
  TautPath taut(choice, options);
  if (!taut.take(stretchesOf(choice, path))) {
    return result;
  }
  taut.settle(result, options.max_turns);
  while (options.over_hills && taut.tryHills(result)) {
    taut.settle(result, options.max_turns);
  }
  if (result.cancelled) {
    return {{}, 0.0, result.turns, false, true};
  }
  WalkTrace shorter = cleaned(taut.trace(), result.length);
  const double length = lengthOf(shorter);
  if (length <= result.length) {
    result.path = std::move(shorter);
    result.length = length;
  }
  return result;
}

}  // namespace mesh_map
