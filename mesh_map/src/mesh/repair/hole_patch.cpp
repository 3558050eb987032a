#include "mesh/repair/hole_patch.h"

#include <mesh_map/base/array_view.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace mesh_map {
namespace {

using Face = HolePatch::Face;

constexpr std::size_t MOST_POINTS = 220;  // of a loop for which all triangulations are compared
constexpr std::size_t MOST_FACES = 1'000'000;  // of a patch that is still refined
constexpr double BEND_STEP = PI / 18;          // smaller differences of angles do not count

Vector3 normalOf(const std::vector<Vector3>& points, const Face& face)
{
  return cross(points[face[1]] - points[face[0]], points[face[2]] - points[face[0]]);
}

/// Thinner than a millionth of its length: as good as no area.
bool hasArea(const std::vector<Vector3>& points, const Face& face)
{
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 side = points[face[(k + 1) % 3]] - points[face[k]];
    longest = std::max(longest, dot(side, side));
  }
  return norm(normalOf(points, face)) > 1e-6 * longest;
}

/// All triangulations compared, by what is best for parts of the loop.
class BestTriangulation
{
 public:
  BestTriangulation(const HoleLoop& loop, const EdgeTest& has_edge)
      : loop_(loop), count_(loop.points.size()), parts_(count_ * count_)
  {
    allowed_.assign(count_ * count_, 1);
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t k = i + 2; k < count_; ++k) {
        allowed_[i * count_ + k] = (i == 0 && k == count_ - 1) || !has_edge(i, k);
      }
    }
  }

  std::vector<Face> faces()
  {
    for (std::size_t i = 0; i + 1 < count_; ++i) {
      part(i, i + 1) = {0.0, 0.0, 0, loop_.beside[i]};
    }
    for (std::size_t length = 2; length < count_; ++length) {
      for (std::size_t i = 0; i + length < count_; ++i) {
        choose(i, i + length);
      }
    }
    std::vector<Face> faces;
    if (std::isfinite(part(0, count_ - 1).area)) {
      collect(0, count_ - 1, faces);
    }
    return faces;
  }

 private:
  struct Part
  {
    double bend = 0.0;
    double area = std::numeric_limits<double>::infinity();
    std::size_t tip = 0;
    Vector3 normal = {0.0, 0.0, 0.0};  // of the face at the side that leads to the rest
  };

  Part& part(std::size_t i, std::size_t k) { return parts_[i * count_ + k]; }

  static double bendOf(const Vector3& one, const Vector3& other)
  {
    return dot(one, one) > 0.0 && dot(other, other) > 0.0 ? angleBetween(one, other) : 0.0;
  }

  void choose(std::size_t i, std::size_t k)
  {
    Part& best = part(i, k);
    if (allowed_[i * count_ + k] == 0) {
      return;
    }
    const Vector3 &a = loop_.points[i], &c = loop_.points[k];
    for (std::size_t tip = i + 1; tip < k; ++tip) {
      const Part &left = part(i, tip), &right = part(tip, k);
      const double below = left.area + right.area;
      if (!std::isfinite(below)) {
        continue;
      }
      const Vector3 &b = loop_.points[tip], normal = cross(b - a, c - a);
      const double twice = norm(normal);
      const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(c - a, c - a)});
      if (!(twice > 1e-6 * longest)) {
        continue;
      }
      double bend = std::max(
          {left.bend, right.bend, bendOf(left.normal, normal), bendOf(right.normal, normal)});
      if (i == 0 && k == count_ - 1) {
        bend = std::max(bend, bendOf(loop_.beside[count_ - 1], normal));
      }
      const double area = below + 0.5 * twice;
      const double step = std::floor(bend / BEND_STEP),
                   best_step = std::floor(best.bend / BEND_STEP);
      if (!std::isfinite(best.area) || step < best_step ||
          (step == best_step && area < best.area)) {
        best = {bend, area, tip, normal};
      }
    }
  }

  void collect(std::size_t i, std::size_t k, std::vector<Face>& faces)
  {
    if (k == i + 1) {
      return;
    }
    const std::size_t tip = part(i, k).tip;
    faces.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(tip),
                     static_cast<std::uint32_t>(k)});
    collect(i, tip, faces);
    collect(tip, k, faces);
  }

  const HoleLoop& loop_;
  std::size_t count_;
  std::vector<Part> parts_;
  std::vector<std::uint8_t> allowed_;
};

