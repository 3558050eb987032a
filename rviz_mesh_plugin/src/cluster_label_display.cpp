#include "rviz_mesh_plugin/cluster_label_display.h"

#include <mesh_msgs/MeshGeometryStamped.h>
#include <ros/message_traits.h>

#include "rviz_mesh_plugin/label_overlay.h"
#include "rviz_mesh_plugin/label_properties.h"

namespace rviz_mesh_plugin {

ClusterLabelDisplay::ClusterLabelDisplay()
    : properties_(new LabelProperties(this)),
      inbox_(std::make_shared<MeshInbox>()),
      loader_(std::make_shared<MeshLoader>(false)),
      topics_(inbox_, loader_),
      services_(inbox_, loader_),
      lines_(this)
{
  connect(properties_, SIGNAL(topicsChanged()), this, SLOT(onTopics()));
  connect(properties_, SIGNAL(lookChanged()), this, SLOT(onLook()));
  connect(properties_, SIGNAL(labelVisibilityChanged(QString)), this,
          SLOT(onLabelVisibility(QString)));
  connect(properties_, SIGNAL(classVisibilityChanged(QString)), this,
          SLOT(onClassVisibility(QString)));
  connect(properties_, SIGNAL(colorChosen(QString)), this, SLOT(onColorChosen(QString)));
}

ClusterLabelDisplay::~ClusterLabelDisplay()
{
  topics_.unsubscribe();
}

void ClusterLabelDisplay::onInitialize()
{
  lines_.attempt([this] {
    overlay_ = std::make_unique<LabelOverlay>(scene_manager_, scene_node_);
    overlay_->setVisible(false);
  });
  onLook();
}

void ClusterLabelDisplay::setSource(const MeshSource& source)
{
  source_ = source;
  properties_->setTopicsHidden(true);
  onTopics();
}

/// The other topic, where there is none yet, is the one that hdf5_map_server has beside it.
void ClusterLabelDisplay::setTopic(const QString& topic, const QString& datatype)
{
  const QString geometry_type =
      QString::fromLatin1(ros::message_traits::datatype<mesh_msgs::MeshGeometryStamped>());
  const QString geometry = "mesh/geometry";
  const QString labels = "new_cluster_label";
  const bool of_labels = datatype != geometry_type;
  properties_->setTopic(topic, of_labels);
  const QString& mine = of_labels ? labels : geometry;
  const std::string other = of_labels ? properties_->geometryTopic() : properties_->labelsTopic();
  if (other.empty() && topic.endsWith("/" + mine)) {
    properties_->setTopic(topic.left(topic.size() - mine.size()) + (of_labels ? geometry : labels),
                          !of_labels);
  }
}

MeshSource ClusterLabelDisplay::source() const
{
  if (source_) {
    return *source_;
  }
  MeshSource source;
  source.geometry_topic = properties_->geometryTopic();
  source.labels_topic = properties_->labelsTopic();
  return source;
}

void ClusterLabelDisplay::onEnable()
{
  lines_.attempt([this] { subscribe(); });
}

void ClusterLabelDisplay::onDisable()
{
  lines_.attempt([this] {
    unsubscribe();
    if (overlay_) {
      overlay_->setVisible(false);
    }
  });
}

void ClusterLabelDisplay::subscribe()
{
  unsubscribe();
  const MeshSource source = this->source();
  state_.subscription_error.clear();
  try {
    // Services and the topic of edits are beside that of the labels.
    ServiceNames names;
    names.geometry_topic = source.geometry_topic;
    names.service_namespace = labelNamespace(source);
    services_.setNames(names);
    state_.subscription_error = topics_.subscribeGeometry(threaded_nh_, source.geometry_topic);
    const std::string error = topics_.subscribeLabels(threaded_nh_, source.labels_topic);
    if (state_.subscription_error.empty()) {
      state_.subscription_error = error;
    }
    owner_.connect(threaded_nh_, names.service_namespace);
    label_colors_.connect(threaded_nh_, names.service_namespace);
  } catch (const ros::Exception& error) {
    state_.subscription_error = "these topics cannot be used: " + std::string(error.what());
  }
  if (store_.mesh() && !source.labels_topic.empty()) {
    services_.requestLabels(store_.mesh()->uuid);  // changes may have been missed
  }
}

void ClusterLabelDisplay::unsubscribe()
{
  topics_.unsubscribe();
  services_.cancel();
  owner_.disconnect();
  label_colors_.disconnect();
}

void ClusterLabelDisplay::restart()
{
  lines_.attempt([this] {
    unsubscribe();
    loader_->clear();
    inbox_->clearLabels();
    store_.clear();
    label_colors_.clear();
    colors_.clear();
    edits_.clear();
    edit_failure_.clear();
    state_ = LabelDisplayState();
    if (overlay_) {
      overlay_->setMesh(nullptr);
    }
    applyChanges();
    if (isEnabled()) {
      subscribe();
    }
  });
}

void ClusterLabelDisplay::reset()
{
  rviz::Display::reset();
  lines_.forget();
  restart();
}

void ClusterLabelDisplay::onTopics()
{
  restart();
}

void ClusterLabelDisplay::onLook()
{
  lines_.attempt([this] {
    if (overlay_) {
      overlay_->setAlpha(properties_->alpha());
      overlay_->setPhantom(properties_->phantom());
      setVisibilityBits(getVisibilityBits());
    }
  });
  queueRender();
}

void ClusterLabelDisplay::onLabelVisibility(const QString& label)
{
  recount_ = true;
  lines_.attempt([&] { applyLook(label.toStdString()); });
}

void ClusterLabelDisplay::onClassVisibility(const QString& label_class)
{
  recount_ = true;
  lines_.attempt([&] {
    for (const auto& label : store_.labels()) {
      if (labelClass(label.first) == label_class.toStdString()) {
        applyLook(label.first);
      }
    }
  });
}

void ClusterLabelDisplay::onColorChosen(const QString& label)
{
  lines_.attempt([&] {
    const std::string name = label.toStdString();
    const Rgba8 color = properties_->chosenColor(name);
    const bool of_class = color == colors_.classColor(labelClass(name));
    edit_failure_ = setLabelColor(name, of_class ? nullptr : &color);
    applyLook(name);  // as it is until the new color is stored
  });
}

std::string ClusterLabelDisplay::activeLabel() const
{
  return properties_->activeLabel();
}

void ClusterLabelDisplay::setActiveLabel(const std::string& label)
{
  properties_->setActiveLabel(label);
}

float ClusterLabelDisplay::brushSize() const
{
  return properties_->brushSize();
}

std::string ClusterLabelDisplay::whyNotEditable(const std::string& label) const
{
  if (label.empty()) {
    return "a label has no name: call it like tree_1, class and instance";
  }
  if (!store_.mesh()) {
    return "there is no mesh to label yet";
  }
  if (!owner_.isHeard()) {
    return "nobody stores labels: no hdf5_map_server or label_manager listens on " +
           (owner_.topic().empty() ? "cluster_label" : owner_.topic());
  }
  return {};
}

std::string ClusterLabelDisplay::setLabelFaces(const std::string& label,
                                               const std::vector<std::uint32_t>& faces)
{
  return storeFaces(label, faces, true);
}

std::string ClusterLabelDisplay::addLabelFaces(const std::string& label,
                                               const std::vector<std::uint32_t>& faces)
{
  return storeFaces(label, faces, false);
}

std::string ClusterLabelDisplay::storeFaces(const std::string& label,
                                            const std::vector<std::uint32_t>& faces, bool override)
{
  std::string reason = whyNotEditable(label);
  if (reason.empty()) {
    edit_failure_.clear();
    lines_.attempt([&] {
      owner_.store(*store_.mesh(), label, faces, override);
      edits_[label] = Clock::now();
    });
  }
  return reason;
}

std::string ClusterLabelDisplay::setLabelColor(const std::string& label, const Rgba8* color)
{
  std::string reason = whyNotEditable(label);
  if (reason.empty()) {
    edit_failure_.clear();
    lines_.attempt([&] { owner_.setColor(store_.mesh()->uuid, label, color); });
  }
  return reason;
}

}  // namespace rviz_mesh_plugin
