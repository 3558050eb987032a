#include <mesh_map/bvh/selection/bvh_selection.h>

#include <gtest/gtest.h>

#include <set>

#include "core/support/ray_hits.h"
#include "regions.h"

using namespace mesh_map;

namespace {

using Faces = std::vector<std::uint32_t>;
using Point = LassoRegion::Point;

const Vector EYE{4, -3, 9};
const Matrix CAMERA = product(perspective(0.4, 0.1, 50.0), viewOf(EYE, {5, 5, 0}));

RayBatch batchOf(const PixelRays& rays)
{
  return {rays.origins, rays.directions, {}};
}

RayHits castSlowly(const TestMesh& mesh, const RayBatch& batch)
{
  RayHits hits;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const RayTest test(batch[i]);
    RayHit best;
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
      const RayHit hit = hitOf(test, mesh.corners(face).data());
      if (hit.face != NO_INDEX && hit.distance < best.distance) {
        best = hit;
        best.face = static_cast<std::uint32_t>(face);
      }
    }
    hits.faces.push_back(best.face);
    hits.distances.push_back(best.distance);
    hits.barycentric.insert(hits.barycentric.end(), best.barycentric.begin(),
                            best.barycentric.end());
  }
  return hits;
}

/// Where a ray goes in the picture.
Point placeOf(const Matrix& camera, const Ray& ray, double along)
{
  double clip[4];
  for (std::size_t i = 0; i < 4; ++i) {
    clip[i] = camera[4 * i + 3];
    for (std::size_t k = 0; k < 3; ++k) {
      clip[i] += camera[4 * i + k] * (ray.origin[k] + along * ray.direction[k]);
    }
  }
  return {clip[0] / clip[3], clip[1] / clip[3]};
}

Faces brutePicture(const TestMesh& mesh, const Region& region, const RayBatch& pixels,
                   const std::vector<std::uint8_t>& mask)
{
  const RayHits hits = castSlowly(mesh, pixels);
  std::set<std::uint32_t> faces;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint32_t face = hits.faces[i];
    if (face == NO_INDEX) {
      continue;
    }
    // By the weights of its corners, unlike the library: so not on the very border of the region.
    const std::vector<float> corners = mesh.corners(face);
    Vector point{};
    for (std::size_t k = 0; k < 9; ++k) {
      point[k % 3] += hits.barycentric[3 * i + k / 3] * corners[k];
    }
    if ((mask.empty() || mask[face] != 0) && region.contains(point)) {
      faces.insert(face);
    }
  }
  return {faces.begin(), faces.end()};
}

}  // namespace

TEST(FrustumPixels, goThroughTheCentersOfCells)
{
  const ConvexRegion frustum(frustumPlanes(CAMERA));
  const PixelRays pixels = frustumPixels(frustum, EYE, 8, 5);
  ASSERT_EQ(batchOf(pixels).size(), 40u);
  for (std::size_t i = 0; i < 40; ++i) {
    const Ray ray = batchOf(pixels)[i];
    EXPECT_EQ(ray.origin, EYE);
    const Point place = placeOf(CAMERA, ray, 3.0);
    EXPECT_NEAR(place[0], -1.0 + 2.0 * (static_cast<double>(i % 8) + 0.5) / 8.0, 1e-9);
    EXPECT_NEAR(place[1], -1.0 + 2.0 * (static_cast<double>(i / 8) + 0.5) / 5.0, 1e-9);
  }
  EXPECT_EQ(batchOf(frustumPixels(frustum, EYE, 0, 5)).size(), 0u);
}

