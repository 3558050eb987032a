#include "tools/selection/brush_path.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "base/vectors.h"
#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

/// Between two events, the surface is looked for so often at most: some ten milliseconds.
constexpr std::size_t MAX_SAMPLES = 2048;

/// How far the brush moves before it is set down again, in radii.
constexpr double STEP = 0.5;

/// Beside the surface, it is looked for every so many pixels.
constexpr double MISSES = 8.0;

/// Closer places in the picture, in pixels, are not told apart. Where a surface is seen at a small
/// angle, a pixel is longer than the brush.
constexpr double FINEST = 1.0 / 16.0;

struct Sample
{
  double at = 0.0;  ///< of the way, in pixels
  std::optional<SurfaceHit> hit;
};

bool areClose(const Sample& a, const Sample& b, double radius, const Ogre::Viewport& viewport)
{
  const double way = b.at - a.at;
  if (way <= FINEST || (!a.hit && !b.hit && way <= MISSES)) {
    return true;
  }
  if (!a.hit || !b.hit || a.hit->mesh != b.hit->mesh) {
    return false;
  }
  const double step = STEP * radius;
  return distance(a.hit->point, b.hit->point) <= step &&
         way <= pixelsOf(step, std::max(a.hit->distance, b.hit->distance), viewport);
}

}  // namespace

BrushPath followBrush(const SurfacePicker& picker, const Ogre::Viewport& viewport,
                      const Gesture& gesture, std::optional<SurfaceHit> before,
                      const SelectionSettings& settings)
{
  const double x = gesture.to.x - gesture.from.x, y = gesture.to.y - gesture.from.y;
  const double length = std::max(std::abs(x), std::abs(y));
  const auto sampleAt = [&](double at) {
    const double share = length > 0.0 ? at / length : 1.0;
    const auto ray =
        rayThrough({gesture.from.x + 0.5 + share * x, gesture.from.y + 0.5 + share * y}, viewport);
    return Sample{at, picker.pick(ray, settings.back_faces).hit};
  };
  std::vector<Sample> samples(2);
  samples[0].hit = std::move(before);
  samples[1] = sampleAt(length);
  // From coarse to fine, so that whatever ends it leaves no long stretch without.
  for (std::size_t taken = 1, last = 0; taken != last && taken < MAX_SAMPLES;) {
    last = taken;
    std::vector<Sample> finer;
    finer.push_back(std::move(samples.front()));
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const double begin = finer.back().at;
      if (taken < MAX_SAMPLES && !areClose(finer.back(), samples[i], settings.radius, viewport)) {
        finer.push_back(sampleAt((begin + samples[i].at) / 2.0));
        ++taken;
      }
      finer.push_back(std::move(samples[i]));
    }
    samples = std::move(finer);
  }
  BrushPath path;
  path.last = samples.back().hit;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].hit) {
      path.hits.push_back(std::move(*samples[i].hit));
    }
  }
  return path;
}

}  // namespace rviz_mesh_plugin
