// A field of random points, restored, extracted again and again: what a sanitizer looks at. What
// the surface has to be is tested from Python.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "reconstruction/marching_cubes.h"
#include "reconstruction/signed_distance_field.h"
#include "reconstruction/surface_extraction.h"

namespace {

using namespace mesh_map;

struct Cloud
{
  std::vector<float> points, origins, intensities;
  std::vector<std::uint8_t> colors;

  MeasuredPoints measured() const { return {points, origins, colors, intensities}; }
};

/// Points of a wavy floor and, where `wild`, some that are nowhere near, or no numbers.
Cloud makeCloud(unsigned seed, bool wild)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-2, 2);
  Cloud cloud;
  for (int i = 0; i < 4000; ++i) {
    const float x = place(random), y = place(random);
    std::vector<float> point = {x, y, 0.2f * std::sin(3 * x)};
    if (wild && i % 100 == 0) {
      point[i / 100 % 3] = i % 200 == 0 ? NAN : 1e9f * place(random);
    }
    cloud.points.insert(cloud.points.end(), point.begin(), point.end());
    cloud.origins.insert(cloud.origins.end(), {0.1f * x, 0.1f * y, 1.5f});
    cloud.colors.insert(cloud.colors.end(), {10, 200, static_cast<std::uint8_t>(i)});
    cloud.intensities.push_back(i % 50 == 0 ? NAN : x);
  }
  return cloud;
}

BvhOptions threads(unsigned count)
{
  BvhOptions run;
  run.threads = count;
  return run;
}

FieldOptions options(bool carve)
{
  FieldOptions options;
  options.colors = options.intensities = true;
  options.carve = carve;
  return options;
}

TEST(SignedDistanceField, GoesOnFromItsStateWithTheSameBits)
{
  for (const bool carve : {false, true}) {
    SignedDistanceField field(options(carve));
    SurfaceExtraction extraction, other_extraction;
    field.integrate(makeCloud(1, true).measured(), threads(1));
    extraction.extract(field, 0, threads(2));
    const auto state = field.state();
    SignedDistanceField other(options(carve));
    other.restore({state.keys, state.distances, state.weights, state.observations, state.colors,
                   state.intensities, state.cell_keys, state.cell_numbers});
    field.integrate(makeCloud(2, true).measured(), threads(3));
    other.integrate(makeCloud(2, true).measured(), threads(1));
    const FieldSurface one = extraction.extract(field, 0, threads(2));
    const FieldSurface two = other_extraction.extract(other, 0, threads(1));
    EXPECT_GT(one.faces.size(), 3000u);
    EXPECT_EQ(one.vertices, two.vertices);
    EXPECT_EQ(one.faces, two.faces);
    EXPECT_EQ(one.colors, two.colors);
  }
}

TEST(SignedDistanceField, AStateOfOtherOptionsIsRefused)
{
  SignedDistanceField field(options(false));
  field.integrate(makeCloud(1, false).measured(), threads(1));
  const auto state = field.state();
  SignedDistanceField plain{FieldOptions()};
  EXPECT_THROW(
      plain.restore({state.keys, state.distances, state.weights, state.observations, state.colors,
                     state.intensities, state.cell_keys, state.cell_numbers}),
      std::invalid_argument);
  EXPECT_EQ(plain.blocks().blocks.size(), 0u);
}

TEST(SignedDistanceField, NormalsOfAStateThatAreNoneDoNoHarm)
{
  SignedDistanceField field(options(false));
  field.integrate(makeCloud(1, false).measured(), threads(1));
  auto state = field.state();
  std::fill(state.cell_numbers.begin(), state.cell_numbers.end(), 3e38f);
  field.restore({state.keys, state.distances, state.weights, state.observations, state.colors,
                 state.intensities, state.cell_keys, state.cell_numbers});
  const IntegrationCounts counts = field.integrate(makeCloud(2, false).measured(), threads(2));
  EXPECT_EQ(counts.used, 4000u);
  SurfaceExtraction extraction;
  EXPECT_GT(extraction.extract(field, 0, threads(1)).faces.size(), 3000u);
}

TEST(SignedDistanceField, ALimitIsNotPassedByMuch)
{
  FieldOptions limited;
  limited.memory_limit = 1 << 20;
  SignedDistanceField field(limited);
  EXPECT_THROW(
      {
        for (unsigned seed = 0; seed < 50; ++seed) {
          Cloud cloud = makeCloud(seed, false);
          for (float& coordinate : cloud.points) {
            coordinate *= 100;
          }
          field.integrate(cloud.measured(), threads(2));
        }
      },
      FieldMemoryError);
  SurfaceExtraction extraction;
  extraction.extract(field, 0, threads(2));
}

TEST(MarchingCubes, EveryCubeIsCutWhereItsCornersDiffer)
{
  for (unsigned inside = 0; inside < 256; ++inside) {
    const auto& triangles = cubeTriangles(static_cast<std::uint8_t>(inside));
    std::vector<int> used(12, 0);
    for (const std::uint8_t edge : triangles) {
      ASSERT_LT(edge, 12);
      ++used[edge];
    }
    for (std::uint8_t edge = 0; edge < 12; ++edge) {
      const unsigned start = edgeStart(edge), end = start | (1u << (edge / 4));
      EXPECT_EQ(((inside >> start) & 1) != ((inside >> end) & 1), used[edge] > 0);
    }
    EXPECT_EQ(cubeTriangles(static_cast<std::uint8_t>(255 - inside)).empty(), triangles.empty());
  }
}

}  // namespace
