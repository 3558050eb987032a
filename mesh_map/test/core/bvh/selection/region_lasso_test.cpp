#include "region_triangles.h"

using namespace mesh_map;

namespace {

using Point = LassoRegion::Point;

/// Whether an odd number of edges is above a point.
bool isIn(const Polygon& polygon, const Point& p)
{
  bool odd = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a[0] > p[0]) != (b[0] > p[0]) &&
        a[1] + (b[1] - a[1]) * (p[0] - a[0]) / (b[0] - a[0]) > p[1]) {
      odd = !odd;
    }
  }
  return odd;
}

/// The distance from a point to the edges.
double distanceTo(const Polygon& polygon, const Point& p)
{
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double x = b[0] - a[0], y = b[1] - a[1], squared = x * x + y * y;
    const double t = squared > 0.0 ? ((p[0] - a[0]) * x + (p[1] - a[1]) * y) / squared : 0.0;
    const double along = std::min(1.0, std::max(0.0, t));
    least = std::min(least, std::hypot(a[0] + along * x - p[0], a[1] + along * y - p[1]));
  }
  return least;
}

std::array<double, 4> clipSpace(const Matrix& matrix, const Vector& p)
{
  std::array<double, 4> result;
  for (std::size_t i = 0; i < 4; ++i) {
    result[i] = matrix[4 * i] * p[0] + matrix[4 * i + 1] * p[1] + matrix[4 * i + 2] * p[2] +
                matrix[4 * i + 3];
  }
  return result;
}

Depth depthIn(const LassoRegion& lasso)
{
  return [&lasso](const Vector& p) {
    const auto [x, y, z, w] = clipSpace(lasso.viewProjection(), p);
    if (w <= 0.0) {
      return -1.0;
    }
    const Point place{x / w, y / w};
    const double distance = distanceTo(lasso.polygon(), place);
    return std::min(
        {1.0 + z / w, 1.0 - z / w, isIn(lasso.polygon(), place) ? distance : -distance});
  };
}

/// Whether a triangle shows at a place of the picture, clearly.
bool shows(const Matrix& matrix, const Triangle& triangle, const Point& place)
{
  // Of the point a + b (B - A) + c (C - A), x - place w and y - place w are 0.
  const auto a = clipSpace(matrix, pointOf(triangle, 0, 0));
  const auto b = clipSpace(matrix, pointOf(triangle, 1, 0));
  const auto c = clipSpace(matrix, pointOf(triangle, 0, 1));
  double rows[2][3];
  for (std::size_t i = 0; i < 2; ++i) {
    const double at_a = a[i] - place[i] * a[3];
    rows[i][0] = b[i] - place[i] * b[3] - at_a;
    rows[i][1] = c[i] - place[i] * c[3] - at_a;
    rows[i][2] = -at_a;
  }
  const double det = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
  const double s = (rows[0][2] * rows[1][1] - rows[0][1] * rows[1][2]) / det;
  const double t = (rows[0][0] * rows[1][2] - rows[0][2] * rows[1][0]) / det;
  const double z = a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2]);
  const double w = a[3] + s * (b[3] - a[3]) + t * (c[3] - a[3]);
  constexpr double sure = 1e-6;
  return std::abs(det) > sure && s > sure && t > sure && s + t < 1.0 - sure && w > sure &&
         std::abs(z) < w - sure;
}

Matrix anyCamera(std::mt19937& random)
{
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Vector eye{3.0 * any(random), 3.0 * any(random), 2.0};
  const Matrix view = viewOf(eye, {any(random), any(random), any(random)});
  return product(random() % 2 == 0 ? perspective(0.5, 0.1, 5.0) : orthographic(2.0, 0.0, 4.0),
                 view);
}

