#include "map_server/map_progress.h"

#include <algorithm>
#include <cstddef>

namespace rviz_mesh_plugin {
namespace {

/// Without "\033[31m" and the like, and characters that are no text.
std::string withoutEscapes(const std::string& line)
{
  std::string text;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\033' && i + 1 < line.size() && line[i + 1] == '[') {
      i = line.find_first_of("ABCDEFGHJKSTfhlmnsu", i + 2);
      if (i == std::string::npos) {
        break;
      }
    } else if (static_cast<unsigned char>(line[i]) >= ' ') {
      text += line[i];
    }
  }
  return text;
}

bool startsWith(const std::string& text, const std::string& start)
{
  return text.compare(0, start.size(), start) == 0;
}

/// Whether a line starts so; then the rest of it.
bool take(const std::string& line, const std::string& start, std::string& rest)
{
  if (!startsWith(line, start)) {
    return false;
  }
  rest = line.substr(start.size());
  return true;
}

void takeFact(const std::string& line, MapProgress& progress)
{
  std::string rest;
  if (take(line, "reading ", rest)) {
    progress = MapProgress();
    progress.stage = MapProgress::Stage::READING;
    progress.text = rest;
  } else if (take(line, "ready: ", rest)) {
    progress = MapProgress();
    progress.stage = MapProgress::Stage::READY;
    progress.text = rest;
  } else if (take(line, "labels: ", rest)) {
    progress.label_owner = rest;
  } else if (take(line, "note: ", rest)) {
    progress.notes.push_back(rest);
  } else if (take(line, "failed: ", rest)) {
    progress.failure = rest;
  }
}

}  // namespace

void takeProgress(const std::string& message, MapProgress& progress)
{
  std::size_t start = 0;
  while (start < message.size()) {
    const std::size_t end = std::min(message.find('\n', start), message.size());
    takeFact(withoutEscapes(message.substr(start, end - start)), progress);
    start = end + 1;
  }
}

std::string plainLine(const std::string& line)
{
  std::string text = withoutEscapes(line);
  // "[WARN] [1668...]: text", as rospy writes it
  for (const char* level : {"[DEBUG]", "[INFO]", "[WARN]", "[ERROR]", "[FATAL]"}) {
    const std::size_t end = text.find("]: ");
    if (startsWith(text, level) && end != std::string::npos) {
      text.erase(0, end + 3);
      break;
    }
  }
  return text;
}

std::string errorLine(const std::vector<std::string>& lines)
{
  const std::string mark = "error: ";
  std::string last;
  for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
    const std::size_t found = line->find(mark);
    // "error: …" or "program: error: …"
    if (found == 0 || (found != std::string::npos && line->find(' ') == found - 1)) {
      return line->substr(found + mark.size());
    }
    if (last.empty()) {
      last = *line;
    }
  }
  return last;
}

bool isRefusedLabel(const std::string& line)
{
  return startsWith(line, "cluster_label: refused");
}

}  // namespace rviz_mesh_plugin
