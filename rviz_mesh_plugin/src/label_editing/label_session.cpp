#include "label_editing/label_session.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <rviz/display_context.h>

#include "displays/display_tree.h"
#include "labels/face_parents.h"
#include "labels/label_name.h"
#include "rendering/labels/label_parts.h"
#include "sources/label_color_source.h"

namespace rviz_mesh_plugin {
namespace {

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
ClusterLabelDisplay* bestDisplay(const rviz::DisplayContext* context, const Rank& rank)
{
  ClusterLabelDisplay* best = nullptr;
  int highest = 0;
  visitDisplays<ClusterLabelDisplay>(context ? context->getRootDisplayGroup() : nullptr,
                                     DisplayChoice::ALL, [&](ClusterLabelDisplay& display) {
                                       const int its = display.mesh() ? rank(display) : 0;
                                       if (its > highest) {
                                         highest = its;
                                         best = &display;
                                       }
                                     });
  return best;
}

std::string quoted(const std::vector<std::string>& labels)
{
  return labels.size() == 1 ? "'" + labels.front() + "'"
                            : counted(labels.size(), "label", "labels");
}

}  // namespace

class LabelSession::OtherMesh
{
 public:
  OtherMesh(LabelSession& session, const MeshId& mesh)
      : session_(session), edited_(session.display_)
  {
    session_.display_ = session_.displayOf(mesh);
  }
  ~OtherMesh() { session_.display_ = edited_; }
  OtherMesh(const OtherMesh&) = delete;
  OtherMesh& operator=(const OtherMesh&) = delete;

