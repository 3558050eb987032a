#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#ifndef Q_MOC_RUN
#include <rviz/panel.h>

#include "navigation/navigation_server.h"
#include "navigation/server_directory.h"
#endif

class QComboBox;
class QLabel;
class QPushButton;
class QTimer;

namespace rviz_mesh_plugin {

/// Shows what a navigation server does and what has become of its last goals, whoever sent them;
/// chooses planner and controller for goals that are clicked, cancels, and clears layers.
class MeshNavigationPanel : public rviz::Panel
{
  Q_OBJECT

 public:
  explicit MeshNavigationPanel(QWidget* parent = nullptr);
  ~MeshNavigationPanel() override;

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

  /// Null before there is one to look at.
  const NavigationServer* server() const { return server_.get(); }

 private Q_SLOTS:
  void work();

 private:
  using Time = ServerWatch::Time;

  void createWidgets();
  QComboBox* createChoice(const char* tip);
  std::string chosenServer() const;
  void followServer();
  void choose();
  void show(Time now);
  void showServers();
  void showChoice(Time now);
  void showGoal(Time now);
  void showButtons();

  ServerDirectory directory_;
  std::unique_ptr<NavigationServer> server_;
  std::pair<std::string, std::string> told_;  ///< planner and controller, to that server
  std::string failure_;                       ///< of work()
  std::string cancel_report_;                 ///< of the goal that was there then

  QComboBox* servers_;
  QComboBox* planner_;
  QComboBox* controller_;
  QLabel* choice_;
  QLabel* phase_;
  QLabel* reason_;
  QLabel* goal_;
  QLabel* remaining_;
  QLabel* outcome_;
  QLabel* before_;
  QLabel* report_;
  QPushButton* cancel_;
  QPushButton* clear_;
  QTimer* timer_;
};

}  // namespace rviz_mesh_plugin
