#include "mesh_view/mesh_labels.h"

#include <numeric>

namespace rviz_mesh_plugin {

void MeshLabels::show(const MeshDataConstPtr& mesh, const LabelClusters& labels, float alpha)
{
  if (mesh != mesh_ || labels.empty()) {
    clear();
  }
  if (!mesh || labels.empty()) {
    return;
  }
  if (!overlay_) {
    overlay_ = std::make_unique<LabelOverlay>(scene_manager_, parent_);
    overlay_->setMesh(mesh);
    mesh_ = mesh;
    setPose(pose_);
  }
  for (auto item = drawn_.begin(); item != drawn_.end();) {
    if (labels.count(item->first) == 0) {
      overlay_->removeLabel(item->first);
      left_out_.erase(item->first);
      item = drawn_.erase(item);
    } else {
      ++item;
    }
  }
  for (const auto& label : labels) {
    LabelClusterConstPtr& drawn = drawn_[label.first];
    if (drawn != label.second) {
      overlay_->setColor(label.first, colors_.color(label.first));
      left_out_[label.first] = overlay_->setLabel(label.second);
      drawn = label.second;
    }
  }
  overlay_->setAlpha(alpha);
}

bool MeshLabels::setOwnColors(const OwnColorsConstPtr& own)
{
  bool changed = false;
  for (const std::string& label : colors_.setOwn(own)) {
    if (drawn_.count(label) != 0) {
      overlay_->setColor(label, colors_.color(label));
      changed = true;
    }
  }
  return changed;
}

void MeshLabels::clear()
{
  overlay_.reset();
  mesh_.reset();
  drawn_.clear();
  left_out_.clear();
}

bool MeshLabels::upload(std::chrono::microseconds budget)
{
  return !overlay_ || overlay_->upload(budget);
}

void MeshLabels::setPose(const std::optional<FramePose>& pose)
{
  pose_ = pose;
  if (overlay_) {
    overlay_->setVisible(pose.has_value());
    if (pose) {
      overlay_->setPose(pose->position, pose->orientation);
    }
  }
}

std::size_t MeshLabels::leftOut() const
{
  return std::accumulate(left_out_.begin(), left_out_.end(), std::size_t{0},
                         [](std::size_t sum, const auto& label) { return sum + label.second; });
}

}  // namespace rviz_mesh_plugin