 private:
  LabelSession& session_;
  const QPointer<ClusterLabelDisplay> edited_;
};

LabelSession::LabelSession(rviz::DisplayContext* context, std::chrono::milliseconds patience)
    : context_(context),
      edits_(patience),
      commands_({[this](const MeshId& mesh) { return displayOf(mesh) != nullptr; },
                 [this](EditCommand& command) { return begin(command); },
                 [this](const EditCommand& command, Edits edits) {
                   return finish(command, std::move(edits));
                 }})
{
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
  ClusterLabelDisplay* best = bestDisplay(context_, [&](const ClusterLabelDisplay& display) {
    return 1 + (mesh && isSame(display.mesh(), mesh) ? 2 : 0) + (display.isEnabled() ? 1 : 0);
  });
  if (display_ != best) {
    showEdits(std::nullopt);
    shows_edits_ = false;
  }
  display_ = best;
  if (const auto reason = commands_.work()) {
    command_failure_ = reason->empty() ? command_failure_ : *reason;
    ++revision_;
  }
  const auto stored = edits_.work(
      PendingEdits::Clock::now(),
      [this](const LabelEdit& edit) {
        const ClusterLabelDisplay* display = displayOf(edit.mesh);
        return display && delivery_.isStored(edit, *display);
      },
      [this](const LabelEdit& edit) {
        ClusterLabelDisplay* display = displayOf(edit.mesh);
        return display ? delivery_.send(edit, *display) : whyNotShown(edit.mesh);
      },
      [this](const LabelEdit& edit) {
        ClusterLabelDisplay* display = edit.faces ? displayOf(edit.mesh) : nullptr;
        if (display) {
          display->askForLabels();
        }
      });
  for (const LabelEdit& edit : stored) {
    saving_.addStored(edit.mesh, edit.label, labelNamespace(displayOf(edit.mesh)->source()));
  }
  showEdits(status());
  const bool saved = saving_.work(nameSpace());
  if (saved || !stored.empty() || labels() != known_) {
    known_ = labels();
    ++revision_;
  }
}

OptionalStatus LabelSession::status() const
{
  const OptionalStatus status = edits_.status();
  if (status || commands_.empty()) {
    return status;
  }
  return commands_.held().empty() ? StatusLine::ok(commands_.first().what, " is being made ready")
                                  : StatusLine::warn(failure());
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
  commands_.giveUp();
  delivery_.forgetAll();
  command_failure_.clear();
  ++revision_;
}

const LabelClusters& LabelSession::labels() const
{
  static const LabelClusters none;
  return display_ ? display_->labels() : none;
}

bool LabelSession::labelsKnown() const
{
  return !display_ || nameSpace().empty() || display_->labelsComplete();
}

std::optional<Rgba8> LabelSession::color(const std::string& label) const
{
  return display_ ? std::optional<Rgba8>(display_->labelColor(label)) : std::nullopt;
}

MeshId LabelSession::id() const
{
  return idOf(mesh());
}

std::string LabelSession::nameSpace() const
{
  return display_ ? labelNamespace(display_->source()) : std::string();
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

LabelFacesConstPtr LabelSession::stored(const std::string& label) const
{
  return facesOf(labels(), label);
}

/// Of an edit that adds to many, which others change meanwhile, what they do is not waited for.
LabelFacesConstPtr LabelSession::faces(const std::string& label) const
{
  const LabelEdit* pending = edits_.find(id(), label);
  if (!pending) {
    return stored(label);
  }
  if (!pending->adds) {
    return pending->faces;
  }
  const LabelFacesConstPtr now = stored(label);
  const bool is_known = now == pending->before || now->size() + pending->faces->size() > MANY_FACES;
  return is_known ? pending->whole : united(now, pending->faces);
}

LabelState LabelSession::state(const std::string& label) const
{
  LabelState state;
  state.faces = faces(label);
  if (!state.faces->empty()) {
    const LabelEdit* pending = edits_.findColor(id(), label);
    state.color = pending ? pending->color : display_ ? display_->ownColor(label) : std::nullopt;
  }
  return state;
}

bool LabelSession::isUnstored(const std::string& label) const
{
  return edits_.isPending(id(), label);
}

bool LabelSession::isUnsaved(const std::string& label) const
{
  return saving_.isUnsaved(id(), label);
}

ClusterLabelDisplay* LabelSession::displayOf(const MeshId& mesh) const
{
  if (display_ && id() == mesh) {
    return display_;
  }
  return bestDisplay(context_, [&](const ClusterLabelDisplay& display) {
    return idOf(display.mesh()) == mesh ? 1 + (display.isEnabled() ? 1 : 0) : 0;
  });
}

std::string LabelSession::whyNotShown(const MeshId& mesh) const
{
  const std::string& uuid = mesh.first;
  return id().first == uuid && this->mesh()
             ? "the mesh '" + uuid + "' is another one now, with other faces"
             : "no display shows the labels of its mesh '" + uuid +
                   "': show that mesh and its labels again, with Map3D";
}

LabelEdit LabelSession::edit(const std::string& label) const
{
  LabelEdit edit;
  edit.mesh = id();
  edit.label = label;
  return edit;
}

LabelEdit LabelSession::facesEdit(const std::string& label, LabelFacesConstPtr faces) const
{
  LabelEdit change = edit(label);
  change.faces = std::move(faces);
  return change;
}

LabelEdit LabelSession::colorEdit(const std::string& label, const std::optional<Rgba8>& color) const
{
  LabelEdit change = edit(label);
  change.color = color;
  return change;
}

/// Clears a label whose faces another one gets.
LabelEdit LabelSession::clearing(const std::string& label, const std::string& after) const
{
  LabelEdit clear = facesEdit(label, labelFaces({}));
  clear.after = after;
  // What is on its way may have been sent, or not.
  clear.based_on = {faces(label), stored(label)};
  return clear;
}

std::string LabelSession::perform(const std::string& what, std::function<Plan()> begin)
{
  EditCommand command;
  command.what = what;
  command.begin = std::move(begin);
  return perform(std::move(command));
}

std::string LabelSession::perform(EditCommand command)
{
  if (!mesh()) {
    return "there is no mesh to label: add a Map3D display, or one of labels with its topics";
  }
  command_failure_.clear();
  command.mesh = id();
  command.order = newest_order_ = nextStepOrder();
  ++revision_;
  return commands_.perform(std::move(command));
}

EditPlan LabelSession::begin(EditCommand& command)
{
  const OtherMesh mesh(*this, command.mesh);
  command.labels_known = labelsKnown();
  return command.begin();
}

/// Keeps edits until they are stored: all, or none.
std::string LabelSession::finish(const EditCommand& command, Edits edits)
{
  const OtherMesh mesh(*this, command.mesh);
  for (const LabelEdit& edit : edits) {
    std::string reason = whyNoLabel(edit.label);
    if (reason.empty() && edit.faces && !edit.faces->empty() &&
        edit.faces->back() >= edit.mesh.second) {
      reason = "these faces are not of the mesh '" + edit.mesh.first + "', whose labels are edited";
    }
    if (!reason.empty()) {
      return reason;
    }
  }
  if (command.step && command.undoes) {
    history_.addUndone(*command.step);
  } else if (command.step) {
    history_.addDone(*command.step);
  } else if (!edits.empty() && id() == command.mesh && labelsKnown() == command.labels_known) {
    // Else what the labels were cannot be told any more.
    history_.addDone(stepOf(command.what, command.order, edits,
                            [this](const std::string& label) { return state(label); }));
  }
  for (LabelEdit& edit : edits) {
    delivery_.forget(edit);
    edits_.add(std::move(edit));
  }
  ++revision_;
  return {};
}

std::string LabelSession::whyNotNow() const
{
  return busy() ? "labels of many faces are still being edited: try again in a moment"
                : std::string();
}

/// Why a step cannot be taken back yet. An edit of many faces that was sent may be stored after
/// what takes it back, and labels that have not arrived seem to be gone.
std::string LabelSession::whyNotBack(const LabelStep& step, bool undo) const
{
  for (const LabelChange& change : step.changes) {
    const bool is_large = change.before.faces->size() + change.after.faces->size() > MANY_FACES;
    if (is_large && edits_.isSent(step.mesh, change.label)) {
      return "'" + change.label +
             "' is on its way to who stores it: try again in a moment, or send it again or give it "
             "up where it does not come back";
    }
    const LabelState& expected = undo ? change.after : change.before;
    if (!labelsKnown() && !expected.faces->empty() && faces(change.label)->empty()) {
      return "the labels of the mesh have not arrived: try again in a moment";
    }
  }
  return {};
}

/// Nobody else can have changed what is put back: where somebody has, it is refused.
std::string LabelSession::step(bool undo)
{
  if (busy()) {
    return whyNotNow();
  }
  const MeshId mesh = id();
  history_.forgetUndoneBefore(mesh, history_.undoOrder(mesh));
  if ((undo ? history_.undoOrder(mesh) : history_.redoOrder(mesh)) == 0) {
    return undo ? "there is nothing to undo" : "there is nothing to redo";
  }
  EditCommand command;
  command.undoes = undo;
  command.step =
      std::make_shared<LabelStep>(undo ? history_.takeDone(mesh) : history_.takeUndone(mesh));
  const std::string reason_to_wait = whyNotBack(*command.step, undo);
  if (!reason_to_wait.empty()) {
    undo ? history_.addDone(*command.step) : history_.addUndone(*command.step);
    return reason_to_wait;
  }
  command.what = (undo ? "undoing " : "redoing ") + command.step->what;
  const std::string told = (undo ? "undone: " : "done again: ") + command.step->what;
  command.begin = [this, undo, step = command.step] {
    Plan plan;
    std::vector<LabelNow> now;
    for (const LabelChange& change : step->changes) {
      now.push_back({state(change.label), stored(change.label)});
      plan.faces += change.before.faces->size() + change.after.faces->size();
    }
    plan.make = [step, undo, now = std::move(now), parents = parents()] {
      return editsBack(*step, undo, now, parents);
    };
    return plan;
  };
  const std::uint64_t newest = newest_order_;
  const std::string reason = perform(std::move(command));
  newest_order_ = newest;
  command_failure_ = reason;
  return reason.empty() ? told : reason;
}

std::string LabelSession::assign(const std::string& label, const GivenFaces& faces)
{
  return perform("labelling '" + label + "'", [this, label, faces] {
    Plan plan;
    plan.faces = faces.count();
    plan.make = [change = edit(label), faces]() mutable {
      change.faces = faces.sorted();
      return Edits{change};
    };
    return plan;
  });
}

std::string LabelSession::add(const std::string& label, const GivenFaces& faces)
{
  if (faces.count() == 0) {
    return {};
  }
  return perform("adding faces to '" + label + "'", [this, label, faces] {
    const LabelEdit* pending = edits_.find(id(), label);
    LabelEdit change = pending ? *pending : facesEdit(label, labelFaces({}));
    change.adds = !pending || pending->adds;
    change.before = stored(label);
    Plan plan;
    plan.faces = faces.count() + change.faces->size() + change.before->size();
    plan.make = [change, faces]() mutable {
      change.faces = united(change.faces, faces.sorted());
      change.whole = united(change.before, change.faces);
      return Edits{change};
    };
    return plan;
  });
}

std::string LabelSession::takeAway(const std::string& label, const GivenFaces& faces)
{
  return perform("taking faces away from '" + label + "'", [this, label, faces] {
    const LabelFacesConstPtr before = this->faces(label);
    Plan plan;
    plan.faces = before->size() + faces.count();
    plan.make = [change = edit(label), faces, before, parents = parents()]() mutable {
      LabelFacesConstPtr gone = faces.sorted();
      if (parents) {  // what is left of a face would bring all of it back
        gone = labelFaces(wholeFaces(*gone, *parents));
      }
      Faces rest;
      std::set_difference(before->begin(), before->end(), gone->begin(), gone->end(),
                          std::back_inserter(rest));
      change.faces = labelFaces(std::move(rest));
      return Edits{change};
    };
    return plan;
  });
}

std::string LabelSession::rename(const std::string& from, const std::string& to)
{
  return perform("renaming '" + from + "' to '" + to + "'", [this, from, to] {
    Plan plan;
    const std::vector<std::string> known = names();
    if (std::find(known.begin(), known.end(), to) != known.end()) {
      plan.reason = "there is a label '" + to + "' already: merge them, or take another name";
      return plan;
    }
    const LabelState old = state(from);
    Edits edits{facesEdit(to, old.faces)};
    if (old.color) {
      edits.push_back(colorEdit(to, old.color));
    }
    edits.push_back(clearing(from, to));
    plan.make = [edits] { return edits; };
    return plan;
  });
}

std::string LabelSession::merge(const std::vector<std::string>& labels, const std::string& into)
{
  return perform("merging " + quoted(labels) + " into '" + into + "'", [this, labels, into] {
    const LabelEdit* pending = edits_.find(id(), into);
    LabelEdit change = pending ? *pending : facesEdit(into, labelFaces({}));
    change.adds = !pending || pending->adds;
    change.before = stored(into);
    Plan plan;
    plan.faces = change.faces->size() + change.before->size();
    std::vector<LabelFacesConstPtr> parts{change.faces};
    std::optional<Rgba8> color;
    Edits cleared;
    for (const std::string& label : labels) {
      if (label != into) {
        parts.push_back(faces(label));
        plan.faces += parts.back()->size();
        color = color ? color : state(label).color;
        cleared.push_back(clearing(label, into));
      }
    }
    if (color && faces(into)->empty()) {  // it is about to go: as renaming
      cleared.insert(cleared.begin(), colorEdit(into, color));
    }
    plan.make = [change, parts, cleared]() mutable {
      Faces all;
      for (const LabelFacesConstPtr& part : parts) {
        all.insert(all.end(), part->begin(), part->end());
      }
      change.faces = GivenFaces(std::move(all)).sorted();
      change.whole = united(change.before, change.faces);
      Edits edits{change};
      edits.insert(edits.end(), cleared.begin(), cleared.end());
      return edits;
    };
    return plan;
  });
}

std::string LabelSession::remove(const std::vector<std::string>& labels)
{
  return perform("deleting " + quoted(labels), [this, labels] {
    Edits edits;
    for (const std::string& label : labels) {
      edits.push_back(facesEdit(label, labelFaces({})));
    }
    Plan plan;
    plan.make = [edits] { return edits; };
    return plan;
  });
}

std::string LabelSession::setColor(const std::vector<std::string>& labels,
                                   const std::optional<Rgba8>& color)
{
  return perform("coloring " + quoted(labels), [this, labels, color] {
    Edits edits;
    for (const std::string& label : labels) {
      edits.push_back(colorEdit(label, color));
    }
    Plan plan;
    plan.make = [edits] { return edits; };
    return plan;
  });
}

std::string LabelSession::import(const std::shared_ptr<const FileLabels>& labels)
{
  return perform("importing labels", [this, labels] {
    Plan plan;
    Edits edits;
    for (const auto& label : *labels) {
      const FileLabel& content = label.second;
      if (content.faces.empty() && faceCount(label.first) == 0) {
        continue;  // it is not there
      }
      edits.push_back(facesEdit(label.first, LabelFacesConstPtr(labels, &content.faces)));
      plan.faces += content.faces.size();
      if (content.color && !content.faces.empty()) {
        edits.push_back(colorEdit(label.first, content.color));
      }
    }
    plan.make = [edits]() mutable {
      for (LabelEdit& edit : edits) {
        edit.faces = edit.faces ? GivenFaces(edit.faces).sorted() : nullptr;
      }
      return edits;
    };
    return plan;
  });
}

std::function<FileLabels()> LabelSession::content() const
{
  std::map<std::string, LabelState> now;
  for (const std::string& name : names()) {
    now.emplace(name, LabelState{faces(name), display_ ? display_->ownColor(name) : std::nullopt});
  }
  return [now] {
    FileLabels content;
    for (const auto& label : now) {
      if (!label.second.faces->empty()) {
        content.emplace(label.first, FileLabel{*label.second.faces, label.second.color});
      }
    }
    return content;
  };
}

std::string LabelSession::failure() const
{
  const std::string of_edits = edits_.failure();
  if (!of_edits.empty()) {
    return of_edits;
  }
  const auto held = commands_.held();
  if (!held.empty()) {
    return held.front()->what + " has to wait: " + whyNotShown(held.front()->mesh);
  }
  return command_failure_.empty() ? saving_.failure() : command_failure_;
}

}  // namespace rviz_mesh_plugin
