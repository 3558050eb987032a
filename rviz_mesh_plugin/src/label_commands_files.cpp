// A part of the commands: import and export.
#include <algorithm>
#include <string>
#include <utility>

#include "rviz_mesh_plugin/label_commands.h"
#include "rviz_mesh_plugin/label_dialogs.h"

namespace rviz_mesh_plugin {
namespace {

std::string countedLabels(const FileLabels& labels)
{
  const auto count = std::count_if(labels.begin(), labels.end(),
                                   [](const auto& label) { return !label.second.faces.empty(); });
  return std::to_string(count) + (count == 1 ? " label" : " labels");
}

}  // namespace

std::string LabelCommands::startImport(const std::string& path)
{
  read_path_ = path;
  read_for_ = session_->mesh();
  reading_.start(
      [path, face_count = read_for_->faceCount()] { return readLabelFile(path, face_count); });
  return {};
}

std::string LabelCommands::startExport(const std::string& path)
{
  const MeshDataConstPtr mesh = session_->mesh();
  LabelFile file;
  file.uuid = mesh->uuid;
  file.labels = session_->content();
  writing_.start([path, file = std::move(file), face_count = mesh->faceCount()] {
    writeLabelFile(path, file, face_count);
    return countedLabels(file.labels) + " exported to " + path;
  });
  return {};
}

std::string LabelCommands::import(const LabelFile& file)
{
  Labels replaced;
  for (const auto& label : file.labels) {
    if (session_->faceCount(label.first) > 0 &&
        session_->faces(label.first) != label.second.faces) {
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
    return importNow(file.labels);
  }
  askButton(parent_, "Import Labels", question, {"Import"},
            then([this, labels = file.labels](int) { return importNow(labels); }));
  return {};
}

std::string LabelCommands::importNow(const FileLabels& labels)
{
  std::string reason = session_->import(labels);
  if (reason.empty()) {
    news_ = countedLabels(labels) + " imported from " + read_path_;
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
      (written->result ? news_ : message_) = written->result ? *written->result : written->error;
    }
  });
}

}  // namespace rviz_mesh_plugin
