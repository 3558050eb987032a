#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

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
  /// Follows the properties of a display (null: there is none); to be called often. True where
  /// something looks other than before.
  bool refresh(rviz::Display* display);

  /// Invalid while it is not known.
  QColor color(const std::string& label) const;
  bool isShown(const std::string& label) const;
  /// Shows the class, too.
  void setShown(const std::string& label, bool shown);

 private:
  struct Look
  {
    QPointer<rviz::ColorProperty> color;
    QPointer<rviz::BoolProperty> shown;
    QPointer<rviz::BoolProperty> class_shown;

    bool isComplete() const { return color && shown && class_shown; }
    bool isShown() const { return shown->getBool() && class_shown->getBool(); }
  };
  const Look* find(const std::string& label) const;
  void read();
  bool isRead() const;

  QPointer<rviz::Display> display_;
  std::map<std::string, Look> looks_;
  std::size_t properties_ = 0;                 ///< that there were
  std::vector<std::pair<QColor, bool>> seen_;  ///< color and visibility of all, in order
};

}  // namespace rviz_mesh_plugin