/// Ears cut off in the best plane, the one with the largest smallest angle first.
class EarCutter
{
 public:
  EarCutter(const HoleLoop& loop, const EdgeTest& has_edge) : has_edge_(has_edge)
  {
    const Vector3& n = loop.normal;
    const Vector3 axis = std::abs(n[0]) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    Vector3 u = cross(n, axis);
    u = u / norm(u);
    const Vector3 v = cross(n, u);
    double area = 0.0;
    for (const Vector3& point : loop.points) {
      flat_.push_back({dot(point - loop.points[0], u), dot(point - loop.points[0], v)});
    }
    for (std::size_t i = 0; i < flat_.size(); ++i) {
      area += cross(flat_[i], flat_[(i + 1) % flat_.size()]);
    }
    if (area < 0.0) {
      for (Vector2& point : flat_) {
        point[1] = -point[1];
      }
    }
  }

  std::vector<Face> faces()
  {
    std::vector<Face> faces;
    std::vector<std::uint32_t> left(flat_.size());
    std::iota(left.begin(), left.end(), 0u);
    std::vector<double> quality(left.size());
    for (std::size_t i = 0; i < left.size(); ++i) {
      quality[i] = qualityOf(left, i);
    }
    while (left.size() > 2) {
      const auto best = std::max_element(quality.begin(), quality.end()) - quality.begin();
      if (!(quality[static_cast<std::size_t>(best)] > 0.0)) {
        return {};
      }
      const std::size_t i = static_cast<std::size_t>(best), count = left.size();
      faces.push_back({left[(i + count - 1) % count], left[i], left[(i + 1) % count]});
      left.erase(left.begin() + best);
      quality.erase(quality.begin() + best);
      for (std::size_t step = 0; step < 2 && left.size() > 2; ++step) {
        const std::size_t at = (i + left.size() - 1 + step) % left.size();
        quality[at] = qualityOf(left, at);
      }
    }
    return faces;
  }

 private:
  /// The sine of its smallest angle, or 0 where it is no ear.
  double qualityOf(const std::vector<std::uint32_t>& left, std::size_t i) const
  {
    const std::size_t count = left.size();
    const std::uint32_t a = left[(i + count - 1) % count], b = left[i], c = left[(i + 1) % count];
    const Vector2 ab = flat_[b] - flat_[a], bc = flat_[c] - flat_[b], ca = flat_[a] - flat_[c];
    const double area = cross(ab, bc), longest = std::max({dot(ab, ab), dot(bc, bc), dot(ca, ca)});
    if (!(area > 1e-6 * longest) || (count > 3 && has_edge_(a, c))) {
      return 0.0;
    }
    for (const std::uint32_t other : left) {
      if (other != a && other != b && other != c && cross(ab, flat_[other] - flat_[a]) >= 0.0 &&
          cross(bc, flat_[other] - flat_[b]) >= 0.0 && cross(ca, flat_[other] - flat_[c]) >= 0.0) {
        return 0.0;
      }
    }
    const double lengths = norm(ab) * norm(bc) * norm(ca);
    return area * std::sqrt(std::min({dot(ab, ab), dot(bc, bc), dot(ca, ca)})) / lengths;
  }

  const EdgeTest& has_edge_;
  std::vector<Vector2> flat_;
};

/// Faces of a patch with what is beside their sides, so that they can be changed.
class PatchEditor
{
 public:
  PatchEditor(const HoleLoop& loop, const EdgeTest& has_edge, HolePatch& patch)
      : loop_count_(loop.points.size()), has_edge_(has_edge), patch_(patch)
  {
    std::unordered_map<std::uint64_t, std::uint32_t> sides;
    beside_.assign(3 * patch.faces.size(), NO_INDEX);
    for (std::uint32_t side = 0; side < beside_.size(); ++side) {
      sides[key(from(side), to(side))] = side;
    }
    for (std::uint32_t side = 0; side < beside_.size(); ++side) {
      const auto other = sides.find(key(to(side), from(side)));
      beside_[side] = other == sides.end() ? NO_INDEX : other->second;
    }
    edges_ = std::move(sides);
  }

  /// Flips edges until each is Delaunay, or for so many rounds.
  void relax()
  {
    for (int round = 0; round < 30; ++round) {
      bool changed = false;
      for (std::uint32_t side = 0; side < beside_.size(); ++side) {
        changed = flip(side) || changed;
      }
      if (!changed) {
        return;
      }
    }
  }

