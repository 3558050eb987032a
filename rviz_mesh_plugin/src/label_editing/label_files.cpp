#include "label_editing/label_files.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <map>
#include <utility>

#include <QByteArray>
#include <QFile>
#include <QFileInfo>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QRegularExpression>
#include <boost/algorithm/string/case_conv.hpp>
#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/trim.hpp>

#include "base/csv_cell.h"
#include "base/qt_colors.h"
#include "base/saved_file.h"
#include "base/status_lines.h"
#include "labels/label_faces.h"
#include "labels/label_name.h"

namespace rviz_mesh_plugin {

// CSV: a row for each run of faces.

namespace {

const char* const HEADER = "label,class,instance,color,first_face,last_face\n";

std::string trimmed(const std::string& text)
{
  return boost::algorithm::trim_copy_if(text, boost::algorithm::is_any_of(" \t\r"));
}

/// Of ASCII.
std::string lowered(const std::string& text)
{
  return boost::algorithm::to_lower_copy(text, std::locale::classic());
}

/// Reads rows of cells, which may be in quotation marks.
class Rows
{
 public:
  Rows(const std::string& text, char delimiter) : text_(text), delimiter_(delimiter) {}

  /// False where there is none left.
  bool next(std::vector<std::string>& cells)
  {
    cells.clear();
    if (place_ >= text_.size()) {
      return false;
    }
    ++line_;
    do {
      cells.push_back(cell());
    } while (take(delimiter_));
    const bool ended = take('\r');  // that of old Macs is no more
    if (!take('\n') && !ended && place_ < text_.size()) {
      throw LabelFileError(where() + ": there is text behind a quotation mark");
    }
    return true;
  }

  /// Of the row before.
  std::string where() const { return "line " + std::to_string(line_); }

 private:
  bool take(char c)
  {
    const bool there = place_ < text_.size() && text_[place_] == c;
    place_ += there ? 1 : 0;
    return there;
  }

  std::string cell()
  {
    if (!take('"')) {
      const std::size_t end =
          std::min(text_.find_first_of(std::string("\r\n") + delimiter_, place_), text_.size());
      const std::size_t begin = std::exchange(place_, end);
      return text_.substr(begin, end - begin);
    }
    std::string cell;
    while (place_ < text_.size()) {
      const char c = text_[place_++];
      if (c == '"' && !take('"')) {
        return cell;
      }
      cell += c;
    }
    throw LabelFileError(where() + ": a quotation mark has no end");
  }

