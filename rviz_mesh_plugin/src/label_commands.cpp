#include "rviz_mesh_plugin/label_commands.h"

#include <algorithm>
#include <exception>
#include <set>
#include <stdexcept>
#include <utility>

#include "rviz_mesh_plugin/label_colors.h"
#include "rviz_mesh_plugin/label_dialogs.h"

namespace rviz_mesh_plugin {

void LabelCommands::attempt(const std::function<void()>& work)
{
  try {
    work();
  } catch (const std::exception& error) {
    message_ = std::string("this went wrong: ") + error.what();
  }
}

LabelSituation LabelCommands::situation() const
{
  LabelSituation situation;
  situation.has_tool = tool_ != nullptr;
  situation.has_mesh = session_->mesh() != nullptr;
  situation.selected = tool_ ? tool_->selection().count() : 0;
  situation.selection_is_of_it = tool_ && session_->isOf(tool_->mesh());
  situation.unstored = session_->unstored();
  situation.failed = session_->failed();
  situation.unsaved = session_->unsaved();
  situation.saving = session_->isSaving();
  situation.file_busy = reading_.isRunning() || writing_.isRunning();
  return situation;
}

void LabelCommands::run(LabelAction action, const std::string& name, const Labels& chosen)
{
  attempt([&] {
    LabelSituation now = situation();
    now.name = name;
    now.chosen = chosen.size();
    now.labels = session_->names().size();
    message_ = whyNot(action, now);
    if (message_.empty()) {
      start(action, name, chosen);
    }
  });
}

/// Commands that a dialog asks about go on when that is answered: by then all may have changed.
void LabelCommands::start(LabelAction action, const std::string& name, const Labels& chosen)
{
  const auto then = [this](const auto& work) {
    return [this, work](const auto& answer) { attempt([&] { message_ = work(answer); }); };
  };
  switch (action) {
    case LabelAction::LABEL_CLUSTER:
      return label(name);
    case LabelAction::RESET_FACES:
      return tool_->clearSelection();
    case LabelAction::NEW:
      return askLabel(
          parent_, "New Label", "", session_->names(),
          then([this](const std::string& label) { return session_->assign(label, selection()); }));
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
      return askLabel(parent_, "Rename " + listed(chosen), chosen[0], session_->names(),
                      then([this, from = chosen[0]](const std::string& to) {
                        return session_->rename(from, to);
                      }));
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
      return askFile(parent_, false, [this](const std::string& path) { startImport(path); });
    case LabelAction::EXPORT:
      return askFile(parent_, true, [this](const std::string& path) { startExport(path); });
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

LabelSession::Faces LabelCommands::selection() const
{
  if (!tool_ || tool_->selection().empty() || !session_->isOf(tool_->mesh())) {
    throw std::runtime_error("the selected faces are gone, or the mesh is another one now");
  }
  return tool_->selection().faces();
}

void LabelCommands::label(const std::string& name)
{
  if (session_->faceCount(name) == 0) {
    message_ = session_->assign(name, selection());
    return;
  }
  askButton(parent_, "Label Cluster",
            QString("There is a label %1 with faces already.").arg(QString::fromStdString(name)),
            {"Replace Them", "Add"}, [this, name](int button) {
              attempt([&] {
                message_ = button == 0 ? session_->assign(name, selection())
                                       : session_->add(name, selection());
              });
            });
}

void LabelCommands::select(const Labels& chosen)
{
  LabelSession::Faces faces;
  for (const std::string& label : chosen) {
    const LabelSession::Faces more = session_->faces(label);
    faces.insert(faces.end(), more.begin(), more.end());
  }
  message_ = tool_->select(session_->mesh(), faces);
}

void LabelCommands::askColors(const Labels& labels)
{
  askColor(parent_, "Color of " + listed(labels), QColor(), [this, labels](const QColor& color) {
    attempt([&] {
      const auto channel = [](int value) { return static_cast<std::uint8_t>(value); };
      message_ = session_->setColor(
          labels, Rgba8{channel(color.red()), channel(color.green()), channel(color.blue()), 255});
    });
  });
}

LabelCommands::Labels LabelCommands::withClasses(const Labels& chosen) const
{
  std::set<std::string> classes;
  for (const std::string& label : chosen) {
    classes.insert(labelClass(label));
  }
  Labels labels = session_->names();
  labels.erase(
      std::remove_if(labels.begin(), labels.end(),
                     [&](const auto& label) { return classes.count(labelClass(label)) == 0; }),
      labels.end());
  return labels;
}

void LabelCommands::startImport(const std::string& path)
{
  attempt([&] {
    if (const MeshDataConstPtr mesh = session_->mesh()) {
      const std::size_t face_count = mesh->faceCount();
      reading_.start([path, face_count] { return readLabelFile(path, face_count); });
    }
  });
}

void LabelCommands::startExport(const std::string& path)
{
  attempt([&] {
    if (const MeshDataConstPtr mesh = session_->mesh()) {
      LabelFile file;
      file.uuid = mesh->uuid;
      file.labels = session_->content();
      writing_.start([path, file = std::move(file), face_count = mesh->faceCount()] {
        writeLabelFile(path, file, face_count);
        return path;
      });
    }
  });
}

void LabelCommands::import(const LabelFile& file)
{
  Labels replaced;
  for (const auto& label : file.labels) {
    if (session_->faceCount(label.first) > 0 &&
        session_->faces(label.first) != label.second.faces) {
      replaced.push_back(label.first);
    }
  }
  QString question;
  const MeshDataConstPtr mesh = session_->mesh();
  if (mesh && !file.uuid.empty() && file.uuid != mesh->uuid) {
    question = "These labels were made for another mesh with as many faces. ";
  }
  if (!replaced.empty()) {
    question += "They replace " + listed(replaced) + ".";
  }
  if (question.isEmpty()) {
    message_ = session_->import(file.labels);
    return;
  }
  askButton(parent_, "Import Labels", question, {"Import"}, [this, labels = file.labels](int) {
    attempt([&] { message_ = session_->import(labels); });
  });
}

void LabelCommands::work()
{
  attempt([&] {
    if (const auto read = reading_.take()) {
      if (read->result) {
        import(*read->result);
      } else {
        message_ = read->error;
      }
    }
    const auto written = writing_.take();
    if (written && !written->result) {
      message_ = written->error;
    }
  });
}

}  // namespace rviz_mesh_plugin
