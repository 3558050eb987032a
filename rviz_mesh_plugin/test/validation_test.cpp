#include <algorithm>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>

#include "meshes.h"
#include "rviz_mesh_plugin/validation.h"

using rviz_mesh_plugin::check;
using rviz_mesh_plugin::Finding;

namespace {

/// JSON has no nan and inf: they are strings there.
double number(const QJsonValue& value)
{
  return value.isString() ? std::strtod(value.toString().toLatin1().constData(), nullptr)
                          : value.toDouble();
}

std::string string(const QJsonObject& message, const char* key)
{
  return message[key].toString().toStdString();
}

template <class Points>
void fillPoints(const QJsonValue& rows, Points& points)
{
  for (const auto& row : rows.toArray()) {
    const QJsonArray p = row.toArray();
    points.push_back(test_meshes::point(number(p[0]), number(p[1]), number(p[2])));
  }
}

std::vector<Finding> checkGeometry(const QJsonObject& json)
{
  auto message = test_meshes::emptyMesh(string(json, "uuid"));
  message.header.frame_id = string(json, "frame_id");
  fillPoints(json["vertices"], message.mesh_geometry.vertices);
  fillPoints(json["vertex_normals"], message.mesh_geometry.vertex_normals);
  for (const auto& row : json["faces"].toArray()) {
    const QJsonArray f = row.toArray();
    test_meshes::addFace(message, f[0].toDouble(), f[1].toDouble(), f[2].toDouble());
  }
  return check(message, string(json, "expected_uuid"));
}

std::optional<std::size_t> vertexCount(const QJsonObject& json)
{
  const QJsonValue count = json["vertex_count"];
  return count.isNull() ? std::nullopt : std::make_optional<std::size_t>(count.toInt());
}

std::vector<Finding> checkCosts(const QJsonObject& json)
{
  std::vector<float> values;
  for (const auto& value : json["costs"].toArray()) {
    values.push_back(static_cast<float>(number(value)));
  }
  auto message = test_meshes::costs(string(json, "type"), values, string(json, "uuid"));
  message.header.frame_id = string(json, "frame_id");
  return check(message, vertexCount(json), string(json, "expected_uuid"));
}

std::vector<Finding> checkColors(const QJsonObject& json)
{
  std::vector<std_msgs::ColorRGBA> values;
  for (const auto& row : json["vertex_colors"].toArray()) {
    const QJsonArray c = row.toArray();
    values.push_back(test_meshes::color(number(c[0]), number(c[1]), number(c[2]), number(c[3])));
  }
  auto message = test_meshes::colors(values, string(json, "uuid"));
  message.header.frame_id = string(json, "frame_id");
  return check(message, vertexCount(json), string(json, "expected_uuid"));
}

std::vector<std::string> rulesOf(const std::vector<Finding>& findings)
{
  std::vector<std::string> rules;
  for (const Finding& finding : findings) {
    rules.push_back(finding.rule);
  }
  std::sort(rules.begin(), rules.end());
  return rules;
}

}  // namespace

TEST(Validation, agrees_with_the_corpus_that_python_is_tested_with_too)
{
  QFile file(VALIDATION_CORPUS);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly)) << VALIDATION_CORPUS;
  const QJsonArray cases = QJsonDocument::fromJson(file.readAll()).array();
  ASSERT_GE(cases.size(), 50);
  for (const auto& entry : cases) {
    const QJsonObject one = entry.toObject();
    const std::string type = string(one, "type");
    const QJsonObject message = one["message"].toObject();
    std::vector<Finding> findings;
    if (type == "MeshGeometryStamped") {
      findings = checkGeometry(message);
    } else if (type == "MeshVertexCostsStamped") {
      findings = checkCosts(message);
    } else if (type == "MeshVertexColorsStamped") {
      findings = checkColors(message);
    } else {
      continue;  // a type that no display receives
    }
    std::vector<std::string> expected;
    for (const auto& rule : one["rules"].toArray()) {
      expected.push_back(rule.toString().toStdString());
    }
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(rulesOf(findings), expected)
        << string(one, "name") << ": " << rviz_mesh_plugin::summarize(findings);
    for (const Finding& finding : findings) {
      EXPECT_FALSE(finding.what.empty() || finding.hint.empty()) << finding.rule;
    }
  }
}

TEST(Validation, names_the_first_bad_face_and_counts_the_others)
{
  auto message = test_meshes::terrain(3, [](double, double) { return 0.0; });
  message.mesh_geometry.faces[5].vertex_indices[1] = 16;
  message.mesh_geometry.faces[7].vertex_indices[2] = 0xFFFFFFFF;
  const auto findings = check(message);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].index, 5u);
  EXPECT_EQ(findings[0].count, 2u);
  EXPECT_EQ(findings[0].sentence(),
            "face 5 refers to vertex 16, but the mesh has 16 vertices (the first of 2); export the "
            "mesh again; "
            "indices count from 0");
}

TEST(Validation, says_how_many_findings_there_are_besides_the_first)
{
  auto message = test_meshes::square();
  message.header.frame_id.clear();
  message.mesh_geometry.vertices[2].y = std::numeric_limits<double>::infinity();
  message.mesh_geometry.faces[0].vertex_indices[0] = 4;
  const std::string text = rviz_mesh_plugin::summarize(check(message));
  EXPECT_NE(text.find("vertex 2 is (-1, inf, 0)"), std::string::npos) << text;
  EXPECT_NE(text.find("(and 2 more findings)"), std::string::npos) << text;
  EXPECT_EQ(rviz_mesh_plugin::summarize({}), "");
}
