#include "rviz_mesh_plugin/cluster_label_display.h"

#include <algorithm>

#include <rviz/display_context.h>
#include <rviz/frame_manager.h>
#include <rviz/validate_floats.h>

#include "rviz_mesh_plugin/label_overlay.h"
#include "rviz_mesh_plugin/label_properties.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::milliseconds BUDGET(8);  // of one update, for each kind of work
constexpr std::chrono::seconds PATIENCE(10);    // until a label that was sent should be stored

}  // namespace

void ClusterLabelDisplay::update(float /*wall_dt*/, float /*ros_dt*/)
{
  guarded([this] {
    takeMessages();
    takeColors();
    applyChanges();
    properties_->work(BUDGET);
    updatePose();
    updateStatuses();
  });
}

void ClusterLabelDisplay::takeMessages()
{
  const MeshLoader::Content content = loader_->take();
  state_.geometry = content.reception;
  state_.working = content.working;
  if (!content.meshes.empty() && content.meshes.back() != store_.mesh()) {
    failure_.clear();
    store_.setMesh(content.meshes.back());
    if (overlay_) {
      overlay_->setMesh(store_.mesh());
    }
    if (!labelsTopic().empty()) {
      services_.requestLabels(store_.mesh()->uuid);
    }
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
  const auto news = owner_.takeColors(store_.mesh()->uuid);
  if (!news) {
    return;
  }
  std::set<std::string> changed;
  for (const auto& old : colors_.own()) {
    changed.insert(old.first);
  }
  for (const std::string& label : changed) {
    if (news->count(label) == 0) {
      colors_.removeOwn(label);
    }
  }
  for (const auto& color : *news) {
    colors_.setOwn(color.first, color.second);
    changed.insert(color.first);
  }
  for (const std::string& label : changed) {
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
      overlay_->setLabel({label, faces->second});
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
  const std::string frame =
      source_ && !source_->frame.empty() ? source_->frame : store_.mesh()->frame_id;
  rviz::FrameManager* frames = context_->getFrameManager();
  Ogre::Vector3 position;
  Ogre::Quaternion orientation;
  const bool known = frames->getTransform(frame, ros::Time(), position, orientation) &&
                     rviz::validateFloats(position) && rviz::validateFloats(orientation);
  overlay_->setVisible(known && isEnabled());
  if (known) {
    orientation.normalise();
    overlay_->setPose(position, orientation);
    lines_.report("Transform",
                  StatusLine{StatusLine::OK, "frame '" + frame + "' is known in the fixed frame '" +
                                                 frames->getFixedFrame() + "'"});
  } else {
    lines_.report("Transform",
                  StatusLine{StatusLine::ERROR,
                             "no transform from frame '" + frame + "' to the fixed frame '" +
                                 frames->getFixedFrame() + "', the labels are hidden until then"});
  }
}

void ClusterLabelDisplay::updateStatuses()
{
  state_.source_given = source_.has_value();
  state_.geometry_topic = geometryTopic();
  state_.labels_topic = labelsTopic();
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
  lines_.report("Labels", failure_.empty() ? labelsStatus(state_, store_)
                                           : StatusLine{StatusLine::ERROR,
                                                        "labels cannot be drawn: " + failure_});
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
