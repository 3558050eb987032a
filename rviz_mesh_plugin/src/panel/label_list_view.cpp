#include "panel/label_list_view.h"

#include <QMouseEvent>
#include <QStyle>
#include <QStyleOptionViewItem>

namespace rviz_mesh_plugin {

void LabelListView::mouseDoubleClickEvent(QMouseEvent* event)
{
  if (isOnBox(event->pos())) {
    mousePressEvent(event);
  } else {
    QTableView::mouseDoubleClickEvent(event);
  }
}

bool LabelListView::isOnBox(const QPoint& place) const
{
  const QModelIndex index = indexAt(place);
  if (!index.data(Qt::CheckStateRole).isValid()) {
    return false;
  }
  QStyleOptionViewItem option = viewOptions();
  option.rect = visualRect(index);
  option.features |= QStyleOptionViewItem::HasCheckIndicator;
  return style()
      ->subElementRect(QStyle::SE_ItemViewItemCheckIndicator, &option, this)
      .contains(place);
}

}  // namespace rviz_mesh_plugin
