#include "rviz_mesh_plugin/label_files.h"

#include <QFile>
#include <QFileInfo>
#include <QSaveFile>

namespace rviz_mesh_plugin {
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
  QSaveFile out(QString::fromStdString(path));
  const auto size = static_cast<qint64>(text.size());
  if (!out.open(QIODevice::WriteOnly) || out.write(text.data(), size) != size || !out.commit()) {
    throw LabelFileError(path + ": it cannot be written: " + out.errorString().toStdString());
  }
}

}  // namespace rviz_mesh_plugin
