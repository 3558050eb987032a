// Paths down a potential: straight on planes; on any mesh, with any labels, they arrive or end.

#include "field_checks.h"

namespace mesh_map {
namespace {

TraceEnd trace(const FieldSample& sample, const FacePoint& start, FieldPath& path)
{
  const TraceMesh mesh = sample.trace();
  checkField(mesh, sample.field);
  return tracePath(mesh, sample.field, start.face, start.position, nullptr, path);
}

/// Distances in a plane, exact.
FieldSample planeField(double jitter, std::uint32_t goal_face, double b, double c)
{
  FieldSample sample(plane(40, jitter));
  const FacePoint goal = sample.point(goal_face, b, c);
  sample.spreadFrom(goal);
  for (std::uint32_t v = 0; v < sample.labels.size(); ++v) {
    sample.labels[v] = sample.distanceTo(v, goal);
  }
  return sample;
}

TEST(FieldTrace, IsStraightOnPlanes)
{
  const double goals[][2] = {{0.3, 0.4}, {0.3, 0.0}, {0.5, 0.5}, {0.0, 0.0}, {1.0, 0.0}};
  std::mt19937 random(2);
  for (const double jitter : {0.0, 0.24}) {
    for (const auto& goal : goals) {
      FieldSample sample = planeField(jitter, 1731, goal[0], goal[1]);
      for (unsigned i = 0; i < 200; ++i) {
        const FacePoint start =
            sample.randomPoint(random, static_cast<std::uint32_t>(random() % 3200));
        FieldPath path;
        ASSERT_EQ(trace(sample, start, path), TraceEnd::ARRIVED);
        ASSERT_NO_FATAL_FAILURE(sample.check(path, start));
        double square = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double gap = start.position[axis] - sample.field.goal[axis];
          square += gap * gap;
        }
        ASSERT_NEAR(pathLength(path), std::sqrt(square), 1e-9);
        ASSERT_NEAR(path.potentials[0], std::sqrt(square), 1e-9);
        ASSERT_EQ(path.potentials.back(), 0.0);
        ASSERT_EQ(path.potentials[0],
                  fieldValue(sample.trace(), sample.field, start.face, start.position));
      }
    }
  }
}

TEST(FieldTrace, ArrivesOnAnyMesh)
{
  std::mt19937 random(3);
  for (const double closed : {0.0, 0.1, 0.4}) {
    for (const TestMesh& mesh : frontMeshes()) {
      FieldSample sample(mesh);
      const auto faces = static_cast<std::uint32_t>(sample.sample.mesh.faceCount());
      if (closed > 0.0) {
        std::uniform_real_distribution<float> slow(0.5f, 4.0f);
        for (const std::uint8_t flag : randomMask(sample.sample.size(), closed, faces)) {
          sample.slowness.push_back(flag != 0 ? FAR : slow(random));
        }
      }
      for (unsigned i = 0; i < 60; ++i) {
        if (i % 10 == 0) {
          sample.spreadFrom(
              sample.randomPoint(random, static_cast<std::uint32_t>(random() % faces)));
        }
        const FacePoint start =
            sample.randomPoint(random, static_cast<std::uint32_t>(random() % faces));
        bool is_reached = false;
        for (std::size_t k = 0; k < 3; ++k) {
          is_reached = is_reached || std::isfinite(sample.labels[sample.corner(start.face, k)]);
        }
        FieldPath path;
        ASSERT_EQ(trace(sample, start, path) == TraceEnd::ARRIVED, is_reached)
            << mesh.name << " " << closed << " " << i;
        if (is_reached) {
          ASSERT_NO_FATAL_FAILURE(sample.check(path, start)) << mesh.name << " " << closed;
        }
      }
    }
  }
}

TEST(FieldTrace, EndsAtTheVertexThatTheFrontCameFrom)
{
  FieldSample sample(terrain(30));
  sample.spread({{7, 0.25}, {800, 0.0}, {500, 90.0}});
  std::mt19937 random(4);
  std::size_t ends[2] = {};
  for (unsigned i = 0; i < 200; ++i) {
    const FacePoint start = sample.randomPoint(random, static_cast<std::uint32_t>(random() % 1800));
    FieldPath path;
    ASSERT_EQ(trace(sample, start, path), TraceEnd::ARRIVED);
    ASSERT_NO_FATAL_FAILURE(sample.check(path, start));
    const std::uint32_t end = path.potentials.back() == 0.0 ? 800 : 7;
    ASSERT_EQ(path.potentials.back(), sample.labels[end]);
    ++ends[end == 7];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(path.points[path.points.size() - 3 + axis],
                double{sample.sample.mesh.positions[3 * end + axis]});
    }
  }
  EXPECT_GT(ends[0], 20u);
  EXPECT_GT(ends[1], 20u);
}

