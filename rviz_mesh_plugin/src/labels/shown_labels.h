#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <set>
#include <string>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The labels of the mesh that is shown. Those that arrive before their mesh wait here for it. A
/// complete set that is expected says nothing of labels that come before it: it was asked for, and
/// what comes meanwhile is newer, or the same. The first is expected since there is a mesh.
class ShownLabels
{
 public:
  /// So many sets of labels are kept for meshes that have not arrived.
  static constexpr std::size_t MAX_WAITING = 1000;

  /// Forgets the labels of another mesh, and takes those that waited for this one (null: none).
  void setMesh(const MeshDataConstPtr& mesh);
  void add(const LabelSetConstPtr& labels);
  void clear();

  /// All labels are asked for once more.
  void expectAll();
  bool expectsAll() const { return expects_all_; }

  const MeshDataConstPtr& mesh() const { return mesh_; }
  const LabelClusters& labels() const { return labels_; }

  /// Labels that are other than when they were taken before: new, changed, or gone.
  std::set<std::string> takeChanged();

  /// Whether all labels of the mesh are known: a complete set has arrived.
  bool isComplete() const { return complete_; }
  /// Face indices that were left out: the mesh has no such faces.
  std::size_t facesBeyond() const;
  /// Of all labels; a face with two labels counts twice.
  std::size_t faceCount() const;
  std::size_t waiting() const { return waiting_.size(); }

 private:
  bool isOfMesh(const LabelSet& labels) const;
  void apply(const LabelSetConstPtr& labels);
  void applyAll(const LabelSetConstPtr& labels);
  void put(const LabelClusterConstPtr& cluster);

  MeshDataConstPtr mesh_;
  LabelClusters labels_;
  std::set<std::string> changed_;
  std::map<std::string, std::size_t> beyond_;
  std::deque<LabelSetConstPtr> waiting_;
  std::set<std::string> newer_;  ///< than the complete set that is expected
  bool expects_all_ = true;
  bool complete_ = false;
};

}  // namespace rviz_mesh_plugin
