#include "panel/cluster_label_panel.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <ros/console.h>
#include <rviz/tool_manager.h>
#include <rviz/visualization_manager.h>
#include <rviz/window_manager_interface.h>
#include <QGridLayout>
#include <QGuiApplication>
#include <QHeaderView>
#include <QKeySequence>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QScreen>
#include <QShortcut>
#include <QString>
#include <QStyle>
#include <QTimer>

#include "panel/label_closing.h"
#include "panel/label_list_view.h"
#include "panel/zoom_button.h"
#include "picking/surface_picker.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int PERIOD = 50;  // milliseconds
const char* const TOOL_CLASS = "rviz_mesh_plugin/ClusterLabel";
const char* const NAME_KEY = "ClusterName";  // as released

}  // namespace

ClusterLabelPanel::ClusterLabelPanel(QWidget* parent)
    : rviz::Panel(parent),
      name_(new QLineEdit(this)),
      list_(new LabelListView(this)),
      status_(new QLabel(this)),
      timer_(new QTimer(this))
{
  createWidgets();
  createList();
  // As in the 3D view, where the tool has these keys.
  const auto onKey = [this](const QKeySequence& key, void (LabelCommands::*act)()) {
    auto* shortcut = new QShortcut(key, this, nullptr, nullptr, Qt::WidgetWithChildrenShortcut);
    connect(shortcut, &QShortcut::activated, this, [this, act] {
      if (commands_) {
        ((*commands_).*act)();
        work();
      }
    });
  };
  onKey(QKeySequence("Ctrl+Z"), &LabelCommands::undo);
  onKey(QKeySequence("Ctrl+Shift+Z"), &LabelCommands::redo);
  onKey(QKeySequence("Ctrl+Y"), &LabelCommands::redo);
  connect(timer_, &QTimer::timeout, this, &ClusterLabelPanel::work);
}