TEST(FrustumPixels, areThoseOfAPartOfAPicture)
{
  // Off the middle of the picture, as a rectangle that somebody has drawn.
  std::vector<Plane> planes = frustumPlanes(CAMERA);
  const double at[4] = {0.1, 0.7, -0.9, -0.2};  // left, right, bottom, top
  for (std::size_t i = 0; i < 4; ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    for (std::size_t k = 0; k < 4; ++k) {
      planes[i][k] = sign * (CAMERA[4 * (i / 2) + k] - at[i] * CAMERA[12 + k]);
    }
  }
  const PixelRays pixels = frustumPixels(ConvexRegion(planes), EYE, 6, 7);
  for (std::size_t i = 0; i < 42; ++i) {
    const Point place = placeOf(CAMERA, batchOf(pixels)[i], 2.0);
    EXPECT_NEAR(place[0], 0.1 + 0.6 * (static_cast<double>(i % 6) + 0.5) / 6.0, 1e-9);
    EXPECT_NEAR(place[1], -0.9 + 0.7 * (static_cast<double>(i / 6) + 0.5) / 7.0, 1e-9);
  }
}

TEST(FrustumPixels, refuseWhatIsNoPyramid)
{
  std::vector<Plane> planes = frustumPlanes(CAMERA);
  EXPECT_THROW(frustumPixels(ConvexRegion(planes), {0, 0, 0}, 8, 5), std::invalid_argument);
  EXPECT_THROW(frustumPixels(ConvexRegion(planes), {4, -3, std::nan("")}, 8, 5),
               std::invalid_argument);
  const std::vector<Plane> three(planes.begin(), planes.begin() + 3);
  EXPECT_THROW(frustumPixels(ConvexRegion(three), EYE, 8, 5), std::invalid_argument);
  std::vector<Plane> turned = planes;
  turned[1] = turned[0];
  EXPECT_THROW(frustumPixels(ConvexRegion(turned), EYE, 8, 5), std::invalid_argument);
  for (double& number : planes[2]) {
    number = -number;
  }
  EXPECT_THROW(frustumPixels(ConvexRegion(planes), EYE, 8, 5), std::invalid_argument);
  planes[2] = {std::nan(""), 0, 0, 1};
  EXPECT_THROW(frustumPixels(ConvexRegion(planes), EYE, 8, 5), std::invalid_argument);
}

TEST(LassoPixels, areThoseInThePolygon)
{
  Matrix infinite = perspective(0.4, 0.1, 50.0);
  infinite[10] = -1.0;
  infinite[11] = -0.2;
  const Matrix view = viewOf(EYE, {5, 5, 0});
  for (const Matrix& camera :
       {CAMERA, product(orthographic(5.0, 1.0, 20.0), view), product(infinite, view)}) {
    std::mt19937 random(1);
    for (const Polygon& outline : outlines(0.2, 0.1, 0.6, random)) {
      const LassoRegion lasso(outline, camera);
      const PixelRays pixels = lassoPixels(lasso, 30, 20);
      std::size_t i = 0;
      for (std::size_t pixel = 0; pixel < 600; ++pixel) {
        const Point center{-1.0 + 2.0 * (static_cast<double>(pixel % 30) + 0.5) / 30.0,
                           -1.0 + 2.0 * (static_cast<double>(pixel / 30) + 0.5) / 20.0};
        if (lasso.polygonContains(center)) {
          ASSERT_LT(i, batchOf(pixels).size());
          const Ray ray = batchOf(pixels)[i++];
          for (const double along : {0.0, 1.0}) {
            const Point place = placeOf(camera, ray, along);
            EXPECT_NEAR(place[0], center[0], 1e-9);
            EXPECT_NEAR(place[1], center[1], 1e-9);
          }
          // It begins on the near plane and goes to the far one.
          const Vector way = unit(ray.direction);
          EXPECT_LT(
              std::abs(frustumPlanes(camera)[4][0] * ray.origin[0] +
                       frustumPlanes(camera)[4][1] * ray.origin[1] +
                       frustumPlanes(camera)[4][2] * ray.origin[2] + frustumPlanes(camera)[4][3]),
              1e-9);
          EXPECT_LT(dot(way, {view[8], view[9], view[10]}), -0.5);
        }
      }
      EXPECT_EQ(i, batchOf(pixels).size());
      EXPECT_EQ(pixels.origins.size(), pixels.directions.size());
    }
  }
  EXPECT_GT(batchOf(lassoPixels(LassoRegion({{-1, -1}, {1, -1}, {0, 1}}, CAMERA), 10, 10)).size(),
            30u);
}

