#pragma once

#include <memory>
#include <string>
#include <vector>

#include <mesh_msgs/MeshGeometryStamped.h>

#include "base/mesh_data.h"
#include "incoming/reception.h"
#include "level_of_detail/mesh_layout.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// Checks, converts and lays out meshes on a thread of its own, which starts with the first of
/// them. Thread safe.
///
/// Of each uuid only the newest message counts: work on an older one is given up, but never twice
/// in a row, so that meshes of a fast publisher are shown. A message with the content of a mesh
/// that is in use in this process yields that very mesh (the same pointer), without being
/// converted: displays of one topic share its memory, and receivers see that nothing has changed.
class MeshLoader
{
 public:
  /// @param with_layouts false: meshes() only
  explicit MeshLoader(bool with_layouts = true);
  ~MeshLoader();  ///< gives up its work, and waits for nothing
  MeshLoader(const MeshLoader&) = delete;
  MeshLoader& operator=(const MeshLoader&) = delete;

  /// Called by ROS or a service. What cannot be done counts as refused.
  /// @param origin where it is to be dropped, nothing happens
  void receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message, const Origin& origin = {});

  /// Counts a message that could not even be read.
  void refuse(const std::string& reason, const Origin& origin = {});

  /// Lays a mesh out anew, split otherwise or without the faces that are hidden now; later requests
  /// for the same mesh replace earlier ones.
  /// New messages are laid out with Split::NONE, those that bring the same mesh again as asked for.
  void layOut(const MeshDataConstPtr& mesh, Split split, const MaterialsConstPtr& materials);

  struct Content
  {
    std::vector<MeshDataConstPtr> meshes;     ///< new, in order of arrival
    std::vector<MeshLayoutConstPtr> layouts;  ///< previews too
    Reception reception;                      ///< failures to lay out count as refused
    std::string working;  ///< what is being done, for a status line; empty: nothing
  };

  /// Hands over and forgets what is ready; the reception goes on counting.
  Content take();

  /// Gives up work, forgets what is ready, and the reception.
  void clear();

 private:
  class Worker;
  void wake();

  std::shared_ptr<Worker> worker_;
  WorkThread thread_{"mesh loader"};
};

}  // namespace rviz_mesh_plugin
