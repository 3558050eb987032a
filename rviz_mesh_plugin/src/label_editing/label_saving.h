#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "label_editing/pending_edits.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// Labels that are stored, but not saved in their maps yet, and having them saved by those who
/// store them. GUI thread only; nothing here waits.
class LabelSaving
{
 public:
  /// A label has been stored there.
  void addStored(const MeshId& mesh, const std::string& label, const std::string& name_space);

  /// Asks those who store labels to write them into the maps, all at the same time. Returns why
  /// not, else an empty string.
  /// @param name_space one more of these; empty: none
  std::string save(const std::string& name_space);
  bool isSaving() const { return !saving_.empty(); }

  /// To be called often. Returns whether anything has changed.
  /// @param name_space where labels are edited now
  bool work(const std::string& name_space);

  /// Labels that were stored since they were saved last.
  std::size_t count() const { return unsaved_.size(); }
  bool isUnsaved(const MeshId& mesh, const std::string& label) const
  {
    return unsaved_.count({mesh, label}) != 0;
  }
  /// Why they are not saved; else empty.
  const std::string& failure() const { return failure_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Unsaved
  {
    std::string name_space;
    std::size_t change = 0;
  };
  /// By one of those who store labels.
  struct Saving
  {
    BackgroundTask<bool> task{"save labels", NAME_PATIENCE};  ///< false: nobody is there
    std::size_t until = 0;                                    ///< changes that are saved then
    Clock::time_point since;
  };

  std::string take(const std::string& name_space, Saving& saving, bool is_edited);

  std::map<std::pair<MeshId, std::string>, Unsaved> unsaved_;
  std::size_t changes_ = 0;
  std::map<std::string, Saving> saving_;  ///< by namespace
  std::string failure_;
};

}  // namespace rviz_mesh_plugin
