#include "displays/cluster_label_display.h"

#include <algorithm>
#include <chrono>

#include <mesh_msgs/MeshGeometryStamped.h>
#include <ros/message_traits.h>
#include <rviz/display_context.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include "displays/display_tree.h"
#include "displays/label_names.h"
#include "displays/label_properties.h"
#include "displays/textured_mesh_display.h"
#include "labels/label_name.h"
#include "mesh_view/frame_pose.h"
#include "rendering/labels/label_overlay.h"

namespace rviz_mesh_plugin {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds BUDGET(8);  // of one update, for each kind of work

/// What is seen of a mesh: as the first display that is enabled and draws it says.
Section sectionOf(const rviz::DisplayGroup* displays, const MeshData& mesh)
{
  std::optional<Section> section;
  visitDisplays<TexturedMeshDisplay>(displays, DisplayChoice::ENABLED,
                                     [&](const TexturedMeshDisplay& display) {
                                       if (!section && display.drawn(mesh.uuid)) {
                                         section = display.section();
                                       }
                                     });
  return section.value_or(Section());
}

}  // namespace

ClusterLabelDisplay::ClusterLabelDisplay() : properties_(new LabelProperties(this)), lines_(this)
{
  using Self = ClusterLabelDisplay;
  connect(properties_, &LabelProperties::topicsChanged, this, &Self::restart);
  connect(properties_, &LabelProperties::lookChanged, this, &Self::onLook);
  connect(properties_, &LabelProperties::visibilityChanged, this, &Self::onVisibility);
  connect(properties_, &LabelProperties::colorChosen, this, &Self::onColorChosen);
}

ClusterLabelDisplay::~ClusterLabelDisplay() = default;

void ClusterLabelDisplay::onInitialize()
{
  lines_.attempt([this] {
    overlay_ = std::make_unique<LabelOverlay>(scene_node_);
    overlay_->setVisible(false);
  });
  onLook();
}

void ClusterLabelDisplay::setSource(const MeshSource& source)
{
  source_ = source;
  properties_->setTopicsHidden(true);
  restart();
}

/// The other topic, where there is none yet, is the one that hdf5_map_server has beside it.
void ClusterLabelDisplay::setTopic(const QString& topic, const QString& datatype)
{
  const bool of_labels =
      datatype != ros::message_traits::datatype<mesh_msgs::MeshGeometryStamped>();
  properties_->setTopic(topic, of_labels);
  const QString names[] = {"mesh/geometry", "new_cluster_label"};
  const QString& mine = names[of_labels ? 1 : 0];
  const std::string other = of_labels ? properties_->geometryTopic() : properties_->labelsTopic();
  if (other.empty() && topic.endsWith("/" + mine)) {
    properties_->setTopic(topic.left(topic.size() - mine.size()) + names[of_labels ? 0 : 1],
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
    label_names_.reset();
  });
}

void ClusterLabelDisplay::subscribe()
{
  unsubscribe();
  store_.expectAll();  // they are asked for anew
  ask_again_ = false;
  takeLabels(false);
  const MeshSource source = this->source();
  asked_for_parents_ = false;
  subscription_error_.clear();
  try {
    // Services and the topic of edits are beside that of the labels.
    MeshSources::Names names;
    names.topics[MeshMember::GEOMETRY] = source.geometry_topic;
    names.topics[MeshMember::LABELS] = source.labels_topic;
    names.services.geometry_topic = source.geometry_topic;
    names.services.service_namespace = labelNamespace(source);
    sources_.connect(threaded_nh_, names);
    subscription_error_ = sources_.error(MeshMember::GEOMETRY);
    if (subscription_error_.empty()) {
      subscription_error_ = sources_.error(MeshMember::LABELS);
    }
    owner_.connect(threaded_nh_, names.services.service_namespace);
    label_colors_.connect(threaded_nh_, names.services.service_namespace);
    face_parents_.connect(names.services.service_namespace);
  } catch (const ros::Exception& error) {
    subscription_error_ = "these topics cannot be used: " + std::string(error.what());
  }
}

void ClusterLabelDisplay::unsubscribe()
{
  sources_.disconnect();
  owner_.disconnect();
  label_colors_.disconnect();
  face_parents_.disconnect();
}

