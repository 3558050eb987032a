#include "panel/label_list_model.h"

#include <algorithm>
#include <exception>
#include <iterator>

#include <ros/console.h>
#include <QColor>
#include <QLocale>

#include "base/qt_colors.h"
#include "labels/label_name.h"
#include "selection/selection_regions.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::milliseconds BUDGET(5);
constexpr std::size_t SLICE = 4096;  // faces between two looks at the clock

}  // namespace

bool LabelAreas::work(const MeshDataConstPtr& mesh, const LabelClusters& labels,
                      std::chrono::microseconds budget)
{
  if (mesh != mesh_) {
    sums_.clear();
    mesh_ = mesh;
  }
  for (auto sum = sums_.begin(); sum != sums_.end();) {
    sum = labels.count(sum->first) == 0 ? sums_.erase(sum) : std::next(sum);
  }
  const auto end = std::chrono::steady_clock::now() + budget;
  for (const auto& label : labels) {
    Sum& sum = sums_[label.first];
    if (sum.label != label.second) {
      sum = Sum{label.second};
    }
    const auto& faces = sum.label->faces;
    while (sum.next < faces.size()) {
      if (!mesh || std::chrono::steady_clock::now() >= end) {
        return false;
      }
      for (const std::size_t last = std::min(sum.next + SLICE, faces.size()); sum.next < last;) {
        sum.area += faceArea(*mesh, faces[sum.next++]);
      }
    }
  }
  return true;
}

std::optional<double> LabelAreas::area(const std::string& label) const
{
  const auto sum = sums_.find(label);
  if (sum == sums_.end() || sum->second.next < sum->second.label->faces.size()) {
    return std::nullopt;
  }
  return sum->second.area;
}

LabelListModel::LabelListModel(LabelSession* session, QObject* parent)
    : QAbstractTableModel(parent), session_(session)
{
}

bool LabelListModel::refresh()
{
  bool changed = refreshLooks();
  if (!areas_known_ || revision_ != session_->revision()) {
    areas_known_ = areas_.work(session_->mesh(), session_->labels(), BUDGET);
    changed = true;
  }
  const bool revised = revision_ != session_->revision();
  revision_ = session_->revision();
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
      return QLocale().toString(static_cast<qulonglong>(session_->faceCount(label)));
    case AREA: {
      const auto area = areas_.area(label);
      return area ? QLocale().toString(*area, 'f', 2) : QString();
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
