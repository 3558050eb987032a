// A part of the panel: what it looks like.
#include <QGridLayout>
#include <QHeaderView>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTableView>

#include "rviz_mesh_plugin/cluster_label_panel.h"

namespace rviz_mesh_plugin {

void ClusterLabelPanel::createWidgets()
{
  auto* grid = new QGridLayout(this);
  name_->setToolTip("Class and instance of the label, as tree_1.");
  connect(name_, &QLineEdit::textEdited, this, [this] { showSituation(); });
  connect(name_, &QLineEdit::editingFinished, this, &ClusterLabelPanel::configChanged);
  status_->setWordWrap(true);
  status_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  grid->addWidget(new QLabel("Cluster Name:", this), 0, 0, 1, 2);
  grid->addWidget(name_, 0, 2, 1, 4);
  grid->addWidget(list_, 2, 0, 1, 6);
  grid->addWidget(status_, 8, 0, 1, 6);
  using Action = LabelAction;
  const auto add = [&](Action action, int row, int column, int width) {
    auto* button = new QPushButton(textOf(action), this);
    connect(button, &QPushButton::clicked, this, [this, action] { press(action); });
    grid->addWidget(button, row, column, 1, width);
    buttons_[action] = button;
  };
  add(Action::LABEL_CLUSTER, 1, 0, 3);
  add(Action::RESET_FACES, 1, 3, 3);
  const Action rows[5][3] = {{Action::NEW, Action::ASSIGN, Action::ADD},
                             {Action::TAKE_AWAY, Action::SELECT, Action::RENAME},
                             {Action::MERGE, Action::DELETE, Action::COLOR},
                             {Action::CLASS_COLOR, Action::IMPORT, Action::EXPORT},
                             {Action::SAVE, Action::SEND_AGAIN, Action::GIVE_UP}};
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 3; ++column) {
      add(rows[row][column], 3 + row, 2 * column, 2);
    }
  }
}

void ClusterLabelPanel::createList()
{
  list_->setSelectionBehavior(QAbstractItemView::SelectRows);
  list_->setSelectionMode(QAbstractItemView::ExtendedSelection);
  list_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  list_->setShowGrid(false);
  list_->setWordWrap(false);
  list_->verticalHeader()->hide();
  list_->verticalHeader()->setDefaultSectionSize(list_->fontMetrics().height() + 6);
  list_->horizontalHeader()->setHighlightSections(false);
  list_->horizontalHeader()->setMinimumSectionSize(20);
  connect(list_, &QTableView::doubleClicked, this, [this] { press(LabelAction::SELECT); });
}

}  // namespace rviz_mesh_plugin
