#include <mesh_map/bvh/selection/bvh_selection.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/require.h"
#include "bvh/selection/bvh_selection_sort.h"
#include "bvh/selection/region_clip.h"

namespace mesh_map {

namespace {

using Matrix = std::array<double, 16>;
using Vector4 = std::array<double, 4>;

double determinant(const Vector3& a, const Vector3& b, const Vector3& c)
{
  return dot(a, cross(b, c));
}

/// The directions of the edges of a pyramid, counterclockwise from left and bottom, of such lengths
/// that their ends are the corners of a parallelogram: that is the picture, up to its size.
std::array<Vector3, 4> pictureCorners(const ConvexRegion& frustum)
{
  const std::vector<Plane>& planes = frustum.planes();
  std::array<Vector3, 4> normals;
  for (std::size_t i = 0; i < 4; ++i) {
    normals[i] = {planes[i][0], planes[i][1], planes[i][2]};
  }
  constexpr std::size_t LEFT = 0, RIGHT = 1, BOTTOM = 2, TOP = 3;
  constexpr std::size_t SIDES[4][2] = {{LEFT, BOTTOM}, {BOTTOM, RIGHT}, {RIGHT, TOP}, {TOP, LEFT}};
  std::array<Vector3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3 edge = cross(normals[SIDES[i][0]], normals[SIDES[i][1]]);
    // The way that is in front of the planes across.
    const std::size_t across = SIDES[(i + 1) % 4][1], beside = SIDES[(i + 2) % 4][1];
    const double one = dot(edge, normals[across]), other = dot(edge, normals[beside]);
    require(one * other > 0.0,
            "the first four planes of the frustum (left, right, bottom, top) "
            "do not form a pyramid");
    corners[i] = one > 0.0 ? edge : -edge;
  }
  // Four vectors a, b, c, d of space sum up to zero with the factors |bcd|, -|acd|, |abd|, -|abc|.
  std::array<double, 4> factors;
  for (std::size_t i = 0; i < 4; ++i) {
    factors[i] =
        std::abs(determinant(corners[(i + 1) % 4], corners[(i + 2) % 4], corners[(i + 3) % 4]));
  }
  for (std::size_t i = 0; i < 4; ++i) {
    corners[i] = factors[i] * corners[i];
  }
  return corners;
}

/// Throws std::invalid_argument where there is none.
Matrix inverse(const Matrix& matrix)
{
  std::array<std::array<double, 8>, 4> rows{};
  double largest = 0.0;
  for (const double entry : matrix) {
    largest = std::isfinite(entry) ? std::max(largest, std::abs(entry)) : std::nan("");
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      rows[i][j] = matrix[4 * i + j] / largest;
    }
    rows[i][4 + i] = 1.0;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    std::size_t pivot = i;
    for (std::size_t j = i + 1; j < 4; ++j) {
      pivot = std::abs(rows[j][i]) > std::abs(rows[pivot][i]) ? j : pivot;
    }
    std::swap(rows[i], rows[pivot]);
    const double divisor = rows[i][i];
    require(std::abs(divisor) > 1e-300, "the view-projection matrix has no inverse");
    for (double& entry : rows[i]) {
      entry /= divisor;
    }
    for (std::size_t j = 0; j < 4; ++j) {
      const double factor = rows[j][i];
      for (std::size_t k = 0; j != i && k < 8; ++k) {
        rows[j][k] -= factor * rows[i][k];
      }
    }
  }
  Matrix result;
  for (std::size_t i = 0; i < 16; ++i) {
    result[i] = rows[i / 4][4 + i % 4];
  }
  return result;
}

Vector4 times(const Matrix& matrix, const Vector4& vector)
{
  Vector4 result{};
  for (std::size_t i = 0; i < 16; ++i) {
    result[i / 4] += matrix[i] * vector[i % 4];
  }
  return result;
}

/// The pixels [begin, end) of one axis of a picture.
struct PixelSpan
{
  std::size_t begin, end;
};

