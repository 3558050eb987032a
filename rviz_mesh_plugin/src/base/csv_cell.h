#pragma once

#include <string>

#include <boost/algorithm/string/replace.hpp>

namespace rviz_mesh_plugin {

/// As RFC 4180 has it; also where the cell has a semicolon, at which some programs cut.
inline std::string quotedCell(const std::string& text)
{
  if (text.find_first_of(",\"\r\n;") == std::string::npos) {
    return text;
  }
  return '"' + boost::algorithm::replace_all_copy(text, "\"", "\"\"") + '"';
}

}  // namespace rviz_mesh_plugin