/// A way that is cut off is the beginning of the whole one.
TEST(FieldTrace, EndsAfterALength)
{
  FieldSample sample(terrain(30));
  std::mt19937 random(6);
  for (unsigned i = 0; i < 300; ++i) {
    if (i % 50 == 0) {
      sample.spreadFrom(sample.randomPoint(random, static_cast<std::uint32_t>(random() % 1800)));
    }
    const FacePoint start = sample.randomPoint(random, static_cast<std::uint32_t>(random() % 1800));
    FieldPath whole;
    ASSERT_EQ(trace(sample, start, whole), TraceEnd::ARRIVED);
    const double length = pathLength(whole);
    for (const double share : {0.0, 0.01, 0.3, 0.9, 1.0, 2.0}) {
      FieldPath part;
      ASSERT_EQ(tracePath(sample.trace(), sample.field, start.face, start.position, nullptr, part,
                          share * length),
                TraceEnd::ARRIVED);
      ASSERT_NEAR(pathLength(part), std::min(share, 1.0) * length, 1e-9 * length);
      const std::size_t count = part.potentials.size();
      ASSERT_EQ(part.points.size(), 3 * count);
      ASSERT_EQ(part.faces.size(), count - 1);
      ASSERT_LE(count, whole.potentials.size());
      for (std::size_t k = 0; k + 1 < count; ++k) {
        ASSERT_EQ(part.faces[k], whole.faces[k]);
        ASSERT_EQ(part.potentials[k], whole.potentials[k]);
        ASSERT_TRUE(std::equal(&part.points[3 * k], &part.points[3 * k] + 3, &whole.points[3 * k]));
        ASSERT_LT(part.potentials[k + 1], part.potentials[k]);
      }
      ASSERT_GE(part.potentials.back(), whole.potentials[count - 1]);
    }
  }
  const FacePoint start = sample.point(0, 0.2, 0.2);
  FieldPath path;
  for (const double wrong : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(tracePath(sample.trace(), sample.field, 0, start.position, nullptr, path, wrong),
                 std::invalid_argument);
  }
}

/// Fronts may leave a label that is a little lower than what the faces around it say.
TEST(FieldTrace, DoesNotEndWhereALabelIsALittleLow)
{
  FieldSample sample(plane(40, 0.2));
  const FacePoint goal = sample.point(1731, 0.0, 0.0);
  const std::uint32_t end = sample.corner(1731, 0);
  for (std::uint32_t v = 0; v < sample.sample.size(); ++v) {
    sample.labels.push_back(sample.distanceTo(v, goal));
  }
  sample.use();
  for (std::uint32_t face = 0; face < 3200; face += 37) {
    const std::uint32_t v = sample.corner(face, 0);
    const double before = sample.labels[v];
    sample.labels[v] = before * 0.999;
    FieldPath path;
    ASSERT_EQ(trace(sample, sample.point(face, 0.0, 0.0), path), TraceEnd::ARRIVED);
    sample.labels[v] = before;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(path.points[path.points.size() - 3 + axis],
                double{sample.sample.mesh.positions[3 * end + axis]})
          << face;
    }
  }
}

