#include "mesh_view/mesh_labels.h"

#include <numeric>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {

void MeshLabels::show(const MeshDataConstPtr& mesh, const LabelClusters& labels, float alpha,
                      const Section& section)
{
  if (mesh != mesh_ || labels.empty()) {
    clear();
  }
  if (!mesh || labels.empty()) {
    return;
  }
  if (!overlay_) {
    overlay_ = std::make_unique<LabelOverlay>(parent_);
    overlay_->setMesh(mesh);
    mesh_ = mesh;
    overlay_->place(pose_);
  }
  eraseIf(drawn_, [&](const auto& label) {
    const bool is_gone = labels.count(label.first) == 0;
    if (is_gone) {
      overlay_->removeLabel(label.first);
    }
    return is_gone;
  });
  for (const auto& label : labels) {
    Drawn& drawn = drawn_[label.first];
    if (drawn.label != label.second) {
      overlay_->setColor(label.first, colors_.color(label.first));
      drawn = {label.second, overlay_->setLabel(label.second)};
    }
  }
  overlay_->setAlpha(alpha);
  overlay_->setSection(section);
  overlay_->setHidden(hiddenFaces(*mesh));
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
}

bool MeshLabels::upload(std::chrono::microseconds budget)
{
  return !overlay_ || overlay_->upload(budget);
}

void MeshLabels::setPose(const std::optional<FramePose>& pose)
{
  pose_ = pose;
  if (overlay_) {
    overlay_->place(pose);
  }
}

std::size_t MeshLabels::leftOut() const
{
  return std::accumulate(
      drawn_.begin(), drawn_.end(), std::size_t{0},
      [](std::size_t sum, const auto& label) { return sum + label.second.left_out; });
}

}  // namespace rviz_mesh_plugin
