#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace rviz_mesh_plugin {

/// A block has at most so many faces.
constexpr std::size_t BLOCK_FACES = 128;

/// Cuts faces that are ordered in space into blocks. They end where the next face is many times as
/// far as usual, too: a block that leaps would make the box of its part large.
/// @param position of a face by its place
/// @param ends_before whether a block has to end before a face, by its place
/// @return the first face of each block, and the end
template <class Position, class EndsBefore>
std::vector<std::size_t> cutIntoBlocks(std::size_t count, const Position& position,
                                       const EndsBefore& ends_before)
{
  constexpr float LEAP = 16.0f;
  constexpr std::size_t SAMPLES = 20000;
  const auto squared_step = [&](std::size_t face) {
    const std::array<float, 3>&a = position(face - 1), &b = position(face);
    const float x = a[0] - b[0];
    const float y = a[1] - b[1];
    const float z = a[2] - b[2];
    return x * x + y * y + z * z;
  };
  std::vector<float> steps;
  for (std::size_t face = 1; face < count; face += std::max<std::size_t>(1, count / SAMPLES)) {
    steps.push_back(squared_step(face));
  }
  const auto usual = steps.begin() + steps.size() / 2;
  std::nth_element(steps.begin(), usual, steps.end());
  const float far = steps.empty() ? 0.0f : LEAP * LEAP * *usual;
  std::vector<std::size_t> begins;
  for (std::size_t face = 0; face < count; ++face) {
    if (face == 0 || face - begins.back() == BLOCK_FACES || ends_before(face) ||
        squared_step(face) > far) {
      begins.push_back(face);
    }
  }
  begins.push_back(count);
  return begins;
}

}  // namespace rviz_mesh_plugin