/// Looks down from z = 10; the picture is that of the square from -1 to 1 at z = 0.
const Matrix DOWN = product(perspective(0.1, 1.0, 100.0), viewOf({0, 0, 10}, {0, 0, 0}));
const Matrix FLAT = orthographic(1.0, -5.0, 5.0);
const Polygon SQUARE{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
const Polygon HORSESHOE{{-0.5, -0.5},  {0.5, -0.5},    {0.5, 0.5},   {0.25, 0.5},
                        {0.25, -0.25}, {-0.25, -0.25}, {-0.25, 0.5}, {-0.5, 0.5}};
const Polygon BOW{{-0.5, -0.5}, {0.5, 0.5}, {0.5, -0.5}, {-0.5, 0.5}};
const Polygon TWICE{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5},
                    {-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};

}  // namespace

TEST(LassoRegion, isTrueOfThePointsOfTriangles)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::array<int, 3> said{};
  int shown = 0;
  for (int i = 0; i < 6000; ++i) {
    const Matrix camera = anyCamera(random);
    const double size = std::pow(10.0, any(random) - 1.0);
    for (const Polygon& outline : outlines(0.5 * any(random), 0.5 * any(random), size, random)) {
      const LassoRegion lasso(outline, camera);
      const Triangle triangle = anyTriangle(random);
      const Side side = check(lasso, triangle, depthIn(lasso), 1e-9);
      ++said[static_cast<std::size_t>(side)];
      for (int k = 0; k < 20; ++k) {
        const Point place{outline[0][0] + 2.0 * size * any(random),
                          outline[0][1] + 2.0 * size * any(random)};
        if (isIn(outline, place) && shows(camera, triangle, place)) {
          EXPECT_NE(side, Side::OUTSIDE);
          ++shown;
        }
      }
    }
  }
  EXPECT_GT(*std::min_element(said.begin(), said.end()), 200);
  EXPECT_GT(shown, 1000);
}

