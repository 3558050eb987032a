// The closest point through the tree is that of a loop over all faces, to the last bit.
#include "closest_checks.h"

using mesh_map::Bvh;
using mesh_map::ClosestOptions;
using mesh_map::NO_INDEX;

namespace {

class ClosestPoint : public testing::TestWithParam<TestMesh>
{
 protected:
  const TestMesh& mesh() const { return GetParam(); }
  const Bvh bvh_ = Bvh::build(GetParam().view());
};

TEST_P(ClosestPoint, IsThatOfEveryFace)
{
  for (const Point& point : pointsAround(mesh(), 15)) {
    expectSame(closestPoint(bvh_, point.data()), lookAtEveryFace(mesh(), point), text(point));
  }
}

TEST_P(ClosestPoint, WithinAMaximumDistanceThatBelongsToIt)
{
  for (const Point& point : pointsAround(mesh(), 4)) {
    const mesh_map::SurfaceHit hit = lookAtEveryFace(mesh(), point);
    for (const double limit : {0.0, 1e-3, hit.distance, std::nextafter(hit.distance, INFINITY),
                               2.0 * hit.distance, 1e300}) {
      ClosestOptions options;
      options.max_distance = limit;
      expectSame(closestPoint(bvh_, point.data(), options), lookAtEveryFace(mesh(), point, limit),
                 text(point));
    }
    ClosestOptions options;
    options.max_distance = hit.distance;
    EXPECT_EQ(closestPoint(bvh_, point.data(), options).face, hit.face);
    options.max_distance = std::nextafter(hit.distance, -1.0);
    EXPECT_EQ(closestPoint(bvh_, point.data(), options).face, NO_INDEX) << text(point);
  }
}

TEST_P(ClosestPoint, OfFacesInAMask)
{
  std::mt19937 random(2);
  for (const unsigned one_of : {1u, 2u, 50u, 100'000u}) {
    std::vector<std::uint8_t> mask(mesh().faceCount());
    for (std::uint8_t& entry : mask) {
      entry = random() % one_of == 0 ? 255 : 0;
    }
    ClosestOptions options;
    options.mask = mask;
    for (const Point& point : pointsAround(mesh(), 3)) {
      expectSame(closestPoint(bvh_, point.data(), options),
                 lookAtEveryFace(mesh(), point, INFINITY, mask), text(point));
    }
  }
}

TEST_P(ClosestPoint, OfFacesThatLookAlongANormal)
{
  std::mt19937 random(4);
  std::normal_distribution<double> any(0.0, 1.0);
  for (const double angle : {0.0, 0.05, 0.6, M_PI / 2, 3.0, M_PI, 10.0}) {
    for (const Point& point : pointsAround(mesh(), 2)) {
      Point normal = {any(random), any(random), any(random)};
      const double length = std::hypot(normal[0], normal[1], normal[2]);
      for (double& x : normal) {
        x /= length;
      }
      normal = random() % 2 == 0 ? Point{0.0, 0.0, 1.0} : normal;
      std::vector<double> scaled;
      const double scale = std::pow(2.0, static_cast<int>(random() % 1800) - 900);
      for (const double x : normal) {
        scaled.push_back(scale * x);
      }
      ClosestOptions options;
      options.max_angle = angle;
      options.normals = scaled;
      expectSame(closestPoint(bvh_, point.data(), options),
                 lookAtEveryFace(mesh(), point, INFINITY, {}, &normal, angle),
                 text(point) + " angle " + std::to_string(angle));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, ClosestPoint, testing::ValuesIn(testMeshes()));

/// A mesh, all coordinates times `scale`, and moved.
TestMesh scaled(TestMesh mesh, float scale, float offset = 0.0f)
{
  mesh.name += " times " + std::to_string(scale);
  for (float& x : mesh.positions) {
    x = x * scale + offset;
  }
  return mesh;
}

/// Two meshes as one.
TestMesh both(TestMesh first, const TestMesh& second)
{
  const auto vertices = static_cast<std::uint32_t>(first.positions.size() / 3);
  first.name += " and " + second.name;
  first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
  for (const std::uint32_t vertex : second.faces) {
    first.faces.push_back(vertices + vertex);
  }
  return first;
}

TEST(ClosestPointOfSpecialMeshes, IsThatOfEveryFace)
{
  const TestMesh point{"a point", {7, 8, 9}, {0, 0, 0, 0, 0, 0}};
  const TestMesh fine = scaled(soup(300), 0.02f, 1e4f);  // where floats are 0.001 apart
  for (const TestMesh& mesh :
       {scaled(soup(500), 1e-30f), scaled(soup(500), 1e-20f), scaled(soup(500), 1e-14f),
        scaled(soup(500), 1e16f), scaled(soup(500), 1e25f), scaled(soup(500), 1e38f), point,
        both(soup(300), fine), terrain(120), withGiant(terrain(60, 0.1f)), identical(5000)}) {
    SCOPED_TRACE(mesh.name);
    const Bvh bvh = Bvh::build(mesh.view());
    std::vector<Point> points = pointsAround(mesh, mesh.faceCount() < 1000 ? 20 : 2);
    for (const Point& at : pointsAround(mesh, 1)) {
      for (const double scale : {1e-30, 1e-20, 1e-14, 1e16, 1e25, 1e38}) {
        points.push_back({scale * at[0], scale * at[1], scale * at[2]});
      }
    }
    for (const Point& at : points) {
      expectSame(closestPoint(bvh, at.data()), lookAtEveryFace(mesh, at), text(at));
    }
  }
}

}  // namespace