void ClusterLabelDisplay::restart()
{
  lines_.attempt([this] {
    unsubscribe();
    sources_.clear();
    store_.clear();
    label_colors_.clear();
    colors_.clear();
    edits_.reset();
    edit_failure_.clear();
    subscription_error_.clear();
    received_ = MeshLoader::Content();
    labels_received_ = Reception();
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

void ClusterLabelDisplay::onVisibility()
{
  recount_ = true;
  renamed_ = true;
  lines_.attempt([this] {
    for (const auto& label : store_.labels()) {
      if (overlay_) {
        overlay_->setVisible(label.first, properties_->visibility().isShown(label.first));
      }
    }
  });
  queueRender();
}

void ClusterLabelDisplay::onColorChosen(const QString& label, const QColor& chosen)
{
  lines_.attempt([&] {
    const std::string name = label.toStdString();
    const Rgba8 color = toRgba8(chosen);
    const bool of_class = color == colors_.classColor(labelClass(name));
    edit_failure_ = setLabelColor(name, of_class ? nullptr : &color);
    applyLook(name);  // as it is until the new color is stored
  });
}

std::optional<Rgba8> ClusterLabelDisplay::ownColor(const std::string& label) const
{
  const OwnColorsConstPtr own = mesh() ? label_colors_.colors(mesh()->uuid) : nullptr;
  const auto color = own ? own->find(label) : OwnColors::const_iterator();
  return own && color != own->end() ? std::optional<Rgba8>(color->second) : std::nullopt;
}

FaceParentsConstPtr ClusterLabelDisplay::faceParents() const
{
  return mesh() ? face_parents_.parents(mesh()->uuid) : nullptr;
}

const LabelLooks& ClusterLabelDisplay::looks() const
{
  static const LabelLooks none;
  return overlay_ ? overlay_->looks() : none;
}

void ClusterLabelDisplay::setShown(const std::string& label, bool shown)
{
  properties_->visibility().setShown(label, shown);
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

std::string ClusterLabelDisplay::storeFaces(const std::string& label,
                                            const LabelFacesConstPtr& faces, bool override)
{
  std::string reason = whyNotEditable(label);
  if (reason.empty()) {
    edit_failure_.clear();
    // Where nobody could tell before.
    face_parents_.request(store_.mesh()->uuid, store_.mesh()->faceCount());
    lines_.attempt([&] {
      const auto edit = sentEdit(*store_.mesh(), label, faces, override, faceParents());
      if (override && faces->empty()) {
        owner_.remove(edit);
      } else {
        owner_.store(edit);
      }
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

void ClusterLabelDisplay::update(float /*wall_dt*/, float /*ros_dt*/)
{
  lines_.repeat([this] { work(); });
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
  received_ = sources_.loader().take();
  if (!received_.meshes.empty() && received_.meshes.back() != store_.mesh()) {
    store_.setMesh(received_.meshes.back());
    asked_for_parents_ = false;
    if (overlay_) {
      overlay_->setMesh(store_.mesh());
    }
    askAnew();  // of a mesh that was here before, once more
    takeLabels(false);
  }
  if (store_.mesh() && !source().labels_topic.empty()) {
    sources_.services().requestLabels(store_.mesh()->uuid);  // once since it was subscribed to
  }
  takeLabels();
}

/// @param answered else answers are those to questions before the last one: they are dropped
void ClusterLabelDisplay::takeLabels(bool answered)
{
  const QueuedAttributes queued = sources_.queue().take();
  labels_received_ = queued.receptions[MeshMember::LABELS];
  for (const LabelSetConstPtr& labels : queued.labels) {
    if (answered || !labels->all) {
      store_.add(labels);
    }
  }
  if (ask_again_ && !store_.expectsAll()) {
    askAnew();
  }
}

/// Not before the last answer has come: it would be lost, and the next one, too, where that is
/// slow.
void ClusterLabelDisplay::askForLabels()
{
  if (store_.expectsAll()) {
    ask_again_ = true;
  } else {
    takeLabels();  // what has come is older than the answer
    askAnew();
  }
}

void ClusterLabelDisplay::askAnew()
{
  ask_again_ = false;
  store_.expectAll();
  sources_.services().cancel();
}

void ClusterLabelDisplay::takeColors()
{
  if (!store_.mesh()) {
    return;
  }
  std::string failure = owner_.work();
  if (!failure.empty()) {
    edit_failure_ = failure;
  }
  const std::string& uuid = store_.mesh()->uuid;
  label_colors_.request(uuid);
  if (!asked_for_parents_ && owner_.isHeard()) {  // who tells of them is there before it listens
    face_parents_.request(uuid, store_.mesh()->faceCount());
    asked_for_parents_ = true;
  }
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
    renamed_ = true;
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
  renamed_ = true;
  properties_->setColor(label, color);
  if (overlay_) {
    overlay_->setColor(label, color);
    overlay_->setVisible(label, properties_->visibility().isShown(label));
    queueRender();
  }
}

void ClusterLabelDisplay::updatePose()
{
  if (!overlay_ || !store_.mesh()) {
    lines_.report("Transform", std::nullopt);
    label_names_.reset();
    return;
  }
  StatusLine line;
  const auto pose =
      findPose(*context_->getFrameManager(),
               source_ && !source_->frame.empty() ? source_->frame : store_.mesh()->frame_id,
               "the labels are", line);
  overlay_->place(isEnabled() ? pose : std::nullopt);
  const Section section = sectionOf(context_->getRootDisplayGroup(), *store_.mesh());
  overlay_->setSection(section);
  const HiddenFacesConstPtr hidden = hiddenFaces(*store_.mesh());
  renamed_ |= hidden != hidden_faces_;
  hidden_faces_ = hidden;
  overlay_->setHidden(hidden);
  lines_.report("Transform", line);
  updateNames(isEnabled() ? pose : std::nullopt, section);
}

void ClusterLabelDisplay::updateNames(const std::optional<FramePose>& pose, const Section& section)
{
  if (!properties_->names() || !pose) {
    label_names_.reset();
    return;
  }
  if (!label_names_) {
    label_names_ = std::make_unique<LabelNames>(scene_node_);
    renamed_ = true;
  }
  if (renamed_) {
    renamed_ = false;
    label_names_->setLabels(store_.mesh(), store_.labels(), overlay_->looks(), hidden_faces_);
  }
  label_names_->place(pose);
  const rviz::ViewController* const view =
      context_->getViewManager() ? context_->getViewManager()->getCurrent() : nullptr;
  if (label_names_->update(view ? view->getCamera() : nullptr, section)) {
    setVisibilityBits(getVisibilityBits());
    queueRender();
  }
}

std::vector<std::string> ClusterLabelDisplay::drawnNames() const
{
  return label_names_ ? label_names_->drawn() : std::vector<std::string>();
}

/// Which mesh is labelled, or why there is none.
StatusLine ClusterLabelDisplay::geometryStatus() const
{
  const std::string topic = source().geometry_topic;
  if (!subscription_error_.empty()) {
    return StatusLine::error(subscription_error_);
  }
  if (topic.empty() && source_) {
    return noMapOpen();
  }
  if (topic.empty()) {
    return StatusLine::error(
        "there is no mesh to label: choose a 'Geometry Topic' and a 'Labels Topic', or add a Map3D "
        "display, which brings a display of labels of its own");
  }
  if (!received_.reception.refusal.empty()) {
    return StatusLine::error("the newest mesh on ", topic,
                             " was refused: ", received_.reception.refusal);
  }
  if (store_.mesh()) {
    return StatusLine::ok(counted(store_.mesh()->faceCount(), "face", "faces"), ", uuid ",
                          quotedName(store_.mesh()->uuid));
  }
  if (!received_.working.empty()) {
    return StatusLine::ok(received_.working);
  }
  return StatusLine::warn("no mesh received on ", topic, " yet: is its node running?");
}

/// Which labels there are, or why there are none.
OptionalStatus ClusterLabelDisplay::labelsStatus() const
{
  if (!store_.mesh()) {
    return std::nullopt;
  }
  if (!labels_received_.refusal.empty()) {
    return StatusLine::error("the newest labels were refused: ", labels_received_.refusal);
  }
  if (source().labels_topic.empty()) {
    return StatusLine::warn(
        "no labels: choose a 'Labels Topic', as /new_cluster_label of hdf5_map_server");
  }
  if (store_.labels().empty() && store_.waiting() > 0) {
    return StatusLine::warn(
        "labels of another mesh have arrived: both topics have to be of one node");
  }
  if (store_.labels().empty()) {
    return StatusLine::ok(store_.isComplete()
                              ? "the mesh has no labels (yet)"
                              : "no label received yet; those that change show here");
  }
  StatusLine line = StatusLine::ok(counted(store_.labels().size(), "label", "labels"), " of ",
                                   counted(classes_.size(), "class", "classes"), " on ",
                                   counted(store_.faceCount(), "face", "faces"));
  if (hidden_ > 0) {
    line.text += joined(", ", hidden_, " hidden");
  }
  if (label_names_ && label_names_->leftOut() > 0) {
    line.text += joined(", ", label_names_->leftOut(), " without their name in the picture: the ",
                        LabelNames::MOST, " with the most faces have it");
  }
  if (!to_show_.empty()) {
    line.text += joined(", ", to_show_.size(), " to be shown yet");
  }
  if (const std::size_t beyond = store_.facesBeyond()) {
    line = StatusLine::warn(line.text, "; ", counted(beyond, "index", "indices"),
                            " left out, which the mesh has no face for: the labels were made for "
                            "another one");
  }
  return line;
}

void ClusterLabelDisplay::updateStatuses()
{
  if (recount_) {
    recount_ = false;
    hidden_ = static_cast<std::size_t>(std::count_if(
        store_.labels().begin(), store_.labels().end(),
        [this](const auto& label) { return !properties_->visibility().isShown(label.first); }));
  }
  lines_.report("Geometry", geometryStatus());
  lines_.report("Labels", labelsStatus());
  lines_.report("Label colors", label_colors_.status());
  lines_.report("Services", sources_.services().report().status(ServiceReport::State::SEARCHING));
  lines_.report("Edits",
                edit_failure_.empty() ? edits_ : OptionalStatus(StatusLine::error(edit_failure_)));
}

}  // namespace rviz_mesh_plugin