TEST(LassoRegion, saysHowTrianglesLie)
{
  struct Case
  {
    const char* name;
    Polygon polygon;
    Matrix matrix;
    Triangle triangle;
    Side side;
  };
  const Case cases[] = {
      {"within", SQUARE, DOWN, {-0.1f, -0.1f, 0, 0.1f, -0.1f, 0, 0, 0.1f, 0}, Side::INSIDE},
      {"its middle only", SQUARE, DOWN, {-9, -9, 0, 9, -9, 0, 0, 9, 0}, Side::TOUCHING},
      {"across an edge", SQUARE, DOWN, {0, 0, 0, 1, 0, 0, 0, 0.1f, 0}, Side::TOUCHING},
      {"a strip across", SQUARE, DOWN, {-2, 0, 0, 2, 0, 0, 2, 0.1f, 0}, Side::TOUCHING},
      {"beside", SQUARE, DOWN, {0.6f, 0, 0, 0.9f, 0, 0, 0.7f, 0.1f, 0}, Side::OUTSIDE},
      {"behind the camera", SQUARE, DOWN, {-9, -9, 11, 9, -9, 11, 0, 9, 11}, Side::OUTSIDE},
      {"before the near plane",
       SQUARE,
       DOWN,
       {-9, -9, 9.5f, 9, -9, 9.5f, 0, 9, 9.5f},
       Side::OUTSIDE},
      {"beyond the far plane", SQUARE, DOWN, {-9, -9, -91, 9, -9, -91, 0, 9, -91}, Side::OUTSIDE},
      {"through the near plane", SQUARE, DOWN, {0, 0, 0, 0.01f, 0, 0, 0, 0, 20}, Side::TOUCHING},
      {"past the camera, beside",
       SQUARE,
       DOWN,
       {1, 0, -20, 1.1f, 0, -20, 1, 0, 20},
       Side::TOUCHING},
      {"past the camera, far beside",
       SQUARE,
       DOWN,
       {9, 0, -20, 9.1f, 0, -20, 9, 0, 20},
       Side::OUTSIDE},
      {"in the gap", HORSESHOE, FLAT, {-0.1f, 0, 0, 0.1f, 0, 0, 0, 0.4f, 0}, Side::OUTSIDE},
      {"over the gap", HORSESHOE, FLAT, {-0.4f, 0, 0, 0.4f, 0, 0, 0, 0.1f, 0}, Side::TOUCHING},
      {"in an arm", HORSESHOE, FLAT, {-0.4f, 0, 0, -0.3f, 0, 0, -0.4f, 0.4f, 0}, Side::INSIDE},
      {"in a bow", BOW, FLAT, {0.4f, 0, 0, 0.3f, 0.1f, 0, 0.3f, -0.1f, 0}, Side::INSIDE},
      {"above the knot", BOW, FLAT, {-0.1f, 0.4f, 0, 0.1f, 0.4f, 0, 0, 0.2f, 0}, Side::OUTSIDE},
      {"the knot", BOW, FLAT, {-0.1f, -0.3f, 0, 0.1f, -0.3f, 0, 0, 0.1f, 0}, Side::TOUCHING},
      {"in twice, so out", TWICE, FLAT, {0, 0, 0, 0.1f, 0, 0, 0, 0.1f, 0}, Side::OUTSIDE},
      {"on the border of twice", TWICE, FLAT, {0, 0, 0, 0.7f, 0, 0, 0, 0.1f, 0}, Side::TOUCHING},
      {"from border to border",
       SQUARE,
       FLAT,
       {-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0.5f, 0.5f, 0},
       Side::INSIDE},
      {"a corner on the border", SQUARE, FLAT, {0.5f, 0, 0, 1, 0, 0, 1, 1, 0}, Side::TOUCHING},
      {"along the border, outside",
       SQUARE,
       FLAT,
       {0.5f, -1, 0, 0.5f, 1, 0, 1, 0, 0},
       Side::TOUCHING},
      {"a corner on a corner", SQUARE, FLAT, {0.5f, 0.5f, 0, 1, 1, 0, 0.5f, 1, 0}, Side::TOUCHING},
      {"on the near plane", SQUARE, FLAT, {0, 0, 5, 0.1f, 0, 5, 0, 0.1f, 5}, Side::INSIDE},
      {"through the far plane", SQUARE, FLAT, {0, 0, -6, 0.1f, 0, -6, 0, 0.1f, 0}, Side::TOUCHING},
      {"edge on", SQUARE, FLAT, {0, 0, 1, 0.1f, 0, 0, 0.2f, 0, -3}, Side::INSIDE},
      {"edge on, through", SQUARE, FLAT, {-1, 0, 1, 0.1f, 0, 0, 1, 0, -3}, Side::TOUCHING},
      {"edge on, seen as a point", SQUARE, FLAT, {0, 0, 1, 0, 0, 0, 0, 0, -3}, Side::INSIDE},
      {"a segment across the border", SQUARE, FLAT, {0, 0, 0, 0, 0, 0, 1, 0, 0}, Side::TOUCHING},
      {"a segment over the square", SQUARE, FLAT, {-1, 0, 0, -1, 0, 0, 1, 0, 0}, Side::TOUCHING},
      {"a segment over the gap",
       HORSESHOE,
       FLAT,
       {-0.4f, 0, 0, -0.4f, 0, 0, 0.4f, 0, 0},
       Side::TOUCHING},
      {"a point", SQUARE, FLAT, {0.1f, 0, 0, 0.1f, 0, 0, 0.1f, 0, 0}, Side::INSIDE},
      {"a point beside", SQUARE, FLAT, {0.6f, 0, 0, 0.6f, 0, 0, 0.6f, 0, 0}, Side::OUTSIDE},
  };
  for (const Case& one : cases) {
    const LassoRegion lasso(one.polygon, one.matrix);
    EXPECT_EQ(lasso.triangle(one.triangle.data()), one.side) << one.name;
    const Side box = lasso.boxInFrustum(boundsOf(one.triangle.data(), 3), false);
    EXPECT_TRUE(box == Side::TOUCHING || box == one.side) << one.name;
  }
}

