#pragma once

#include <gtest/gtest.h>

#include <mesh_map/bvh/tree/bvh.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "spatial/opencl_program.h"
#include "spatial/spatial_queries.h"

/// What tests of queries and of OpenCL share.
namespace query_test {

/// A folder that goes with it.
class TemporaryFolder
{
 public:
  TemporaryFolder() : path_((std::filesystem::temp_directory_path() / "mesh_test_XXXXXX").string())
  {
    if (!::mkdtemp(&path_[0])) {
      throw std::runtime_error("no folder " + path_);
    }
  }
  ~TemporaryFolder()
  {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }
  std::vector<std::string> files() const
  {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) {
      if (!entry.is_directory()) {
        names.push_back(entry.path().string());
      }
    }
    return names;
  }

 private:
  std::string path_;
};

/// Lines that were logged, by any thread.
class Log
{
 public:
  rviz_mesh_plugin::LogFunction function() const
  {
    return [lines = lines_](rviz_mesh_plugin::LogLevel level, const std::string& line) {
      const std::lock_guard<std::mutex> lock(lines->mutex);
      lines->of[level == rviz_mesh_plugin::LogLevel::WARNING].push_back(line);
    };
  }
  std::vector<std::string> infos() const { return copy(0); }
  std::vector<std::string> warnings() const { return copy(1); }

 private:
  struct Lines
  {
    std::mutex mutex;
    std::vector<std::string> of[2];
  };
  std::vector<std::string> copy(int level) const
  {
    const std::lock_guard<std::mutex> lock(lines_->mutex);
    return lines_->of[level];
  }
  std::shared_ptr<Lines> lines_ = std::make_shared<Lines>();
};

using BvhPtr = std::shared_ptr<const mesh_map::Bvh>;

inline BvhPtr build(const std::vector<float>& positions, const std::vector<std::uint32_t>& faces)
{
  return std::make_shared<const mesh_map::Bvh>(mesh_map::Bvh::build({positions, faces}));
}

/// A wavy square from (0, 0) to (10, 10), of 2 cells^2 faces, moved by `offset`; below it, if
/// wanted, one triangle that is a million times larger.
inline BvhPtr waves(unsigned cells, float offset = 0.0f, bool giant = false)
{
  std::vector<float> positions;
  std::vector<std::uint32_t> faces;
  for (unsigned i = 0; i <= cells; ++i) {
    for (unsigned j = 0; j <= cells; ++j) {
      const float x = 10.0f * i / cells, y = 10.0f * j / cells;
      const float z = std::sin(2.0f * x) * std::cos(1.5f * y);
      positions.insert(positions.end(), {x + offset, y + offset, z + offset});
      if (i < cells && j < cells) {
        const unsigned a = i * (cells + 1) + j, b = a + cells + 1;
        faces.insert(faces.end(), {a, b, a + 1, a + 1, b, b + 1});
      }
    }
  }
  if (giant) {
    const auto v = static_cast<std::uint32_t>(positions.size() / 3);
    positions.insert(positions.end(), {-1e6f, -1e6f, -3, 3e6f, -1e6f, -3, -1e6f, 3e6f, -3});
    faces.insert(faces.end(), {v, v + 1, v + 2});
  }
  return build(positions, faces);
}

/// Triangles of any shape about a cube of edge 10, each one `copies` times.
inline BvhPtr soup(unsigned triangles, unsigned copies = 1)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(0.0f, 10.0f);
  std::normal_distribution<float> side(0.0f, 1.0f);
  std::vector<float> positions;
  std::vector<std::uint32_t> faces;
  for (unsigned i = 0; i < triangles; ++i) {
    const float center[3] = {place(random), place(random), place(random)};
    for (unsigned k = 0; k < 9; ++k) {
      positions.push_back(center[k % 3] + side(random));
    }
    for (unsigned copy = 0; copy < copies; ++copy) {
      faces.insert(faces.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    }
  }
  return build(positions, faces);
}

/// Origins or points about the meshes above, and directions, 3 numbers each; some of them bad.
struct Questions
{
  std::vector<double> points, directions;

  explicit Questions(std::size_t count, double offset = 0.0, bool with_bad = true)
  {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(-2.0, 12.0);
    std::normal_distribution<double> side(0.0, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
      for (unsigned k = 0; k < 3; ++k) {
        points.push_back(offset + place(random));
        directions.push_back(i % 7 == 0 ? (k == i / 7 % 3 ? -1.0 : 0.0) : side(random));
      }
    }
    const double bad[] = {std::nan(""), INFINITY, -INFINITY, 1e300, 0.0};
    for (std::size_t i = 0; with_bad && i < 5 && 20 * i < count; ++i) {
      points[60 * i] = bad[i];
      directions[60 * i + 31 % (3 * count)] = bad[i];
    }
    if (with_bad && count > 150) {
      std::fill_n(directions.begin() + 450, 3, 0.0);
    }
  }

  mesh_map::RayBatch rays() const { return {points, directions, {}}; }
};

}  // namespace query_test

namespace mesh_map {

inline bool operator==(const RayHits& a, const RayHits& b)
{
  return a.faces == b.faces && a.distances == b.distances && a.barycentric == b.barycentric;
}

}  // namespace mesh_map

namespace query_test {

/// Skips where there is no device. What PoCL compiles, which takes it long, lies in the build
/// folder for the programs and runs to come.
class DeviceTest : public testing::Test
{
 public:
  static void SetUpTestSuite()
  {
    ::setenv("POCL_CACHE_DIR", POCL_CACHE, 0);
    ::unsetenv("MESH_TOOLS_OPENCL");
  }

 protected:
  void SetUp() override
  {
    try {
      if (!rviz_mesh_plugin::listDevices().empty()) {
        return;
      }
    } catch (const cl::Error&) {
    }
    GTEST_SKIP() << "no OpenCL device; Debian's pocl-opencl-icd makes one of any processor";
  }

  /// Options that send every batch to the device.
  rviz_mesh_plugin::SpatialQueriesOptions options() const
  {
    rviz_mesh_plugin::SpatialQueriesOptions options;
    options.log = log_.function();
    options.cache_folder = cache_.path();
    options.device_threshold = 0;
    return options;
  }

  const TemporaryFolder cache_;
  const Log log_{};
};

}  // namespace query_test
