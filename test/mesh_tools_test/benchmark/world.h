// The mesh that benchmarks of RViz show, as rviz_benchmark.py writes it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace rviz_benchmark {

/// The mesh to show, and two cost layers of it.
struct World
{
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::array<float, 3> lower{};
  std::array<float, 3> upper{};

  float cost(int layer, std::size_t vertex) const
  {
    const auto& p = vertices[vertex];
    return layer == 0 ? (p[2] - lower[2]) / std::max(upper[2] - lower[2], 1e-6f)
                      : 0.5f + 0.5f * std::sin(0.7f * p[0]) * std::cos(0.7f * p[1]);
  }

  /// Blue to red.
  std::array<float, 3> color(int layer, std::size_t vertex) const
  {
    const float c = cost(layer, vertex);
    return {c, 0.2f, 1.0f - c};
  }
};

template <class T>
std::vector<T> read(const std::string& path)
{
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<T> values(file ? static_cast<std::size_t>(file.tellg()) / sizeof(T) : 0);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(T)));
  if (!file || values.empty()) {
    throw std::runtime_error(path + " cannot be read");
  }
  return values;
}

inline World readWorld(const std::string& folder)
{
  World world;
  world.vertices = read<std::array<float, 3>>(folder + "/vertices.f32");
  world.faces = read<std::array<std::uint32_t, 3>>(folder + "/faces.u32");
  world.lower = world.upper = world.vertices.front();
  for (const auto& p : world.vertices) {
    for (int k = 0; k < 3; ++k) {
      world.lower[k] = std::min(world.lower[k], p[k]);
      world.upper[k] = std::max(world.upper[k], p[k]);
    }
  }
  return world;
}

}  // namespace rviz_benchmark
