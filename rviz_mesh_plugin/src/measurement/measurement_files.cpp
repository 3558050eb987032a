#include "measurement/measurement_files.h"

#include <cmath>
#include <stdexcept>

#include <QFileInfo>
#include <QString>

#include "base/csv_cell.h"
#include "base/saved_file.h"

namespace rviz_mesh_plugin {
namespace {

/// To a micrometer.
std::string cell(double value)
{
  return QString::number(value, 'f', 6).toStdString();
}

std::string positionsOf(const std::vector<SurfacePoint>& points)
{
  std::string text;
  for (const SurfacePoint& point : points) {
    text += text.empty() ? "" : "; ";
    text += cell(point.position[0]) + " " + cell(point.position[1]) + " " + cell(point.position[2]);
  }
  return text;
}

const std::vector<const char*> COLUMNS{"number",          "kind",
                                       "state",           "frame",
                                       "map_uuid",        "straight_m",
                                       "in_plan_m",       "height_difference_m",
                                       "slope_deg",       "along_surface_m",
                                       "surface_area_m2", "wall_area_m2",
                                       "plan_area_m2",    "uncovered_area_m2",
                                       "outline_m",       "lowest_z_m",
                                       "highest_z_m",     "ascent_m",
                                       "descent_m",       "gaps",
                                       "gaps_m",          "points_x_y_z_m",
                                       "remark"};

/// The cells of one row, by column.
class Row
{
 public:
  Row() : cells_(COLUMNS.size()) {}
  void set(const std::string& column, const std::string& text)
  {
    for (std::size_t i = 0; i < COLUMNS.size(); ++i) {
      if (column == COLUMNS[i]) {
        cells_[i] = quotedCell(text);
      }
    }
  }
  void set(const std::string& column, double value) { set(column, cell(value)); }
  std::string text() const
  {
    std::string line;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      line += (i > 0 ? "," : "") + cells_[i];
    }
    return line + "\n";
  }

 private:
  std::vector<std::string> cells_;
};

void setEnds(const Measurement& measurement, Row& row)
{
  row.set("straight_m", measurement.straight());
  row.set("in_plan_m", measurement.plan());
  row.set("height_difference_m", measurement.rise());
  row.set("slope_deg", measurement.slope() * 180.0 / M_PI);
}

void setArea(const SurfaceArea& area, Row& row)
{
  row.set("surface_area_m2", area.surface);
  row.set("wall_area_m2", area.walls);
  row.set("plan_area_m2", area.plan);
  row.set("uncovered_area_m2", area.uncovered);
  row.set("outline_m", area.outline);
}

void setProfile(const SurfaceProfile& profile, Row& row)
{
  if (profile.pieces.empty()) {
    return;  // there is nothing that could be told
  }
  const SurfaceProfile::Heights heights = profile.heights();
  double gaps = 0.0;
  for (const auto& gap : profile.gaps()) {
    gaps += gap.end - gap.begin;
  }
  row.set("along_surface_m", heights.surface);
  row.set("lowest_z_m", heights.lowest);
  row.set("highest_z_m", heights.highest);
  row.set("ascent_m", heights.ascent);
  row.set("descent_m", heights.descent);
  row.set("gaps", std::to_string(profile.gaps().size()));
  row.set("gaps_m", gaps);
}

Row rowOf(const Measurement& measurement)
{
  Row row;
  row.set("number", std::to_string(measurement.number));
  row.set("kind", nameOf(measurement.kind));
  const char* const states[] = {"waiting", "done", "failed"};
  row.set("state", measurement.stale ? "mesh gone" : states[measurement.state]);
  row.set("frame", measurement.frame);
  row.set("map_uuid", measurement.uuid);
  row.set("points_x_y_z_m", positionsOf(measurement.points));
  row.set("remark", measurement.remark());
  if (measurement.kind != MeasurementKind::AREA) {
    setEnds(measurement, row);
  }
  if (measurement.state != Measurement::DONE) {
    return row;
  }
  switch (measurement.kind) {
    case MeasurementKind::DISTANCE:
      if (measurement.result.path.connected) {
        row.set("along_surface_m", measurement.result.path.length);
      }
      break;
    case MeasurementKind::AREA:
      setArea(measurement.result.area, row);
      break;
    default:
      setProfile(measurement.result.profile, row);
  }
  return row;
}

}  // namespace

std::string measurementsToCsv(const std::vector<Measurement>& measurements)
{
  std::string text;
  for (const char* column : COLUMNS) {
    text += (text.empty() ? "" : ",") + std::string(column);
  }
  text += "\n";
  for (const Measurement& measurement : measurements) {
    text += rowOf(measurement).text();
  }
  return text;
}

std::string profileToCsv(const Measurement& profile)
{
  std::string text = "piece,distance_m,z_m,x_m,y_m,frame,map_uuid\n";
  const std::string owner = "," + quotedCell(profile.frame) + "," + quotedCell(profile.uuid) + "\n";
  const auto& pieces = profile.result.profile.pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (const SurfaceProfile::Point& point : pieces[i]) {
      const auto position = profile.result.profile.position(point);
      text += std::to_string(i + 1) + "," + cell(point.distance) + "," + cell(point.z) + "," +
              cell(position[0]) + "," + cell(position[1]) + owner;
    }
  }
  return text;
}

void writeCsv(const std::string& path, const std::string& text, bool replace)
{
  if (!replace && QFileInfo::exists(QString::fromStdString(path))) {
    throw std::runtime_error(path + " is there by now and was left as it is: export again");
  }
  const std::string problem = saveFile(path, text);
  if (!problem.empty()) {
    throw std::runtime_error(path + " cannot be written: " + problem);
  }
}

}  // namespace rviz_mesh_plugin
