#pragma once

#include <QString>

#ifndef Q_MOC_RUN
#include <rviz/properties/line_edit_with_button.h>
#include <rviz/properties/string_property.h>
#endif

namespace rviz_mesh_plugin {

/// The path of a file: to be typed, or chosen with a button.
class MapFileProperty : public rviz::StringProperty
{
  Q_OBJECT

 public:
  /// @param filters for the file dialog, separated by ";;"
  MapFileProperty(const QString& name, const QString& default_value, const QString& description,
                  const QString& filters, rviz::Property* parent, const char* changed_slot,
                  QObject* receiver);

  QWidget* createEditor(QWidget* parent, const QStyleOptionViewItem& option) override;

  /// Opens the file dialog and returns; the choice becomes the value.
  void openDialog(QWidget* parent);

 private:
  QString filters_;
};

/// Edits a MapFileProperty.
class MapFileEditor : public rviz::LineEditWithButton
{
  Q_OBJECT

 public:
  MapFileEditor(MapFileProperty* property, QWidget* parent);

 protected Q_SLOTS:
  void onButtonClick() override;

 private:
  MapFileProperty* property_;
};

}  // namespace rviz_mesh_plugin
