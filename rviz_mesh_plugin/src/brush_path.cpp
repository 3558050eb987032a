#include "rviz_mesh_plugin/brush_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include <rviz/viewport_mouse_event.h>

#include "rviz_mesh_plugin/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

/// Between two events, the brush is set down so often at most.
constexpr std::size_t MAX_SAMPLES = 256;

/// How far the brush moves before it is set down again, in radii.
constexpr double STEP = 0.5;

/// Beside the surface, it is looked for every so many pixels.
constexpr int MISSES = 8;

struct Sample
{
  Pixel at;
  std::optional<SurfaceHit> hit;
};

bool areClose(const Sample& a, const Sample& b, double radius, const Ogre::Viewport& viewport)
{
  const int way = std::max(std::abs(a.at.x - b.at.x), std::abs(a.at.y - b.at.y));
  if (way <= 1 || (!a.hit && !b.hit && way <= MISSES)) {
    return true;
  }
  if (!a.hit || !b.hit || a.hit->mesh != b.hit->mesh) {
    return false;
  }
  const auto& p = a.hit->point;
  const auto& q = b.hit->point;
  const double step = STEP * radius;
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) <= step &&
         way <= pixelsOf(step, std::max(a.hit->distance, b.hit->distance), viewport);
}

}  // namespace

BrushPath followBrush(const SurfacePicker& picker, const rviz::ViewportMouseEvent& event,
                      const Gesture& gesture, std::optional<SurfaceHit> before,
                      const SelectionSettings& settings)
{
  rviz::ViewportMouseEvent between = event;
  const auto sampleAt = [&](const Pixel& at) {
    between.x = at.x;
    between.y = at.y;
    return Sample{at, picker.pick(between, settings.back_faces).hit};
  };
  Sample last{gesture.from, std::move(before)};
  std::vector<Sample> ahead{sampleAt(gesture.to)};  // the next one last
  BrushPath path;
  path.last = ahead.front().hit;
  for (std::size_t samples = 1; !ahead.empty();) {
    const Pixel next = ahead.back().at;
    if (samples < MAX_SAMPLES && !areClose(last, ahead.back(), settings.radius, *event.viewport)) {
      ahead.push_back(sampleAt({(last.at.x + next.x) / 2, (last.at.y + next.y) / 2}));
      ++samples;
      continue;
    }
    last = std::move(ahead.back());
    ahead.pop_back();
    if (last.hit) {
      path.hits.push_back(*last.hit);
    }
  }
  return path;
}

}  // namespace rviz_mesh_plugin
