#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include <mesh_msgs/SetLabelColor.h>
#include <ros/node_handle.h>

#include "base/mesh_data.h"
#include "sources/edit_publisher.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// The way of edits to who owns the labels of a map (hdf5_map_server, label_manager). GUI thread
/// only; nothing waits for an answer.
class LabelClient
{
 public:
  /// @param patience with one who deletes labels; then what waits for that is sent
  explicit LabelClient(std::chrono::milliseconds patience = std::chrono::seconds(10))
      : patience_(patience)
  {
  }

  /// Uses the topic cluster_label and the services delete_label and set_label_color in this
  /// namespace; none where it is empty. @throw ros::InvalidNameException
  void connect(ros::NodeHandle& node_handle, const std::string& name_space);
  void disconnect();

  /// Where edits go; empty while not connected.
  std::string topic() const { return publisher_.topic(); }
  bool isHeard() const { return publisher_.isHeard(); }

  /// Edits of one label arrive in the order in which they were given, removals
  /// among them; of those that wait, what a later one replaces is left out.
  void store(const SentEdit& edit);

  /// Has the label of this edit, which takes all faces away from it, deleted by work(); where
  /// nobody offers to, the edit is stored instead: the label stays, with no faces.
  void remove(const SentEdit& edit);

  /// Has a color stored by work(); null: none.
  void setColor(const std::string& uuid, const std::string& label, const Rgba8* color);

  /// To be called often. Returns why a color could not be stored, or a label not be deleted; empty
  /// where nothing new went wrong.
  std::string work();

 private:
  using Edit = SentEdit;
  struct Request
  {
    Edit edit;
    bool removes = false;
  };
  struct Deletion
  {
    std::vector<Edit> not_offered;  ///< to be stored instead
    std::string failure;
  };
  static Deletion deleteLabels(const std::string& service, const std::vector<Edit>& edits,
                               const Cancellation& cancellation);
  void wait(const Edit& edit, bool removes);
  bool isWaitedFor(const std::string& label) const;
  std::string takeDeletion();
  void sendWaiting();

  std::string color_service_;
  std::string delete_service_;
  EditPublisher publisher_;
  /// By label: of a color that is dragged about, the newest counts.
  std::map<std::string, mesh_msgs::SetLabelColor::Request> requests_;
  BackgroundTask<std::string> storing_{"label owner", NAME_PATIENCE};
  std::deque<Request> waiting_;             ///< deletions, and what waits for them
  std::vector<std::string> being_deleted_;  ///< labels
  std::chrono::steady_clock::time_point deleting_since_;
  const std::chrono::milliseconds patience_;
  BackgroundTask<Deletion> deleting_{"delete labels", NAME_PATIENCE};
};

}  // namespace rviz_mesh_plugin
