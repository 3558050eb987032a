#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <rviz/display.h>
#include <rviz/properties/property.h>

#include "conversion/mesh_conversion.h"
#include "displays/textured_mesh_display.h"
#include "meshes.h"
#include "rendering/mesh_visual.h"
#include "status_fixture.h"

/// A display on topics of its own, and publishers on them.
class DisplayFixture : public StatusFixture
{
 protected:
  using Display = rviz_mesh_plugin::TexturedMeshDisplay;

  void SetUp() override
  {
    StatusFixture::SetUp();
    // Names of their own for each test: nothing latched by another one arrives
    // here.
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    geometry_topic = "/" + name + "/mesh";
    costs_topic = "/" + name + "/vertex_costs";
    colors_topic = "/" + name + "/vertex_colors";
    geometry = node.advertise<mesh_msgs::MeshGeometryStamped>(geometry_topic, 100, true);
    costs = node.advertise<mesh_msgs::MeshVertexCostsStamped>(costs_topic, 100, true);
    colors = node.advertise<mesh_msgs::MeshVertexColorsStamped>(colors_topic, 100, true);
  }

  /// A display without wireframe and normals on the topics above, by the name
  /// that it is loaded with.
  Display* createMeshDisplay(const std::string& class_id = "rviz_map_plugin/Mesh")
  {
    auto* display = createDisplayAs<Display>(class_id);
    set(display, {"Show Wireframe"}, false);
    set(display, {"Show Normals"}, false);
    set(display, {"Display Type", "Legend"}, false);
    set(display, {"Display Type", "Vertex Costs Topic"}, costs_topic.c_str());
    set(display, {"Display Type", "Vertex Colors Topic"}, colors_topic.c_str());
    set(display, {"Geometry Topic"}, geometry_topic.c_str());
    spinFrames(1);  // it has subscribed then
    return display;
  }

  static rviz::Property* find(rviz::Property* property, const std::vector<const char*>& path)
  {
    for (const char* name : path) {
      property = property->subProp(name);
    }
    return property;
  }

  /// Changes a property, and lets a display that draws already follow.
  static void set(rviz::Property* property, const std::vector<const char*>& path,
                  const QVariant& value)
  {
    find(property, path)->setValue(value);
    const auto* display = dynamic_cast<Display*>(property);
    if (display && display->isEnabled() && display->visual()) {
      spinFrames(1);
    }
  }

  /// Whether the display draws this mesh, in full.
  static bool shows(const Display* display, const rviz_mesh_plugin::MeshData& expected)
  {
    const auto drawn = display->mesh();
    const auto* visual = display->visual();
    return drawn && drawn->uuid == expected.uuid && drawn->indices == expected.indices &&
           drawn->vertices.size() == expected.vertices.size() &&
           std::memcmp(drawn->vertices.data(), expected.vertices.data(),
                       expected.vertices.size() * sizeof(expected.vertices[0])) == 0 &&
           visual && visual->layout() == visual->shownLayout() && !visual->layout()->preview &&
           visual->progress() >= 1.0f;
  }

  /// Publishes a mesh and waits until the display draws it.
  testing::AssertionResult show(Display* display, const mesh_msgs::MeshGeometryStamped& message)
  {
    const auto expected = rviz_mesh_plugin::convert(message);
    geometry.publish(message);
    if (spinUntil([&] { return shows(display, *expected); })) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << "Topic: " << status(display, "Topic")
                                       << "\nGeometry: " << status(display, "Geometry");
  }

  ros::NodeHandle node;
  std::string geometry_topic;
  std::string costs_topic;
  std::string colors_topic;
  ros::Publisher geometry;
  ros::Publisher costs;
  ros::Publisher colors;
};
