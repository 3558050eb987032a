#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
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
  bool eventFilter(QObject* watched, QEvent* event) override;

  /// Null before there is one to look at.
  const NavigationServer* server() const { return server_.get(); }

 private Q_SLOTS:
  void work();

 private:
  using Time = ServerWatch::Time;
  using Choice = std::pair<std::string, std::string>;  ///< planner and controller

  /// Of what the user has done, while this goal was there.
  struct ActReport
  {
    std::string text;
    std::string goal;   ///< id
    bool busy = false;  ///< whether there was something to cancel
    Time since;
  };

  void guarded(const std::function<void()>& act);
  void createWidgets();
  QComboBox* createChoice(const char* tip);
  std::string chosenServer() const;
  void followServer();
  Choice choice() const;
  void tellChoice();
  void choose(bool anyway);
  void cancel();
  void report(const std::string& text);
  std::string reportOfAct(Time now);
  void show(Time now);
  void showServers();
  void showChoice(Time now);
  void showGoal(Time now);
  void showButtons();

  ServerDirectory directory_;
  std::unique_ptr<NavigationServer> server_;
  std::optional<Choice> told_;  ///< to that server
  std::string named_;           ///< what the user has named it; empty: it was chosen for him
  std::string failure_;         ///< of work()
  ActReport report_of_act_;

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
