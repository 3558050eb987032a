#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>

#include "conversion/validation.h"
#include "support/meshes.h"

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

std::optional<std::size_t> count(const QJsonObject& json, const char* key)
{
  const QJsonValue count = json[key];
  return count.isNull() ? std::nullopt : std::make_optional<std::size_t>(count.toInt());
}

std::optional<std::size_t> vertexCount(const QJsonObject& json)
{
  return count(json, "vertex_count");
}

std::vector<float> floats(const QJsonValue& values)
{
  std::vector<float> all;
  for (const auto& value : values.toArray()) {
    all.push_back(static_cast<float>(number(value)));
  }
  return all;
}

std::vector<std::uint32_t> integers(const QJsonValue& values)
{
  std::vector<std::uint32_t> all;
  for (const auto& value : values.toArray()) {
    all.push_back(static_cast<std::uint32_t>(value.toDouble()));
  }
  return all;
}

template <class Message>
Message identified(const QJsonObject& json)
{
  Message message;
  message.uuid = string(json, "uuid");
  message.header.frame_id = string(json, "frame_id");
  return message;
}

std::vector<Finding> checkFaceCosts(const QJsonObject& json)
{
  auto message = identified<mesh_msgs::MeshFaceCostsStamped>(json);
  message.mesh_face_costs.costs = floats(json["costs"]);
  return check(message, count(json, "face_count"), string(json, "expected_uuid"));
}

std::vector<Finding> checkSparse(const QJsonObject& json)
{
  auto message = identified<mesh_msgs::MeshVertexCostsSparseStamped>(json);
  message.mesh_vertex_costs.vertices = integers(json["vertices"]);
  message.mesh_vertex_costs.costs = floats(json["costs"]);
  message.mesh_vertex_costs.default_value = static_cast<float>(number(json["default_value"]));
  return check(message, vertexCount(json), string(json, "expected_uuid"));
}

mesh_msgs::MeshFaceCluster cluster(const QJsonObject& json)
{
  mesh_msgs::MeshFaceCluster message;
  message.face_indices = integers(json["face_indices"]);
  message.label = string(json, "label");
  return message;
}

std::vector<Finding> checkCluster(const QJsonObject& json)
{
  return check(cluster(json), count(json, "face_count"));
}

std::vector<Finding> checkMaterials(const QJsonObject& json)
{
  auto message = identified<mesh_msgs::MeshMaterialsStamped>(json);
  auto& materials = message.mesh_materials;
  for (const auto& one : json["clusters"].toArray()) {
    materials.clusters.push_back(cluster(one.toObject()));
  }
  for (const auto& one : json["materials"].toArray()) {
    const QJsonArray c = one.toObject()["color"].toArray();
    mesh_msgs::MeshMaterial material;
    material.color = test_meshes::color(number(c[0]), number(c[1]), number(c[2]), number(c[3]));
    material.has_texture = one.toObject()["has_texture"].toBool();
    materials.materials.push_back(material);
  }
  materials.cluster_materials = integers(json["cluster_materials"]);
  for (const auto& row : json["vertex_tex_coords"].toArray()) {
    mesh_msgs::MeshVertexTexCoords pair;
    pair.u = static_cast<float>(number(row.toArray()[0]));
    pair.v = static_cast<float>(number(row.toArray()[1]));
    materials.vertex_tex_coords.push_back(pair);
  }
  return check(message, vertexCount(json), count(json, "face_count"),
               string(json, "expected_uuid"));
}

std::vector<Finding> checkTexture(const QJsonObject& json)
{
  mesh_msgs::MeshTexture message;
  message.uuid = string(json, "uuid");
  message.image.encoding = string(json, "encoding");
  message.image.width = static_cast<std::uint32_t>(json["width"].toDouble());
  message.image.height = static_cast<std::uint32_t>(json["height"].toDouble());
  message.image.step = static_cast<std::uint32_t>(json["step"].toDouble());
  message.image.data.resize(json["bytes"].toInt());
  return check(message, string(json, "expected_uuid"));
}

std::vector<Finding> checkCosts(const QJsonObject& json)
{
  auto message =
      test_meshes::costs(string(json, "type"), floats(json["costs"]), string(json, "uuid"));
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
  ASSERT_GE(cases.size(), 140);
  const std::map<std::string, std::vector<Finding> (*)(const QJsonObject&)> checkers = {
      {"MeshGeometryStamped", checkGeometry},   {"MeshVertexCostsStamped", checkCosts},
      {"MeshVertexColorsStamped", checkColors}, {"MeshFaceCostsStamped", checkFaceCosts},
      {"MeshFaceCluster", checkCluster},        {"MeshVertexCostsSparseStamped", checkSparse},
      {"MeshMaterialsStamped", checkMaterials}, {"MeshTexture", checkTexture}};
  for (const auto& entry : cases) {
    const QJsonObject one = entry.toObject();
    const std::string type = string(one, "type");
    const QJsonObject message = one["message"].toObject();
    const auto checker = checkers.find(type);
    ASSERT_NE(checker, checkers.end()) << type;
    const std::vector<Finding> findings = checker->second(message);
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
  EXPECT_EQ(findings[0].count, 2u);
  EXPECT_EQ(findings[0].sentence(),
            "face 5 refers to vertex 16, but the mesh has 16 vertices (the first of 2); export the "
            "mesh again; "
            "indices count from 0");
}

TEST(Validation, compares_what_arrived_before_its_geometry)
{
  rviz_mesh_plugin::Materials materials;
  materials.faces = {0, 5, 7};
  materials.texture_coordinates.resize(4);
  EXPECT_FALSE(rviz_mesh_plugin::checkMaterialsFit(materials, 4, 8));
  const auto beyond = rviz_mesh_plugin::checkMaterialsFit(materials, 4, 5);
  ASSERT_TRUE(beyond);
  EXPECT_EQ(beyond->sentence(),
            "the materials refer to face 5, but the mesh has 5 faces (the first of 2); publish the "
            "materials of this geometry");
  EXPECT_EQ(rviz_mesh_plugin::checkMaterialsFit(materials, 3, 8)->rule, "texture_coordinate_count");
  rviz_mesh_plugin::CostUpdate update;
  update.vertices = {3, 4, 9};
  EXPECT_FALSE(rviz_mesh_plugin::checkUpdateFits(update, 10));
  EXPECT_EQ(rviz_mesh_plugin::checkUpdateFits(update, 4)->what,
            "entry 1 refers to vertex 4, but there are 4");
  EXPECT_EQ(rviz_mesh_plugin::checkCostCount(4, 5, true)->rule, "cost_count");
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
