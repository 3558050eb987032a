#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <mesh_map/bvh/selection/region.h>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QWheelEvent>

#include "selection/selection_regions.h"
#include "support/tool_fixture.h"
#include "tools/cluster_label_tool.h"

/// The tool that selects, and a user's hands.
class SelectionToolFixture : public ToolFixture
{
 protected:
  using Faces = rviz_mesh_plugin::FaceSelection::Faces;
  using Pixel = rviz_mesh_plugin::Pixel;

  void SetUp() override
  {
    ToolFixture::SetUp();
    tool = std::make_unique<rviz_mesh_plugin::ClusterLabelTool>();
    tool->initialize(manager());
    status_connection = QObject::connect(manager(), &rviz::VisualizationManager::statusUpdate,
                                         [this](const QString& text) { said = text; });
    tool->activate();
  }

  void TearDown() override
  {
    QObject::disconnect(status_connection);
    tool.reset();
    ToolFixture::TearDown();
  }

  /// A bumpy mesh in a frame that lies askew.
  Display* showTerrain(std::uint32_t cells = 20, const std::string& uuid = "mesh")
  {
    putFrame("askew", {{0.3, -0.2, 0.4}, {0.9, 0.2, -0.1, 0.3}});
    auto message = test_meshes::terrain(cells, [](double x, double y) {
      return 0.25 * std::sin(5.1 * x + 0.3) * std::cos(4.3 * y);
    });
    message.header.frame_id = "askew";
    message.uuid = uuid;
    return showPrepared(message);
  }

  /// Two bumpy storeys: faces 0..799 of the floor, around z = 0; 800..1599 of the roof, at z = 1.
  static mesh_msgs::MeshGeometryStamped storeys()
  {
    auto message = test_meshes::terrain(20, [](double x, double) { return 0.1 * std::sin(5 * x); });
    const auto floor = message.mesh_geometry;
    for (auto vertex : floor.vertices) {
      vertex.z += 1.0;
      message.mesh_geometry.vertices.push_back(vertex);
    }
    for (auto face : floor.faces) {
      for (auto& index : face.vertex_indices) {
        index += static_cast<std::uint32_t>(floor.vertices.size());
      }
      message.mesh_geometry.faces.push_back(face);
    }
    return message;
  }

  Display* showPrepared(const mesh_msgs::MeshGeometryStamped& message)
  {
    Display* display = createMeshDisplay();
    EXPECT_TRUE(show(display, message));
    waitUntilPrepared();
    return display;
  }

  void takeView(int number)
  {
    if (number == 0) {
      lookAt({3, -2, 2.5}, {0.3, -0.2, 0.4});
    } else if (number == 1) {
      lookAt({-2, 1.5, -3}, {0.3, -0.2, 0.4});
    } else {
      viewFromAbove(0.3, -0.2, 130.0);
    }
    spinFrames();
  }

  void send(const Pixel& at, QEvent::Type type, Qt::MouseButton button, Qt::MouseButtons down,
            Qt::KeyboardModifiers modifiers)
  {
    const QPointF place(at.x, at.y);
    QMouseEvent event(type, place, place, place, button, down, modifiers);
    rviz::ViewportMouseEvent passed(panel(), viewport(), &event, last.x, last.y);
    last = at;
    tool->processMouseEvent(passed);
  }
  void press(const Pixel& at, Qt::MouseButton button = Qt::LeftButton,
             Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    held = button;
    send(at, QEvent::MouseButtonPress, button, button, modifiers);
  }
  void move(const Pixel& at, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    send(at, QEvent::MouseMove, Qt::NoButton, held, modifiers);
  }
  void release(const Pixel& at, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    const Qt::MouseButton button = held;
    held = Qt::NoButton;
    send(at, QEvent::MouseButtonRelease, button, Qt::NoButton, modifiers);
  }
  void drag(const std::vector<Pixel>& path, Qt::MouseButton button = Qt::LeftButton,
            Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    press(path.front(), button, modifiers);
    for (const Pixel& at : path) {
      move(at, modifiers);
    }
    release(path.back(), modifiers);
  }
  void click(const Pixel& at, Qt::MouseButton button = Qt::LeftButton) { drag({at}, button); }
  void wheel(const Pixel& at, int delta, Qt::KeyboardModifiers modifiers)
  {
    QWheelEvent event(QPointF(at.x, at.y), QPointF(at.x, at.y), QPoint(), QPoint(0, delta),
                      Qt::NoButton, modifiers, Qt::NoScrollPhase, false);
    rviz::ViewportMouseEvent passed(panel(), viewport(), &event, at.x, at.y);
    tool->processMouseEvent(passed);
  }
  void key(int code, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    QKeyEvent event(QEvent::KeyPress, code, modifiers);
    tool->processKeyEvent(&event, panel());
  }

  void choose(const char* property, const QVariant& value)
  {
    tool->getPropertyContainer()->subProp(property)->setValue(value);
  }

  /// Waits for what is being looked for.
  testing::AssertionResult settle()
  {
    return spinUntil([&] { return !tool->busy(); }) ? testing::AssertionSuccess()
                                                    : testing::AssertionFailure() << "still busy";
  }

  rviz_mesh_plugin::ShownMesh shown() const { return picker.meshes().at(0); }
  Faces selected() const { return tool->selection().faces(); }
  bool says(const std::string& text) const
  {
    return said.toStdString().find(text) != std::string::npos;
  }

  static std::array<float, 9> cornersOf(const rviz_mesh_plugin::MeshData& mesh, std::uint32_t face)
  {
    std::array<float, 9> corners;
    for (unsigned i = 0; i < 9; ++i) {
      corners[i] = mesh.vertices[mesh.indices[3 * face + i / 3]].position[i % 3];
    }
    return corners;
  }

  /// The faces of a mesh that touch a region.
  static Faces touching(const rviz_mesh_plugin::MeshData& mesh, const mesh_map::Region& region)
  {
    Faces faces;
    for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
      if (region.triangle(cornersOf(mesh, face).data()) != mesh_map::Side::OUTSIDE) {
        faces.push_back(face);
      }
    }
    return faces;
  }

  const std::vector<Pixel> LASSO{{200, 150}, {420, 140}, {330, 230}, {440, 330}, {210, 320}};
  std::unique_ptr<rviz_mesh_plugin::ClusterLabelTool> tool;
  Pixel last;
  Qt::MouseButton held = Qt::NoButton;
  QString said;
  QMetaObject::Connection status_connection;
};