  const std::string& text_;
  const char delimiter_;
  std::size_t place_ = 0;
  std::size_t line_ = 0;
};

/// Of #rrggbb, or red,green,blue.
std::optional<Rgba8> toColor(const std::string& text, const std::string& where)
{
  if (text.empty() || lowered(text) == "none") {
    return std::nullopt;
  }
  // Never destroyed: a thread may still read a file while the process ends.
  static const QRegularExpression& FORM = *new QRegularExpression(
      "\\A(?:#?([0-9a-fA-F]{2})([0-9a-fA-F]{2})([0-9a-fA-F]{2})|"
      "([0-9]{1,3})\\s*,\\s*([0-9]{1,3})\\s*,\\s*([0-9]{1,3}))\\z");
  const auto match = FORM.match(QString::fromStdString(text));
  const bool decimal = !match.captured(4).isEmpty();
  const auto channel = [&](int i) {
    return match.captured(i + (decimal ? 4 : 1)).toInt(nullptr, decimal ? 10 : 16);
  };
  if (!match.hasMatch() || std::max({channel(0), channel(1), channel(2)}) > 255) {
    throw LabelFileError(where + ": '" + shortened(text) + "' is no color as #rrggbb");
  }
  return toRgba8({channel(0), channel(1), channel(2)});
}

std::size_t toFace(const std::string& text, std::size_t face_count, const std::string& where)
{
  const bool number = !text.empty() && text.size() <= 10 &&
                      text.find_first_not_of("0123456789") == std::string::npos;
  const unsigned long long face =
      number ? std::stoull(text) : std::numeric_limits<unsigned long long>::max();
  if (face >= face_count) {
    throw LabelFileError(where + ": '" + shortened(text) + "' is no face of the mesh, which has " +
                         std::to_string(face_count));
  }
  return static_cast<std::size_t>(face);
}

/// The places of cells in a row, by the name of their column.
using Columns = std::map<std::string, std::size_t>;

Columns columnsOf(const std::vector<std::string>& header)
{
  Columns columns;
  for (std::size_t place = 0; place < header.size(); ++place) {
    columns[lowered(trimmed(header[place]))] = place;
  }
  if (columns.count("label") == 0 || columns.count("first_face") == 0) {
    throw LabelFileError("line 1 does not name the columns label and first_face");
  }
  return columns;
}

void addRow(FileLabels& labels, const Columns& columns, const std::vector<std::string>& cells,
            std::size_t face_count, const std::string& where)
{
  const auto cell = [&](const char* name) {
    const auto column = columns.find(name);
    return column != columns.end() && column->second < cells.size() ? cells[column->second]
                                                                    : std::string();
  };
  const std::string name = cell("label");
  const std::string reason = whyNoLabel(name);
  if (!reason.empty()) {
    throw LabelFileError(where + ": " + reason);
  }
  FileLabel& label = labels[name];
  const auto color = toColor(trimmed(cell("color")), where);
  if (color && label.color && !(*color == *label.color)) {
    throw LabelFileError(where + ": label '" + shortened(name) + "' has two colors");
  }
  label.color = color ? color : label.color;
  const std::string first_text = trimmed(cell("first_face"));
  const std::string last_text = trimmed(cell("last_face"));
  if (first_text.empty() && last_text.empty()) {
    return;
  }
  const std::size_t first = toFace(first_text, face_count, where);
  const std::size_t last = last_text.empty() ? first : toFace(last_text, face_count, where);
  if (last < first) {
    throw LabelFileError(where + ": the last face comes before the first");
  }
  if (label.faces.size() + (last - first) >= face_count) {
    throw LabelFileError(where + ": label '" + shortened(name) + "' has faces twice");
  }
  for (std::size_t face = first; face <= last; ++face) {
    label.faces.push_back(static_cast<std::uint32_t>(face));
  }
}

}  // namespace

std::string labelsToCsv(const FileLabels& labels)
{
  std::string out = HEADER;
  for (const auto& label : labels) {
    const auto& own = label.second.color;
    const std::string color = own ? toQColor(*own).name().toStdString() : std::string();
    const std::string head = quotedCell(label.first) + "," + quotedCell(labelClass(label.first)) +
                             "," + quotedCell(labelInstance(label.first)) + "," + color + ",";
    const std::vector<std::uint32_t>& faces = label.second.faces;
    if (faces.empty()) {
      out += head + ",\n";
    }
    for (std::size_t first = 0, next = 0; first < faces.size(); first = next) {
      for (next = first + 1; next < faces.size() && faces[next] == faces[next - 1] + 1;) {
        ++next;
      }
      out += head + std::to_string(faces[first]) + "," + std::to_string(faces[next - 1]) + "\n";
    }
  }
  return out;
}

FileLabels labelsFromCsv(const std::string& text, std::size_t face_count)
{
  const std::string head = text.substr(0, text.find('\n'));
  Rows rows(text, head.find(';') == std::string::npos ? ',' : ';');
  std::vector<std::string> cells;
  if (!rows.next(cells)) {
    throw LabelFileError("it is empty");
  }
  const Columns columns = columnsOf(cells);
  FileLabels labels;
  while (rows.next(cells)) {
    if (cells.size() > 1 || !trimmed(cells[0]).empty()) {
      addRow(labels, columns, cells, face_count, rows.where());
    }
  }
  for (auto& label : labels) {
    sortFaces(label.second.faces);
  }
  return labels;
}

// JSON.

namespace {

const char* const FORMAT = "mesh_labels";
constexpr int VERSION = 1;

/// With quotation marks.
std::string quotedText(const std::string& text)
{
  const QByteArray list =
      QJsonDocument(QJsonArray{QString::fromStdString(text)}).toJson(QJsonDocument::Compact);
  return list.mid(1, list.size() - 2).toStdString();
}

void append(std::string& out, const std::string& label, const FileLabel& content)
{
  out += "{\"label\": " + quotedText(label) + ", \"class\": " + quotedText(labelClass(label)) +
         ", \"instance\": " + quotedText(labelInstance(label)) + ", \"color\": ";
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
  if (QString::fromStdString(name) != label.toString()) {
    throw LabelFileError(where + ": the name of the label has half a character");
  }
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

QJsonObject parseJson(const std::string& text)
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
  std::string out = "{\"format\": " + quotedText(FORMAT) +
                    ", \"version\": " + std::to_string(VERSION) +
                    ", \"uuid\": " + quotedText(file.uuid) +
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
  const QJsonObject content = parseJson(text);
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

// Files of either kind.

namespace {

constexpr qint64 MAX_BYTES = qint64{1} << 30;

std::string readAll(const std::string& path)
{
  const QFileInfo info(QString::fromStdString(path));
  if (info.exists() && !info.isFile()) {  // a pipe would be read forever
    throw LabelFileError("it is no file");
  }
  QFile file(info.filePath());
  if (!file.open(QIODevice::ReadOnly)) {
    throw LabelFileError("it cannot be read: " + file.errorString().toStdString());
  }
  if (file.size() > MAX_BYTES) {
    throw LabelFileError("it has more than a gigabyte: that is no file of labels");
  }
  const QByteArray bytes = file.readAll();
  if (file.error() != QFileDevice::NoError) {
    throw LabelFileError("it cannot be read: " + file.errorString().toStdString());
  }
  return bytes.startsWith("\xEF\xBB\xBF") ? bytes.mid(3).toStdString() : bytes.toStdString();
}

LabelFile parse(const std::string& text, std::size_t face_count)
{
  if (!isUtf8(text)) {
    throw LabelFileError("it is no UTF-8");
  }
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start != std::string::npos && (text[start] == '{' || text[start] == '[')) {
    return labelsFromJson(text, face_count);
  }
  return {std::string(), labelsFromCsv(text, face_count)};
}

}  // namespace

LabelFile readLabelFile(const std::string& path, std::size_t face_count)
{
  try {
    return parse(readAll(path), face_count);
  } catch (const LabelFileError& error) {
    throw LabelFileError(path + ": " + error.what());
  }
}

void writeLabelFile(const std::string& path, const LabelFile& file, std::size_t face_count)
{
  const bool csv = QFileInfo(QString::fromStdString(path)).suffix().toLower() == "csv";
  const std::string text = csv ? labelsToCsv(file.labels) : labelsToJson(file, face_count);
  const std::string problem = saveFile(path, text);
  if (!problem.empty()) {
    throw LabelFileError(path + ": it cannot be written: " + problem);
  }
}

}  // namespace rviz_mesh_plugin
