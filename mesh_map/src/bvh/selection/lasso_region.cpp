#include <mesh_map/bvh/selection/region.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bvh/selection/picture_polygon.h"
#include "bvh/selection/region_clip.h"

namespace mesh_map {

namespace {

using Matrix = std::array<double, 16>;

constexpr double LARGEST_CORNER = 1e30;

double row(const Matrix& matrix, std::size_t index, const Vector3& point)
{
  return height(
      {matrix[4 * index], matrix[4 * index + 1], matrix[4 * index + 2], matrix[4 * index + 3]},
      point[0], point[1], point[2]);
}

/// A point of the picture, of one in front of the camera; or not finite.
Vector2 project(const Matrix& matrix, const Vector3& point)
{
  const double w = row(matrix, 3, point);
  if (!(w > 0.0)) {
    return {std::nan(""), std::nan("")};
  }
  return {row(matrix, 0, point) / w, row(matrix, 1, point) / w};
}

bool isValid(const std::vector<Vector2>& polygon, const Matrix& matrix)
{
  return polygon.size() >= 3 &&
         std::all_of(polygon.begin(), polygon.end(),
                     [](const Vector2& point) {
                       return std::abs(point[0]) <= LARGEST_CORNER &&
                              std::abs(point[1]) <= LARGEST_CORNER;
                     }) &&
         std::all_of(matrix.begin(), matrix.end(), [](double x) { return std::isfinite(x); });
}

/// Scaled so that sums of products do not overflow; the picture is the same.
Matrix scaled(const Matrix& matrix)
{
  double largest = 0.0;
  for (const double entry : matrix) {
    largest = std::max(largest, std::abs(entry));
  }
  Matrix result{};
  for (std::size_t i = 0; i < 16; ++i) {
    result[i] = largest > 0.0 ? matrix[i] / largest : 0.0;
  }
  return result;
}

/// Near, far, and the four sides of a rectangle of the picture, a little larger, since it is for
/// the polygon to tell what lies on its border.
std::vector<Plane> planesAround(const Rectangle& bounds, const Matrix& matrix)
{
  std::vector<Plane> planes;
  // What `factor` times a row and `share` times the last row sum up to is not negative.
  const auto add = [&](std::size_t index, double factor, double share) {
    Plane plane;
    for (std::size_t i = 0; i < 4; ++i) {
      plane[i] = factor * matrix[4 * index + i] + share * matrix[12 + i];
    }
    // Without a normal it holds everywhere (a far plane at infinity) or nowhere.
    if (plane[0] != 0.0 || plane[1] != 0.0 || plane[2] != 0.0 || plane[3] < 0.0) {
      planes.push_back(plane);
    }
  };
  add(2, 1.0, 1.0);
  add(2, -1.0, 1.0);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double low = bounds.lower[axis], high = bounds.upper[axis];
    const double wider = 1e-9 * std::max({high - low, std::abs(low), std::abs(high)});
    add(axis, 1.0, wider - low);
    add(axis, -1.0, wider + high);
  }
  if (planes.empty()) {
    planes.push_back({});
  }
  return planes;
}

/// Corners of a shape with weights, and how far from a place of the picture these lead.
struct Weighted
{
  std::array<std::size_t, 3> corners{0, 0, 0};
  std::array<double, 3> weights{1.0, 0.0, 0.0};
  double squared_error = std::numeric_limits<double>::infinity();

  /// Takes others if they lead nearer to the place.
  void offer(const ConvexPolygon& shape, const Vector2& place, const std::array<std::size_t, 3>& of,
             std::array<double, 3> shares)
  {
    double sum = 0.0;
    for (double& share : shares) {
      share = std::max(0.0, share);
      sum += share;
    }
    Vector2 error = -place;
    for (std::size_t k = 0; k < 3; ++k) {
      shares[k] /= sum;
      error = error + shares[k] * shape[of[k]];
    }
    if (dot(error, error) < squared_error) {
      *this = {of, shares, dot(error, error)};
    }
  }
};

/// What planes left of a triangle, in space and in the picture.
struct Rest
{
  ConvexPolygon shape;
  std::array<Vector3, ClippedTriangle::MAX_CORNERS> points;
  bool whole = true;  // nothing was cut

  Rest(const ConvexRegion& frustum, std::uint32_t cutting, const Matrix& matrix,
       const float* corners)
  {
    const PlaneSides sides = planeSides(frustum.planes(), cutting, corners);
    if (sides.outside != 0) {
      return;
    }
    ClippedTriangle rest(corners);
    rest.cut(frustum.planes(), sides.cutting);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const Vector2 place = project(matrix, rest[i]);
      if (std::isfinite(place[0]) && std::isfinite(place[1])) {
        points[shape.size] = rest[i];
        shape.corners[shape.size++] = place;
      }
    }
    whole = sides.cutting == 0 && shape.size == rest.size();
    double area = 0.0;
    for (std::size_t i = 1; i + 1 < shape.size; ++i) {
      area += turn(shape[0], shape[i], shape[i + 1]);
    }
    if (area < 0.0) {
      std::reverse(shape.corners.begin(), shape.corners.begin() + shape.size);
      std::reverse(points.begin(), points.begin() + shape.size);
    }
  }

