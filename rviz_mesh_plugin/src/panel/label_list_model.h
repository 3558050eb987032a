#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <QAbstractTableModel>
#include <QColor>
#include <QPointer>

#ifndef Q_MOC_RUN
#include <rviz/display.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>

#include "label_editing/label_session.h"
#include "panel/label_areas.h"
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

/// The labels of a session as a table, tree_2 before tree_10.
class LabelListModel : public QAbstractTableModel
{
 public:
  enum Column
  {
    CLASS,  ///< with a check box (drawn or not) and the color
    INSTANCE,
    FACES,
    AREA,
    STATE,
    COLUMNS
  };

  /// @param session outlives this
  explicit LabelListModel(LabelSession* session, QObject* parent = nullptr);

  /// Follows the session; to be called often. True where the rows are others than before.
  bool refresh();

  const std::vector<std::string>& labels() const { return labels_; }

  int rowCount(const QModelIndex& parent = QModelIndex()) const override;
  int columnCount(const QModelIndex& parent = QModelIndex()) const override;
  QVariant data(const QModelIndex& index, int role) const override;
  bool setData(const QModelIndex& index, const QVariant& value, int role) override;
  QVariant headerData(int section, Qt::Orientation orientation, int role) const override;
  Qt::ItemFlags flags(const QModelIndex& index) const override;

 private:
  bool refreshRows();
  QVariant text(const std::string& label, int column) const;

  LabelSession* session_;
  std::vector<std::string> labels_;
  std::size_t revision_ = 0;
  LabelAreas areas_;
  bool areas_known_ = false;
  LabelLooks looks_;
};

}  // namespace rviz_mesh_plugin
