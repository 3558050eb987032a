#include "measurement/measurement_files.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <QTemporaryDir>

#include "measured_meshes.h"

using namespace measured_meshes;
using rviz_mesh_plugin::Measurement;
using rviz_mesh_plugin::MeasurementKind;
using rviz_mesh_plugin::measurementsToCsv;
using rviz_mesh_plugin::profileToCsv;

namespace {

std::vector<std::string> split(const std::string& text, char at)
{
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) {
    parts.push_back(part);
  }
  return parts;
}

Measurement measurement(const MeshData& mesh, MeasurementKind kind,
                        const std::vector<SurfacePoint>& points)
{
  Measurement made;
  made.number = 7;
  made.kind = kind;
  made.frame = "map";
  made.uuid = "a \"mesh\", of two";
  made.points = points;
  made.result = rviz_mesh_plugin::measure(mesh, kind, points);
  made.state = Measurement::DONE;
  return made;
}

/// The cell of a column in the last row. Uuid, remark and points have no comma here.
std::string cell(const std::string& csv, const std::string& column)
{
  const auto lines = split(csv, '\n');
  const auto names = split(lines[0], ',');
  std::string row = lines.back();
  const auto quoted = row.find("\"a \"\"mesh\"\", of two\"");
  EXPECT_NE(quoted, std::string::npos) << row;
  row.replace(quoted, 20, "uuid");
  const auto cells = split(row + ",", ',');
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == column) {
      return cells.at(i);
    }
  }
  return "no such column";
}

std::string textOf(const std::string& path)
{
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

}  // namespace

TEST(MeasurementFiles, a_distance_has_its_values_with_units)
{
  const MeshData mesh = terrain(4, [](double x, double) { return 0.75 * x; });
  const auto made = measurement(mesh, MeasurementKind::DISTANCE,
                                {pointAt(mesh, -0.4, 0.1), pointAt(mesh, 0.4, 0.1)});
  const std::string csv = measurementsToCsv({made});
  EXPECT_EQ(cell(csv, "number"), "7");
  EXPECT_EQ(cell(csv, "kind"), "Distance");
  EXPECT_EQ(cell(csv, "frame"), "map");
  EXPECT_EQ(cell(csv, "straight_m"), "1.000000");
  EXPECT_EQ(cell(csv, "in_plan_m"), "0.800000");
  EXPECT_EQ(cell(csv, "height_difference_m"), "0.600000");
  EXPECT_EQ(cell(csv, "slope_deg").substr(0, 7), "36.8698");
  EXPECT_EQ(cell(csv, "along_surface_m"), "1.000000");
  EXPECT_EQ(cell(csv, "surface_area_m2"), "");
  EXPECT_NE(csv.find("\"-0.400000 0.100000 -0.300000; 0.400000 0.100000 0.300000\""),
            std::string::npos)
      << csv;
}

TEST(MeasurementFiles, an_area_and_a_profile)
{
  const MeshData mesh = terrain(4, [](double x, double) { return 0.75 * x; });
  const auto area =
      measurement(mesh, MeasurementKind::AREA,
                  {pointAt(mesh, 0, 0), pointAt(mesh, 0.5, 0), pointAt(mesh, 0.5, 0.5)});
  std::string csv = measurementsToCsv({area});
  EXPECT_EQ(cell(csv, "surface_area_m2"), "0.156250");
  EXPECT_EQ(cell(csv, "plan_area_m2"), "0.125000");
  EXPECT_EQ(cell(csv, "straight_m"), "") << "of which points?";
  const auto profile = measurement(mesh, MeasurementKind::PROFILE,
                                   {pointAt(mesh, -0.4, 0.1), pointAt(mesh, 0.4, 0.1)});
  csv = measurementsToCsv({area, profile});
  EXPECT_EQ(cell(csv, "ascent_m"), "0.600000");
  EXPECT_EQ(cell(csv, "gaps"), "0");
  const auto rows = split(profileToCsv(profile), '\n');
  ASSERT_EQ(rows.size(), 1 + profile.result.profile.pieces[0].size());
  EXPECT_EQ(rows[0], "piece,distance_m,z_m,x_m,y_m,frame,map_uuid");
  EXPECT_EQ(rows[1], "1,0.000000,-0.300000,-0.400000,0.100000,map,\"a \"\"mesh\"\", of two\"");
  EXPECT_EQ(rows.back().substr(0, 37), "1,0.800000,0.300000,0.400000,0.100000");
}

TEST(MeasurementFiles, the_step_of_a_gap_of_length_0_is_told)
{
  MeshData mesh = terrain(4, [](double, double) { return 0.0; });
  addBox(mesh, {0, -0.5f, 0.25f}, {0.75f, 0.5f, 1});
  const auto profile = measurement(mesh, MeasurementKind::PROFILE,
                                   {pointAt(mesh, -0.5, 0.1), pointAt(mesh, 0.5, 0.1, 1.0)});
  EXPECT_EQ(profile.remark(), "1 gap of 0.000 m: 0.50 to 0.500 m with a step of +1.000 m");
  const std::string csv = measurementsToCsv({profile});
  EXPECT_EQ(cell(csv, "highest_z_m"), "1.000000");
  EXPECT_EQ(cell(csv, "gaps"), "1");
}

TEST(MeasurementFiles, a_file_is_replaced_where_that_was_said_alone)
{
  const QTemporaryDir folder;
  const std::string path = folder.filePath("a.csv").toStdString();
  rviz_mesh_plugin::writeCsv(path, "one\n", false);
  EXPECT_EQ(textOf(path), "one\n");
  try {
    rviz_mesh_plugin::writeCsv(path, "two\n", false);
    FAIL() << "it is there";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), path + " is there by now and was left as it is: export again");
  }
  EXPECT_EQ(textOf(path), "one\n");
  rviz_mesh_plugin::writeCsv(path, "three\n", true);
  EXPECT_EQ(textOf(path), "three\n");
  try {
    rviz_mesh_plugin::writeCsv(path + "/b.csv", "x", false);
    FAIL() << "that is no folder";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).find(path + "/b.csv cannot be written: "), 0u)
        << error.what();
  }
}