TEST(LassoRegion, knowsBoxesWithoutTriangles)
{
  const LassoRegion lasso(SQUARE, DOWN);
  const auto boxAt = [](double x, double z, double half) {
    return Box{{x - half, -half, z - half}, {x + half, half, z + half}};
  };
  EXPECT_EQ(lasso.boxInFrustum(boxAt(0, 0, 0.1), true), Side::INSIDE);
  EXPECT_EQ(lasso.boxInFrustum(boxAt(0.5, 0, 0.1), false), Side::TOUCHING);
  EXPECT_EQ(lasso.boxInFrustum(boxAt(0.7, 0, 0.1), false), Side::OUTSIDE);
  EXPECT_EQ(lasso.boxInFrustum(boxAt(0, 9, 0.01), false), Side::TOUCHING);
  EXPECT_EQ(lasso.boxInFrustum(boxAt(0, 20, 5), false), Side::TOUCHING);  // behind the camera
  const LassoRegion horseshoe(HORSESHOE, FLAT);
  EXPECT_EQ(horseshoe.boxInFrustum({{-0.2, -0.2, 0}, {0.2, 0.9, 1}}, true), Side::OUTSIDE);
  EXPECT_EQ(horseshoe.boxInFrustum({{-0.4, -0.4, 0}, {0.4, -0.3, 1}}, true), Side::INSIDE);
}

TEST(LassoRegion, goesToInfinity)
{
  Matrix camera = perspective(0.1, 1.0, 100.0);
  camera[10] = -1.0;  // the far plane goes to infinity
  camera[11] = -2.0;
  const float far[] = {-1e9f, 0, -1e12f, 1e9f, 0, -1e12f, 0, 1e9f, -1e12f};
  const LassoRegion lasso(SQUARE, product(camera, viewOf({0, 0, 10}, {0, 0, 0})));
  EXPECT_EQ(lasso.triangle(far), Side::INSIDE);
  EXPECT_NE(lasso.boxInFrustum(boundsOf(far, 3), true), Side::OUTSIDE);
  EXPECT_EQ(LassoRegion(SQUARE, DOWN).triangle(far), Side::OUTSIDE);
}

TEST(LassoRegion, containsNothingIfInvalid)
{
  const float corners[] = {-9, -9, 0, 9, -9, 0, 0, 9, 0};
  const double inf = std::numeric_limits<double>::infinity();
  std::vector<LassoRegion> invalid;
  for (const double bad : {inf, -inf, std::nan(""), 2e30}) {
    invalid.emplace_back(Polygon{{-1, -1}, {1, bad}, {0, 1}}, DOWN);
  }
  for (std::size_t i = 0; i < 16; ++i) {
    Matrix matrix = DOWN;
    matrix[i] = i % 2 == 0 ? inf : std::nan("");
    invalid.emplace_back(SQUARE, matrix);
  }
  invalid.emplace_back(Polygon{{-1, -1}, {1, 1}}, DOWN);
  invalid.emplace_back(Polygon{}, DOWN);
  invalid.emplace_back(SQUARE, Matrix{});
  for (const LassoRegion& lasso : invalid) {
    EXPECT_FALSE(lasso.valid());
    EXPECT_EQ(lasso.triangle(corners), Side::OUTSIDE);
    EXPECT_EQ(lasso.boxInFrustum(boundsOf(corners, 3), true), Side::OUTSIDE);
    EXPECT_FALSE(lasso.contains({0, 0, 0}));
    EXPECT_FALSE(lasso.polygonContains({0, 0}));
  }
  Matrix negative = DOWN;  // w < 0 before the camera: OpenGL shows nothing of it
  for (double& entry : negative) {
    entry = -entry;
  }
  EXPECT_EQ(LassoRegion(SQUARE, negative).triangle(corners), Side::OUTSIDE);
}
