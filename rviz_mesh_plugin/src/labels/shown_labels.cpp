#include "labels/shown_labels.h"

#include "labels/label_faces.h"

namespace rviz_mesh_plugin {

void ShownLabels::setMesh(const MeshDataConstPtr& mesh)
{
  if (mesh == mesh_) {
    return;
  }
  for (const auto& label : labels_) {
    changed_.insert(label.first);
  }
  // The same mesh in another frame, say, keeps its labels.
  if (!mesh || !mesh_ || mesh->uuid != mesh_->uuid || mesh->faceCount() != mesh_->faceCount()) {
    labels_.clear();
    beyond_.clear();
    expectAll();
    complete_ = false;
  }
  mesh_ = mesh;
  std::deque<LabelSetConstPtr> others;
  for (const LabelSetConstPtr& labels : waiting_) {
    if (mesh_ && isOfMesh(*labels)) {
      apply(labels);
    } else {
      others.push_back(labels);
    }
  }
  waiting_.swap(others);
}

void ShownLabels::add(const LabelSetConstPtr& labels)
{
  if (mesh_ && isOfMesh(*labels)) {
    apply(labels);
    if (expects_all_) {
      for (const LabelCluster& cluster : labels->clusters) {
        newer_.insert(cluster.label);
      }
    }
    return;
  }
  waiting_.push_back(labels);
  if (waiting_.size() > MAX_WAITING) {
    waiting_.pop_front();
  }
}

void ShownLabels::clear()
{
  setMesh(nullptr);
  waiting_.clear();
}

void ShownLabels::expectAll()
{
  newer_.clear();
  expects_all_ = true;
}

bool ShownLabels::isOfMesh(const LabelSet& labels) const
{
  return labels.uuid.empty() || labels.uuid == mesh_->uuid;
}

void ShownLabels::apply(const LabelSetConstPtr& labels)
{
  if (labels->all) {
    applyAll(labels);
    return;
  }
  for (const LabelCluster& cluster : labels->clusters) {
    put(LabelClusterConstPtr(labels, &cluster));
  }
}

void ShownLabels::applyAll(const LabelSetConstPtr& labels)
{
  std::set<std::string> kept = newer_;
  for (const LabelCluster& cluster : labels->clusters) {
    kept.insert(cluster.label);
  }
  for (auto label = labels_.begin(); label != labels_.end();) {
    if (kept.count(label->first) == 0) {
      changed_.insert(label->first);
      beyond_.erase(label->first);
      label = labels_.erase(label);
    } else {
      ++label;
    }
  }
  for (const LabelCluster& cluster : labels->clusters) {
    if (newer_.count(cluster.label) == 0) {
      put(LabelClusterConstPtr(labels, &cluster));
    }
  }
  newer_.clear();
  expects_all_ = false;
  complete_ = true;
}

void ShownLabels::put(const LabelClusterConstPtr& cluster)
{
  const std::string& name = cluster->label;
  const LabelClusterConstPtr inside = withinMesh(cluster, mesh_->faceCount());
  beyond_.erase(name);
  if (inside != cluster) {
    beyond_[name] = cluster->faces.size() - inside->faces.size();
  }
  const auto known = labels_.find(name);
  if (inside->faces.empty()) {
    if (known != labels_.end()) {
      labels_.erase(known);
      changed_.insert(name);
    }
  } else if (known == labels_.end() || known->second->faces != inside->faces) {
    labels_[name] = inside;
    changed_.insert(name);
  }
}

std::set<std::string> ShownLabels::takeChanged()
{
  std::set<std::string> changed;
  changed.swap(changed_);
  return changed;
}

std::size_t ShownLabels::facesBeyond() const
{
  std::size_t sum = 0;
  for (const auto& label : beyond_) {
    sum += label.second;
  }
  return sum;
}

std::size_t ShownLabels::faceCount() const
{
  std::size_t sum = 0;
  for (const auto& label : labels_) {
    sum += label.second->faces.size();
  }
  return sum;
}

}  // namespace rviz_mesh_plugin