void ClusterLabelPanel::createWidgets()
{
  auto* grid = new QGridLayout(this);
  name_->setToolTip("Class and instance of the label, as tree_1.");
  connect(name_, &QLineEdit::textEdited, this, [this] { showSituation(); });
  connect(name_, &QLineEdit::editingFinished, this, &ClusterLabelPanel::configChanged);
  status_->setWordWrap(true);
  status_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  grid->addWidget(new QLabel("Cluster Name:", this), 0, 0, 1, 2);
  grid->addWidget(name_, 0, 2, 1, 2);
  zoom_ = new ZoomButton([this] { return zoomTarget(); }, [this] { return vis_manager_; });
  grid->addWidget(zoom_, 0, 4, 1, 2);
  grid->addWidget(list_, 3, 0, 1, 6);
  grid->setRowStretch(3, 1);
  // Below it buttons would move, whenever it says more or less, and be missed.
  grid->addWidget(status_, 4, 0, 1, 6);
  using Action = LabelAction;
  const auto add = [&](Action action, int row, int column, int width) {
    auto* button = new QPushButton(textOf(action), this);
    connect(button, &QPushButton::clicked, this, [this, action] { press(action); });
    grid->addWidget(button, row, column, 1, width);
    buttons_[action] = button;
  };
  add(Action::LABEL_CLUSTER, 1, 0, 2);
  add(Action::RESET_FACES, 1, 2, 2);
  add(Action::SELECT_BY, 1, 4, 2);
  add(Action::HIDE, 2, 0, 2);
  add(Action::ISOLATE, 2, 2, 2);
  add(Action::SHOW_ALL, 2, 4, 2);
  const Action rows[5][3] = {{Action::NEW, Action::ASSIGN, Action::ADD},
                             {Action::TAKE_AWAY, Action::SELECT, Action::RENAME},
                             {Action::MERGE, Action::DELETE, Action::COLOR},
                             {Action::CLASS_COLOR, Action::IMPORT, Action::EXPORT},
                             {Action::SAVE, Action::SEND_AGAIN, Action::GIVE_UP}};
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 3; ++column) {
      add(rows[row][column], 5 + row, 2 * column, 2);
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

int ClusterLabelPanel::leastRows(int screen_height)
{
  constexpr int ROWS = 10, FEWER_ROWS = 4, ENOUGH = 900;
  return screen_height < ENOUGH ? FEWER_ROWS : ROWS;
}

ClusterLabelPanel::~ClusterLabelPanel()
{
  try {
    commands_.reset();
    if (closing_) {
      LabelClosing::goOnWithoutPanel(std::move(closing_));
    }
  } catch (const std::exception& error) {
    ROS_ERROR("panel of labels: %s", error.what());
  }
}

void ClusterLabelPanel::onInitialize()
{
  try {
    session_ = std::make_shared<LabelSession>(vis_manager_);
    commands_ = std::make_unique<LabelCommands>(session_.get(), this);
    closing_ = std::make_unique<LabelClosing>(
        session_, this, [this](const std::string& problem) { commands_->say(problem); });
    model_ = new LabelListModel(session_.get(), this);
    list_->setModel(model_);
    // Nothing is cut off: where there is no room for all columns, the list scrolls.
    list_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
    list_->horizontalHeader()->setStretchLastSection(true);
    const QScreen* screen = QGuiApplication::primaryScreen();
    const int rows = leastRows(screen ? screen->availableSize().height() : 0);
    list_->setMinimumHeight(list_->horizontalHeader()->sizeHint().height() +
                            rows * list_->verticalHeader()->defaultSectionSize() +
                            list_->style()->pixelMetric(QStyle::PM_ScrollBarExtent) +
                            2 * list_->frameWidth());
    connect(list_->selectionModel(), &QItemSelectionModel::selectionChanged, this,
            [this] { showSituation(); });
    timer_->start(PERIOD);
    showSituation();
  } catch (const std::exception& error) {
    ROS_ERROR("the panel of labels cannot work: %s", error.what());
  }
}

void ClusterLabelPanel::load(const rviz::Config& config)
{
  rviz::Panel::load(config);
  QString name;
  if (config.mapGetString(NAME_KEY, &name)) {
    name_->setText(name);
  }
}

void ClusterLabelPanel::save(rviz::Config config) const
{
  rviz::Panel::save(config);
  config.mapSetValue(NAME_KEY, name_->text());
}

void ClusterLabelPanel::setTool(ClusterLabelTool* tool)
{
  if (commands_ && tool != commands_->tool()) {
    if (commands_->tool()) {
      commands_->tool()->disconnect(this);
    }
    commands_->setTool(tool);
    if (tool) {
      tool_asked_for_ = true;  // who removes it does not want it
      tool->addHistory(session_);
      connect(tool, &ClusterLabelTool::selectionChanged, this, [this] { showSituation(); });
      connect(tool, &ClusterLabelTool::labelRequested, this, [this] { press(LabelAction::NEW); });
    }
  }
}

void ClusterLabelPanel::press(LabelAction action)
{
  if (commands_) {
    commands_->run(action, situation(), chosen());
    work();
  }
}

void ClusterLabelPanel::work()
{
  std::string failure;
  try {
    followTool();
    rviz::WindowManagerInterface* windows = vis_manager_->getWindowManager();
    closing_->watch(windows ? windows->getParentWindow() : window());
    session_->work(commands_->tool() ? commands_->tool()->mesh() : nullptr);
    commands_->work();
    followList();
    closing_->work();
  } catch (const std::exception& error) {
    failure = std::string("this went wrong: ") + error.what();
    ROS_ERROR_THROTTLE(10, "panel of labels: %s", failure.c_str());
  }
  failure_ = failure;
  showSituation();
}

void ClusterLabelPanel::followTool()
{
  rviz::ToolManager* tools = vis_manager_->getToolManager();
  if (commands_->tool() || !tools) {
    return;
  }
  const auto find = [&] {
    for (int i = 0; i < tools->numTools(); ++i) {
      if (auto* tool = dynamic_cast<ClusterLabelTool*>(tools->getTool(i))) {
        setTool(tool);
      }
    }
  };
  find();
  if (!commands_->tool() && !tool_asked_for_) {
    tool_asked_for_ = true;
    tools->addTool(TOOL_CLASS);
    find();
  }
}

/// What is chosen stays so, by name.
void ClusterLabelPanel::followList()
{
  const std::vector<std::string> before = chosen();
  const std::size_t rows = model_->labels().size();
  if (model_->refresh()) {
    const std::vector<std::string>& labels = model_->labels();
    QItemSelection selection;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (std::find(before.begin(), before.end(), labels[i]) != before.end()) {
        const QModelIndex index = model_->index(static_cast<int>(i), 0);
        selection.select(index, index);
      }
    }
    list_->selectionModel()->select(selection,
                                    QItemSelectionModel::Select | QItemSelectionModel::Rows);
    if (rows == 0) {
      list_->scrollToTop();
    }
  }
}

