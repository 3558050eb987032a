#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <std_msgs/ColorRGBA.h>

#include "rviz_mesh_plugin/validation.h"

/// What the checks of all messages are made of.
namespace rviz_mesh_plugin {

/// Finite as a float, which is what OGRE computes with: 1e60 is finite as a double only.
inline bool isFinite(double value)
{
  return std::isfinite(static_cast<float>(value));
}

template <class Point>
bool isFinitePoint(const Point& point)
{
  return isFinite(point.x) && isFinite(point.y) && isFinite(point.z);
}

template <class Function>
bool anyChannel(const std_msgs::ColorRGBA& color, const Function& function)
{
  return function(color.r) || function(color.g) || function(color.b) || function(color.a);
}

/// Counts the elements for which @a is_bad holds and adds one finding for them; @a describe is
/// given the first.
template <class Elements, class IsBad, class Describe>
void addFinding(std::vector<Finding>& findings, const char* rule, const Elements& elements,
                const IsBad& is_bad, const Describe& describe, const char* hint)
{
  std::size_t first = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (is_bad(elements[i])) {
      first = count == 0 ? i : first;
      ++count;
    }
  }
  if (count > 0) {
    findings.push_back({rule, describe(first), first, count, hint});
  }
}

template <class... Parts>
inline std::string text(const Parts&... parts)
{
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

/// Text of a message in quotes, on one line and not too long for a status line.
inline std::string shown(const std::string& text)
{
  std::string line = text.size() <= 60 ? text : text.substr(0, 57) + "...";
  for (char& c : line) {
    c = static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
  }
  return "'" + line + "'";
}

inline void checkUuid(std::vector<Finding>& findings, const std::string& given,
                      const std::string& expected)
{
  if (!expected.empty() && given != expected) {
    findings.push_back(
        {"uuid_mismatch",
         text("the uuid is ", shown(given), ", but ", shown(expected), " is expected"),
         std::nullopt, 1, "publish it with the uuid of the geometry it belongs to"});
  }
}

template <class Message>
void checkIdentity(std::vector<Finding>& findings, const Message& message, const std::string& uuid)
{
  checkUuid(findings, message.uuid, uuid);
  if (message.header.frame_id.empty()) {
    findings.push_back({"frame_id_empty", "header.frame_id is empty", std::nullopt, 1,
                        "set it to the frame of the coordinates"});
  }
}

/// Color channels are numbers from 0 to 1; @a describe is given the first that is not.
template <class Colors, class ColorOf, class Describe>
void checkChannels(std::vector<Finding>& findings, const Colors& colors, const ColorOf& color_of,
                   const Describe& describe)
{
  addFinding(
      findings, "color_not_finite", colors,
      [&](const auto& element) {
        return anyChannel(color_of(element), [](float c) { return !std::isfinite(c); });
      },
      describe, "color channels are numbers from 0 to 1");
  addFinding(
      findings, "color_out_of_range", colors,
      [&](const auto& element) {
        return anyChannel(color_of(element),
                          [](float c) { return std::isfinite(c) && (c < 0.0f || c > 1.0f); });
      },
      describe, "color channels run from 0 to 1: divide by 255?");
}

/// @param noun what has the costs, e.g. "vertex"
inline void checkCostValues(std::vector<Finding>& findings, const std::vector<float>& costs,
                            const char* noun)
{
  addFinding(
      findings, "cost_negative_infinity", costs,
      [](float cost) { return std::isinf(cost) && cost < 0.0f; },
      [&](std::size_t first) { return text("the cost of ", noun, " ", first, " is -inf"); },
      "lethal is +inf, unknown is NaN");
}

}  // namespace rviz_mesh_plugin
