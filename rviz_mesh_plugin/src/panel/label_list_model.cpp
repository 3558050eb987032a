#include "panel/label_list_model.h"

#include <algorithm>
#include <exception>

#include <ros/console.h>
#include <QLocale>

#include "labels/label_name.h"
#include "labels/label_order.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::milliseconds BUDGET(5);

rviz::Property* childOf(const rviz::Property& parent, const char* name)
{
  for (int i = 0; i < parent.numChildren(); ++i) {
    if (parent.childAt(i)->getName() == name) {
      return parent.childAt(i);
    }
  }
  return nullptr;
}

/// The colors, and the labels that can be hidden.
std::size_t countProperties(const rviz::Property* display)
{
  const rviz::Property* colors = display ? childOf(*display, "Colors") : nullptr;
  const rviz::Property* classes = display ? childOf(*display, "Visible Labels") : nullptr;
  int count = colors ? colors->numChildren() : 0;
  for (int i = 0; classes && i < classes->numChildren(); ++i) {
    count += classes->childAt(i)->numChildren();
  }
  return static_cast<std::size_t>(count);
}

}  // namespace

/// The display makes and deletes properties a while after its labels have changed.
bool LabelLooks::refresh(rviz::Display* display)
{
  if (display != display_ || !isRead()) {
    display_ = display;
    read();
  }
  std::vector<std::pair<QColor, bool>> seen;
  seen.reserve(looks_.size());
  for (const auto& look : looks_) {
    const bool known = look.second.isComplete();
    seen.emplace_back(known ? look.second.color->getColor() : QColor(),
                      known && look.second.isShown());
  }
  seen.swap(seen_);
  return seen != seen_;
}

bool LabelLooks::isRead() const
{
  return countProperties(display_) == properties_ &&
         std::all_of(looks_.begin(), looks_.end(),
                     [](const auto& look) { return look.second.isComplete(); });
}

void LabelLooks::read()
{
  looks_.clear();
  properties_ = countProperties(display_);
  const rviz::Property* colors = display_ ? childOf(*display_, "Colors") : nullptr;
  const rviz::Property* classes = display_ ? childOf(*display_, "Visible Labels") : nullptr;
  for (int i = 0; colors && i < colors->numChildren(); ++i) {
    rviz::Property* color = colors->childAt(i);
    looks_[color->getNameStd()].color = dynamic_cast<rviz::ColorProperty*>(color);
  }
  for (int i = 0; classes && i < classes->numChildren(); ++i) {
    rviz::Property* label_class = classes->childAt(i);
    for (int j = 0; j < label_class->numChildren(); ++j) {
      Look& look = looks_[label_class->childAt(j)->getNameStd()];
      look.shown = dynamic_cast<rviz::BoolProperty*>(label_class->childAt(j));
      look.class_shown = dynamic_cast<rviz::BoolProperty*>(label_class);
    }
  }
}

const LabelLooks::Look* LabelLooks::find(const std::string& label) const
{
  const auto look = looks_.find(label);
  return look != looks_.end() && look->second.isComplete() ? &look->second : nullptr;
}

QColor LabelLooks::color(const std::string& label) const
{
  const Look* look = find(label);
  return look ? look->color->getColor() : QColor();
}

bool LabelLooks::isShown(const std::string& label) const
{
  const Look* look = find(label);
  return !look || look->isShown();
}

void LabelLooks::setShown(const std::string& label, bool shown)
{
  if (const Look* look = find(label)) {
    const QPointer<rviz::BoolProperty> label_class = look->class_shown;
    look->shown->setBool(shown);
    if (shown && label_class) {
      label_class->setBool(true);
    }
  }
}

LabelListModel::LabelListModel(LabelSession* session, QObject* parent)
    : QAbstractTableModel(parent), session_(session)
{
}

bool LabelListModel::refresh()
{
  bool changed = looks_.refresh(session_->display());
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
    if (role == Qt::CheckStateRole && column == CLASS) {
      return looks_.isShown(label) ? Qt::Checked : Qt::Unchecked;
    }
    if (role == Qt::DecorationRole && column == CLASS) {
      const QColor color = looks_.color(label);
      return color.isValid() ? color : QColor(Qt::transparent);  // takes as much room
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
    looks_.setShown(labels_[static_cast<std::size_t>(index.row())], value.toInt() == Qt::Checked);
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
