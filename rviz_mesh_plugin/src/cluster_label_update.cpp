#include "rviz_mesh_plugin/cluster_label_display.h"

#include <algorithm>

#include <rviz/display_context.h>

#include "rviz_mesh_plugin/frame_pose.h"
#include "rviz_mesh_plugin/label_overlay.h"
#include "rviz_mesh_plugin/label_properties.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::milliseconds BUDGET(8);  // of one update, for each kind of work
constexpr std::chrono::seconds PATIENCE(10);    // until a label that was sent should be stored

}  // namespace

void ClusterLabelDisplay::update(float /*wall_dt*/, float /*ros_dt*/)
{
  const bool done = lines_.attempt([this] { work(); });
  if (done && work_failed_) {
    lines_.report("Display", std::nullopt);
  }
  work_failed_ = !done;
}

void ClusterLabelDisplay::work()
{
  takeMessages();
  takeColors();
  applyChanges();
  properties_->work(BUDGET);
  updatePose();
  updateStatuses();
}

void ClusterLabelDisplay::takeMessages()
{
  const MeshLoader::Content content = loader_->take();
  state_.geometry = content.reception;
  state_.working = content.working;
  if (!content.meshes.empty() && content.meshes.back() != store_.mesh()) {
    store_.setMesh(content.meshes.back());
    if (overlay_) {
      overlay_->setMesh(store_.mesh());
    }
    services_.cancel();  // the labels of a mesh that was here before are asked for once more
  }
  if (store_.mesh() && !source().labels_topic.empty()) {
    services_.requestLabels(store_.mesh()->uuid);
  }
  const InboxContent news = inbox_->take();
  state_.labels = news.labels_reception;
  for (const LabelSetConstPtr& labels : news.labels) {
    store_.add(labels);
    for (const LabelCluster& cluster : labels->clusters) {
      edits_.erase(cluster.label);
    }
  }
}

void ClusterLabelDisplay::takeColors()
{
  if (!store_.mesh()) {
    return;
  }
  std::string failure = owner_.takeFailure();
  if (!failure.empty()) {
    edit_failure_ = failure;
  }
  const std::string& uuid = store_.mesh()->uuid;
  label_colors_.request(uuid);
  for (const std::string& label : colors_.setOwn(label_colors_.colors(uuid))) {
    applyLook(label);
  }
}

/// Takes changes of labels to the properties at once and to the overlay in slices.
void ClusterLabelDisplay::applyChanges()
{
  const std::set<std::string> changed = store_.takeChanged();
  if (!changed.empty()) {
    recount_ = true;
    to_show_.insert(changed.begin(), changed.end());
    std::vector<std::string> names;
    classes_.clear();
    for (const auto& label : store_.labels()) {
      names.push_back(label.first);
      ++classes_[labelClass(label.first)];
    }
    if (names != names_) {
      names_ = names;
      properties_->setLabels(names_);
    }
  }
  if (!overlay_) {
    return;
  }
  const auto end = Clock::now() + BUDGET;
  bool new_objects = false;
  while (!to_show_.empty() && Clock::now() < end) {
    const std::string label = *to_show_.begin();
    to_show_.erase(to_show_.begin());
    const auto faces = store_.labels().find(label);
    if (faces == store_.labels().end()) {
      overlay_->removeLabel(label);
    } else {
      applyLook(label);
      overlay_->setLabel(faces->second);
    }
    new_objects = true;
  }
  if (!overlay_->upload(BUDGET) || new_objects) {
    queueRender();
  }
  if (new_objects) {
    setVisibilityBits(getVisibilityBits());
  }
}

void ClusterLabelDisplay::applyLook(const std::string& label)
{
  if (store_.labels().count(label) == 0) {
    return;
  }
  const Rgba8 color = colors_.color(label);
  properties_->setColor(label, color);
  if (overlay_) {
    overlay_->setColor(label, color);
    overlay_->setVisible(label, properties_->isShown(label));
    queueRender();
  }
}

void ClusterLabelDisplay::updatePose()
{
  if (!overlay_ || !store_.mesh()) {
    lines_.report("Transform", std::nullopt);
    return;
  }
  StatusLine line;
  const auto pose =
      findPose(*context_->getFrameManager(),
               source_ && !source_->frame.empty() ? source_->frame : store_.mesh()->frame_id,
               "the labels are", line);
  overlay_->setVisible(pose && isEnabled());
  if (pose) {
    overlay_->setPose(pose->position, pose->orientation);
  }
  lines_.report("Transform", line);
}

void ClusterLabelDisplay::updateStatuses()
{
  state_.source_given = source_.has_value();
  const MeshSource source = this->source();
  state_.geometry_topic = source.geometry_topic;
  state_.labels_topic = source.labels_topic;
  state_.label_count = store_.labels().size();
  state_.class_count = classes_.size();
  state_.to_show = to_show_.size();
  if (recount_) {
    recount_ = false;
    state_.hidden = static_cast<std::size_t>(
        std::count_if(store_.labels().begin(), store_.labels().end(),
                      [this](const auto& label) { return !properties_->isShown(label.first); }));
  }
  lines_.report("Geometry", labelGeometryStatus(state_, store_));
  lines_.report("Labels", labelsStatus(state_, store_));
  lines_.report("Label colors", label_colors_.status());
  lines_.report("Services", servicesStatus(services_.report()));
  const auto late = std::find_if(edits_.begin(), edits_.end(), [](const auto& edit) {
    return Clock::now() - edit.second > PATIENCE;
  });
  if (!edit_failure_.empty()) {
    lines_.report("Edits", StatusLine{StatusLine::ERROR, edit_failure_});
  } else if (late != edits_.end()) {
    lines_.report("Edits", StatusLine{StatusLine::WARN,
                                      "label '" + late->first + "' was sent to " + owner_.topic() +
                                          ", but has not come back as stored: see the log of the "
                                          "node that listens there"});
  } else if (!edits_.empty()) {
    lines_.report("Edits",
                  StatusLine{StatusLine::OK, "'" + edits_.begin()->first + "' is being stored"});
  } else {
    lines_.report("Edits", std::nullopt);
  }
}

}  // namespace rviz_mesh_plugin
