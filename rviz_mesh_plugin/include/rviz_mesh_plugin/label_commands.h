#pragma once

#include <functional>
#include <string>
#include <vector>

#include <QObject>
#include <QPointer>

#ifndef Q_MOC_RUN
#include "rviz_mesh_plugin/background_task.h"
#include "rviz_mesh_plugin/cluster_label_tool.h"
#include "rviz_mesh_plugin/label_actions.h"
#include "rviz_mesh_plugin/label_files.h"
#include "rviz_mesh_plugin/label_session.h"
#endif

class QWidget;

namespace rviz_mesh_plugin {

/// Does what the buttons of the panel of labels say. Nothing here waits or throws: what goes wrong
/// is in message().
class LabelCommands
{
 public:
  /// @param session, parent (of dialogs) outlive this
  LabelCommands(LabelSession* session, QWidget* parent) : session_(session), parent_(parent) {}

  void setTool(ClusterLabelTool* tool) { tool_ = tool; }
  ClusterLabelTool* tool() const { return tool_; }

  /// All that it decides by but the labels chosen and the name, which others know.
  LabelSituation situation() const;

  void run(LabelAction action, const std::string& name, const std::vector<std::string>& chosen);
  /// To be called often.
  void work();

  /// What became of the newest command; empty if all is well.
  const std::string& message() const { return message_; }
  void say(const std::string& message) { message_ = message; }
  /// Nothing is thrown: the message says what went wrong.
  void attempt(const std::function<void()>& work);

 private:
  using Labels = std::vector<std::string>;
  LabelSession::Faces selection() const;
  void start(LabelAction action, const std::string& name, const Labels& chosen);
  void label(const std::string& name);
  void select(const Labels& chosen);
  void askColors(const Labels& labels);
  Labels withClasses(const Labels& chosen) const;
  void startImport(const std::string& path);
  void startExport(const std::string& path);
  void import(const LabelFile& file);

  LabelSession* session_;
  QWidget* parent_;
  QPointer<ClusterLabelTool> tool_;
  std::string message_;
  BackgroundTask<LabelFile> reading_;
  BackgroundTask<std::string> writing_;  ///< the path
};

}  // namespace rviz_mesh_plugin
