#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <QColor>
#include <QObject>
#include <QPointer>
#include <QString>

#ifndef Q_MOC_RUN
#include "label_editing/label_files.h"
#include "label_editing/label_session.h"
#include "panel/label_actions.h"
#include "threads/background_task.h"
#include "tools/cluster_label_tool.h"
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

  /// What went wrong with the newest command; empty if all is well.
  const std::string& message() const { return message_; }
  /// What it has done, where that is not to be seen in the list.
  const std::string& report() const { return report_; }
  void say(const std::string& message) { message_ = message; }
  /// Nothing is thrown: the message says what went wrong.
  void attempt(const std::function<void()>& work);

 private:
  using Labels = std::vector<std::string>;
  LabelSession::Faces selection() const;
  void start(LabelAction action, const std::string& name, const Labels& chosen);
  /// What a dialog calls back: does that work, which returns why it cannot, unless the mesh is
  /// another one by then.
  template <class Work>
  auto then(const Work& work);
  std::string whyNotOf(const MeshDataConstPtr& mesh) const;

  static QString unknownLabels();

  // These return why they cannot, else an empty string.
  std::string label(const std::string& name);
  std::string rename(const std::string& from, const std::string& to);
  std::string setColor(const Labels& labels, const std::optional<QColor>& color);
  std::string startImport(const std::string& path);
  std::string startExport(const std::string& path);
  std::string import(const LabelFile& file);
  std::string importNow(const FileLabels& labels);

  void select(const Labels& chosen);
  void askColors(const Labels& labels);
  Labels withClasses(const Labels& chosen) const;

  LabelSession* session_;
  QWidget* parent_;
  QPointer<ClusterLabelTool> tool_;
  std::string message_;
  std::string report_;
  BackgroundTask<LabelFile> reading_{"import labels"};
  std::string read_path_;
  MeshDataConstPtr read_for_;
  BackgroundTask<std::string> writing_{"export labels"};  ///< the report
};

template <class Work>
auto LabelCommands::then(const Work& work)
{
  return [this, work, mesh = session_->mesh()](const auto& answer) {
    attempt([&] {
      message_ = whyNotOf(mesh);
      if (message_.empty()) {
        message_ = work(answer);
      }
    });
  };
}

}  // namespace rviz_mesh_plugin