/// Those among which all are whose centers the polygon may contain.
PixelSpan pixelsOf(const LassoRegion& lasso, std::size_t axis, std::size_t count)
{
  double lowest = 1.0, highest = -1.0;
  for (const LassoRegion::Point& corner : lasso.polygon()) {
    lowest = std::min(lowest, corner[axis]);
    highest = std::max(highest, corner[axis]);
  }
  const auto size = static_cast<double>(count);
  const auto pixel = [size](double at) {
    return static_cast<std::size_t>(std::min(std::max(0.5 * (at + 1.0) * size, 0.0), size));
  };
  const std::size_t begin = pixel(lowest), end = pixel(highest);
  return {begin - std::min<std::size_t>(begin, 1), std::min(end + 2, count)};
}

}  // namespace

PixelRays frustumPixels(const ConvexRegion& frustum, const std::array<double, 3>& eye,
                        std::size_t columns, std::size_t rows)
{
  require(frustum.valid() && frustum.planes().size() >= 4,
          "a frustum has four planes or more that are finite and have a "
          "normal, the first of them left, right, bottom and top");
  const char* const names[4] = {"left", "right", "bottom", "top"};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3 size{std::abs(eye[0]), std::abs(eye[1]), std::abs(eye[2])};
    const double distance = height(frustum.planes()[i], eye[0], eye[1], eye[2]);
    require(std::abs(distance) <= 1e-5 * (1.0 + heightTerms(frustum.planes()[i], size)),
            "the " + std::string(names[i]) + " plane of the frustum passes the eye at " +
                std::to_string(distance) + " m");
  }
  const std::array<Vector3, 4> corners = pictureCorners(frustum);
  PixelRays rays;
  rays.origins.assign(eye.begin(), eye.end());
  rays.directions.reserve(3 * columns * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const double x = (static_cast<double>(column) + 0.5) / static_cast<double>(columns);
      const double y = (static_cast<double>(row) + 0.5) / static_cast<double>(rows);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rays.directions.push_back((1.0 - x) * (1.0 - y) * corners[0][axis] +
                                  x * (1.0 - y) * corners[1][axis] + x * y * corners[2][axis] +
                                  (1.0 - x) * y * corners[3][axis]);
      }
    }
  }
  return rays;
}

PixelRays lassoPixels(const LassoRegion& lasso, std::size_t columns, std::size_t rows)
{
  const Matrix matrix = inverse(lasso.viewProjection());
  const PixelSpan across = pixelsOf(lasso, 0, columns), up = pixelsOf(lasso, 1, rows);
  PixelRays rays;
  for (std::size_t row = up.begin; row < up.end; ++row) {
    for (std::size_t column = across.begin; column < across.end; ++column) {
      const double x = (2.0 * static_cast<double>(column) + 1.0) / static_cast<double>(columns);
      const double y = (2.0 * static_cast<double>(row) + 1.0) / static_cast<double>(rows);
      if (!lasso.polygonContains({x - 1.0, y - 1.0})) {
        continue;
      }
      const Vector4 near = times(matrix, {x - 1.0, y - 1.0, -1.0, 1.0});
      const Vector4 far = times(matrix, {x - 1.0, y - 1.0, 1.0, 1.0});
      const double turned = near[3] < 0.0 ? -1.0 : 1.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rays.origins.push_back(near[axis] / near[3]);
        // Along far / far[3] - near / near[3], also where far[3] is 0: infinitely far.
        rays.directions.push_back(turned * (far[axis] * near[3] - near[axis] * far[3]));
      }
    }
  }
  return rays;
}

std::vector<std::uint32_t> facesInPicture(const Bvh& bvh, const Region& region,
                                          const RayBatch& pixels, ArrayView<std::uint8_t> mask,
                                          const RayCast& cast)
{
  const RayHits hits = cast(pixels);
  FaceSet faces(bvh.faceCount());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint32_t face = hits.faces[i];
    if (face == NO_INDEX || (!mask.empty() && mask[face] == 0)) {
      continue;
    }
    const RayTest ray(pixels[i]);
    if (region.contains(ray.origin() + hits.distances[i] * ray.direction())) {
      faces.add(face);
    }
  }
  return faces.sorted(pixels.size());
}

}  // namespace mesh_map
