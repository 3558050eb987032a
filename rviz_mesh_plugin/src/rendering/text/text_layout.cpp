#include "rendering/text/text_layout.h"

#include <algorithm>
#include <array>
#include <utility>

#include <OgreCamera.h>
#include <OgreViewport.h>

namespace rviz_mesh_plugin {

std::optional<PicturePlace> placeInPicture(const Ogre::Vector3& point, const Ogre::Camera* camera)
{
  const Ogre::Viewport* const viewport = camera ? camera->getViewport() : nullptr;
  if (!viewport || viewport->getActualHeight() <= 0) {
    return std::nullopt;
  }
  const Ogre::Matrix4& projection = camera->getProjectionMatrix();
  const Ogre::Vector3 seen =
      camera->getDerivedOrientation().Inverse() * (point - camera->getDerivedPosition());
  const Ogre::Real w = projection[3][2] * seen.z + projection[3][3];
  if (!(w > 0.0f)) {
    return std::nullopt;
  }
  const Ogre::Real half_width = 0.5f * viewport->getActualWidth();
  const Ogre::Real half_height = 0.5f * viewport->getActualHeight();
  PicturePlace place;
  place.x = half_width *
            (1.0f + (projection[0][0] * seen.x + projection[0][2] * seen.z + projection[0][3]) / w);
  place.y = half_height *
            (1.0f + (projection[1][1] * seen.y + projection[1][2] * seen.z + projection[1][3]) / w);
  place.meters = w / (half_height * projection[1][1]);
  return place;
}

bool TextLayout::isFree(const Box& box) const
{
  return std::none_of(taken_.begin(), taken_.end(), [&](const Box& other) {
    return box.left < other.right && other.left < box.right && box.low < other.high &&
           other.low < box.high;
  });
}

std::optional<std::pair<int, int>> TextLayout::add(const Ogre::Vector3& point, int width,
                                                   int height)
{
  constexpr int AWAY = 8;  // as far as above the point
  const auto place = placeInPicture(point, camera_);
  if (!place) {
    return std::nullopt;
  }
  const int down = height + 2 * AWAY, aside = width / 2 + AWAY, middle = height / 2 + AWAY;
  const std::array<std::pair<int, int>, 4> ways{
      {{0, 0}, {0, -down}, {aside, -middle}, {-aside, -middle}}};
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const float left = place->x - static_cast<float>(width / 2) + static_cast<float>(ways[i].first);
    const float low = place->y + static_cast<float>(AWAY + ways[i].second);
    const Box box{left, low, left + static_cast<float>(width), low + static_cast<float>(height)};
    if (isFree(box)) {
      taken_.push_back(box);
      return ways[i];
    }
  }
  return std::nullopt;
}

}  // namespace rviz_mesh_plugin
