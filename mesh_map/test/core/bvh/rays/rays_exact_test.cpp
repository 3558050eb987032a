#include <optional>

#include "bvh/rays/ray_test.h"
#include "ray_checks.h"
#include "ray_samples.h"

using mesh_map::NO_INDEX;
using mesh_map::Ray;
using mesh_map::RayHit;
using mesh_map::RayTest;

namespace {

using Wide = long double;
using WidePoint = std::array<Wide, 3>;

WidePoint minus(const WidePoint& a, const WidePoint& b)
{
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

WidePoint cross(const WidePoint& a, const WidePoint& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Wide dot(const WidePoint& a, const WidePoint& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Another way to the same: where the ray meets the plane, and the weights of that point from the
/// areas that it cuts the triangle into.
struct PlaneHit
{
  Wide distance;
  WidePoint weights;
  bool front;
};

std::optional<PlaneHit> meetPlane(const Ray& ray, const std::vector<float>& t)
{
  const WidePoint a = {t[0], t[1], t[2]}, b = {t[3], t[4], t[5]}, c = {t[6], t[7], t[8]};
  const WidePoint o = {ray.origin[0], ray.origin[1], ray.origin[2]};
  WidePoint d = {ray.direction[0], ray.direction[1], ray.direction[2]};
  const Wide length = std::sqrt(dot(d, d));
  d = {d[0] / length, d[1] / length, d[2] / length};
  const WidePoint normal = cross(minus(b, a), minus(c, a));
  const Wide area = std::sqrt(dot(normal, normal)), slope = dot(normal, d);
  if (!(std::abs(slope) > 1e-3L * area) || !(area > 1e-6L)) {
    return std::nullopt;
  }
  PlaneHit hit;
  hit.distance = dot(normal, minus(a, o)) / slope;
  const WidePoint p = {o[0] + hit.distance * d[0], o[1] + hit.distance * d[1],
                       o[2] + hit.distance * d[2]};
  const Wide square = area * area;
  hit.weights = {dot(normal, cross(minus(b, p), minus(c, p))) / square,
                 dot(normal, cross(minus(c, p), minus(a, p))) / square,
                 dot(normal, cross(minus(a, p), minus(b, p))) / square};
  hit.front = slope < 0;
  return hit;
}

TEST(RayTest, agrees_with_planes_and_areas_in_long_double)
{
  std::size_t hits = 0, misses = 0;
  for (const TestMesh& mesh : {soup(200), terrain(8), cube(3)}) {
    RaySamples samples(mesh);
    for (std::size_t i = 0; i < 30000; ++i) {
      const std::size_t face = samples.index(mesh.faceCount());
      const std::vector<float> corners = mesh.corners(face);
      const Point a = samples.corner(face, 0), b = samples.corner(face, 1);
      Ray ray = rayTo(samples.point(3.0),
                      between(a, between(b, samples.corner(face, 2), samples.number(-0.3, 1.3)),
                              samples.number(-0.3, 1.3)));
      if (i % 5 == 0) {
        ray.max_distance = samples.number(0.0, samples.size());
      }
      const std::optional<PlaneHit> expected = meetPlane(ray, corners);
      if (!expected) {
        continue;
      }
      const bool back_faces = i % 2 == 0;
      const RayHit hit = hitOf(RayTest(ray), corners.data(), back_faces);
      const Wide smallest =
          std::min({expected->weights[0], expected->weights[1], expected->weights[2]});
      const Wide room =
          std::min<Wide>({smallest, expected->distance, ray.max_distance - expected->distance});
      const std::string what = mesh.name + " face " + std::to_string(face) + ", " + describe(ray);
      if (std::abs(room) > 1e-9L) {
        EXPECT_EQ(hit.face != NO_INDEX, room > 0 && (back_faces || expected->front)) << what;
      }
      if (hit.face == NO_INDEX) {
        ++misses;
        continue;
      }
      ++hits;
      EXPECT_NEAR(hit.distance, expected->distance, 1e-10) << what;
      EXPECT_EQ(hit.face, 0u);
      double sum = 0.0;
      const std::array<double, 3> direction = RayTest(ray).direction();
      for (std::size_t k = 0; k < 3; ++k) {
        sum += hit.barycentric[k];
        EXPECT_NEAR(hit.barycentric[k], expected->weights[k], 1e-8) << what;
        EXPECT_GE(hit.barycentric[k], 0.0) << what;
        const double by_weights = hit.barycentric[0] * corners[k] +
                                  hit.barycentric[1] * corners[k + 3] +
                                  hit.barycentric[2] * corners[k + 6];
        EXPECT_NEAR(by_weights, ray.origin[k] + hit.distance * direction[k], 1e-11) << what;
      }
      EXPECT_NEAR(sum, 1.0, 1e-15);
    }
  }
  EXPECT_GT(hits, 10000u);
  EXPECT_GT(misses, 10000u);
}

const float TRIANGLE[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};  // counter-clockwise seen from above

struct Case
{
  const char* name;
  Ray ray;
  bool front;  ///< hit if back faces are passed
  double distance;
};

constexpr double NEVER = -1.0;
constexpr double INF = std::numeric_limits<double>::infinity();
constexpr double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();

TEST(RayTest, says_exactly_what_is_plain)
{
  const Case cases[] = {
      {"from above", {{0.2, 0.2, 3}, {0, 0, -1}}, true, 3.0},
      {"from below", {{0.2, 0.2, -3}, {0, 0, 2}}, false, 3.0},
      {"of any length", {{0.2, 0.2, 3}, {0, 0, -7e250}}, true, 3.0},
      {"of the smallest length", {{0.2, 0.2, 3}, {0, 0, -5e-324}}, true, 3.0},
      {"slanted", {{0.2 - 3, 0.2 - 4, 12}, {3, 4, -12}}, true, 13.0},
      {"through a corner", {{1, 0, 3}, {0, 0, -1}}, true, 3.0},
      {"through the first corner", {{0, 0, 3}, {0, 0, -1}}, true, 3.0},
      {"through an edge", {{0.5, 0.5, 3}, {0, 0, -1}}, true, 3.0},
      {"beside", {{0.5, 0.5000001, 3}, {0, 0, -1}}, false, NEVER},
      {"away", {{0.2, 0.2, 3}, {0, 0, 1}}, false, NEVER},
      {"from the surface", {{0.2, 0.2, 0}, {0, 0, -1}}, true, 0.0},
      {"from a corner", {{0, 0, 0}, {1, 1, -3}}, true, 0.0},
      {"in the plane", {{-1, 0.2, 0}, {1, 0, 0}}, false, NEVER},
      {"along an edge", {{-1, 0, 0}, {1, 0, 0}}, false, NEVER},
      {"ending there", {{0.2, 0.2, 3}, {0, 0, -1}, 3.0}, true, 3.0},
      {"ending before", {{0.2, 0.2, 3}, {0, 0, -1}, 2.9999999999999996}, false, NEVER},
      {"without length, there", {{0.2, 0.2, 0}, {0, 0, -1}, 0.0}, true, 0.0},
      {"without length, elsewhere", {{0.2, 0.2, 1}, {0, 0, -1}, 0.0}, false, NEVER},
      {"of a negative length", {{0.2, 0.2, 0}, {0, 0, -1}, -1.0}, false, NEVER},
      {"of a length that is no number", {{0.2, 0.2, 3}, {0, 0, -1}, NOT_A_NUMBER}, false, NEVER},
      {"of no direction", {{0.2, 0.2, 0}, {0, -0.0, 0}}, false, NEVER},
      {"from afar", {{0.25, 0.25, 1e300}, {0, 0, -1}}, true, 1e300},
      {"from beyond numbers", {{0.2, 0.2, INF}, {0, 0, -1}}, false, NEVER},
      {"from no number", {{NOT_A_NUMBER, 0.2, 3}, {0, 0, -1}}, false, NEVER},
      {"along no number", {{0.2, 0.2, 3}, {0, NOT_A_NUMBER, -1}}, false, NEVER},
      {"along infinity", {{0.2, 0.2, 3}, {0, 0, -INF}}, false, NEVER},
  };
  for (const Case& c : cases) {
    const RayHit hit = hitOf(RayTest(c.ray), TRIANGLE);
    const RayHit front = hitOf(RayTest(c.ray), TRIANGLE, false);
    EXPECT_EQ(hit.face, c.distance == NEVER ? NO_INDEX : 0) << c.name;
    EXPECT_EQ(front.face, c.front ? 0 : NO_INDEX) << c.name;
    EXPECT_EQ(hit.distance, c.distance == NEVER ? INF : c.distance) << c.name;
    EXPECT_FALSE(std::signbit(hit.distance)) << c.name;
  }
}

TEST(RayTest, does_not_hit_triangles_without_area)
{
  const float point[] = {1, 2, 3, 1, 2, 3, 1, 2, 3}, segment[] = {0, 0, 0, 1, 1, 0, 3, 3, 0};
  EXPECT_EQ(hitOf(RayTest({{1, 2, 9}, {0, 0, -1}}), point).face, NO_INDEX);
  EXPECT_EQ(hitOf(RayTest({{1, 1, 9}, {0, 0, -1}}), segment).face, NO_INDEX);
  EXPECT_EQ(hitOf(RayTest({{2, 2, 0}, {1, -1, 0}}), segment).face, NO_INDEX);
}

TEST(RayTest, turns_directions_to_length_1_whatever_their_length)
{
  for (const double length : {5e-322, 1e-310, 1e-200, 1e-90, 1.0, 1e90, 1e200, 1e308}) {
    const RayTest test({{0, 0, 0}, {0.6 * length, -0.8 * length, 0.0}});
    ASSERT_TRUE(test.valid());
    EXPECT_NEAR(test.direction()[0], 0.6, length < 1e-300 ? 0.01 : 1e-15) << length;
    EXPECT_NEAR(test.direction()[1], -0.8, length < 1e-300 ? 0.01 : 1e-15) << length;
    EXPECT_NEAR(std::hypot(test.direction()[0], test.direction()[1]), 1.0, 1e-15) << length;
  }
}

TEST(RayTest, has_determinants_of_exact_sign_however_they_cancel)
{
  __extension__ using Exact = __int128;
  std::mt19937_64 random(7);
  std::uniform_int_distribution<std::int64_t> large(std::int64_t{1} << 51, std::int64_t{1} << 52);
  std::uniform_int_distribution<std::int64_t> small(-3, 3);
  std::size_t rounded_away = 0;
  for (std::size_t i = 0; i < 100000; ++i) {
    const std::int64_t a = large(random), b = large(random);
    const std::int64_t c = a + small(random), d = b + small(random);
    const Exact exact = static_cast<Exact>(a) * d - static_cast<Exact>(b) * c;
    const double da = static_cast<double>(a), db = static_cast<double>(b);
    const double dc = static_cast<double>(c), dd = static_cast<double>(d);
    const double value = mesh_map::determinant(da, db, dc, dd);
    ASSERT_EQ(value > 0.0, exact > 0) << a << " " << b << " " << c << " " << d;
    ASSERT_EQ(value < 0.0, exact < 0) << a << " " << b << " " << c << " " << d;
    ASSERT_EQ(mesh_map::determinant(dc, dd, da, db), -value);
    rounded_away += (da * dd - db * dc > 0.0) != (exact > 0) ? 1 : 0;
  }
  EXPECT_GT(rounded_away, 0u);  // plain rounding would not do
}

}  // namespace
