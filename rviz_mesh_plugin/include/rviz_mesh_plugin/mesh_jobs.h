#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <mesh_msgs/MeshGeometryStamped.h>

#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/mesh_layout.h"

namespace rviz_mesh_plugin {

/// A message to convert, or a mesh to lay out.
struct MeshJob
{
  std::string uuid;
  mesh_msgs::MeshGeometryStamped::ConstPtr message;
  MeshDataConstPtr mesh;
  Split split = Split::NONE;
  MaterialsConstPtr materials;

  bool isSameLayout(const MeshJob& other) const
  {
    return mesh == other.mesh && split == other.split && materials == other.materials;
  }
  std::string describe() const;
};

/// What a MeshLoader has to do, and how each mesh was asked to be laid out last.
class MeshJobs
{
 public:
  /// Messages of more meshes than this do not wait.
  static constexpr std::size_t MOST_MESSAGES = 16;

  /// In place of an older message of the mesh; where too many wait, the oldest goes.
  /// @param dropped jobs that are in the way: to free them takes long
  /// @return what is refused and why, else empty
  std::string add(const mesh_msgs::MeshGeometryStamped::ConstPtr& message,
                  std::vector<MeshJob>& dropped);

  /// Remembers how a mesh is to be laid out, and removes what was asked before.
  void setWish(const MeshJob& layout);
  void add(MeshJob layout) { waiting_.push_back(std::move(layout)); }

  /// The mesh has come: layouts of another one of that uuid are obsolete.
  void arrive(const MeshDataConstPtr& mesh);
  /// How the mesh of a job was asked to be laid out last; nothing changes where it was not.
  void applyWish(MeshJob& job) const;

  bool empty() const { return waiting_.empty(); }
  MeshJob takeFirst();
  void clear();

 private:
  struct Wish
  {
    std::weak_ptr<const MeshData> mesh;
    Split split = Split::NONE;
    std::weak_ptr<const Materials> materials;
  };

  std::deque<MeshJob> waiting_;
  std::map<std::string, Wish> wishes_;  ///< by uuid
};

}  // namespace rviz_mesh_plugin
