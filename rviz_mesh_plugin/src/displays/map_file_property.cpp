#include "displays/map_file_property.h"

#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QPushButton>

#include "map_server/file_state.h"

namespace rviz_mesh_plugin {
namespace {

constexpr const char* FILTERS =
    "Maps and meshes (*.h5 *.hdf5 *.ply *.obj *.stl *.dae *.glb *.gltf);;"
    "Maps (*.h5 *.hdf5);;All files (*)";

}  // namespace

QWidget* MapFileProperty::createEditor(QWidget* parent, const QStyleOptionViewItem& /*option*/)
{
  return new MapFileEditor(this, parent);
}

void MapFileProperty::openDialog(QWidget* parent)
{
  auto* dialog = new QFileDialog(parent, getName(), QString(), FILTERS);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setFileMode(QFileDialog::ExistingFile);
  const QFileInfo chosen(QString::fromStdString(resolvedPath(getStdString())));
  if (chosen.dir().exists()) {
    dialog->setDirectory(chosen.dir());
    dialog->selectFile(chosen.fileName());
  }
  // Where the property is deleted first, Qt ends the connection.
  connect(dialog, &QFileDialog::fileSelected, this,
          [this](const QString& path) { setValue(path); });
  connect(this, &QObject::destroyed, dialog, &QWidget::close);
  dialog->open();
}

MapFileEditor::MapFileEditor(MapFileProperty* property, QWidget* parent)
    : rviz::LineEditWithButton(parent), property_(property)
{
  button()->setToolTip("Choose a file");
}

void MapFileEditor::onButtonClick()
{
  MapFileProperty* property = property_;
  QWidget* parent = window();
  // Some window managers end the editor as soon as the dialog has the focus, and then its text
  // would replace the choice: better at once, everywhere.
  deleteLater();
  property->openDialog(parent);
}

}  // namespace rviz_mesh_plugin
