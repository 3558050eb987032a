#include "measurement/measurement_list.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "measured_meshes.h"

using namespace measured_meshes;
using rviz_mesh_plugin::Measurement;
using rviz_mesh_plugin::MeasurementKind;
using rviz_mesh_plugin::MeasurementList;
using rviz_mesh_plugin::MeshDataConstPtr;

namespace {

/// Level, but for one vertex, which is neither of the bounds nor of a face at x = -0.9 or 0.9.
MeshDataConstPtr shown(double height)
{
  return std::make_shared<MeshData>(terrain(10, [&](double x, double y) {
    return x > 0.9 && y > 0.9 ? 1.0 : std::abs(x) < 0.05 && std::abs(y) < 0.05 ? height : 0.0;
  }));
}

}  // namespace

TEST(MeasurementList, of_a_mesh_that_is_another_one_between_the_points_are_stale)
{
  MeasurementList list([] {});
  MeshDataConstPtr mesh = shown(0.25);
  const auto work = [&] { list.work([&](const std::string&) { return std::vector{mesh}; }); };
  list.add(MeasurementKind::PROFILE, mesh, "map", "display",
           {pointAt(*mesh, -0.9, 0.05), pointAt(*mesh, 0.9, 0.05)});
  const Measurement& measurement = list.all()[0];
  for (int i = 0; i < 1000 && measurement.state == Measurement::WAITING; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    work();
  }
  ASSERT_EQ(measurement.state, Measurement::DONE) << measurement.error;
  EXPECT_FALSE(measurement.stale);
  for (int i = 0; i < 2; ++i) {
    mesh = shown(0.5);
    work();
    EXPECT_TRUE(measurement.stale);
    mesh = shown(0.25);
    work();
    EXPECT_FALSE(measurement.stale) << "the same, made anew";
    EXPECT_EQ(measurement.mesh.lock(), mesh);
  }
}
