#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/selection/bvh_selection.h>

#include <gtest/gtest.h>

#include "core/support/ray_hits.h"
#include "regions.h"

using namespace mesh_map;

namespace {

using Faces = std::vector<std::uint32_t>;

const SphereRegion EVERYWHERE({0, 0, 0}, 1e9);

/// Adds a square of 2 n^2 faces in the plane across an axis.
void addSquare(TestMesh& mesh, std::size_t axis, float at, float from, float to, unsigned n)
{
  const auto base = static_cast<unsigned>(mesh.positions.size() / 3);
  for (unsigned i = 0; i <= n; ++i) {
    for (unsigned j = 0; j <= n; ++j) {
      float p[3];
      p[axis] = at;
      p[(axis + 1) % 3] = from + (to - from) * static_cast<float>(i) / static_cast<float>(n);
      p[(axis + 2) % 3] = from + (to - from) * static_cast<float>(j) / static_cast<float>(n);
      mesh.positions.insert(mesh.positions.end(), p, p + 3);
    }
  }
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j < n; ++j) {
      const unsigned v = base + i * (n + 1) + j, w = v + n + 1;
      mesh.faces.insert(mesh.faces.end(), {v, w, v + 1, v + 1, w, w + 1});
    }
  }
}

Faces range(std::uint32_t begin, std::uint32_t end)
{
  Faces faces;
  for (std::uint32_t face = begin; face < end; ++face) {
    faces.push_back(face);
  }
  return faces;
}

/// castRay() for each ray by looking at every face, and how often that was asked for.
struct SlowCast
{
  const TestMesh& mesh;
  std::size_t calls = 0, rays = 0;

  RayHits operator()(const RayBatch& batch)
  {
    ++calls;
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
      rays += test.valid() ? 1 : 0;
      hits.faces.push_back(best.face);
      hits.distances.push_back(best.distance);
      hits.barycentric.insert(hits.barycentric.end(), best.barycentric.begin(),
                              best.barycentric.end());
    }
    return hits;
  }
};

Faces seen(const TestMesh& mesh, const Region& region, const Faces& faces, const Vector& eye)
{
  SlowCast cast{mesh};
  return seenFaces(Bvh::build(mesh.view()), region, faces, eye, std::ref(cast));
}

/// The definition: one sample after the other, against one face after the other.
bool isSeen(const TestMesh& mesh, const Region& region, std::uint32_t face, const Vector& eye)
{
  const std::vector<float> corners = mesh.corners(face);
  std::vector<Vector> samples;
  for (std::size_t k = 0; k < 4; ++k) {
    Vector sample;
    for (std::size_t i = 0; i < 3; ++i) {
      const double sum = double{corners[i]} + corners[3 + i] + corners[6 + i];
      sample[i] = k == 3 ? sum / 3.0 : (sum + 3.0 * corners[3 * k + i]) / 6.0;
    }
    if (region.contains(sample)) {
      samples.push_back(sample);
    }
  }
  if (samples.empty()) {
    samples.push_back(region.witness(corners.data()));
  }
  return std::any_of(samples.begin(), samples.end(), [&](const Vector& sample) {
    const Vector way{sample[0] - eye[0], sample[1] - eye[1], sample[2] - eye[2]};
    const double distance = std::sqrt(dot(way, way));
    const double near =
        1e-9 * distance +
        std::max({std::abs(sample[0]), std::abs(sample[1]), std::abs(sample[2])}) / 8388608.0;
    const RayTest ray({eye, way, std::numeric_limits<double>::infinity()});
    double nearest = distance - near;
    const bool at_eye = nearest <= 0.0;
    std::uint32_t first = NO_INDEX;
    for (std::size_t other = 0; other < mesh.faceCount() && !at_eye; ++other) {
      const RayHit hit = hitOf(ray, mesh.corners(other).data());
      if (hit.face != NO_INDEX &&
          (first == NO_INDEX ? hit.distance <= nearest : hit.distance < nearest)) {
        nearest = hit.distance;
        first = static_cast<std::uint32_t>(other);
      }
    }
    return first == NO_INDEX || first == face ||
           closestPointOnTriangle(mesh.corner(first, 0), mesh.corner(first, 1),
                                  mesh.corner(first, 2), sample.data())
                   .distance <= near;
  });
}

}  // namespace

TEST(SeenFaces, areNotHiddenByAWall)
{
  TestMesh mesh{"wall", {}, {}};
  addSquare(mesh, 0, 1.0f, -1.0f, 1.0f, 6);  // faces 0 to 71
  addSquare(mesh, 0, 2.0f, -1.0f, 1.0f, 6);  // as large, behind it: hidden
  addSquare(mesh, 0, 3.0f, 7.0f, 8.0f, 2);   // beside it
  const Vector eye{0, 0, 0};
  Faces expected = range(0, 72);
  const Faces beside = range(144, 152);
  expected.insert(expected.end(), beside.begin(), beside.end());
  EXPECT_EQ(seen(mesh, EVERYWHERE, range(0, 152), eye), expected);
  EXPECT_EQ(seen(mesh, EVERYWHERE, range(72, 144), eye), Faces());
  EXPECT_EQ(seen(mesh, EVERYWHERE, range(72, 144), {9, 0, 0}), range(72, 144));
  EXPECT_EQ(seen(mesh, EVERYWHERE, {}, eye), Faces());
}

