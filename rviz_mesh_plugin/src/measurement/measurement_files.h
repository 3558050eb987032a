#pragma once

#include <string>
#include <vector>

#include "measurement/measurement.h"

namespace rviz_mesh_plugin {

/// CSV with a header, with units in the names of columns; numbers have points, whatever the locale.
/// A row for each measurement; cells are empty where a column is not of its kind.
std::string measurementsToCsv(const std::vector<Measurement>& measurements);

/// A row for each point of a profile, numbered by pieces: between them there is a gap.
std::string profileToCsv(const Measurement& profile);

/// Writes a file; the old one or the new one is there at any time. Not for the GUI thread, which
/// must not wait for a disk. @param replace false: one that is there is left as it is
/// @throw std::runtime_error that begins with the path
void writeCsv(const std::string& path, const std::string& text, bool replace);

}  // namespace rviz_mesh_plugin
