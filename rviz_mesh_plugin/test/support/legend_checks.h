#pragma once

#include <cmath>
#include <cstdint>

#include <osmesa_harness/image.h>
#include <osmesa_harness/image_compare.h>
#include <QColor>
#include <QImage>

#include "base/mesh_data.h"

/// Legends in pictures of the 3D view.
namespace legend_checks {

constexpr int DISTANCE = 8;  ///< of a legend to the border and to the next one

inline osmesa_harness::Rgb toRgb(const rviz_mesh_plugin::Rgba8& color)
{
  return {color.red, color.green, color.blue};
}

inline osmesa_harness::Rgb toRgb(QRgb color)
{
  return {static_cast<std::uint8_t>(qRed(color)), static_cast<std::uint8_t>(qGreen(color)),
          static_cast<std::uint8_t>(qBlue(color))};
}

/// A pixel of a legend over a background.
inline osmesa_harness::Rgb blend(QRgb pixel, const osmesa_harness::Rgb& background)
{
  const double alpha = qAlpha(pixel) / 255.0;
  const auto mix = [&](int above, int below) {
    return static_cast<std::uint8_t>(std::lround(alpha * above + (1.0 - alpha) * below));
  };
  return {mix(qRed(pixel), background.red), mix(qGreen(pixel), background.green),
          mix(qBlue(pixel), background.blue)};
}

/// How many pixels of an image differ from those of a legend whose right side is @a right pixels
/// from the border.
inline int differences(const osmesa_harness::Image& image, const QImage& picture,
                       int right = DISTANCE, const osmesa_harness::Rgb& background = {48, 48, 48})
{
  const int left = image.width() - right - picture.width();
  const int top = (image.height() - picture.height()) / 2;
  int count = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      count += !osmesa_harness::isNear(image.at(left + x, top + y),
                                       blend(picture.pixel(x, y), background), 2);
    }
  }
  return count;
}

}  // namespace legend_checks
