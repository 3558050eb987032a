#include "measurement/measurement.h"

#include <cmath>

#include "base/grouped_number.h"
#include "base/vectors.h"

namespace rviz_mesh_plugin {
namespace {

std::string decimal(double value, int decimals)
{
  return groupedNumber(value, decimals).toStdString();
}

std::string metersOf(double value)
{
  return decimal(value, 3) + " m";
}

std::string signedMeters(double value)
{
  const std::string text = metersOf(std::abs(value));
  return (value < 0.0 ? "-" : "+") + text;
}

std::string squareMeters(double value)
{
  return decimal(value, 3) + " m²";
}

std::string slopeText(const Measurement& measurement)
{
  const double degrees = measurement.slope() * 180.0 / M_PI;
  const std::string text = decimal(degrees, 1) + "°";
  // Beyond a tenfold rise percents say nothing.
  return std::abs(measurement.rise()) <= 10.0 * measurement.plan()
             ? text + " (" + decimal(100.0 * std::tan(measurement.slope()), 1) + " %)"
             : text;
}

std::string gapsText(const SurfaceProfile& profile)
{
  const auto gaps = profile.gaps();
  if (gaps.empty()) {
    return profile.connected ? "" : "the points are on surfaces that the section does not connect";
  }
  double length = 0.0;
  for (const auto& gap : gaps) {
    length += gap.end - gap.begin;
  }
  std::string text = std::to_string(gaps.size()) + (gaps.size() == 1 ? " gap" : " gaps") + " of " +
                     metersOf(length) + ":";
  constexpr std::size_t MOST = 5;
  for (std::size_t i = 0; i < std::min(gaps.size(), MOST); ++i) {
    text += (i > 0 ? ", " : " ") + decimal(gaps[i].begin, 2) + " to " + metersOf(gaps[i].end);
    if (gaps[i].end - gaps[i].begin < 0.001) {
      text += " with a step of " + signedMeters(gaps[i].step);
    }
  }
  return text + (gaps.size() > MOST ? ", ..." : "");
}

std::string areaRemark(const SurfaceArea& area)
{
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (area.uncovered > 0.0) {
    add(squareMeters(area.uncovered) + " of the outline without this surface");
  }
  if (area.doubled > 0.0) {
    add(squareMeters(area.doubled) +
        " of it above or below other parts of it, which may hide holes");
  }
  if (!area.connected) {
    add("the corners are on surfaces that are not connected within the outline");
  }
  if (area.steep) {
    add("seen along the normal of the outline, which is steep");
  }
  return text;
}

}  // namespace

const char* nameOf(MeasurementKind kind)
{
  return kind == MeasurementKind::DISTANCE ? "Distance"
         : kind == MeasurementKind::AREA   ? "Area"
                                           : "Profile";
}

double Measurement::straight() const
{
  return distance(points.front().position, points.back().position);
}

double Measurement::plan() const
{
  const auto &a = points.front().position, &b = points.back().position;
  return std::hypot(b[0] - a[0], b[1] - a[1]);
}

double Measurement::rise() const
{
  return points.back().position[2] - points.front().position[2];
}

double Measurement::slope() const
{
  return std::atan2(rise(), plan());
}

std::string Measurement::value() const
{
  switch (kind) {
    case MeasurementKind::DISTANCE:
      return metersOf(straight());
    case MeasurementKind::AREA:
      return state == DONE ? squareMeters(result.area.surface) : "";
    default:
      return metersOf(plan());
  }
}

std::string Measurement::details() const
{
  std::string text;
  if (kind == MeasurementKind::DISTANCE) {
    text = signedMeters(rise()) + " in height, " + slopeText(*this) + ", " + metersOf(plan()) +
           " in plan";
  }
  if (state == WAITING) {
    return text + (text.empty() ? "" : "; ") + "measuring the surface…";
  }
  if (state == FAILED) {
    return text + (text.empty() ? "" : "; ") + "the surface could not be measured: " + error;
  }
  switch (kind) {
    case MeasurementKind::DISTANCE:
      text = (result.path.connected ? metersOf(result.path.length) + " along the surface, "
                                    : std::string()) +
             text;
      break;
    case MeasurementKind::AREA:
      text = squareMeters(result.area.plan) + " in plan, " +
             (result.area.walls > 0.0 ? squareMeters(result.area.walls) + " of walls beside it, "
                                      : std::string()) +
             metersOf(result.area.outline) + " around";
      break;
    default:
      if (result.profile.pieces.empty()) {
        break;
      }
      const SurfaceProfile::Heights heights = result.profile.heights();
      text = "z " + decimal(heights.lowest, 3) + " to " + metersOf(heights.highest) + ", " +
             metersOf(heights.ascent) + " up, " + metersOf(heights.descent) + " down, " +
             metersOf(heights.surface) + " along the surface";
  }
  const std::string known = remark();
  return text + (text.empty() || known.empty() ? "" : "; ") + known;
}

std::string Measurement::remark() const
{
  if (state != DONE) {
    return error;
  }
  switch (kind) {
    case MeasurementKind::DISTANCE:
      return result.path.connected ? "" : "the points are not connected along the surface";
    case MeasurementKind::AREA:
      return areaRemark(result.area);
    default:
      return gapsText(result.profile);
  }
}

std::vector<std::string> Measurement::lines() const
{
  const std::string name = std::to_string(number) + ": ";
  if (state == FAILED && kind != MeasurementKind::DISTANCE) {
    return {name + "not measured"};
  }
  if (state == WAITING && kind != MeasurementKind::DISTANCE) {
    return {name + "measuring…"};
  }
  switch (kind) {
    case MeasurementKind::DISTANCE: {
      std::vector<std::string> lines{name + value()};
      if (state == DONE && result.path.connected) {
        lines.push_back(metersOf(result.path.length) + " on surface");
      }
      lines.push_back(signedMeters(rise()) + ", " + slopeText(*this));
      return lines;
    }
    case MeasurementKind::AREA:
      return {name + value(), squareMeters(result.area.plan) + " in plan"};
    default:
      const SurfaceProfile::Heights heights = result.profile.heights();
      std::vector<std::string> lines{
          name + value(), metersOf(heights.ascent) + " up, " + metersOf(heights.descent) + " down"};
      const std::size_t gaps = result.profile.gaps().size();
      if (gaps > 0) {
        lines.push_back(std::to_string(gaps) + (gaps == 1 ? " gap" : " gaps"));
      }
      return lines;
  }
}

MeasuredSurface measure(const MeshData& mesh, MeasurementKind kind,
                        const std::vector<SurfacePoint>& points, const std::atomic<bool>* cancel)
{
  MeasuredSurface result;
  switch (kind) {
    case MeasurementKind::DISTANCE:
      result.path = findPath(mesh, points.front(), points.back(), cancel);
      break;
    case MeasurementKind::AREA:
      result.area = findArea(mesh, points, cancel);
      break;
    default:
      result.profile = findProfile(mesh, points.front(), points.back(), cancel);
  }
  return result;
}

}  // namespace rviz_mesh_plugin
