#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <QPointer>
#include <QString>

#include "label_editing/label_files.h"
#include "label_editing/label_session.h"
#include "threads/background_task.h"
#include "tools/cluster_label_tool.h"

class QWidget;

namespace rviz_mesh_plugin {

/// What the buttons of the panel of labels do.
enum class LabelAction
{
  LABEL_CLUSTER,
  RESET_FACES,
  SELECT_BY,
  HIDE,
  ISOLATE,
  SHOW_ALL,
  NEW,
  ASSIGN,
  ADD,
  TAKE_AWAY,
  SELECT,
  RENAME,
  MERGE,
  DELETE,
  COLOR,
  CLASS_COLOR,
  IMPORT,
  EXPORT,
  SAVE,
  SEND_AGAIN,
  GIVE_UP,
  COUNT
};

/// What decides which of them are possible.
struct LabelSituation
{
  bool has_tool = false;
  bool has_shown_mesh = false;     ///< whose faces can be selected
  bool has_mesh = false;           ///< whose labels are edited
  bool selection_is_of_it = true;  ///< and not of another mesh
  std::size_t selected = 0;        ///< faces
  bool selecting = false;          ///< some are being looked for
  std::size_t hidden = 0;          ///< faces, of meshes that are shown
  std::string name;                ///< in the field "Cluster Name"
  std::size_t labels = 0;          ///< in the list
  std::size_t chosen = 0;          ///< of these
  std::size_t unstored = 0;
  std::size_t failed = 0;
  std::size_t unsaved = 0;
  bool saving = false;
  bool file_busy = false;  ///< one is being read or written
};

/// On the button.
const char* textOf(LabelAction action);
/// What it does, in a sentence.
const char* tipOf(LabelAction action);
/// Why it is not possible, with the way out; empty if it is.
std::string whyNot(LabelAction action, const LabelSituation& situation);

/// One line on the labels and on what is not stored or saved.
std::string describe(const LabelSituation& situation);

/// What becomes of labels that are not saved and edits that are not stored where RViz is closed
/// now.
std::string describeLoss(std::size_t unsaved, std::size_t unstored);

/// Does what the buttons of the panel of labels say. Nothing here waits or throws: what goes wrong
/// is in message().
class LabelCommands
{
 public:
  /// @param session, parent (of dialogs) outlive this
  LabelCommands(LabelSession* session, QWidget* parent) : session_(session), parent_(parent) {}

  void setTool(ClusterLabelTool* tool) { tool_ = tool; }
  ClusterLabelTool* tool() const { return tool_; }

  /// All that it decides by but the labels listed and chosen and the name, which others know.
  LabelSituation situation() const;

  /// @param chosen labels, as many as the situation says
  void run(LabelAction action, const LabelSituation& situation,
           const std::vector<std::string>& chosen);
  /// The newest step, of labels or selection; or what was undone last.
  void undo() { step(true); }
  void redo() { step(false); }
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
  FaceBits selection() const;
  void start(LabelAction action, const std::string& name, const Labels& chosen);
  /// What a dialog calls back: does that work, which returns why it cannot, unless the mesh is
  /// another one by then.
  template <class Work>
  auto then(const Work& work);
  std::string whyNotOf(const MeshDataConstPtr& mesh) const;

  static QString unknownLabels();

  // These return why they cannot, else an empty string.
  /// @param finished after that nothing is selected
  std::string label(const std::string& name, bool finished);
  std::string labelled(std::string reason, bool finished);
  std::string rename(const std::string& from, const std::string& to);
  std::string startImport(const std::string& path);
  std::string startExport(const std::string& path);
  std::string import(const LabelFile& file);
  std::string importNow(const std::shared_ptr<const FileLabels>& labels);

  void step(bool undo);
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
