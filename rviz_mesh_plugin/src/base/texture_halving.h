#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The side of an image of half the size.
constexpr std::uint32_t halfOf(std::uint32_t side)
{
  return std::max(side / 2, 1u);
}

/// Appends the means of each two by two pixels. A side of one pixel stays; of an odd side the last
/// pixel is left out.
/// @param rows, count all of an image, or an even number of them
inline void appendHalved(const Rgba8* rows, std::uint32_t count, std::uint32_t width,
                         std::uint32_t height, std::vector<Rgba8>& halved)
{
  const std::size_t right = width > 1 ? 1 : 0;
  const std::size_t below = height > 1 ? width : 0;
  const std::uint32_t row_count = height > 1 ? count / 2 : 1;
  halved.reserve(std::size_t{halfOf(width)} * halfOf(height));
  for (std::uint32_t row = 0; row < row_count; ++row) {
    const Rgba8* p = rows + std::size_t{2} * row * width;
    for (std::uint32_t column = 0; column < halfOf(width); ++column, p += 2) {
      const auto mean = [&](std::uint8_t Rgba8::*channel) {
        const int sum =
            p->*channel + p[right].*channel + p[below].*channel + p[below + right].*channel;
        return static_cast<std::uint8_t>((sum + 2) / 4);
      };
      halved.push_back(
          {mean(&Rgba8::red), mean(&Rgba8::green), mean(&Rgba8::blue), mean(&Rgba8::alpha)});
    }
  }
}

}  // namespace rviz_mesh_plugin
