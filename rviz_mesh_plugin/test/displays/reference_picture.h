#pragma once

#include <array>
#include <cmath>
#include <vector>

#include <osmesa_harness/image.h>

/// What a flat mesh made by test_meshes::terrain() must look like from above (viewFromAbove(0, 0,
/// pixels_per_meter)), computed without OpenGL: the color of each pixel is interpolated linearly in
/// the face below its middle.
/// @param vertex_colors channels 0..1, one per vertex; RViz's background where there is no mesh
inline osmesa_harness::Image referencePicture(
    int width, int height, double pixels_per_meter, int cells,
    const std::vector<std::array<double, 3>>& vertex_colors)
{
  osmesa_harness::Image image(width, height, {48, 48, 48});
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      // In cells, from the lower left corner of the mesh.
      const double x = ((column + 0.5 - width / 2) / pixels_per_meter + 1.0) * cells / 2.0;
      const double y = ((height / 2 - row - 0.5) / pixels_per_meter + 1.0) * cells / 2.0;
      if (x < 0.0 || y < 0.0 || x >= cells || y >= cells) {
        continue;
      }
      const int cell_x = static_cast<int>(x);
      const int cell_y = static_cast<int>(y);
      const double u = x - cell_x;
      const double v = y - cell_y;
      const auto& c00 = vertex_colors[cell_y * (cells + 1) + cell_x];
      const auto& c10 = vertex_colors[cell_y * (cells + 1) + cell_x + 1];
      const auto& c01 = vertex_colors[(cell_y + 1) * (cells + 1) + cell_x];
      const auto& c11 = vertex_colors[(cell_y + 1) * (cells + 1) + cell_x + 1];
      std::array<std::uint8_t, 3> bytes;
      for (int channel = 0; channel < 3; ++channel) {
        const double value = u >= v ? c00[channel] + u * (c10[channel] - c00[channel]) +
                                          v * (c11[channel] - c10[channel])
                                    : c00[channel] + v * (c01[channel] - c00[channel]) +
                                          u * (c11[channel] - c01[channel]);
        bytes[channel] = static_cast<std::uint8_t>(std::lround(255.0 * value));
      }
      image.set(column, row, {bytes[0], bytes[1], bytes[2]});
    }
  }
  return image;
}
