#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <utility>

#include "rviz_mesh_plugin/label_colors.h"
#include "rviz_mesh_plugin/label_faces.h"
#include "rviz_mesh_plugin/label_files.h"
#include "rviz_mesh_plugin/label_name.h"
#include "rviz_mesh_plugin/service_log.h"

namespace rviz_mesh_plugin {
namespace {

const char* const HEADER = "label,class,instance,color,first_face,last_face\n";

std::string quoted(const std::string& text)
{
  if (text.find_first_of(",\"\r\n;") == std::string::npos) {
    return text;
  }
  std::string out = "\"";
  for (const char c : text) {
    out += c == '"' ? "\"\"" : std::string(1, c);
  }
  return out + "\"";
}

std::string trimmed(const std::string& text)
{
  const char* const blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? std::string()
                                    : text.substr(first, text.find_last_not_of(blanks) - first + 1);
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
    take('\r');
    if (!take('\n') && place_ < text_.size()) {
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

std::optional<Rgba8> toColor(const std::string& text, const std::string& where)
{
  if (text.empty() || text == "none") {
    return std::nullopt;
  }
  const std::string digits = text.substr(text[0] == '#' ? 1 : 0);
  if (digits.size() != 6 ||
      digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
    throw LabelFileError(where + ": '" + shortened(text) + "' is no color as #rrggbb");
  }
  const unsigned long value = std::stoul(digits, nullptr, 16);
  return Rgba8{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8 & 255),
               static_cast<std::uint8_t>(value & 255), 255};
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

/// Which cell holds what.
struct Columns
{
  enum Name
  {
    LABEL,
    COLOR,
    FIRST,
    LAST
  };
  std::array<std::size_t, 4> places{};

  explicit Columns(const std::vector<std::string>& header)
  {
    const std::array<const char*, 4> names = {"label", "color", "first_face", "last_face"};
    for (std::size_t name = 0; name < names.size(); ++name) {
      places[name] = static_cast<std::size_t>(
          std::find_if(header.begin(), header.end(),
                       [&](const std::string& cell) { return trimmed(cell) == names[name]; }) -
          header.begin());
    }
    if (places[LABEL] == header.size() || places[FIRST] == header.size()) {
      throw LabelFileError("line 1 does not name the columns label and first_face");
    }
  }

  std::string of(const std::vector<std::string>& cells, Name name) const
  {
    const std::size_t place = places[name];
    return place < cells.size() ? cells[place] : std::string();
  }
};

void addRow(FileLabels& labels, const Columns& columns, const std::vector<std::string>& cells,
            std::size_t face_count, const std::string& where)
{
  const std::string name = columns.of(cells, Columns::LABEL);
  const std::string reason = whyNoLabel(name);
  if (!reason.empty()) {
    throw LabelFileError(where + ": " + reason);
  }
  FileLabel& label = labels[name];
  const auto color = toColor(trimmed(columns.of(cells, Columns::COLOR)), where);
  if (color && label.color && !(*color == *label.color)) {
    throw LabelFileError(where + ": label '" + shortened(name) + "' has two colors");
  }
  label.color = color ? color : label.color;
  const std::string first_text = trimmed(columns.of(cells, Columns::FIRST));
  const std::string last_text = trimmed(columns.of(cells, Columns::LAST));
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
    char color[8] = "";
    if (label.second.color) {
      const Rgba8& own = *label.second.color;
      std::snprintf(color, sizeof(color), "#%02x%02x%02x", own.red, own.green, own.blue);
    }
    const std::string head = quoted(label.first) + "," + quoted(labelClass(label.first)) + "," +
                             quoted(labelInstance(label.first)) + "," + color + ",";
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
  const Columns columns(cells);
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

}  // namespace rviz_mesh_plugin