/// Whose labels are edited, or the first that is shown.
MeshDataConstPtr ClusterLabelPanel::meshToZoomTo() const
{
  const ClusterLabelTool* const tool = commands_ ? commands_->tool() : nullptr;
  MeshDataConstPtr mesh = session_ ? session_->mesh() : nullptr;
  if (!mesh && tool) {
    mesh = tool->mesh();
  }
  if (!mesh && vis_manager_) {
    const auto shown = SurfacePicker(vis_manager_).meshes();
    mesh = shown.empty() ? nullptr : shown.front().mesh;
  }
  return mesh;
}

ZoomTarget ClusterLabelPanel::zoomTarget() const
{
  ZoomTarget target;
  target.mesh = meshToZoomTo();
  const ClusterLabelTool* const tool = commands_ ? commands_->tool() : nullptr;
  if (session_) {
    for (const std::string& name : chosen()) {
      const auto found = session_->labels().find(name);
      if (found != session_->labels().end()) {
        target.labels.push_back(found->second);
      }
    }
  }
  if (tool && target.mesh && tool->mesh() == target.mesh) {
    target.faces = tool->selection().bits();
  }
  return target;
}

std::vector<std::string> ClusterLabelPanel::chosen() const
{
  std::vector<std::string> chosen;
  if (model_) {
    for (const QModelIndex& index : list_->selectionModel()->selectedRows()) {
      chosen.push_back(model_->labels().at(static_cast<std::size_t>(index.row())));
    }
  }
  return chosen;
}

LabelSituation ClusterLabelPanel::situation() const
{
  LabelSituation now = commands_->situation();
  now.name = name_->text().trimmed().toStdString();
  now.labels = model_->labels().size();
  now.chosen = static_cast<std::size_t>(list_->selectionModel()->selectedRows().size());
  return now;
}

void ClusterLabelPanel::showSituation()
{
  if (!commands_) {
    return;
  }
  zoom_->allow(meshToZoomTo() != nullptr);
  const LabelSituation now = situation();
  for (const auto& button : buttons_) {
    const std::string reason = whyNot(button.first, now);
    QString tip = tipOf(button.first);
    if (!reason.empty()) {
      tip += "\nNot now: " + QString::fromStdString(reason) + ".";
    }
    if (button.second->toolTip() != tip) {
      button.second->setEnabled(reason.empty());
      button.second->setToolTip(tip);
    }
  }
  QString text = QString::fromStdString(describe(now));
  for (const std::string& problem : {failure_, session_->failure(), commands_->message()}) {
    if (!problem.empty()) {
      text += "<br><font color=\"#c00000\">" + QString::fromStdString(problem).toHtmlEscaped() +
              "</font>";
    }
  }
  if (!commands_->report().empty()) {
    text += "<br>" + QString::fromStdString(commands_->report()).toHtmlEscaped() + ".";
  }
  if (status_->text() != text) {
    status_->setText(text);
  }
}

}  // namespace rviz_mesh_plugin
