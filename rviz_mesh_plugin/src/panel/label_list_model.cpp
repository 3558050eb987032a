#include "panel/label_list_model.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

#include <ros/console.h>
#include <QColor>

#include "base/grouped_number.h"
#include "base/qt_colors.h"
#include "labels/label_name.h"
#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t SLICE = 1 << 16;  // faces between two looks at whether it is given up

}  // namespace

bool LabelAreas::follow(const MeshDataConstPtr& mesh, const LabelClusters& labels)
{
  bool changed = false;
  if (mesh != mesh_) {
    task_.drop();
    changed = !known_.empty();
    known_.clear();
    mesh_ = mesh;
  }
  if (auto done = task_.take()) {
    if (done->result) {
      for (auto& one : *done->result) {
        known_[one.first] = std::move(one.second);
      }
      changed = true;
    } else {
      ROS_ERROR_THROTTLE(10, "the areas of labels are not known: %s", done->error.c_str());
    }
  }
  for (auto one = known_.begin(); one != known_.end();) {
    const auto label = labels.find(one->first);
    const bool same = label != labels.end() && label->second == one->second.label;
    changed = changed || !same;
    one = same ? std::next(one) : known_.erase(one);
  }
  if (!mesh || task_.isRunning()) {
    return changed;
  }
  std::vector<std::pair<std::string, LabelClusterConstPtr>> missing;
  for (const auto& label : labels) {
    if (known_.count(label.first) == 0) {
      missing.emplace_back(label.first, label.second);
    }
  }
  if (!missing.empty()) {
    task_.start([mesh, missing = std::move(missing)](const Cancellation& cancellation) {
      Areas areas;
      for (const auto& label : missing) {
        Known& known = areas[label.first];
        known.label = label.second;
        const auto& faces = label.second->faces;
        for (std::size_t i = 0; i < faces.size(); ++i) {
          if (i % SLICE == 0) {
            throwIfCanceled(&cancellation.flag());
          }
          known.area += faceArea(*mesh, faces[i]);
        }
      }
      return areas;
    });
  }
  return changed;
}

std::optional<double> LabelAreas::area(const std::string& label) const
{
  const auto known = known_.find(label);
  return known == known_.end() ? std::nullopt : std::make_optional(known->second.area);
}

LabelListModel::LabelListModel(LabelSession* session, QObject* parent)
    : QAbstractTableModel(parent), session_(session)
{
}

bool LabelListModel::refresh()
{
  bool changed = refreshLooks();
  changed = areas_.follow(session_->mesh(), session_->labels()) || changed;
  const bool revised = revision_ != session_->revision();
  revision_ = session_->revision();
  changed = changed || revised;
  const bool other_rows = revised && refreshRows();
  if (changed && !other_rows && rowCount() > 0) {
    Q_EMIT dataChanged(index(0, 0), index(rowCount() - 1, COLUMNS - 1));
  }
  return other_rows;
}

bool LabelListModel::refreshRows()
{
  std::vector<std::string> labels = session_->names();
  std::sort(labels.begin(), labels.end(), LabelLess());
  if (labels == labels_) {
    return false;
  }
  beginResetModel();
  labels_ = std::move(labels);
  endResetModel();
  return true;
}

/// True where something looks other than before.
bool LabelListModel::refreshLooks()
{
  const LabelLooks now = session_->display() ? session_->display()->looks() : LabelLooks();
  const bool changed = !(now == looks_);
  looks_ = now;
  return changed;
}

int LabelListModel::rowCount(const QModelIndex& parent) const
{
  return parent.isValid() ? 0 : static_cast<int>(labels_.size());
}

int LabelListModel::columnCount(const QModelIndex& parent) const
{
  return parent.isValid() ? 0 : COLUMNS;
}

QVariant LabelListModel::text(const std::string& label, int column) const
{
  switch (column) {
    case CLASS:
      return QString::fromStdString(labelClass(label));
    case INSTANCE:
      return QString::fromStdString(labelInstance(label));
    case FACES:
      return groupedNumber(session_->faceCount(label));
    case AREA: {
      const auto area = areas_.area(label);
      return area ? groupedNumber(*area, 2) : QString();
    }
    case STATE:
      return QString(session_->isUnstored(label) ? "…" : session_->isUnsaved(label) ? "*" : "");
    default:
      return {};
  }
}

QVariant LabelListModel::data(const QModelIndex& index, int role) const
{
  if (!index.isValid() || index.row() >= rowCount()) {
    return {};
  }
  try {
    const std::string& label = labels_[static_cast<std::size_t>(index.row())];
    const int column = index.column();
    if (role == Qt::DisplayRole) {
      return text(label, column);
    }
    if (role == Qt::TextAlignmentRole && (column == FACES || column == AREA)) {
      return static_cast<int>(Qt::AlignRight | Qt::AlignVCenter);
    }
    if (role == Qt::ToolTipRole && column == STATE) {
      return QString(session_->isUnstored(label)  ? "is not stored yet"
                     : session_->isUnsaved(label) ? "is stored, but not saved in the map"
                                                  : "");
    }
    const auto look = looks_.find(label);
    const bool known = look != looks_.end();
    if (role == Qt::CheckStateRole && column == CLASS) {
      return !known || look->second.visible ? Qt::Checked : Qt::Unchecked;
    }
    if (role == Qt::DecorationRole && column == CLASS) {
      return known ? toQColor(look->second.color) : QColor(Qt::transparent);  // takes as much room
    }
  } catch (const std::exception& error) {
    ROS_ERROR_THROTTLE(10, "the list of labels cannot be shown: %s", error.what());
  }
  return {};
}

bool LabelListModel::setData(const QModelIndex& index, const QVariant& value, int role)
{
  if (!index.isValid() || index.row() >= rowCount() || role != Qt::CheckStateRole) {
    return false;
  }
  try {
    if (ClusterLabelDisplay* display = session_->display()) {
      display->setShown(labels_[static_cast<std::size_t>(index.row())],
                        value.toInt() == Qt::Checked);
    }
    refreshLooks();
  } catch (const std::exception& error) {
    ROS_ERROR("the label cannot be shown or hidden: %s", error.what());
    return false;
  }
  Q_EMIT dataChanged(this->index(0, CLASS), this->index(rowCount() - 1, CLASS));
  return true;
}

QVariant LabelListModel::headerData(int section, Qt::Orientation orientation, int role) const
{
  if (orientation != Qt::Horizontal || section >= COLUMNS) {
    return {};
  }
  static const char* const NAMES[] = {"Class", "Instance", "Faces", "Area [m²]", ""};
  static const char* const TIPS[] = {"Checked: drawn", "", "", "Of its faces",
                                     "…: not stored yet, *: not saved in the map"};
  if (role == Qt::DisplayRole) {
    return QString(NAMES[section]);
  }
  return role == Qt::ToolTipRole ? QVariant(QString(TIPS[section])) : QVariant();
}

Qt::ItemFlags LabelListModel::flags(const QModelIndex& index) const
{
  const Qt::ItemFlags flags = QAbstractTableModel::flags(index);
  return index.column() == CLASS ? flags | Qt::ItemIsUserCheckable : flags;
}

}  // namespace rviz_mesh_plugin
