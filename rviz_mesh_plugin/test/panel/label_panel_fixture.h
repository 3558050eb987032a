#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/visualization_manager.h>
#include <QLabel>
#include <QMainWindow>
#include <QMessageBox>
#include <QPushButton>
#include <QTableView>

#include "labels/label_faces.h"
#include "panel/cluster_label_panel.h"
#include "support/kept_picture.h"
#include "support/label_display_fixture.h"
#include "support/label_fixture.h"
#include "tools/cluster_label_tool.h"

/// The panel in a window of its own, with the tool and three labels.
class LabelPanelFixture : public LabelDisplayFixture
{
 protected:
  using Faces = std::vector<std::uint32_t>;

  void TearDown() override
  {
    window.reset();
    tool.reset();
    LabelDisplayFixture::TearDown();
  }

  /// tree_1 in row 0, tree_2 in row 1, wall_1 in row 2; each row is 0.4 m² of 20 faces.
  void start(bool listen = true)
  {
    server->addLabel("tree_1", test_labels::rows(10, 0, 1));
    server->addLabel("tree_2", test_labels::rows(10, 1, 2));
    server->addLabel("wall_1", test_labels::rows(10, 2, 3));
    if (listen) {
      server->listen(name_space);
    }
    createMeshDisplay();
    display = createLabels();
    publishMesh();
    ASSERT_TRUE(says(display, "Labels", "3 labels"));
    createPanel();
    ASSERT_TRUE(spinUntil([&] { return list()->model()->rowCount() == 3; }));
  }

  void createPanel()
  {
    tool = std::make_unique<rviz_mesh_plugin::ClusterLabelTool>();
    tool->initialize(manager());
    window = std::make_unique<QMainWindow>();
    panel = new rviz_mesh_plugin::ClusterLabelPanel;
    window->setCentralWidget(panel);
    window->resize(360, 600);
    panel->initialize(manager());
    panel->setTool(tool.get());
    window->show();
  }

  /// What the panel does all the time.
  void refresh() { QMetaObject::invokeMethod(panel, "work", Qt::DirectConnection); }

  /// Another mesh of as many faces comes, of whose labels nothing is known.
  testing::AssertionResult showGarden()
  {
    auto mesh = test_meshes::terrain(10, [](double, double) { return 0.0; });
    mesh.uuid = "garden";
    geometry.publish(mesh);
    const bool shown = spinUntil([&] {
      refresh();
      const auto now = panel->session()->mesh();
      return now && now->uuid == "garden" && panel->session()->labels().empty();
    });
    return shown ? testing::AssertionSuccess() : testing::AssertionFailure() << text();
  }

  testing::AssertionResult select(const Faces& faces)
  {
    std::string reason;
    const bool selected = spinUntil([&] {
      reason = tool->select(display->mesh(), faces);
      return reason.empty();
    });
    refresh();
    return selected ? testing::AssertionSuccess() : testing::AssertionFailure() << reason;
  }

  QPushButton* button(const QString& text)
  {
    for (auto* button : panel->findChildren<QPushButton*>()) {
      if (button->text().remove('&') == text) {
        return button;
      }
    }
    ADD_FAILURE() << "no button " << text.toStdString();
    return nullptr;
  }

  void click(const QString& text)
  {
    EXPECT_TRUE(button(text)->isEnabled())
        << text.toStdString() << ": " << button(text)->toolTip().toStdString();
    button(text)->click();
  }

  QTableView* list() { return panel->findChild<QTableView*>(); }

  QString cell(int row, int column)
  {
    return list()->model()->index(row, column).data().toString();
  }

  void choose(const std::vector<int>& chosen)
  {
    list()->clearSelection();
    for (const int row : chosen) {
      list()->selectionModel()->select(list()->model()->index(row, 0),
                                       QItemSelectionModel::Select | QItemSelectionModel::Rows);
    }
    refresh();
  }

  /// The dialog that is open; null: none is.
  template <class Dialog>
  Dialog* open()
  {
    for (auto* dialog : panel->findChildren<Dialog*>()) {
      if (dialog->isVisible()) {
        return dialog;
      }
    }
    return nullptr;
  }

  template <class Dialog>
  Dialog* dialog()
  {
    EXPECT_TRUE(spinUntil([&] { return open<Dialog>() != nullptr; }));
    return open<Dialog>();
  }

  template <class Dialog>
  bool noDialog()
  {
    return spinUntil([&] { return open<Dialog>() == nullptr; });
  }

  void answer(const QString& text)
  {
    ASSERT_TRUE(dialog<QMessageBox>());
    for (QAbstractButton* button : dialog<QMessageBox>()->buttons()) {
      if (button->text().remove('&') == text) {
        button->click();
        ASSERT_TRUE(noDialog<QMessageBox>());
        return;
      }
    }
    FAIL() << "no answer " << text.toStdString();
  }

  /// Waits until so many edits have arrived, stores the last, and checks what its label has then.
  testing::AssertionResult stores(std::size_t count, const std::string& label, const Faces& faces)
  {
    if (!spinUntil([&] { return server->edits().size() >= count; })) {
      return testing::AssertionFailure() << server->edits().size() << " edits; " << text();
    }
    const auto edit = server->edits().at(count - 1);
    auto cluster = edit.cluster;
    const auto known = display->labels().find(cluster.label);
    if (!edit.override && known != display->labels().end()) {
      const Faces& before = known->second->faces;
      cluster.face_indices.insert(cluster.face_indices.end(), before.begin(), before.end());
      rviz_mesh_plugin::sortFaces(cluster.face_indices);
    }
    server->labels.publish(cluster);
    if (cluster.label != label || cluster.face_indices != faces) {
      return testing::AssertionFailure() << cluster;
    }
    const bool stored = spinUntil([&] { return !panel->session()->isUnstored(cluster.label); });
    refresh();
    return stored ? testing::AssertionSuccess() : testing::AssertionFailure() << text();
  }

  std::string text()
  {
    std::string text;
    for (const auto* label : panel->findChildren<QLabel*>()) {
      text += label->text().toStdString() + "\n";
    }
    return text;
  }

  testing::AssertionResult shows(const std::string& expected)
  {
    if (spinUntil([&] { return text().find(expected) != std::string::npos; })) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << text();
  }

  Display* display = nullptr;
  rviz_mesh_plugin::ClusterLabelPanel* panel = nullptr;
  std::unique_ptr<rviz_mesh_plugin::ClusterLabelTool> tool;
  std::unique_ptr<QMainWindow> window;
};
