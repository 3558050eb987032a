#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <QPointer>

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "displays/cluster_label_display.h"
#include "label_editing/label_files.h"
#include "label_editing/pending_edits.h"
#include "threads/background_task.h"

namespace rviz {
class DisplayContext;
}

namespace rviz_mesh_plugin {

/// Edits the labels of one mesh: finds the display that shows them, sends edits through it, follows
/// them until they are stored and then saved in the map. GUI thread only; nothing here waits.
///
/// Functions that edit return why they cannot, else an empty string. What they were asked for is
/// kept until it is stored, even where nobody listens, the display is gone, or the mesh changes.
class LabelSession
{
 public:
  using Faces = std::vector<std::uint32_t>;

  /// @param context outlives this
  /// @param patience until an edit that was sent should be stored
  explicit LabelSession(rviz::DisplayContext* context,
                        std::chrono::milliseconds patience = std::chrono::seconds(10));
  ~LabelSession();

  /// To be called often.
  /// @param mesh whose labels are to be edited; null: of the first display that has one
  void work(const MeshDataConstPtr& mesh);

  ClusterLabelDisplay* display() const { return display_; }
  MeshDataConstPtr mesh() const { return display_ ? display_->mesh() : nullptr; }
  /// Whether that is this one.
  bool isOf(const MeshDataConstPtr& mesh) const;
  /// Another number wherever labels, edits or what is saved may have changed.
  std::size_t revision() const { return revision_; }
  /// As they are stored.
  const LabelClusters& labels() const;
  /// Whether there are no others; false while those who store them have not said what there is.
  bool labelsKnown() const;
  /// As it is drawn; nothing where there is no display.
  std::optional<Rgba8> color(const std::string& label) const;
  /// All labels that are stored or are to be.
  std::vector<std::string> names() const;
  /// Of a label, as they are to be.
  Faces faces(const std::string& label) const;
  std::size_t faceCount(const std::string& label) const;
  /// With all that is not stored yet.
  FileLabels content() const;

  std::string assign(const std::string& label, const Faces& faces);
  /// Those that others add at the same time stay.
  std::string add(const std::string& label, const Faces& faces);
  std::string takeAway(const std::string& label, const Faces& faces);
  /// Keeps a color of the label's own. The old label goes when the new one is stored, unless it
  /// has changed by then.
  std::string rename(const std::string& from, const std::string& to);
  /// Into one of them. The others go when that is stored, unless they have changed by then.
  std::string merge(const std::vector<std::string>& labels, const std::string& into);
  std::string remove(const std::vector<std::string>& labels);
  /// Nothing: the color of its class.
  std::string setColor(const std::vector<std::string>& labels, const std::optional<Rgba8>& color);
  /// Labels of those names become what they are there; others stay.
  std::string import(const FileLabels& labels);

  /// Edits that are not stored.
  std::size_t unstored() const { return edits_.count(); }
  std::size_t failed() const { return edits_.failed(); }
  bool isUnstored(const std::string& label) const;
  /// Labels that were stored since they were saved last.
  std::size_t unsaved() const { return unsaved_.size(); }
  bool isUnsaved(const std::string& label) const;
  /// Why something is not stored or saved; else empty.
  std::string failure() const;
  void sendAgain();
  /// Forgets edits that are not stored.
  void giveUp();

  /// Asks those who store labels to write them into the maps, all at the same time.
  std::string save();
  bool isSaving() const { return !saving_.empty(); }

 private:
  using Clock = std::chrono::steady_clock;
  using Key = std::pair<MeshId, std::string>;
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

  std::string put(LabelEdit edit);
  MeshId id() const;
  LabelEdit edit(const std::string& label) const;
  LabelEdit clearing(const std::string& label, const std::string& after) const;
  /// The mesh of an edit need not be the one whose labels are edited now.
  ClusterLabelDisplay* displayOf(const LabelEdit& edit) const;
  std::string send(const LabelEdit& edit);
  bool isStored(const LabelEdit& edit) const;
  void takeSaved();
  void showEdits(const OptionalStatus& status);
  std::string takeSaved(const std::string& name_space, Saving& saving);

  rviz::DisplayContext* context_;
  QPointer<ClusterLabelDisplay> display_;
  bool shows_edits_ = false;  ///< there, of this session
  std::string namespace_;     ///< of who stores its labels
  ros::NodeHandle node_;
  ros::Publisher everybody_;
  PendingEdits edits_;
  std::map<Key, Unsaved> unsaved_;
  std::size_t changes_ = 0;
  std::size_t revision_ = 0;
  LabelClusters known_;                   ///< at that revision
  std::map<std::string, Saving> saving_;  ///< by namespace
  std::string save_failure_;
};

}  // namespace rviz_mesh_plugin