  /// A new point in a face.
  void split(std::uint32_t face, const Vector3& point)
  {
    const auto middle = static_cast<std::uint32_t>(patch_.points.size());
    patch_.points.push_back(point);
    const auto second = static_cast<std::uint32_t>(patch_.faces.size()), third = second + 1;
    const Face corners = patch_.faces[face];
    const std::array<std::uint32_t, 3> around = {beside_[3 * face], beside_[3 * face + 1],
                                                 beside_[3 * face + 2]};
    patch_.faces[face] = {corners[0], corners[1], middle};
    patch_.faces.push_back({corners[1], corners[2], middle});
    patch_.faces.push_back({corners[2], corners[0], middle});
    beside_.resize(3 * patch_.faces.size(), NO_INDEX);
    join(3 * face, around[0]);
    join(3 * second, around[1]);
    join(3 * third, around[2]);
    join(3 * face + 1, 3 * second + 2);
    join(3 * second + 1, 3 * third + 2);
    join(3 * third + 1, 3 * face + 2);
  }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b)
  {
    return (std::uint64_t{a} << 32) | b;
  }

  std::uint32_t from(std::uint32_t side) const { return patch_.faces[side / 3][side % 3]; }
  std::uint32_t to(std::uint32_t side) const { return patch_.faces[side / 3][(side + 1) % 3]; }
  std::uint32_t tip(std::uint32_t side) const { return patch_.faces[side / 3][(side + 2) % 3]; }

  void join(std::uint32_t side, std::uint32_t other)
  {
    beside_[side] = other;
    edges_[key(from(side), to(side))] = side;
    if (other != NO_INDEX) {
      beside_[other] = side;
    }
  }

  bool exists(std::uint32_t a, std::uint32_t b) const
  {
    return edges_.count(key(a, b)) > 0 || edges_.count(key(b, a)) > 0 ||
           (a < loop_count_ && b < loop_count_ && has_edge_(a, b));
  }

  double angleAt(std::uint32_t at, std::uint32_t a, std::uint32_t b) const
  {
    return angleBetween(patch_.points[a] - patch_.points[at], patch_.points[b] - patch_.points[at]);
  }

  bool flip(std::uint32_t side)
  {
    const std::uint32_t other = beside_[side];
    if (other == NO_INDEX) {
      return false;
    }
    const std::uint32_t a = from(side), b = to(side), c = tip(side), d = tip(other);
    if (angleAt(c, a, b) + angleAt(d, a, b) <= PI + 1e-9 || exists(c, d)) {
      return false;
    }
    const Face one = {a, d, c}, two = {d, b, c};
    const Vector3 before = normalOf(patch_.points, patch_.faces[side / 3]) +
                           normalOf(patch_.points, patch_.faces[other / 3]);
    const Vector3 n = normalOf(patch_.points, one), m = normalOf(patch_.points, two);
    const double size = norm(before);
    if (!hasArea(patch_.points, one) || !hasArea(patch_.points, two) ||
        !(dot(n, before) > 0.5 * norm(n) * size) || !(dot(m, before) > 0.5 * norm(m) * size)) {
      return false;
    }
    const std::uint32_t f = side / 3, g = other / 3;
    const std::uint32_t bc = beside_[3 * f + (side + 1) % 3], ca = beside_[3 * f + (side + 2) % 3];
    const std::uint32_t ad = beside_[3 * g + (other + 1) % 3],
                        db = beside_[3 * g + (other + 2) % 3];
    edges_.erase(key(a, b));
    edges_.erase(key(b, a));
    patch_.faces[f] = one;
    patch_.faces[g] = two;
    join(3 * f, ad);
    join(3 * f + 2, ca);
    join(3 * g, db);
    join(3 * g + 1, bc);
    join(3 * f + 1, 3 * g + 2);
    edges_[key(c, d)] = 3 * g + 2;
    return true;
  }

  std::size_t loop_count_;
  const EdgeTest& has_edge_;
  HolePatch& patch_;
  std::vector<std::uint32_t> beside_;                       // sides, of the other face
  std::unordered_map<std::uint64_t, std::uint32_t> edges_;  // those there are, in each direction
};

/// One round of moving each new point to the middle of its neighbors.
void smooth(HolePatch& patch, std::size_t loop_count)
{
  const std::size_t count = patch.points.size();
  std::vector<Vector3> sums(count, {0.0, 0.0, 0.0});
  std::vector<double> numbers(count, 0.0);
  for (const Face& face : patch.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t other = 1; other < 3; ++other) {  // each neighbor is seen from two faces
        sums[face[k]] = sums[face[k]] + patch.points[face[(k + other) % 3]];
        numbers[face[k]] += 1.0;
      }
    }
  }
  for (std::size_t i = loop_count; i < count; ++i) {
    patch.points[i] = sums[i] / numbers[i];
  }
}

