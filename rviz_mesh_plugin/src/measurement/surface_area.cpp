#include "measurement/surface_area.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include <mesh_map/mesh/topology.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "base/vectors.h"
#include "measurement/outline.h"
#include "selection/face_neighbors.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// So many faces are looked at between two looks at the cancel flag.
constexpr std::size_t STRETCH = 1 << 16;

/// Cosines of angles between normals and the direction of view.
const double STEEP_OUTLINE = std::cos(M_PI / 3.0);
const double WALL = std::sin(5.0 * M_PI / 180.0);
const double TURNED_OVER = -std::sin(M_PI / 180.0);

/// Faces lie in the same direction from an edge up to this angle between them, in radians.
constexpr double SAME_ANGLE = 1e-3;

using Polygon = std::vector<Vector3d>;

/// The faces near an outline, with coordinates of which the third is the direction of view.
class View
{
 public:
  View(const MeshData& mesh, const std::vector<SurfacePoint>& corners,
       const std::atomic<bool>* cancel)
      : mesh_(mesh), corners_(corners), cancel_(cancel)
  {
    if (corners.size() < 3) {
      throw std::invalid_argument("an outline has at least three corners");
    }
    origin_ = vectorOf(corners[0].position);
    Vector3d newell = Vector3d::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector3d a = vectorOf(corners[i].position) - origin_;
      const Vector3d b = vectorOf(corners[(i + 1) % corners.size()].position) - origin_;
      newell += a.cross(b);
      area_.outline += (b - a).norm();
    }
    area_.plan = 0.5 * std::abs(newell[2]);
    area_.steep = std::abs(newell[2]) < STEEP_OUTLINE * newell.norm();
    axes_.setIdentity();
    if (area_.steep) {
      const Vector3d normal = newell.normalized();
      const Vector3d level = Vector3d(-normal[1], normal[0], 0.0).normalized();
      axes_.row(0) = level;
      axes_.row(1) = normal.cross(level);
      axes_.row(2) = normal;
    }
  }

  SurfaceArea area()
  {
    std::vector<Vector2d> outline;
    for (const SurfacePoint& corner : corners_) {
      outline.push_back((axes_ * (vectorOf(corner.position) - origin_)).head<2>());
    }
    const Outline shape(outline);
    collect(shape);
    flood(shape);
    area_.uncovered = std::max(0.0, shape.area() - covered_);
    if (area_.uncovered <= 1e-9 * shape.area()) {
      area_.uncovered = 0.0;
    }
    area_.doubled = std::max(0.0, covered_ - shape.area());
    if (area_.doubled <= 1e-6 * shape.area()) {
      area_.doubled = 0.0;
    }
    return area_;
  }

 private:
  Vector3d seen(const std::array<float, 3>& position) const
  {
    return axes_ * (vectorOf(position) - origin_);
  }

  void collect(const Outline& outline)
  {
    std::vector<std::uint32_t> places(mesh_.vertexCount(), NONE);
    for (std::uint32_t face = 0; face < mesh_.faceCount(); ++face) {
      if (face % STRETCH == 0) {
        throwIfCanceled(cancel_);
      }
      const Vector3d a = seen(cornerOf(mesh_, face, 0)), b = seen(cornerOf(mesh_, face, 1)),
                     c = seen(cornerOf(mesh_, face, 2));
      if (!outline.isNear(a.cwiseMin(b).cwiseMin(c).head<2>(),
                          a.cwiseMax(b).cwiseMax(c).head<2>())) {
        continue;
      }
      faces_.push_back(face);
      for (unsigned corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = mesh_.indices[3 * std::size_t{face} + corner];
        if (places[vertex] == NONE) {
          places[vertex] = static_cast<std::uint32_t>(near_.vertices.size());
          near_.vertices.push_back(mesh_.vertices[vertex]);
        }
        near_.indices.push_back(places[vertex]);
      }
    }
  }

  Polygon polygonOf(std::uint32_t face) const
  {
    return {seen(cornerOf(near_, face, 0)), seen(cornerOf(near_, face, 1)),
            seen(cornerOf(near_, face, 2))};
  }

  /// Cosine between its normal and the direction of view; 0 where rounding may have turned it.
  double facing(std::uint32_t face) const
  {
    const Vector3d normal = normalOf(near_, face);
    return isThin(face) ? 0.0 : axes_.row(2).dot(normal) / normal.norm();
  }

  /// Whether a corner is in the opposite edge as far as its coordinates can tell: modelers close
  /// gaps so, where one edge meets several, and rounding may turn such a face over.
  bool isThin(std::uint32_t face) const
  {
    double longest = 0.0, greatest = 0.0;
    for (unsigned side = 0; side < 3; ++side) {
      const Vector3d a = vectorOf(cornerOf(near_, face, side));
      const Vector3d b = vectorOf(cornerOf(near_, face, (side + 1) % 3));
      longest = std::max(longest, (b - a).norm());
      greatest = std::max(greatest, a.cwiseAbs().maxCoeff());
    }
    return normalOf(near_, face).norm() <= 2.0 * FLT_EPSILON * greatest * longest;
  }

  void flood(const Outline& outline)
  {
    corners_of_ = joinedCorners(near_);
    topology_ = mesh_map::buildTopology(corners_of_, near_.vertexCount());
    throwIfCanceled(cancel_);
    rows_ = mesh_map::edgeFaces(topology_.face_edges, topology_.edgeCount());
    throwIfCanceled(cancel_);
    sides_.assign(faces_.size(), 0);
    const auto [level, upright] = findSeeds();
    // Walls only where there is nothing else, since they look to neither side.
    const std::vector<std::uint32_t>& seeds = level.empty() ? upright : level;
    int fronts = 0;
    for (const std::uint32_t seed : seeds) {
      fronts += facing(seed) >= 0.0 ? 1 : -1;
    }
    // Most fronts of these faces: a ceiling is measured from below, also where it is of a solid.
    view_side_ = fronts >= 0 ? 1 : -1;
    for (const std::uint32_t seed : seeds) {
      if (sides_[seed] == 0) {
        sides_[seed] = static_cast<std::int8_t>(facing(seed) >= 0.0 ? view_side_ : -view_side_);
        area_.connected = area_.connected && seed == seeds.front();
        visit(seed, outline);
      }
    }
    area_.connected =
        area_.connected && std::all_of(upright.begin(), upright.end(),
                                       [&](std::uint32_t face) { return leadsToMeasured(face); });
  }

  /// Over other walls, also where these are beside the outline by the last digits.
  bool leadsToMeasured(std::uint32_t wall) const
  {
    std::vector<bool> found(faces_.size(), false);
    std::vector<std::uint32_t> queue{wall};
    found[wall] = true;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::uint32_t face = queue[next];
      if (sides_[face] != 0) {
        return true;
      }
      if (!isWall(face)) {
        continue;
      }
      for (std::size_t side = 0; side < 3; ++side) {
        const std::uint32_t edge = topology_.face_edges[3 * std::size_t{face} + side];
        if (edge == mesh_map::NO_INDEX) {
          continue;
        }
        for (std::uint32_t i = rows_.offsets[edge]; i < rows_.offsets[edge + 1]; ++i) {
          if (!found[rows_.faces[i]]) {
            found[rows_.faces[i]] = true;
            queue.push_back(rows_.faces[i]);
          }
        }
      }
    }
    return false;
  }

  /// Of faces in the same three places all but the first.
  bool isCopy(std::uint32_t face) const
  {
    return (topology_.face_flags[face] & mesh_map::FACE_DUPLICATE) != 0;
  }

  std::uint32_t firstCopy(std::uint32_t face) const
  {
    const auto places = [&](std::uint32_t of) {
      const std::uint32_t* const corners = &corners_of_[3 * std::size_t{of}];
      std::array<std::uint32_t, 3> sorted{corners[0], corners[1], corners[2]};
      std::sort(sorted.begin(), sorted.end());
      return sorted;
    };
    std::uint32_t first = face;
    if (isCopy(face)) {
      for (first = 0; places(first) != places(face);) {
        ++first;
      }
    }
    return first;
  }

  /// Faces of the corners: walls, and others.
  struct Seeds
  {
    std::vector<std::uint32_t> level;
    std::vector<std::uint32_t> upright;
  };
  Seeds findSeeds() const
  {
    Seeds seeds;
    for (const SurfacePoint& corner : corners_) {
      const auto found = std::lower_bound(faces_.begin(), faces_.end(), corner.face);
      if (found != faces_.end() && *found == corner.face) {
        const std::uint32_t face = firstCopy(static_cast<std::uint32_t>(found - faces_.begin()));
        (isWall(face) ? seeds.upright : seeds.level).push_back(face);
      }
    }
    return seeds;
  }

  bool isWall(std::uint32_t face) const { return std::abs(facing(face)) < WALL; }

  void visit(std::uint32_t seed, const Outline& outline)
  {
    std::vector<std::uint32_t> queue{seed};
    for (std::size_t next = 0; next < queue.size(); ++next) {
      if (next % STRETCH == 0) {
        throwIfCanceled(cancel_);
      }
      const std::uint32_t face = queue[next];
      const Polygon polygon = polygonOf(face);
      const bool cut = count(face, polygon, outline);
      for (std::size_t side = 0; side < 3; ++side) {
        if (cut && !outline.meets(polygon[side].head<2>(), polygon[(side + 1) % 3].head<2>())) {
          continue;
        }
        for (const Neighbor& neighbor : reachedOver(face, side)) {
          const int orientation = neighbor.turned ? -sides_[face] : sides_[face];
          if (sides_[neighbor.face] == 0 &&
              orientation * view_side_ * facing(neighbor.face) >= TURNED_OVER) {
            sides_[neighbor.face] = static_cast<std::int8_t>(orientation);
            queue.push_back(neighbor.face);
          }
        }
      }
    }
  }

  struct Neighbor
  {
    std::uint32_t face;
    bool turned;   ///< runs along the edge as the face beside it does: one of them is turned round
    double angle;  ///< around the edge, from the face over its measured side; up to a whole turn
  };

  /// Where the measured side of a face leads over one of its edges: where several parts meet there,
  /// only to the face that is next around the edge, not to what is inside or behind.
  std::vector<Neighbor> reachedOver(std::uint32_t face, std::size_t side) const
  {
    const std::uint32_t edge = topology_.face_edges[3 * std::size_t{face} + side];
    std::vector<Neighbor> others;
    if (edge == mesh_map::NO_INDEX) {
      return others;
    }
    for (std::uint32_t i = rows_.offsets[edge]; i < rows_.offsets[edge + 1]; ++i) {
      const std::uint32_t other = rows_.faces[i];
      if (other != face && !isCopy(other)) {
        const std::size_t place = placeOf(edge, other);
        const bool turned = corners_of_[3 * std::size_t{other} + place] ==
                            corners_of_[3 * std::size_t{face} + side];
        others.push_back({other, turned, 0.0});
      }
    }
    return others.size() < 2 ? others : nextAround(face, side, edge, others);
  }

  std::vector<Neighbor> nextAround(std::uint32_t face, std::size_t side, std::uint32_t edge,
                                   const std::vector<Neighbor>& others) const
  {
    const Vector3d begin = seen(cornerOf(near_, face, side));
    const Vector3d along = (seen(cornerOf(near_, face, (side + 1) % 3)) - begin).normalized();
    const auto inwards = [&](std::uint32_t of, std::size_t place) {
      const Vector3d third = seen(cornerOf(near_, of, (place + 2) % 3)) - begin;
      return Vector3d(third - along.dot(third) * along);
    };
    const Vector3d level = inwards(face, side).normalized();
    const Vector3d out = sides_[face] * along.cross(level);
    std::vector<Neighbor> around;
    bool covered = false;  // by the face of another part that lies on it
    for (Neighbor other : others) {
      const Vector3d to = inwards(other.face, placeOf(edge, other.face));
      const double angle = std::atan2(to.dot(out), to.dot(level));
      if (to.squaredNorm() == 0.0) {
        continue;
      }
      if (std::abs(angle) < SAME_ANGLE) {
        covered = covered || !other.turned;
      } else {
        other.angle = angle > 0.0 ? angle : angle + 2.0 * M_PI;
        around.push_back(other);
      }
    }
    std::sort(around.begin(), around.end(),
              [](const Neighbor& a, const Neighbor& b) { return a.angle < b.angle; });
    std::size_t end = endOfAngle(around, 0);
    // Those not turned have what they enclose behind them, as the face itself has.
    const auto front = [&](std::size_t from, std::size_t to) {
      return static_cast<std::size_t>(
          std::find_if(around.begin() + static_cast<std::ptrdiff_t>(from),
                       around.begin() + static_cast<std::ptrdiff_t>(to),
                       [](const Neighbor& neighbor) { return !neighbor.turned; }) -
          around.begin());
    };
    std::size_t first = front(0, end);
    if (first == end) {
      if (around.empty() || covered) {
        return {};
      }
      first = 0;
    }
    std::vector<Neighbor> reached{around[first]};
    // A wall of sheets stands on a floor that goes on behind it.
    if (isWall(around[first].face) && end < around.size()) {
      const std::size_t behind = endOfAngle(around, end);
      if (std::none_of(around.begin() + static_cast<std::ptrdiff_t>(end),
                       around.begin() + static_cast<std::ptrdiff_t>(behind),
                       [](const Neighbor& neighbor) { return neighbor.turned; })) {
        reached.push_back(around[end]);
      }
    }
    return reached;
  }

  static std::size_t endOfAngle(const std::vector<Neighbor>& around, std::size_t begin)
  {
    std::size_t end = begin;
    while (end < around.size() && around[end].angle < around[begin].angle + SAME_ANGLE) {
      ++end;
    }
    return end;
  }

  /// Of an edge in a face of it.
  std::size_t placeOf(std::uint32_t edge, std::uint32_t face) const
  {
    std::size_t place = 0;
    while (place < 2 && topology_.face_edges[3 * std::size_t{face} + place] != edge) {
      ++place;
    }
    return place;
  }

  /// @return whether the outline may go through it
  bool count(std::uint32_t face, const Polygon& polygon, const Outline& outline)
  {
    const Vector2d low = polygon[0].cwiseMin(polygon[1]).cwiseMin(polygon[2]).head<2>();
    const Vector2d high = polygon[0].cwiseMax(polygon[1]).cwiseMax(polygon[2]).head<2>();
    const bool cut = outline.cuts(low, high);
    Vector2d found = Vector2d::Zero();
    if (cut) {
      found = outline.within(polygon);
    } else if (outline.contains(polygon[0].head<2>())) {
      found = 0.5 * twiceAreas(polygon);
    }
    (isWall(face) && !isThin(face) ? area_.walls : area_.surface) += found[0];
    covered_ += found[1];
    return cut;
  }

  const MeshData& mesh_;
  const std::vector<SurfacePoint>& corners_;
  const std::atomic<bool>* cancel_;
  Vector3d origin_;
  Eigen::Matrix3d axes_;
  std::vector<std::uint32_t> faces_;       ///< of the mesh, ascending
  MeshData near_;                          ///< these
  std::vector<std::uint32_t> corners_of_;  ///< of joinedCorners()
  mesh_map::Topology topology_;
  mesh_map::EdgeFaces rows_;
  std::vector<std::int8_t> sides_;  ///< measured: 1: the front, -1: the back; 0: not reached
  int view_side_ = 1;               ///< 1: from where the third coordinate grows, -1: from below
  SurfaceArea area_;
  double covered_ = 0.0;
};

}  // namespace

SurfaceArea findArea(const MeshData& mesh, const std::vector<SurfacePoint>& corners,
                     const std::atomic<bool>* cancel)
{
  throwIfCanceled(cancel);
  return View(mesh, corners, cancel).area();
}

}  // namespace rviz_mesh_plugin
