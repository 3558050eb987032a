#pragma once

#include <QTableView>

namespace rviz_mesh_plugin {

/// The list of labels. A second click on a box within the time of a double click is one more click,
/// and no double click at its row.
class LabelListView : public QTableView
{
 public:
  explicit LabelListView(QWidget* parent = nullptr) : QTableView(parent) {}

 protected:
  void mouseDoubleClickEvent(QMouseEvent* event) override;

 private:
  bool isOnBox(const QPoint& place) const;
};

}  // namespace rviz_mesh_plugin
