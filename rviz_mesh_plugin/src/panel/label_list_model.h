#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <QAbstractTableModel>

#include "label_editing/label_session.h"
#include "labels/label_colors.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// The areas of the faces of labels, added up on a thread. To be used by one thread, which never
/// waits.
class LabelAreas
{
 public:
  /// To be called often. True where more is known than before, or less.
  bool follow(const MeshDataConstPtr& mesh, const LabelClusters& labels);

  /// In square meters of the mesh; nothing while it is not known.
  std::optional<double> area(const std::string& label) const;

 private:
  struct Known
  {
    LabelClusterConstPtr label;  ///< whose faces they are
    double area = 0.0;
  };
  using Areas = std::map<std::string, Known>;

  MeshDataConstPtr mesh_;
  Areas known_;
  BackgroundTask<Areas> task_{"label areas"};
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
  bool refreshLooks();
  QVariant text(const std::string& label, int column) const;

  LabelSession* session_;
  std::vector<std::string> labels_;
  std::size_t revision_ = 0;
  LabelAreas areas_;
  LabelLooks looks_;  ///< as they are drawn
};

}  // namespace rviz_mesh_plugin
