#include "panel/label_commands.h"

#include <algorithm>
#include <array>
#include <exception>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/erase_if.h"
#include "base/status_lines.h"
#include "labels/label_name.h"
#include "panel/label_dialogs.h"
#include "panel/select_by_dialog.h"

namespace rviz_mesh_plugin {
namespace {

/// What has to be there, or so.
enum Need : unsigned
{
  FAILED_EDITS = 1 << 0,
  FACES = 1 << 1,  ///< of whatever mesh
  MESH = 1 << 2,
  NAME = 1 << 3,
  TOOL = 1 << 4,
  SELECTION = 1 << 5,
  ONE_CHOSEN = 1 << 6,
  CHOSEN = 1 << 7,
  TWO_CHOSEN = 1 << 8,
  LABELS = 1 << 9,
  IDLE_FILES = 1 << 10,
  IDLE_OWNER = 1 << 11,
  SHOWN_MESH = 1 << 12,
  HIDDEN = 1 << 13
};

struct Words
{
  const char* text;
  unsigned needs;
  const char* tip;
};

constexpr std::array<Words, static_cast<std::size_t>(LabelAction::COUNT)> WORDS = {{
    {"Label Cluster", MESH | NAME | TOOL | SELECTION,
     "Labels the selected faces with the name above."},
    {"Reset Faces", FACES, "Selects nothing."},
    {"Select By…", TOOL | SHOWN_MESH,
     "Selects faces by the values of a cost layer, by height, by slope or by label."},
    {"Hide", TOOL | FACES,
     "Hides the selected faces in all displays: they are not drawn, pointed at or selected, and "
     "stay "
     "in the map (H in the view)."},
    {"Isolate", TOOL | FACES, "Hides all faces but the selected ones (Shift+H in the view)."},
    {"Show All", TOOL | HIDDEN, "Shows all faces that are hidden (Ctrl+H in the view)."},
    {"New…", MESH | TOOL | SELECTION,
     "Labels the selected faces: asks for class and instance (Enter in the view)."},
    {"Assign", MESH | TOOL | SELECTION | ONE_CHOSEN,
     "Gives the label the selected faces instead of those it has."},
    {"Add", MESH | TOOL | SELECTION | ONE_CHOSEN, "Adds the selected faces to the label."},
    {"Take Away", MESH | TOOL | SELECTION | ONE_CHOSEN,
     "Takes the selected faces away from the label."},
    {"Select Faces", MESH | TOOL | CHOSEN, "Selects the faces of these labels."},
    {"Rename…", MESH | ONE_CHOSEN, "Gives the label another name."},
    {"Merge…", MESH | TWO_CHOSEN, "Makes one label of these."},
    {"Delete…", MESH | CHOSEN, "Deletes these labels."},
    {"Color…", MESH | CHOSEN,
     "Gives these labels a color of their own, or that of their class again."},
    {"Class Color…", MESH | CHOSEN, "Gives all labels of these classes a color, or takes it away."},
    {"Import…", MESH | IDLE_FILES, "Reads labels from a JSON or CSV file."},
    {"Export…", MESH | LABELS | IDLE_FILES, "Writes all labels to a JSON or CSV file."},
    {"Save", MESH | IDLE_OWNER, "Has the labels written into the map."},
    {"Send Again", FAILED_EDITS, "Sends edits again that have not been stored."},
    {"Give Up", FAILED_EDITS, "Forgets edits that have not been stored."},
}};

const Words& wordsOf(LabelAction action)
{
  return WORDS.at(static_cast<std::size_t>(action));
}

std::string countedLabels(const FileLabels& labels)
{
  const auto count = std::count_if(labels.begin(), labels.end(),
                                   [](const auto& label) { return !label.second.faces.empty(); });
  return counted(static_cast<std::size_t>(count), "label", "labels");
}

}  // namespace

const char* textOf(LabelAction action)
{
  return wordsOf(action).text;
}

const char* tipOf(LabelAction action)
{
  return wordsOf(action).tip;
}

std::string whyNot(LabelAction action, const LabelSituation& situation)
{
  const struct
  {
    Need need;
    bool met;
    const char* reason;
  } needs[] = {
      {FAILED_EDITS, situation.failed > 0, "no edit has failed"},
      {FACES, situation.selected > 0 || situation.selecting, "nothing is selected"},
      {MESH, situation.has_mesh,
       "there is no mesh to label: add a Map3D display, or one of labels with its topics"},
      {NAME, !situation.name.empty(), "the field 'Cluster Name' is empty"},
      {TOOL, situation.has_tool,
       "nothing can be selected: add the tool ClusterLabel with the + of the toolbar"},
      {SHOWN_MESH, situation.has_shown_mesh,
       "no mesh is shown: add and enable a TexturedMesh or Map3D display"},
      {HIDDEN, situation.hidden > 0, "no face is hidden"},
      {SELECTION, situation.selected > 0,
       "nothing is selected: select faces with the tool ClusterLabel (key l)"},
      {SELECTION, situation.selection_is_of_it,
       "the selected faces are of a mesh whose labels no display shows: add one for it"},
      {ONE_CHOSEN, situation.chosen == 1, "choose one label in the list"},
      {CHOSEN, situation.chosen > 0, "choose labels in the list"},
      {TWO_CHOSEN, situation.chosen > 1, "choose two labels or more in the list"},
      {LABELS, situation.labels > 0, "there are no labels"},
      {IDLE_FILES, !situation.file_busy, "a file is being read or written"},
      {IDLE_OWNER, !situation.saving, "labels are being saved"},
  };
  for (const auto& one : needs) {
    if ((wordsOf(action).needs & one.need) != 0 && !one.met) {
      return one.reason;
    }
  }
  return {};
}

std::string describe(const LabelSituation& situation)
{
  if (!situation.has_mesh && situation.unstored + situation.unsaved == 0) {
    return "No labels to edit: add a Map3D display, or one of labels with its topics.";
  }
  std::string text = counted(situation.labels, "label", "labels");
  if (situation.unstored > 0) {
    text += ", " + counted(situation.unstored, "edit", "edits") + " not stored yet";
  }
  if (situation.saving) {
    text += ", being saved";
  } else if (situation.unsaved > 0) {
    text += ", " + counted(situation.unsaved, "label", "labels") + " not saved in the map";
  }
  if (situation.hidden > 0) {
    text += ", " + counted(situation.hidden, "face is", "faces are") + " hidden";
  }
  if (situation.file_busy) {
    text += ", a file is being read or written";
  }
  return text + ".";
}

std::string describeLoss(std::size_t unsaved, std::size_t unstored)
{
  std::string text;
  if (unsaved > 0) {
    const bool one = unsaved == 1;
    text += counted(unsaved, "label", "labels") + (one ? " is" : " are") +
            " not saved in the map, but safe in the journal of the node that stores labels, which "
            "writes " +
            (one ? "it" : "them") + " into the map when it saves next. ";
  }
  if (unstored > 0) {
    text += counted(unstored, "edit", "edits") + (unstored == 1 ? " is" : " are") +
            " not stored, and would be lost. ";
  }
  return text;
}

void LabelCommands::attempt(const std::function<void()>& work)
{
  try {
    work();
  } catch (const std::exception& error) {
    message_ = std::string("this went wrong: ") + error.what();
  }
}

QString LabelCommands::unknownLabels()
{
  return "The labels of this mesh are not known yet: wait until who stores them has answered, see "
         "the status of their display.";
}

LabelSituation LabelCommands::situation() const
{
  LabelSituation situation;
  situation.has_tool = tool_ != nullptr;
  situation.has_shown_mesh = tool_ && tool_->shownMesh();
  situation.has_mesh = session_->mesh() != nullptr;
  situation.selected = tool_ ? tool_->selection().count() : 0;
  situation.selecting = tool_ && tool_->busy();
  situation.hidden = tool_ ? tool_->hiddenCount() : 0;
  situation.selection_is_of_it = tool_ && session_->isOf(tool_->mesh());
  situation.unstored = session_->unstored();
  situation.failed = session_->failed();
  situation.unsaved = session_->unsaved();
  situation.saving = session_->isSaving();
  situation.file_busy = reading_.isRunning() || writing_.isRunning();
  return situation;
}

void LabelCommands::run(LabelAction action, const LabelSituation& situation, const Labels& chosen)
{
  attempt([&] {
    report_.clear();
    message_ = whyNot(action, situation);
    if (message_.empty()) {
      start(action, situation.name, chosen);
    }
  });
}

std::string LabelCommands::whyNotOf(const MeshDataConstPtr& mesh) const
{
  if (session_->isOf(mesh)) {
    return {};
  }
  return session_->mesh() ? "the mesh is another one now: nothing is done to its labels"
                          : "there is no mesh to label any more";
}

void LabelCommands::start(LabelAction action, const std::string& name, const Labels& chosen)
{
  switch (action) {
    case LabelAction::LABEL_CLUSTER:
      message_ = label(name, false);
      return;
    case LabelAction::RESET_FACES:
      return tool_->clearSelection();
    case LabelAction::SELECT_BY:
      return openSelectBy(parent_, tool_, session_);
    case LabelAction::HIDE:
      return tool_->hide();
    case LabelAction::ISOLATE:
      return tool_->isolate();
    case LabelAction::SHOW_ALL:
      return tool_->showAll();
    case LabelAction::NEW:
      return askLabel(parent_, "New Label", "", session_->names(),
                      then([this](const std::string& label) { return this->label(label, true); }));
    case LabelAction::ASSIGN:
      message_ = session_->assign(chosen[0], selection());
      return;
    case LabelAction::ADD:
      message_ = session_->add(chosen[0], selection());
      return;
    case LabelAction::TAKE_AWAY:
      message_ = session_->takeAway(chosen[0], selection());
      return;
    case LabelAction::SELECT:
      return select(chosen);
    case LabelAction::RENAME:
      return askLabel(
          parent_, "Rename " + listed(chosen), chosen[0], session_->names(),
          then([this, from = chosen[0]](const std::string& to) { return rename(from, to); }));
    case LabelAction::MERGE:
      return askChoice(
          parent_, "Merge Labels", "Make one label of " + listed(chosen) + ":", chosen,
          then([this, chosen](const std::string& into) { return session_->merge(chosen, into); }));
    case LabelAction::DELETE:
      askButton(parent_, "Delete Labels", "Delete " + listed(chosen) + "?", {"Delete"},
                then([this, chosen](int) { return session_->remove(chosen); }));
      return;
    case LabelAction::COLOR:
      return askColors(chosen);
    case LabelAction::CLASS_COLOR:
      return askColors(withClasses(chosen));
    case LabelAction::IMPORT:
      return askFile(parent_, false,
                     then([this](const std::string& path) { return startImport(path); }));
    case LabelAction::EXPORT:
      return askFile(parent_, true,
                     then([this](const std::string& path) { return startExport(path); }));
    case LabelAction::SAVE:
      message_ = session_->save();
      return;
    case LabelAction::SEND_AGAIN:
      return session_->sendAgain();
    case LabelAction::GIVE_UP:
      return session_->giveUp();
    case LabelAction::COUNT:
      return;
  }
}

FaceBits LabelCommands::selection() const
{
  if (!tool_ || tool_->selection().empty() || !session_->isOf(tool_->mesh())) {
    throw std::runtime_error("the selected faces are gone, or the mesh is another one now");
  }
  if (tool_->busy()) {
    throw std::runtime_error("faces are still being looked for: wait, or give up with Esc");
  }
  return tool_->selection().bits();
}

/// The next label begins with nothing selected; undo brings the faces back, and takes the label.
std::string LabelCommands::labelled(std::string reason, bool finished)
{
  if (reason.empty() && finished && tool_) {
    tool_->clearSelection(session_->newestOrder());
  }
  return reason;
}

std::string LabelCommands::label(const std::string& name, bool finished)
{
  if (session_->busy()) {  // what the label has by then is not known
    return session_->whyNotNow();
  }
  const FaceBits faces = selection();
  const QString label = QString::fromStdString(name);
  if (session_->faceCount(name) == 0) {
    // What the label may have already stays.
    return labelled(
        session_->labelsKnown() ? session_->assign(name, faces) : session_->add(name, faces),
        finished);
  }
  askButton(parent_, "Label Cluster", QString("There is a label %1 with faces already.").arg(label),
            {"Replace Them", "Add"}, then([this, name, finished](int button) {
              return labelled(button == 0 ? session_->assign(name, selection())
                                          : session_->add(name, selection()),
                              finished);
            }));
  return {};
}

std::string LabelCommands::rename(const std::string& from, const std::string& to)
{
  if (session_->labelsKnown()) {
    return session_->rename(from, to);
  }
  askButton(
      parent_, "Rename Label",
      unknownLabels() + QString(" A label %1 would be replaced.").arg(QString::fromStdString(to)),
      {"Rename"}, then([this, from, to](int) { return session_->rename(from, to); }));
  return {};
}

void LabelCommands::select(const Labels& chosen)
{
  std::vector<LabelFacesConstPtr> faces;
  for (const std::string& label : chosen) {
    faces.push_back(session_->faces(label));
  }
  message_ = tool_->selectLabels(session_->mesh(), faces);
}

void LabelCommands::step(bool undo)
{
  attempt([&] {
    message_.clear();
    if (tool_) {
      report_ = undo ? tool_->undo() : tool_->redo();
    } else {
      report_ = undo ? session_->undo() : session_->redo();
    }
  });
}

void LabelCommands::askColors(const Labels& labels)
{
  askColor(parent_, "Color of " + listed(labels), session_->color(labels.at(0)),
           then([this, labels](const auto& color) { return session_->setColor(labels, color); }));
}

LabelCommands::Labels LabelCommands::withClasses(const Labels& chosen) const
{
  std::set<std::string> classes;
  for (const std::string& label : chosen) {
    classes.insert(labelClass(label));
  }
  Labels labels = session_->names();
  eraseIf(labels, [&](const auto& label) { return classes.count(labelClass(label)) == 0; });
  return labels;
}

std::string LabelCommands::startImport(const std::string& path)
{
  read_path_ = path;
  read_for_ = session_->mesh();
  reading_.start([path, face_count = read_for_->faceCount()](const Cancellation&) {
    return readLabelFile(path, face_count);
  });
  return {};
}

std::string LabelCommands::startExport(const std::string& path)
{
  const MeshDataConstPtr mesh = session_->mesh();
  writing_.start([path, uuid = mesh->uuid, content = session_->content(),
                  face_count = mesh->faceCount()](const Cancellation&) {
    LabelFile file;
    file.uuid = uuid;
    file.labels = content();
    writeLabelFile(path, file, face_count);
    return countedLabels(file.labels) + " exported to " + path;
  });
  return {};
}

std::string LabelCommands::import(const LabelFile& file)
{
  const auto labels = std::make_shared<const FileLabels>(file.labels);
  Labels replaced;
  for (const auto& label : file.labels) {
    if (session_->faceCount(label.first) > 0 &&
        *session_->faces(label.first) != label.second.faces) {
      replaced.push_back(label.first);
    }
  }
  QString question;
  if (!file.uuid.empty() && file.uuid != session_->mesh()->uuid) {
    question = "These labels were made for another mesh with as many faces. ";
  }
  if (!session_->labelsKnown()) {
    question += unknownLabels() + QString(" Those of the same names would be replaced. ");
  }
  if (!replaced.empty()) {
    question += "They replace " + listed(replaced) + ".";
  }
  if (question.isEmpty()) {
    return importNow(labels);
  }
  askButton(parent_, "Import Labels", question, {"Import"},
            then([this, labels](int) { return importNow(labels); }));
  return {};
}

std::string LabelCommands::importNow(const std::shared_ptr<const FileLabels>& labels)
{
  std::string reason = session_->import(labels);
  if (reason.empty()) {
    report_ = countedLabels(*labels) + " imported from " + read_path_;
  }
  return reason;
}

void LabelCommands::work()
{
  attempt([&] {
    if (const auto read = reading_.take()) {
      const MeshDataConstPtr mesh = std::move(read_for_);
      message_ = read->result ? whyNotOf(mesh) : read->error;
      if (message_.empty()) {
        message_ = import(*read->result);
      }
    }
    if (const auto written = writing_.take()) {
      (written->result ? report_ : message_) = written->result ? *written->result : written->error;
    }
  });
}

}  // namespace rviz_mesh_plugin
