#include "rviz_mesh_plugin/label_session.h"

#include <algorithm>
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

}  // namespace

LabelSession::LabelSession(rviz::DisplayContext* context, std::chrono::milliseconds patience)
    : context_(context), edits_(patience)
{
  everybody_ = node_.advertise<mesh_msgs::MeshFaceClusterStamped>(EVERYBODY, QUEUE);
}

LabelSession::~LabelSession()
{
  if (cancellation_) {
    cancellation_->set();
  }
}

void LabelSession::work(const MeshDataConstPtr& mesh)
{
  display_ = chooseDisplay(context_->getRootDisplayGroup(), mesh);
  connect();
  const auto stored = edits_.work(
      Clock::now(), [this](const LabelEdit& edit) { return isStored(edit); },
      [this](const LabelEdit& edit) { return send(edit); });
  for (const LabelEdit& edit : stored) {
    unsaved_[{edit.uuid, edit.label}] = {namespace_, ++changes_};
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

void LabelSession::connect()
{
  namespace_ = display_ ? labelNamespace(*display_) : std::string();
  try {
    colors_.connect(node_, namespace_);
  } catch (const ros::InvalidNameException&) {  // the display says so
  }
  if (display_) {
    colors_.request(display_->mesh()->uuid);
  }
}

const LabelClusters& LabelSession::labels() const
{
  static const LabelClusters none;
  return display_ ? display_->labels() : none;
}

OwnColorsConstPtr LabelSession::ownColors() const
{
  const MeshDataConstPtr mesh = this->mesh();
  return mesh ? colors_.colors(mesh->uuid) : nullptr;
}

std::vector<std::string> LabelSession::names() const
{
  std::set<std::string> names;
  for (const auto& label : labels()) {
    names.insert(label.first);
  }
  if (const MeshDataConstPtr mesh = this->mesh()) {
    const auto pending = edits_.labels(mesh->uuid);
    names.insert(pending.begin(), pending.end());
  }
  return {names.begin(), names.end()};
}

const LabelSession::Faces* LabelSession::find(const std::string& label) const
{
  const MeshDataConstPtr mesh = this->mesh();
  if (const auto pending = mesh ? edits_.faces(mesh->uuid, label) : nullptr) {
    return pending.get();
  }
  const auto stored = labels().find(label);
  return stored == labels().end() ? nullptr : &stored->second->faces;
}

LabelSession::Faces LabelSession::faces(const std::string& label) const
{
  const Faces* found = find(label);
  return found ? *found : Faces();
}

std::size_t LabelSession::faceCount(const std::string& label) const
{
  const Faces* found = find(label);
  return found ? found->size() : 0;
}

bool LabelSession::isUnstored(const std::string& label) const
{
  const MeshDataConstPtr mesh = this->mesh();
  return mesh && edits_.isPending(mesh->uuid, label);
}

bool LabelSession::isUnsaved(const std::string& label) const
{
  const MeshDataConstPtr mesh = this->mesh();
  return mesh && unsaved_.count({mesh->uuid, label}) != 0;
}

std::string LabelSession::send(const LabelEdit& edit)
{
  const MeshDataConstPtr mesh = this->mesh();
  if (!mesh || mesh->uuid != edit.uuid) {
    return "no display shows the labels of its mesh '" + edit.uuid +
           "': show that mesh and its labels again, with Map3D";
  }
  if (mesh->faceCount() != edit.face_count) {
    return "the mesh '" + edit.uuid + "' is another one now, with other faces";
  }
  if (!edit.faces) {
    return display_->setLabelColor(edit.label, edit.color ? &*edit.color : nullptr);
  }
  const std::string reason = display_->setLabelFaces(edit.label, *edit.faces);
  if (reason.empty()) {
    tellEverybody(edit, *mesh);
  }
  return reason;
}

/// Not where the UUID says "the only one": that may be another mesh for who hears it.
void LabelSession::tellEverybody(const LabelEdit& edit, const MeshData& mesh)
{
  if (edit.uuid.empty() || edit.uuid == "mesh" ||
      ros::names::append(namespace_, "cluster_label") == EVERYBODY) {
    return;
  }
  mesh_msgs::MeshFaceClusterStamped message;
  message.header.frame_id = mesh.frame_id;
  message.header.stamp = ros::Time::now();
  message.uuid = edit.uuid;
  message.cluster.label = edit.label;
  message.cluster.face_indices = *edit.faces;
  message.override = true;
  everybody_.publish(message);
}

bool LabelSession::isStored(const LabelEdit& edit) const
{
  const MeshDataConstPtr mesh = this->mesh();
  if (!mesh || mesh->uuid != edit.uuid) {
    return false;
  }
  if (!edit.faces) {
    const OwnColorsConstPtr own = ownColors();
    const auto color = own ? own->find(edit.label) : OwnColors::const_iterator();
    const bool has_own = own && color != own->end();
    return edit.color ? has_own && color->second == *edit.color : !has_own;
  }
  const auto label = labels().find(edit.label);
  return label == labels().end() ? edit.faces->empty() : label->second->faces == *edit.faces;
}

std::string LabelSession::failure() const
{
  const std::string failure = edits_.failure();
  return failure.empty() ? save_failure_ : failure;
}

}  // namespace rviz_mesh_plugin
