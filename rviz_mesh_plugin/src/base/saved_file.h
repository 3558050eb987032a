#pragma once

#include <string>

#include <QSaveFile>
#include <QString>

namespace rviz_mesh_plugin {

/// Writes a file of this text: the old file or the new one is there at any time.
/// @return why it cannot be written; else empty
inline std::string saveFile(const std::string& path, const std::string& text)
{
  QSaveFile out(QString::fromStdString(path));
  const auto size = static_cast<qint64>(text.size());
  if (!out.open(QIODevice::WriteOnly) || out.write(text.data(), size) != size || !out.commit()) {
    return out.errorString().toStdString();
  }
  return {};
}

}  // namespace rviz_mesh_plugin
