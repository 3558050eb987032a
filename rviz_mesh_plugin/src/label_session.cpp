#include "rviz_mesh_plugin/label_session.h"

#include <algorithm>
#include <iterator>
#include <set>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <ros/names.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>

namespace rviz_mesh_plugin {
namespace {

/// As released; label_manager listens there, and leaves labels of a map that a server has to that.
/// Not latched: an old edit that is heard again would undo newer ones.
const char* const EVERYBODY = "/cluster_label";
constexpr std::uint32_t QUEUE = 100;

void findDisplays(const rviz::DisplayGroup* group, std::vector<ClusterLabelDisplay*>& found)
{
  for (int i = 0; group && i < group->numDisplays(); ++i) {
    rviz::Display* display = group->getDisplayAt(i);
    auto* labels = dynamic_cast<ClusterLabelDisplay*>(display);
    if (labels && labels->mesh()) {
      found.push_back(labels);
    }
    findDisplays(dynamic_cast<rviz::DisplayGroup*>(display), found);
  }
}

MeshId idOf(const MeshDataConstPtr& mesh)
{
  return mesh ? MeshId{mesh->uuid, mesh->faceCount()} : MeshId();
}

bool isSame(const MeshDataConstPtr& a, const MeshDataConstPtr& b)
{
  return a == b || (a && b && a->uuid == b->uuid && a->faceCount() == b->faceCount() &&
                    a->vertexCount() == b->vertexCount());
}

/// Those of the mesh are better than others, those that are enabled better than those that are not.
ClusterLabelDisplay* chooseDisplay(const rviz::DisplayGroup* root, const MeshDataConstPtr& mesh)
{
  std::vector<ClusterLabelDisplay*> displays;
  findDisplays(root, displays);
  const auto rank = [&](const ClusterLabelDisplay* display) {
    return (mesh && isSame(display->mesh(), mesh) ? 2 : 0) + (display->isEnabled() ? 1 : 0);
  };
  const auto best =
      std::max_element(displays.begin(), displays.end(),
                       [&](const auto* a, const auto* b) { return rank(a) < rank(b); });
  return best == displays.end() ? nullptr : *best;
}

/// None: the label is not there.
const LabelSession::Faces& storedFaces(const ClusterLabelDisplay& display, const std::string& label)
{
  static const LabelSession::Faces none;
  const auto stored = display.labels().find(label);
  return stored == display.labels().end() ? none : stored->second->faces;
}

bool hasChanged(const LabelEdit& edit, const ClusterLabelDisplay& display)
{
  if (edit.based_on.empty()) {
    return false;
  }
  const auto& faces = storedFaces(display, edit.label);
  return std::none_of(edit.based_on.begin(), edit.based_on.end(),
                      [&](const auto& expected) { return *expected == faces; });
}

}  // namespace

LabelSession::LabelSession(rviz::DisplayContext* context, std::chrono::milliseconds patience)
    : context_(context), edits_(patience)
{
  everybody_ = node_.advertise<mesh_msgs::MeshFaceClusterStamped>(EVERYBODY, QUEUE);
}

LabelSession::~LabelSession()
{
  for (const auto& saving : saving_) {
    saving.second.cancellation->set();
  }
}

void LabelSession::work(const MeshDataConstPtr& mesh)
{
  display_ = chooseDisplay(context_->getRootDisplayGroup(), mesh);
  namespace_ = display_ ? labelNamespace(*display_) : std::string();
  const auto stored = edits_.work(
      Clock::now(), [this](const LabelEdit& edit) { return isStored(edit); },
      [this](const LabelEdit& edit) { return send(edit); });
  for (const LabelEdit& edit : stored) {
    unsaved_[{edit.mesh(), edit.label}] = {labelNamespace(*displayOf(edit)), ++changes_};
  }
  takeSaved();
  if (!stored.empty() || labels() != known_) {
    known_ = labels();
    ++revision_;
  }
}

bool LabelSession::isOf(const MeshDataConstPtr& mesh) const
{
  return mesh && isSame(mesh, this->mesh());
}

void LabelSession::sendAgain()
{
  edits_.sendAgain();
  ++revision_;
}

void LabelSession::giveUp()
{
  edits_.giveUp();
  ++revision_;
}

const LabelClusters& LabelSession::labels() const
{
  static const LabelClusters none;
  return display_ ? display_->labels() : none;
}

bool LabelSession::labelsKnown() const
{
  return !display_ || namespace_.empty() || display_->labelsComplete();
}

std::optional<Rgba8> LabelSession::color(const std::string& label) const
{
  return display_ ? std::optional<Rgba8>(display_->labelColor(label)) : std::nullopt;
}

MeshId LabelSession::id() const
{
  return idOf(mesh());
}

std::vector<std::string> LabelSession::names() const
{
  std::set<std::string> names;
  for (const auto& label : labels()) {
    names.insert(label.first);
  }
  const auto pending = edits_.labels(id());
  names.insert(pending.begin(), pending.end());
  return {names.begin(), names.end()};
}

LabelSession::Faces LabelSession::faces(const std::string& label) const
{
  const LabelEdit* pending = edits_.find(id(), label);
  if (pending && !pending->adds) {
    return *pending->faces;
  }
  const Faces stored = display_ ? storedFaces(*display_, label) : Faces();
  if (!pending) {
    return stored;
  }
  Faces all;
  std::set_union(stored.begin(), stored.end(), pending->faces->begin(), pending->faces->end(),
                 std::back_inserter(all));
  return all;
}

std::size_t LabelSession::faceCount(const std::string& label) const
{
  if (edits_.find(id(), label)) {
    return faces(label).size();
  }
  const auto stored = labels().find(label);
  return stored == labels().end() ? 0 : stored->second->faces.size();
}

bool LabelSession::isUnstored(const std::string& label) const
{
  return edits_.isPending(id(), label);
}

bool LabelSession::isUnsaved(const std::string& label) const
{
  return unsaved_.count({id(), label}) != 0;
}

ClusterLabelDisplay* LabelSession::displayOf(const LabelEdit& edit) const
{
  if (display_ && id() == edit.mesh()) {
    return display_;
  }
  std::vector<ClusterLabelDisplay*> displays;
  findDisplays(context_->getRootDisplayGroup(), displays);
  ClusterLabelDisplay* found = nullptr;
  for (ClusterLabelDisplay* display : displays) {
    if (idOf(display->mesh()) == edit.mesh() && (!found || display->isEnabled())) {
      found = display;
    }
  }
  return found;
}

std::string LabelSession::send(const LabelEdit& edit)
{
  ClusterLabelDisplay* display = displayOf(edit);
  if (!display) {
    return mesh() && mesh()->uuid == edit.uuid
               ? "the mesh '" + edit.uuid + "' is another one now, with other faces"
               : "no display shows the labels of its mesh '" + edit.uuid +
                     "': show that mesh and its labels again, with Map3D";
  }
  if (!edit.faces) {
    return display->setLabelColor(edit.label, edit.color ? &*edit.color : nullptr);
  }
  if (hasChanged(edit, *display)) {
    return "it has changed meanwhile, elsewhere, and what is new would be lost: give up and look "
           "at it, or delete it";
  }
  const std::string reason = edit.adds ? display->addLabelFaces(edit.label, *edit.faces)
                                       : display->setLabelFaces(edit.label, *edit.faces);
  if (reason.empty()) {
    tellEverybody(edit, *display);
  }
  return reason;
}

/// Not where the UUID says "the only one": that may be another mesh for who hears it.
void LabelSession::tellEverybody(const LabelEdit& edit, const ClusterLabelDisplay& display)
{
  if (edit.uuid.empty() || edit.uuid == "mesh" ||
      ros::names::append(labelNamespace(display), "cluster_label") == EVERYBODY) {
    return;
  }
  mesh_msgs::MeshFaceClusterStamped message;
  message.header.frame_id = display.mesh()->frame_id;
  message.header.stamp = ros::Time::now();
  message.uuid = edit.uuid;
  message.cluster.label = edit.label;
  message.cluster.face_indices = *edit.faces;
  message.override = !edit.adds;
  everybody_.publish(message);
}

bool LabelSession::isStored(const LabelEdit& edit) const
{
  const ClusterLabelDisplay* display = displayOf(edit);
  if (!display) {
    return false;
  }
  if (!edit.faces) {
    const OwnColorsConstPtr own = display->ownColors();
    const auto color = own ? own->find(edit.label) : OwnColors::const_iterator();
    const bool has_own = own && color != own->end();
    return edit.color ? has_own && color->second == *edit.color : !has_own;
  }
  const Faces& stored = storedFaces(*display, edit.label);
  return edit.adds
             ? std::includes(stored.begin(), stored.end(), edit.faces->begin(), edit.faces->end())
             : stored == *edit.faces;
}

std::string LabelSession::failure() const
{
  const std::string failure = edits_.failure();
  return failure.empty() ? save_failure_ : failure;
}

}  // namespace rviz_mesh_plugin