/// Labels that no front would leave: there may be no way, but there is an end.
TEST(FieldTrace, EndsWithAnyLabels)
{
  std::mt19937 random(5);
  const double wild[] = {-1.0,
                         0.0,
                         1e-300,
                         1e300,
                         std::numeric_limits<double>::quiet_NaN(),
                         std::numeric_limits<double>::infinity()};
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (const TestMesh& mesh : {terrain(20), tangle(60, 300, 1), slivers(), cube(4)}) {
    FieldSample sample(mesh);
    const auto faces = static_cast<std::uint32_t>(sample.sample.mesh.faceCount());
    for (unsigned i = 0; i < 300; ++i) {
      sample.spreadFrom(sample.randomPoint(random, static_cast<std::uint32_t>(random() % faces)));
      if (i % 2 == 0) {
        sample.field.goal_face = NO_INDEX;
      }
      for (double& label : sample.labels) {
        const unsigned choice = static_cast<unsigned>(random() % 40);
        label = choice < 6 && i % 3 == 0 ? wild[choice]
                : i % 3 == 1             ? any(random)
                                         : label * any(random);
      }
      const FacePoint start =
          sample.randomPoint(random, static_cast<std::uint32_t>(random() % faces));
      FieldPath path;
      if (trace(sample, start, path) == TraceEnd::ARRIVED) {
        ASSERT_NO_FATAL_FAILURE(sample.check(path, start, true)) << mesh.name;
      }
    }
  }
}

TEST(FieldTrace, WithoutSlownessEverythingIsAsFar)
{
  FieldSample sample(terrain(20));
  std::mt19937 random(6);
  sample.slowness.assign(sample.sample.size(), 0.0f);
  sample.spreadFrom(sample.point(400, 0.2, 0.3));
  for (unsigned i = 0; i < 50; ++i) {
    const FacePoint start = sample.randomPoint(random, static_cast<std::uint32_t>(random() % 800));
    FieldPath path;
    ASSERT_EQ(trace(sample, start, path), TraceEnd::ARRIVED);
    EXPECT_EQ(path.potentials.front(), 0.0);
    EXPECT_EQ(path.points.back(), sample.field.goal[2]);
  }
}

TEST(FieldTrace, OfOnePointAtTheGoal)
{
  FieldSample sample = planeField(0.2, 900, 0.3, 0.3);
  FieldPath path;
  ASSERT_EQ(trace(sample, {900, sample.field.goal}, path), TraceEnd::ARRIVED);
  EXPECT_EQ(path.points.size(), 3u);
  EXPECT_TRUE(path.faces.empty());
  EXPECT_EQ(path.potentials, std::vector<double>{0.0});
  const FacePoint start = sample.point(900, 0.5, 0.1);
  ASSERT_EQ(trace(sample, start, path), TraceEnd::ARRIVED);
  EXPECT_EQ(path.faces, std::vector<std::uint32_t>{900});
  ASSERT_NO_FATAL_FAILURE(sample.check(path, start));
}

TEST(FieldTrace, GoesThroughVerticesAndAlongEdges)
{
  // From corner to corner of a regular grid: its diagonals are edges of one half only.
  FieldSample sample(terrain(8, 8.0f));
  for (std::size_t v = 0; v < sample.sample.size(); ++v) {
    sample.sample.mesh.positions[3 * v + 2] = 0.0f;
  }
  const FacePoint corners[] = {sample.point(0, 0.0, 0.0), sample.point(127, 0.0, 1.0),
                               sample.point(14, 0.0, 1.0), sample.point(113, 1.0, 0.0)};
  for (const FacePoint& goal : corners) {
    sample.spreadFrom(goal);
    for (std::uint32_t v = 0; v < sample.labels.size(); ++v) {
      sample.labels[v] = sample.distanceTo(v, goal);
    }
    for (const FacePoint& start : corners) {
      FieldPath path;
      ASSERT_EQ(trace(sample, start, path), TraceEnd::ARRIVED);
      ASSERT_NO_FATAL_FAILURE(sample.check(path, start));
      EXPECT_NEAR(
          pathLength(path),
          std::hypot(start.position[0] - goal.position[0], start.position[1] - goal.position[1]),
          1e-12);
    }
  }
}