  /// The point that shows at a place of the picture which is in the shape.
  Vector3 pointAt(const Vector2& place, const Matrix& matrix) const
  {
    Weighted best;
    for (std::size_t i = 0; i < shape.size; ++i) {
      const std::size_t next = i + 1 < shape.size ? i + 1 : 0;
      best.offer(shape, place, {0, i, next},
                 {turn(shape[i], shape[next], place), turn(shape[next], shape[0], place),
                  turn(shape[0], shape[i], place)});
      const Vector2 side = shape[next] - shape[i];
      const double along = dot(place - shape[i], side);
      best.offer(shape, place, {i, next, 0}, {dot(side, side) - along, along, 0.0});
      best.offer(shape, place, {i, 0, 0}, {1.0, 0.0, 0.0});
    }
    // Weights in the picture are weights in space times w.
    double sum = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      best.weights[k] /= row(matrix, 3, points[best.corners[k]]);
      sum += best.weights[k];
    }
    Vector3 point{};
    for (std::size_t k = 0; k < 3; ++k) {
      point = point + best.weights[k] / sum * points[best.corners[k]];
    }
    return point;
  }
};

}  // namespace

LassoRegion::LassoRegion(std::vector<Point> polygon, const std::array<double, 16>& view_projection)
    : polygon_(std::move(polygon)),
      view_projection_(view_projection),
      matrix_(scaled(view_projection)),
      frustum_({Plane{}})
{
  valid_ = isValid(polygon_, view_projection_);
  if (valid_) {
    picture_ = std::make_shared<const PicturePolygon>(polygon_);
    frustum_ = ConvexRegion(planesAround(picture_->bounds(), matrix_));
    valid_ = frustum_.valid();
  }
}

bool LassoRegion::polygonContains(const Point& point) const
{
  return valid_ && picture_->contains(point);
}

bool LassoRegion::contains(const std::array<double, 3>& point) const
{
  return frustum_.contains(point) && polygonContains(project(matrix_, point));
}

Side LassoRegion::triangle(const float* corners) const
{
  return triangle(corners, ALL_PLANES);
}

Side LassoRegion::triangle(const float* corners, std::uint32_t cutting) const
{
  if (!valid_) {
    return Side::OUTSIDE;
  }
  const Rest rest(frustum_, cutting, matrix_, corners);
  if (rest.shape.size == 0) {
    return Side::OUTSIDE;
  }
  const Side side = picture_->convex(rest.shape);
  return side == Side::INSIDE && !rest.whole ? Side::TOUCHING : side;
}

Side LassoRegion::boxInFrustum(const Box& box, bool in_frustum) const
{
  if (!valid_) {
    return Side::OUTSIDE;
  }
  Vector3 middle, half, largest;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    middle[axis] = 0.5 * box.lower[axis] + 0.5 * box.upper[axis];
    half[axis] = 0.5 * box.upper[axis] - 0.5 * box.lower[axis];
    largest[axis] = std::max(std::abs(box.lower[axis]), std::abs(box.upper[axis]));
  }
  const auto plane = [this](std::size_t i) {
    return Plane{matrix_[4 * i], matrix_[4 * i + 1], matrix_[4 * i + 2], matrix_[4 * i + 3]};
  };
  const Plane depth = plane(3);
  const double w = row(matrix_, 3, middle), w_terms = heightTerms(depth, largest);
  const double least_w = w - heightTerms({depth[0], depth[1], depth[2], 0.0}, half);
  if (!(least_w > 1e-6 * w_terms)) {
    return Side::TOUCHING;  // it reaches behind the camera, or nearly so
  }
  // At the middle, the picture has the coordinate `place`; x - place * w is 0 there and linear, so
  // it bounds how far x / w gets from `place`. Roundings, also those of cuts, are relative to
  // terms.
  Rectangle bounds;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Plane across = plane(axis);
    const double place = row(matrix_, axis, middle) / w;
    double reach = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      reach += std::abs(across[i] - place * depth[i]) * half[i];
    }
    const double rounding =
        16.0 * HEIGHT_ROUNDING * (heightTerms(across, largest) + std::abs(place) * w_terms);
    reach = (reach + rounding) / least_w * (1.0 + 1e-9);
    bounds.lower[axis] = place - reach;
    bounds.upper[axis] = place + reach;
  }
  const Side side = picture_->rectangle(bounds);
  return side == Side::INSIDE && !in_frustum ? Side::TOUCHING : side;
}

std::array<double, 3> LassoRegion::witness(const float* corners) const
{
  const Rest rest(frustum_, ALL_PLANES, matrix_, corners);
  if (!valid_ || rest.shape.size == 0) {
    return ClippedTriangle(corners).center();
  }
  return rest.pointAt(picture_->common(rest.shape), matrix_);
}

}  // namespace mesh_map
