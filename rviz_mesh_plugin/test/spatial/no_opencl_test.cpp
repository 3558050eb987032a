#include <gtest/gtest.h>

#include <cstdlib>

#include "query_fixture.h"

// A process of its own: the ICD loader looks for platforms once.

using query_test::Log;
using query_test::Questions;
using rviz_mesh_plugin::SpatialQueries;
using rviz_mesh_plugin::SpatialQueriesOptions;

TEST(NoOpenCl, is_one_warning_and_the_native_answers)
{
  ::setenv("OCL_ICD_VENDORS", "/nonexistent", 1);
  ::unsetenv("MESH_TOOLS_OPENCL");
  const auto bvh = query_test::waves(20);
  const Log log;
  SpatialQueriesOptions options;
  options.log = log.function();
  options.device_threshold = 0;
  const Questions questions(1000);
  const auto expected = mesh_map::castRays(*bvh, questions.rays());
  for (int i = 0; i < 3; ++i) {
    const SpatialQueries queries(bvh, options);
    EXPECT_TRUE(queries.castRays(questions.rays()) == expected);
    EXPECT_FALSE(queries.waitForDevice());
    EXPECT_TRUE(queries.castRays(questions.rays()) == expected);
  }
  ASSERT_EQ(log.warnings().size(), 1u);
  EXPECT_EQ(log.warnings()[0],
            "OpenCL: clGetPlatformIDs failed with error -1001 (no platform; Debian's "
            "pocl-opencl-icd makes a device of any processor); queries are answered natively");
  EXPECT_TRUE(log.infos().empty());
  EXPECT_EQ(mesh_map::queryCount(mesh_map::BackEnd::OPENCL, mesh_map::Query::RAY), 0u);
}
