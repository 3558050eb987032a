#pragma once

#include <map>
#include <string>

#include <QColor>
#include <QPointer>

#ifndef Q_MOC_RUN
#include <rviz/display.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#endif

namespace rviz_mesh_plugin {

/// Color and visibility of labels, as the properties of their display have them.
class LabelLooks
{
 public:
  /// To be called often: its properties are looked through once in between. Null: there is none.
  void setDisplay(rviz::Display* display);

  /// Invalid while it is not known.
  QColor color(const std::string& label);
  bool isShown(const std::string& label);
  /// Shows the class, too.
  void setShown(const std::string& label, bool shown);

 private:
  struct Look
  {
    QPointer<rviz::ColorProperty> color;
    QPointer<rviz::BoolProperty> shown;
    QPointer<rviz::BoolProperty> class_shown;
  };
  Look* find(const std::string& label);
  void read();

  QPointer<rviz::Display> display_;
  std::map<std::string, Look> looks_;
  bool read_ = false;
};

}  // namespace rviz_mesh_plugin
