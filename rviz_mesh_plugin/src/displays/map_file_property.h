#pragma once

#ifndef Q_MOC_RUN
#include <rviz/properties/line_edit_with_button.h>
#include <rviz/properties/string_property.h>
#endif

namespace rviz_mesh_plugin {

/// The path of a map file: to be typed, or chosen with a button.
class MapFileProperty : public rviz::StringProperty
{
  Q_OBJECT

 public:
  using rviz::StringProperty::StringProperty;

  QWidget* createEditor(QWidget* parent, const QStyleOptionViewItem& option) override;

  /// Opens the file dialog and returns; the choice becomes the value.
  void openDialog(QWidget* parent);
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