TEST(SeenFaces, ofTwoStoreysAreThoseAbove)
{
  TestMesh mesh{"storeys", {}, {}};
  addSquare(mesh, 2, 0.0f, 0.0f, 10.0f, 10);
  addSquare(mesh, 2, 3.0f, 0.0f, 10.0f, 10);
  const Bvh bvh = Bvh::build(mesh.view());
  const SphereRegion brush({5, 5, 1.5}, 3.0);
  const Faces selected = selectFaces(bvh, brush);
  EXPECT_GT(selected.size(), 100u);
  const Faces above = seen(mesh, brush, selected, {5, 5, 20});
  EXPECT_FALSE(above.empty());
  EXPECT_GE(above.front(), 200u);
  const Faces below = seen(mesh, brush, selected, {5, 5, -20});
  EXPECT_FALSE(below.empty());
  EXPECT_LT(below.back(), 200u);
  const Faces between = seen(mesh, brush, selected, {5, 5, 1.5});
  EXPECT_EQ(between, selected);
}

TEST(SeenFaces, areSeenThroughFacesThatTouchThem)
{
  EXPECT_EQ(seen(identical(50), EVERYWHERE, range(0, 50), {0.2, 0.2, 3}), range(0, 50));
  TestMesh mesh{"label on a wall", {}, {}};
  addSquare(mesh, 0, 1.0f, -1.0f, 1.0f, 2);
  addSquare(mesh, 0, 1.0f, -0.7f, 0.9f, 3);  // in the same plane
  EXPECT_EQ(seen(mesh, EVERYWHERE, range(0, 26), {0, 0, 0}), range(0, 26));
  TestMesh far = terrain(10, 10.0f, 1e6f);
  for (std::size_t i = 2; i < far.positions.size(); i += 3) {
    far.positions[i] = 1e6f + 0.25f * std::round(4.0f * std::sin(far.positions[i - 1]));
  }
  EXPECT_EQ(seen(far, EVERYWHERE, range(0, 200), {1e6 + 5, 1e6 + 5, 1e6 + 900}), range(0, 200));
}

TEST(SeenFaces, areSeenInTheRegionAlone)
{
  // A large triangle, half of it behind a wall; the region is about a part of it.
  TestMesh mesh{"large", {5, -9, -9, 5, 9, -9, 5, 0, 9}, {0, 1, 2}};
  addSquare(mesh, 0, 1.0f, -1.0f, 1.0f, 4);  // hides it all, since the eye is near
  const Vector eye{0, 0, 0};
  EXPECT_EQ(seen(mesh, EVERYWHERE, {0}, eye), Faces{0});  // its corners are seen past the wall
  EXPECT_EQ(seen(mesh, SphereRegion({5, 0, 0}, 0.5), {0}, eye), Faces());
  EXPECT_EQ(seen(mesh, SphereRegion({5, 7, -8}, 0.5), {0}, eye), Faces{0});
}

TEST(SeenFaces, areThoseOfTheDefinition)
{
  std::size_t some = 0;
  for (const TestMesh& mesh : {terrain(5), soup(80), cube(2), slivers(), identical(20),
                               withGiant(soup(80)), terrain(8, 10.0f, 1e6f)}) {
    const Bvh bvh = Bvh::build(mesh.view());
    std::vector<NamedRegion> regions = regionsFor(mesh, 5, 1);
    for (const NamedRegion& named : regions) {
      const Faces selected = selectFaces(bvh, *named.region);
      if (selected.empty()) {
        continue;
      }
      const Vector corner{mesh.positions[0], mesh.positions[1], mesh.positions[2]};
      for (const Vector& eye : {Vector{corner[0] + 1, corner[1] + 2, corner[2] + 3}, corner}) {
        SlowCast cast{mesh};
        const Faces found = seenFaces(bvh, *named.region, selected, eye, std::ref(cast));
        Faces expected;
        for (const std::uint32_t face : selected) {
          if (isSeen(mesh, *named.region, face, eye)) {
            expected.push_back(face);
          }
        }
        ASSERT_EQ(found, expected) << mesh.name << ", " << named.name;
        ASSERT_TRUE(std::includes(selected.begin(), selected.end(), found.begin(), found.end()));
        EXPECT_LE(cast.calls, 2u);
        EXPECT_LE(cast.rays, 4 * selected.size());
        some += found.empty() || found.size() == selected.size() ? 0 : 1;
      }
    }
  }
  EXPECT_GT(some, 30u);
}

TEST(SeenFaces, areNoneFromNowhere)
{
  const TestMesh mesh = terrain(5);
  for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_EQ(seen(mesh, EVERYWHERE, range(0, 50), {0, bad, 0}), Faces());
  }
  EXPECT_EQ(seen(mesh, EVERYWHERE, range(0, 50), {1e300, 0, 0}).size(), 50u);
}

TEST(SeenFaces, passOnThatTheyAreCanceled)
{
  const TestMesh mesh = terrain(5);
  const RayCast canceled = [](const RayBatch&) -> RayHits { throw Canceled(); };
  EXPECT_THROW(seenFaces(Bvh::build(mesh.view()), EVERYWHERE, range(0, 50), {0, 0, 9}, canceled),
               Canceled);
}
