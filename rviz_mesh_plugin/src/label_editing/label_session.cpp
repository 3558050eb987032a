#include "label_editing/label_session.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>
#include <utility>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <ros/console.h>
#include <ros/names.h>
#include <rviz/display_context.h>
#include <std_srvs/Trigger.h>

#include "displays/display_tree.h"
#include "labels/face_parents.h"
#include "labels/label_faces.h"
#include "labels/label_name.h"
#include "ros_client/service_call.h"
#include "sources/label_client.h"
#include "sources/label_color_source.h"

namespace rviz_mesh_plugin {
namespace {

/// As released; label_manager listens there, and leaves labels of a map that a server has to that.
/// Not latched: an old edit that is heard again would undo newer ones.
const char* const EVERYBODY = "/cluster_label";
constexpr std::uint32_t QUEUE = 100;

constexpr std::chrono::seconds SAVE_PATIENCE(120);

MeshId idOf(const MeshDataConstPtr& mesh)
{
  return mesh ? MeshId{mesh->uuid, mesh->faceCount()} : MeshId();
}

bool isSame(const MeshDataConstPtr& a, const MeshDataConstPtr& b)
{
  return a == b || (a && b && a->uuid == b->uuid && a->faceCount() == b->faceCount() &&
                    a->vertexCount() == b->vertexCount());
}

/// The first of those with a mesh that have the highest rank above 0; null: none has.
template <class Rank>
ClusterLabelDisplay* bestDisplay(const rviz::DisplayContext& context, const Rank& rank)
{
  ClusterLabelDisplay* best = nullptr;
  int highest = 0;
  visitDisplays<ClusterLabelDisplay>(context.getRootDisplayGroup(), DisplayChoice::ALL,
                                     [&](ClusterLabelDisplay& display) {
                                       const int its = display.mesh() ? rank(display) : 0;
                                       if (its > highest) {
                                         highest = its;
                                         best = &display;
                                       }
                                     });
  return best;
}

/// None: the label is not there.
const LabelSession::Faces& facesOf(const LabelClusters& labels, const std::string& label)
{
  static const LabelSession::Faces none;
  const auto stored = labels.find(label);
  return stored == labels.end() ? none : stored->second->faces;
}

bool hasChanged(const LabelEdit& edit, const ClusterLabelDisplay& display)
{
  if (edit.based_on.empty()) {
    return false;
  }
  const auto& faces = facesOf(display.labels(), edit.label);
  return std::none_of(edit.based_on.begin(), edit.based_on.end(),
                      [&](const auto& expected) { return *expected == faces; });
}

/// Asks who stores labels in this namespace to write them into the map; false: nobody is there.
/// @throw std::runtime_error that says why they are not saved; Canceled
bool saveLabels(const std::string& name_space, const Cancellation& cancellation)
{
  using std_srvs::Trigger;
  const std::string service = ros::names::append(name_space, "save_map");
  const auto answer = ServiceCall(cancellation).callPatiently<Trigger>(service, Trigger::Request());
  if (!answer) {
    return false;
  }
  if (!answer->refusal.empty()) {
    throw std::runtime_error(service + " refuses it: " + shortened(answer->refusal));
  }
  Trigger::Response response;
  try {
    response = answer->read<Trigger::Response>();
  } catch (const RejectedMessage& rejected) {
    throw std::runtime_error(service + " answers: " + rejected.what());
  }
  if (!response.success) {
    throw std::runtime_error(service + " says: " + shortened(response.message));
  }
  return true;
}

/// Faces as they come back when they are stored: where the mesh was made of another one, with all
/// parts of a face of that.
LabelSession::Faces asStored(const LabelSession::Faces& faces, const ClusterLabelDisplay& display)
{
  const FaceParentsConstPtr parents = display.faceParents();
  return parents ? wholeFaces(faces, *parents) : faces;
}

}  // namespace

LabelSession::LabelSession(rviz::DisplayContext* context, std::chrono::milliseconds patience)
    : context_(context), edits_(patience)
{
  everybody_ = node_.advertise<mesh_msgs::MeshFaceClusterStamped>(EVERYBODY, QUEUE);
}

LabelSession::~LabelSession()
{
  showEdits(std::nullopt);
}

/// Of several sessions, only one with edits under way says so.
void LabelSession::showEdits(const OptionalStatus& status)
{
  if (display_ && (status || shows_edits_)) {
    display_->showEdits(status);
    shows_edits_ = status.has_value();
  }
}

void LabelSession::work(const MeshDataConstPtr& mesh)
{
  // Those of the mesh are better than others, those that are enabled better than those that are
  // not.
  ClusterLabelDisplay* best = bestDisplay(*context_, [&](const ClusterLabelDisplay& display) {
    return 1 + (mesh && isSame(display.mesh(), mesh) ? 2 : 0) + (display.isEnabled() ? 1 : 0);
  });
  if (display_ != best) {
    showEdits(std::nullopt);
    shows_edits_ = false;
  }
  display_ = best;
  namespace_ = display_ ? labelNamespace(display_->source()) : std::string();
  const auto stored = edits_.work(
      Clock::now(), [this](const LabelEdit& edit) { return isStored(edit); },
      [this](const LabelEdit& edit) { return send(edit); });
  for (const LabelEdit& edit : stored) {
    unsaved_[{edit.mesh, edit.label}] = {labelNamespace(displayOf(edit)->source()), ++changes_};
  }
  showEdits(edits_.status());
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
  const Faces& stored = facesOf(labels(), label);
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
  return edits_.find(id(), label) ? faces(label).size() : facesOf(labels(), label).size();
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
  if (display_ && id() == edit.mesh) {
    return display_;
  }
  return bestDisplay(*context_, [&](const ClusterLabelDisplay& display) {
    return idOf(display.mesh()) == edit.mesh ? 1 + (display.isEnabled() ? 1 : 0) : 0;
  });
}

std::string LabelSession::send(const LabelEdit& edit)
{
  ClusterLabelDisplay* display = displayOf(edit);
  const std::string& uuid = edit.mesh.first;
  if (!display) {
    return mesh() && mesh()->uuid == uuid
               ? "the mesh '" + uuid + "' is another one now, with other faces"
               : "no display shows the labels of its mesh '" + uuid +
                     "': show that mesh and its labels again, with Map3D";
  }
  if (!edit.faces) {
    return display->setLabelColor(edit.label, edit.color ? &*edit.color : nullptr);
  }
  if (hasChanged(edit, *display)) {
    return "it has changed meanwhile, elsewhere, and what is new would be lost: give up and look "
           "at it, or delete it";
  }
  const Faces faces = asStored(*edit.faces, *display);
  const std::string reason = display->storeFaces(edit.label, faces, !edit.adds);
  // Not where the UUID says "the only one": that may be another mesh for who hears it. Nor that a
  // label has gone: its owner deletes it, and no faces would be a label without faces elsewhere.
  const bool removes = faces.empty() && !edit.adds;
  if (reason.empty() && !removes && !uuid.empty() && uuid != "mesh" &&
      ros::names::append(labelNamespace(display->source()), "cluster_label") != EVERYBODY) {
    everybody_.publish(labelEdit(*display->mesh(), edit.label, faces, !edit.adds));
  }
  return reason;
}

bool LabelSession::isStored(const LabelEdit& edit) const
{
  const ClusterLabelDisplay* display = displayOf(edit);
  if (!display) {
    return false;
  }
  if (!edit.faces) {
    return display->ownColor(edit.label) == edit.color;
  }
  const Faces& stored = facesOf(display->labels(), edit.label);
  return edit.adds
             ? std::includes(stored.begin(), stored.end(), edit.faces->begin(), edit.faces->end())
             : stored == asStored(*edit.faces, *display);
}

LabelEdit LabelSession::edit(const std::string& label) const
{
  LabelEdit edit;
  edit.mesh = id();
  edit.label = label;
  return edit;
}

/// Clears a label whose faces another one gets.
LabelEdit LabelSession::clearing(const std::string& label, const std::string& after) const
{
  LabelEdit clear = edit(label);
  clear.faces = std::make_shared<Faces>();
  clear.after = after;
  // What is on its way may have been sent, or not.
  clear.based_on = {std::make_shared<Faces>(faces(label)),
                    std::make_shared<Faces>(facesOf(labels(), label))};
  return clear;
}

/// Checks what is to be kept until it is stored.
std::string LabelSession::put(LabelEdit edit)
{
  const MeshDataConstPtr mesh = this->mesh();
  if (!mesh) {
    return "there is no mesh to label: add a Map3D display, or one of labels with its topics";
  }
  std::string reason = whyNoLabel(edit.label);
  if (reason.empty() && edit.faces && !edit.faces->empty() &&
      edit.faces->back() >= mesh->faceCount()) {
    reason = "these faces are not of the mesh '" + mesh->uuid + "', whose labels are edited";
  }
  if (reason.empty()) {
    edits_.add(std::move(edit));
    ++revision_;
  }
  return reason;
}

std::string LabelSession::assign(const std::string& label, const Faces& faces)
{
  auto sorted = std::make_shared<Faces>(faces);
  sortFaces(*sorted);
  LabelEdit change = edit(label);
  change.faces = std::move(sorted);
  return put(std::move(change));
}

std::string LabelSession::add(const std::string& label, const Faces& faces)
{
  if (faces.empty()) {
    return {};
  }
  const LabelEdit* pending = edits_.find(id(), label);
  LabelEdit change = pending ? *pending : edit(label);
  change.adds = !pending || pending->adds;
  auto all = std::make_shared<Faces>(faces);
  if (pending) {
    all->insert(all->end(), pending->faces->begin(), pending->faces->end());
  }
  sortFaces(*all);
  change.faces = std::move(all);
  return put(std::move(change));
}

std::string LabelSession::takeAway(const std::string& label, const Faces& faces)
{
  Faces sorted = faces;
  sortFaces(sorted);
  if (display_) {
    sorted = asStored(sorted, *display_);  // what is left of a face would bring all of it back
  }
  const Faces before = this->faces(label);
  Faces rest;
  std::set_difference(before.begin(), before.end(), sorted.begin(), sorted.end(),
                      std::back_inserter(rest));
  return assign(label, rest);
}

std::string LabelSession::rename(const std::string& from, const std::string& to)
{
  const std::vector<std::string> known = names();
  if (std::find(known.begin(), known.end(), to) != known.end()) {
    return "there is a label '" + to + "' already: merge them, or take another name";
  }
  const std::optional<Rgba8> own = display_ ? display_->ownColor(from) : std::nullopt;
  std::string reason = assign(to, faces(from));
  if (reason.empty() && own) {
    reason = setColor({to}, own);
  }
  if (reason.empty()) {
    reason = put(clearing(from, to));
  }
  return reason;
}

std::string LabelSession::merge(const std::vector<std::string>& labels, const std::string& into)
{
  Faces all;
  for (const std::string& label : labels) {
    const Faces faces = label == into ? Faces() : this->faces(label);
    all.insert(all.end(), faces.begin(), faces.end());
  }
  std::string reason = add(into, all);
  for (const std::string& label : labels) {
    if (reason.empty() && label != into) {
      reason = put(clearing(label, into));
    }
  }
  return reason;
}

std::string LabelSession::remove(const std::vector<std::string>& labels)
{
  std::string reason;
  for (const std::string& label : labels) {
    reason = reason.empty() ? assign(label, {}) : reason;
  }
  return reason;
}

std::string LabelSession::setColor(const std::vector<std::string>& labels,
                                   const std::optional<Rgba8>& color)
{
  std::string reason;
  for (const std::string& label : labels) {
    LabelEdit change = edit(label);
    change.color = color;
    reason = reason.empty() ? put(std::move(change)) : reason;
  }
  return reason;
}

std::string LabelSession::import(const FileLabels& labels)
{
  std::string reason;
  for (const auto& label : labels) {
    if (label.second.faces.empty() && faceCount(label.first) == 0) {
      continue;  // it is not there
    }
    reason = reason.empty() ? assign(label.first, label.second.faces) : reason;
    if (reason.empty() && label.second.color && !label.second.faces.empty()) {
      reason = setColor({label.first}, label.second.color);
    }
  }
  return reason;
}

FileLabels LabelSession::content() const
{
  FileLabels content;
  for (const std::string& name : names()) {
    FileLabel label;
    label.faces = faces(name);
    label.color = display_ ? display_->ownColor(name) : std::nullopt;
    if (!label.faces.empty()) {
      content.emplace(name, std::move(label));
    }
  }
  return content;
}

std::string LabelSession::save()
{
  std::set<std::string> namespaces;
  for (const auto& label : unsaved_) {
    namespaces.insert(label.second.name_space);
  }
  if (!namespace_.empty()) {
    namespaces.insert(namespace_);
  }
  if (namespaces.empty()) {
    return "there is nothing to save: no display shows labels";
  }
  if (isSaving()) {
    return "labels are being saved already";
  }
  save_failure_.clear();
  for (const std::string& name_space : namespaces) {
    Saving& saving = saving_[name_space];
    saving.until = changes_;
    saving.since = Clock::now();
    saving.task.start([name_space](const Cancellation& cancellation) {
      return saveLabels(name_space, cancellation);
    });
  }
  return {};
}

void LabelSession::takeSaved()
{
  for (auto saving = saving_.begin(); saving != saving_.end();) {
    const std::string failure = takeSaved(saving->first, saving->second);
    if (!failure.empty()) {
      save_failure_ += (save_failure_.empty() ? "" : "; ") + failure;
    }
    if (saving->second.task.isRunning()) {
      ++saving;
    } else {
      saving = saving_.erase(saving);
      ++revision_;
    }
  }
}

/// Forgets what has been saved. Returns what went wrong.
std::string LabelSession::takeSaved(const std::string& name_space, Saving& saving)
{
  const auto outcome = saving.task.take();
  if (!outcome && Clock::now() - saving.since <= SAVE_PATIENCE) {
    return {};
  }
  const std::string service = ros::names::append(name_space, "save_map");
  if (!outcome) {
    saving.task.drop();
    return "labels are not saved: " + service + " has not answered for two minutes";
  }
  if (!outcome->result) {
    return "labels are not saved: " + outcome->error;
  }
  const bool is_there = *outcome->result;
  if (!is_there && name_space == namespace_) {
    return "labels are not saved: nobody offers the service " + service;
  }
  for (auto label = unsaved_.begin(); label != unsaved_.end();) {
    const bool is_over = label->second.name_space == name_space &&
                         (!is_there || label->second.change <= saving.until);
    label = is_over ? unsaved_.erase(label) : std::next(label);
  }
  if (is_there) {
    return {};
  }
  const std::string gone = "nobody offers the service " + service +
                           " any more: labels that were stored there are in the map, or in the "
                           "journal beside it, which its next server puts into it";
  ROS_WARN("%s", gone.c_str());  // RViz may be closing
  return gone;
}

std::string LabelSession::failure() const
{
  const std::string failure = edits_.failure();
  return failure.empty() ? save_failure_ : failure;
}

}  // namespace rviz_mesh_plugin