/// The point of a face that is nearest to a point: weights of its corners, and the square of the
/// distance.
std::pair<Vector3, double> nearestIn(const std::vector<Vector3>& points, const Face& face,
                                     const Vector3& point)
{
  const Vector3 &a = points[face[0]], &b = points[face[1]], &c = points[face[2]];
  const Vector3 u = b - a, v = c - a, n = cross(u, v);
  const Vector2 inside = barycentricWeights(u, v, n, point - a);
  const auto squared = [&](const Vector3& w) {
    const Vector3 gap = w[0] * a + w[1] * b + w[2] * c - point;
    return dot(gap, gap);
  };
  Vector3 best = {1.0 - inside[0] - inside[1], inside[0], inside[1]};
  if (best[0] >= 0.0 && best[1] >= 0.0 && best[2] >= 0.0) {
    return {best, squared(best)};
  }
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t l = (k + 1) % 3;
    const Vector3 side = points[face[l]] - points[face[k]];
    const double along = dot(point - points[face[k]], side) / dot(side, side);
    const double share = std::min(1.0, std::max(0.0, along));
    Vector3 weights = {0.0, 0.0, 0.0};
    weights[k] = 1.0 - share;
    weights[l] = share;
    const double found = squared(weights);
    if (found < distance) {
      distance = found;
      best = weights;
    }
  }
  return {best, distance};
}

}  // namespace

HolePatch closedHole(const HoleLoop& loop, const EdgeTest& has_edge)
{
  HolePatch patch;
  patch.points = loop.points;
  patch.faces = loop.points.size() <= MOST_POINTS ? BestTriangulation(loop, has_edge).faces()
                                                  : EarCutter(loop, has_edge).faces();
  PatchEditor(loop, has_edge, patch).relax();
  return patch;
}

void refinePatch(const HoleLoop& loop, const EdgeTest& has_edge, HolePatch& patch)
{
  constexpr int rounds = 40, smoothings = 8;
  const std::size_t loop_count = loop.points.size();
  const std::vector<Face> coarse = patch.faces;
  // Around a spike of a few short edges the others decide.
  const double mean =
      std::accumulate(loop.spacing.begin(), loop.spacing.end(), 0.0) / double(loop_count);
  std::vector<double> spacing;
  for (const double length : loop.spacing) {
    spacing.push_back(std::max(length, 0.5 * mean));
  }
  PatchEditor editor(loop, has_edge, patch);
  for (int round = 0; round < rounds && patch.faces.size() < MOST_FACES; ++round) {
    bool changed = false;
    const std::size_t before = patch.faces.size();
    for (std::uint32_t face = 0; face < before; ++face) {
      const Face corners = patch.faces[face];
      const Vector3 middle =
          (patch.points[corners[0]] + patch.points[corners[1]] + patch.points[corners[2]]) / 3.0;
      const double wanted = (spacing[corners[0]] + spacing[corners[1]] + spacing[corners[2]]) / 3.0;
      const bool is_large = std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
        const double scaled = std::sqrt(2.0) * distance(middle, patch.points[v]);
        return scaled > wanted && scaled > spacing[v];
      });
      if (is_large) {
        editor.split(face, middle);
        spacing.push_back(wanted);
        changed = true;
      }
    }
    if (!changed) {
      break;
    }
    editor.relax();
  }
  for (int i = 0; i < smoothings && patch.points.size() > loop_count; ++i) {
    smooth(patch, loop_count);
    editor.relax();
  }
  for (std::size_t i = loop_count; i < patch.points.size(); ++i) {
    std::pair<Vector3, double> best = {{}, std::numeric_limits<double>::infinity()};
    Face of = coarse[0];
    for (const Face& face : coarse) {
      const auto found = nearestIn(loop.points, face, patch.points[i]);
      if (found.second < best.second) {
        best = found;
        of = face;
      }
    }
    patch.sources.push_back(of);
    patch.weights.push_back(best.first);
  }
}

double largestFold(const HoleLoop& loop, const HolePatch& patch)
{
  double largest = 0.0;
  const auto count = static_cast<std::uint32_t>(loop.points.size());
  std::unordered_map<std::uint64_t, Vector3> normals;  // of the face at each directed side
  const auto key = [](std::uint32_t a, std::uint32_t b) { return (std::uint64_t{a} << 32) | b; };
  for (const Face& face : patch.faces) {
    if (!hasArea(patch.points, face)) {
      return PI;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      normals[key(face[k], face[(k + 1) % 3])] = normalOf(patch.points, face);
    }
  }
  for (const auto& [side, normal] : normals) {
    const auto a = static_cast<std::uint32_t>(side >> 32), b = static_cast<std::uint32_t>(side);
    const auto other = normals.find(key(b, a));
    Vector3 beside = {0.0, 0.0, 0.0};
    if (other != normals.end()) {
      beside = other->second;
    } else if (a < count && b == (a + 1) % count) {
      beside = loop.beside[a];
    }
    if (dot(beside, beside) > 0.0) {
      largest = std::max(largest, angleBetween(normal, beside));
    }
  }
  return largest;
}

}  // namespace mesh_map
