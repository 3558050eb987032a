#include <algorithm>
#include <cmath>
#include <utility>

#include <QByteArray>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>

#include "rviz_mesh_plugin/label_colors.h"
#include "rviz_mesh_plugin/label_faces.h"
#include "rviz_mesh_plugin/label_files.h"
#include "rviz_mesh_plugin/label_name.h"
#include "rviz_mesh_plugin/service_log.h"

namespace rviz_mesh_plugin {
namespace {

const char* const FORMAT = "mesh_labels";
constexpr int VERSION = 1;

/// With quotation marks.
std::string quoted(const std::string& text)
{
  const QByteArray list =
      QJsonDocument(QJsonArray{QString::fromStdString(text)}).toJson(QJsonDocument::Compact);
  return list.mid(1, list.size() - 2).toStdString();
}

void append(std::string& out, const std::string& label, const FileLabel& content)
{
  out += "{\"label\": " + quoted(label) + ", \"class\": " + quoted(labelClass(label)) +
         ", \"instance\": " + quoted(labelInstance(label)) + ", \"color\": ";
  if (content.color) {
    out += "[" + std::to_string(content.color->red) + ", " + std::to_string(content.color->green) +
           ", " + std::to_string(content.color->blue) + "]";
  } else {
    out += "null";
  }
  out += ", \"faces\": [";
  const char* separator = "";
  for (const std::uint32_t face : content.faces) {
    out += separator + std::to_string(face);
    separator = ", ";
  }
  out += "]}";
}

/// A whole number from 0 up to a limit; negative: it is none.
double wholeNumber(const QJsonValue& value, double limit)
{
  const double number = value.isDouble() ? value.toDouble() : -1.0;
  return number >= 0.0 && number <= limit && number == std::floor(number) ? number : -1.0;
}

Rgba8 toColor(const QJsonValue& value, const std::string& where)
{
  const QJsonArray channels = value.toArray();
  if (!value.isArray() || channels.size() != 3) {
    throw LabelFileError(where + ": the color is not [red, green, blue]");
  }
  std::uint8_t bytes[3] = {};
  for (int i = 0; i < 3; ++i) {
    const double channel = wholeNumber(channels[i], 255.0);
    if (channel < 0.0) {
      throw LabelFileError(where + ": the color has to be of whole numbers from 0 to 255");
    }
    bytes[i] = static_cast<std::uint8_t>(channel);
  }
  return {bytes[0], bytes[1], bytes[2], 255};
}

std::vector<std::uint32_t> toFaces(const QJsonArray& list, const std::string& where,
                                   std::size_t face_count)
{
  std::vector<std::uint32_t> faces;
  faces.reserve(static_cast<std::size_t>(list.size()));
  for (int i = 0; i < list.size(); ++i) {
    const double face = wholeNumber(list[i], static_cast<double>(face_count) - 1.0);
    if (face < 0.0) {
      throw LabelFileError(where + ": faces[" + std::to_string(i) + "] is no face of the mesh; " +
                           "those are whole numbers from 0 to " +
                           std::to_string(face_count - std::min<std::size_t>(1, face_count)));
    }
    faces.push_back(static_cast<std::uint32_t>(face));
  }
  sortFaces(faces);
  return faces;
}

void addLabel(FileLabels& labels, const QJsonValue& entry, std::string where,
              std::size_t face_count)
{
  const QJsonObject fields = entry.toObject();
  const QJsonValue label = fields["label"];
  const QJsonValue faces = fields["faces"];
  if (!label.isString() || !faces.isArray()) {
    throw LabelFileError(where + " has no text \"label\" or no list \"faces\"");
  }
  const std::string name = label.toString().toStdString();
  where += ", '" + shortened(name) + "'";
  const std::string reason = whyNoLabel(name);
  if (!reason.empty()) {
    throw LabelFileError(where + ": " + reason);
  }
  if (labels.count(name) != 0) {
    throw LabelFileError(where + " comes twice");
  }
  FileLabel content;
  content.faces = toFaces(faces.toArray(), where, face_count);
  if (!fields["color"].isNull() && !fields["color"].isUndefined()) {
    content.color = toColor(fields["color"], where);
  }
  labels.emplace(name, std::move(content));
}

QJsonObject parse(const std::string& text)
{
  QJsonParseError error;
  const QByteArray bytes = QByteArray::fromRawData(text.data(), static_cast<int>(text.size()));
  const QJsonDocument document = QJsonDocument::fromJson(bytes, &error);
  if (error.error != QJsonParseError::NoError) {
    const auto end = text.begin() + std::min<std::ptrdiff_t>(error.offset, bytes.size());
    throw LabelFileError("line " + std::to_string(1 + std::count(text.begin(), end, '\n')) +
                         " is no JSON: " + error.errorString().toStdString());
  }
  return document.object();
}

}  // namespace

std::string labelsToJson(const LabelFile& file, std::size_t face_count)
{
  std::string out = "{\"format\": " + quoted(FORMAT) + ", \"version\": " + std::to_string(VERSION) +
                    ", \"uuid\": " + quoted(file.uuid) +
                    ", \"faces\": " + std::to_string(face_count) + ",\n \"labels\": [";
  const char* separator = "\n  ";
  for (const auto& label : file.labels) {
    out += separator;
    append(out, label.first, label.second);
    separator = ",\n  ";
  }
  return out + "\n ]}\n";
}

LabelFile labelsFromJson(const std::string& text, std::size_t face_count)
{
  const QJsonObject content = parse(text);
  if (content["format"].toString() != FORMAT) {
    throw LabelFileError(std::string("it does not say \"format\": \"") + FORMAT + "\"");
  }
  if (content["version"].toInt(-1) != VERSION) {
    throw LabelFileError("it is not of version " + std::to_string(VERSION));
  }
  if (content.contains("faces") &&
      content["faces"].toDouble(-1.0) != static_cast<double>(face_count)) {
    throw LabelFileError("it is for a mesh of " +
                         content["faces"].toVariant().toString().toStdString() +
                         " faces, this one has " + std::to_string(face_count));
  }
  if (!content["labels"].isArray()) {
    throw LabelFileError("it has no list \"labels\"");
  }
  LabelFile file;
  file.uuid = content["uuid"].toString().toStdString();
  const QJsonArray labels = content["labels"].toArray();
  for (int i = 0; i < labels.size(); ++i) {
    addLabel(file.labels, labels[i], "labels[" + std::to_string(i) + "]", face_count);
  }
  return file;
}

}  // namespace rviz_mesh_plugin