TEST(LassoPixels, areFoundInAHugePicture)
{
  // Pixels 10 to 12 of a million, and rows 20 to 23: looking at all would take hours.
  constexpr std::size_t SIZE = 1000000;
  const auto at = [](double pixel) { return 2.0 * pixel / SIZE - 1.0; };
  const LassoRegion lasso({{at(10), at(20)}, {at(13), at(20)}, {at(13), at(24)}, {at(10), at(24)}},
                          CAMERA);
  EXPECT_EQ(batchOf(lassoPixels(lasso, SIZE, SIZE)).size(), 12u);
  const LassoRegion beside({{-9, -9}, {-8, -9}, {-8, -8}}, CAMERA);
  EXPECT_EQ(batchOf(lassoPixels(beside, SIZE, SIZE)).size(), 0u);
}

TEST(LassoPixels, refuseAMatrixWithoutAnInverse)
{
  Matrix flat = CAMERA;
  std::copy(flat.begin(), flat.begin() + 4, flat.begin() + 4);
  const Polygon outline{{-1, -1}, {1, -1}, {0, 1}};
  EXPECT_THROW(lassoPixels(LassoRegion(outline, flat), 8, 8), std::invalid_argument);
  EXPECT_THROW(lassoPixels(LassoRegion(outline, Matrix{}), 8, 8), std::invalid_argument);
  flat[3] = std::nan("");
  EXPECT_THROW(lassoPixels(LassoRegion(outline, flat), 8, 8), std::invalid_argument);
}

TEST(FacesInPicture, areThoseOfAllPixels)
{
  std::mt19937 random(1);
  for (const TestMesh& mesh : {terrain(20), soup(300), withGiant(soup(100)), cube(4)}) {
    const Bvh bvh = Bvh::build(mesh.view());
    const RayCast cast = [&mesh](const RayBatch& batch) { return castSlowly(mesh, batch); };
    const Vector middle{mesh.corner(0, 0)[0], mesh.corner(0, 0)[1], mesh.corner(0, 0)[2]};
    const Vector eye{middle[0] + 2, middle[1] - 1, middle[2] + 5};
    const Matrix camera = product(perspective(0.4, 0.1, 50.0), viewOf(eye, middle));
    std::vector<std::uint8_t> mask(mesh.faceCount());
    for (std::uint8_t& entry : mask) {
      entry = random() % 2 == 0 ? 1 : 0;
    }
    const ConvexRegion frustum(frustumPlanes(camera));
    const PixelRays pixels = frustumPixels(frustum, eye, 24, 18);
    const SphereRegion brush({middle[0] + 0.111, middle[1], middle[2]}, 1.0);
    const LassoRegion lasso({{-0.5, -0.8}, {0.9, 0.1}, {0.3, 0.7}}, camera);
    const PixelRays outlined = lassoPixels(lasso, 24, 18);
    for (const std::vector<std::uint8_t>& some : {std::vector<std::uint8_t>(), mask}) {
      const Faces faces = facesInPicture(bvh, frustum, batchOf(pixels), some, cast);
      EXPECT_EQ(faces, brutePicture(mesh, frustum, batchOf(pixels), some)) << mesh.name;
      EXPECT_FALSE(faces.empty()) << mesh.name;
      const Faces touched = selectFaces(bvh, frustum, SelectionMode::TOUCHING, some);
      EXPECT_TRUE(std::includes(touched.begin(), touched.end(), faces.begin(), faces.end()));
      EXPECT_EQ(facesInPicture(bvh, brush, batchOf(pixels), some, cast),
                brutePicture(mesh, brush, batchOf(pixels), some))
          << mesh.name;
      EXPECT_EQ(facesInPicture(bvh, lasso, batchOf(outlined), some, cast),
                brutePicture(mesh, lasso, batchOf(outlined), some))
          << mesh.name;
    }
  }
}
