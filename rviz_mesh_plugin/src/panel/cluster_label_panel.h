#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#ifndef Q_MOC_RUN
#include <rviz/panel.h>

#include "label_editing/label_session.h"
#include "panel/label_commands.h"
#include "panel/label_list_model.h"
#include "tools/cluster_label_tool.h"
#endif

class QLabel;
class QLineEdit;
class QPushButton;
class QTableView;
class QTimer;

namespace rviz_mesh_plugin {

class LabelClosing;
class ZoomButton;
struct ZoomTarget;

/// Lists the labels of a mesh and edits them, with the faces that the tool ClusterLabel has
/// selected. Asks before RViz is closed with labels that are not saved.
class ClusterLabelPanel : public rviz::Panel
{
  Q_OBJECT

 public:
  explicit ClusterLabelPanel(QWidget* parent = nullptr);
  ~ClusterLabelPanel() override;

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

  /// Whose selection is labelled. By default that of RViz, which is added where there is none.
  void setTool(ClusterLabelTool* tool);

  /// So many labels are always seen where the screen has this height in pixels: ten beside RViz's
  /// other panels in a window of 1,000, fewer where there is no room for that.
  static int leastRows(int screen_height);

  /// Null before initialize().
  LabelSession* session() { return session_.get(); }

 private Q_SLOTS:
  void work();

 private:
  void createWidgets();
  void createList();
  void press(LabelAction action);
  void followTool();
  void followList();
  LabelSituation situation() const;
  void showSituation();
  std::vector<std::string> chosen() const;
  MeshDataConstPtr meshToZoomTo() const;
  ZoomTarget zoomTarget() const;

  std::shared_ptr<LabelSession> session_;
  std::unique_ptr<LabelCommands> commands_;
  std::unique_ptr<LabelClosing> closing_;
  LabelListModel* model_ = nullptr;
  QLineEdit* name_;
  QTableView* list_;
  QLabel* status_;
  ZoomButton* zoom_ = nullptr;
  std::map<LabelAction, QPushButton*> buttons_;
  QTimer* timer_;
  std::string failure_;  ///< of work()
  bool tool_asked_for_ = false;
};

}  // namespace rviz_mesh_plugin
