#include "labels/label_colors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "labels/label_name.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t HUES = 12;
constexpr std::size_t LETHAL_PLACE = 11;

/// FNV-1a: the same on all machines, unlike std::hash.
std::uint32_t hashOf(const std::string& text)
{
  std::uint32_t hash = 2166136261u;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  }
  return hash ^ (hash >> 15);
}

/// Twelve hues in full, light and dark colors; but for the color of lethal costs, in place of which
/// there is one half way to the next hue.
Rgba8 paletteColor(std::size_t place)
{
  struct Tone
  {
    float saturation;
    float value;
  };
  constexpr Tone TONES[] = {{0.85f, 0.95f}, {0.42f, 1.0f}, {0.9f, 0.58f}};
  const Tone& tone = TONES[place / HUES];
  const float step = static_cast<float>(place % HUES) + (place == LETHAL_PLACE ? 0.5f : 0.0f);
  const float hue = step / HUES * 6.0f;
  const auto channel = [&](float offset) {
    const float k = std::fmod(offset + hue, 6.0f);
    const float share = std::max(0.0f, std::min({k, 4.0f - k, 1.0f}));
    const float level = tone.value * (1.0f - tone.saturation * share);
    return static_cast<std::uint8_t>(std::lround(255.0f * level));
  };
  return {channel(5.0f), channel(3.0f), channel(1.0f), 255};
}

}  // namespace

Rgba8 LabelColors::color(const std::string& label)
{
  if (own_) {
    const auto own = own_->find(label);
    if (own != own_->end()) {
      return own->second;
    }
  }
  return classColor(labelClass(label));
}

std::vector<std::string> LabelColors::setOwn(const OwnColorsConstPtr& own)
{
  std::vector<std::string> changed;
  if (own == own_) {
    return changed;
  }
  OwnColors before;
  for (const OwnColorsConstPtr& colors : {own_, own}) {
    for (const auto& label : colors ? *colors : OwnColors()) {
      before.emplace(label.first, color(label.first));
    }
  }
  own_ = own;
  for (const auto& old : before) {
    if (!(color(old.first) == old.second)) {
      changed.push_back(old.first);
    }
  }
  return changed;
}

Rgba8 LabelColors::classColor(const std::string& label_class)
{
  const auto known = classes_.find(label_class);
  if (known != classes_.end()) {
    return paletteColor(known->second);
  }
  std::size_t place = hashOf(label_class) % PALETTE_SIZE;
  if (used_.size() < PALETTE_SIZE) {
    while (used_.count(place) != 0) {
      place = (place + 5) % PALETTE_SIZE;  // another hue; 5 and 36 have no common divisor
    }
  }
  used_.insert(place);
  classes_[label_class] = place;
  return paletteColor(place);
}

void LabelColors::clear()
{
  own_.reset();
  classes_.clear();
  used_.clear();
}

}  // namespace rviz_mesh_plugin