TEST(FieldTrace, DirectionsAreUnitVectorsOrZero)
{
  for (const double closed : {0.0, 0.2}) {
    for (const TestMesh& mesh : frontMeshes()) {
      FieldSample sample(mesh);
      for (const std::uint8_t flag : randomMask(sample.sample.size(), closed, 7)) {
        sample.slowness.push_back(flag != 0 ? FAR : 2.0f);
      }
      sample.spreadFrom(sample.point(0, 0.3, 0.3));
      std::vector<float> normals(sample.sample.mesh.positions.size());
      for (std::size_t v = 0; v < sample.sample.size(); ++v) {
        normals[3 * v + 2] = 1.0f;
      }
      const LargeArray<float> at_vertices =
          vertexDirections(sample.trace(), *sample.sample.front, sample.field, normals, 2);
      const LargeArray<float> at_faces = faceDirections(sample.trace(), sample.field, 2);
      ASSERT_EQ(at_vertices.size(), normals.size());
      ASSERT_EQ(at_faces.size(), sample.sample.mesh.faces.size());
      std::size_t units = 0;
      for (const LargeArray<float>* const directions : {&at_vertices, &at_faces}) {
        for (std::size_t i = 0; i < directions->size(); i += 3) {
          const float* const d = directions->data() + i;
          const double length = std::sqrt(double{d[0]} * d[0] + d[1] * d[1] + d[2] * d[2]);
          ASSERT_TRUE(length == 0.0 || std::abs(length - 1.0) < 1e-6) << mesh.name;
          units += length > 0.0;
          if (directions == &at_vertices) {
            ASSERT_LT(std::abs(d[2]), 1e-6) << mesh.name;
            ASSERT_TRUE(length == 0.0 || std::isfinite(sample.labels[i / 3])) << mesh.name;
          }
        }
      }
      EXPECT_TRUE(units > 0 || !sample.isFaceOpen(0) || sample.longestSide(0) == 0.0) << mesh.name;
    }
  }
}

TEST(FieldTrace, IsCancelled)
{
  FieldSample sample = planeField(0.2, 900, 0.3, 0.3);
  const FacePoint start = sample.point(20, 0.3, 0.3);
  const std::atomic<bool> cancel{true};
  FieldPath path;
  EXPECT_EQ(tracePath(sample.trace(), sample.field, start.face, start.position, &cancel, path),
            TraceEnd::CANCELED);
}

TEST(FieldTrace, RefusesWhatIsNotOnTheMesh)
{
  FieldSample sample = planeField(0.2, 900, 0.3, 0.3);
  FieldPath path;
  FacePoint start = sample.point(20, 0.3, 0.3);
  start.position[2] += 0.01;
  EXPECT_THROW(trace(sample, start, path), std::invalid_argument);
  start.position[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(trace(sample, start, path), std::invalid_argument);
  start = sample.point(20, 0.3, 0.3);
  sample.field.goal[0] += 0.5;
  EXPECT_THROW(trace(sample, start, path), std::invalid_argument);
  sample.field.goal_face = 3200;
  EXPECT_THROW(trace(sample, start, path), std::invalid_argument);
  sample.field.goal_face = NO_INDEX;
  sample.labels.pop_back();
  sample.use();
  EXPECT_THROW(trace(sample, start, path), std::invalid_argument);
}

}  // namespace
}  // namespace mesh_map
