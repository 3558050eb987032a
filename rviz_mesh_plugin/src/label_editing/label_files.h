#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// A label as it is in a file.
struct FileLabel
{
  std::vector<std::uint32_t> faces;  ///< ascending, each once
  std::optional<Rgba8> color;        ///< of its own
};

/// By name.
using FileLabels = std::map<std::string, FileLabel>;

struct LabelFile
{
  std::string uuid;  ///< of the mesh; empty where the file does not say it
  FileLabels labels;
};

/// Says in which line or place what is wrong.
class LabelFileError : public std::runtime_error
{
 public:
  using std::runtime_error::runtime_error;
};

/// Both are the formats of "mesh_tool labels export", see the README of mesh_msgs_hdf5. Tests hold
/// this and labels/label_tables.py there to the same cases, mesh_msgs/test/label_files.json.
std::string labelsToJson(const LabelFile& file, std::size_t face_count);
std::string labelsToCsv(const FileLabels& labels);

/// @param face_count of the mesh that they are for. @throw LabelFileError
LabelFile labelsFromJson(const std::string& text, std::size_t face_count);
FileLabels labelsFromCsv(const std::string& text, std::size_t face_count);

/// Of either kind. Takes long for a large file: not for the GUI thread.
/// @throw LabelFileError that begins with the path
LabelFile readLabelFile(const std::string& path, std::size_t face_count);

/// As CSV where the path ends so, else as JSON. The old file or the new one is there at any time.
/// @throw LabelFileError that begins with the path
void writeLabelFile(const std::string& path, const LabelFile& file, std::size_t face_count);

}  // namespace rviz_mesh_plugin
