#include "rviz_mesh_plugin/cluster_label_panel.h"

#include <algorithm>
#include <exception>

#include <ros/console.h>
#include <rviz/tool_manager.h>
#include <rviz/visualization_manager.h>
#include <rviz/window_manager_interface.h>
#include <QHeaderView>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTableView>
#include <QTimer>

namespace rviz_mesh_plugin {
namespace {

constexpr int PERIOD = 50;  // milliseconds
const char* const TOOL = "rviz_mesh_plugin/ClusterLabel";
const char* const NAME_KEY = "ClusterName";  // as released

}  // namespace

ClusterLabelPanel::ClusterLabelPanel(QWidget* parent)
    : rviz::Panel(parent),
      name_(new QLineEdit(this)),
      list_(new QTableView(this)),
      status_(new QLabel(this)),
      timer_(new QTimer(this))
{
  createWidgets();
  createList();
  connect(timer_, &QTimer::timeout, this, &ClusterLabelPanel::work);
}

ClusterLabelPanel::~ClusterLabelPanel()
{
  try {
    commands_.reset();
    askWhenGone();
  } catch (const std::exception& error) {
    ROS_ERROR("panel of labels: %s", error.what());
  }
}

void ClusterLabelPanel::onInitialize()
{
  try {
    session_ = std::make_unique<LabelSession>(vis_manager_);
    commands_ = std::make_unique<LabelCommands>(session_.get(), this);
    model_ = new LabelListModel(session_.get(), this);
    list_->setModel(model_);
    list_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
    list_->horizontalHeader()->setSectionResizeMode(LabelListModel::INSTANCE, QHeaderView::Stretch);
    connect(model_, &QAbstractItemModel::dataChanged, list_, [this] {
      list_->resizeColumnToContents(LabelListModel::FACES);
      list_->resizeColumnToContents(LabelListModel::AREA);
    });
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
      connect(tool, &ClusterLabelTool::selectionChanged, this, [this] { showSituation(); });
      connect(tool, &ClusterLabelTool::labelRequested, this, [this] { press(LabelAction::NEW); });
    }
  }
}

void ClusterLabelPanel::press(LabelAction action)
{
  if (commands_) {
    commands_->run(action, name_->text().trimmed().toStdString(), chosen());
    work();
  }
}

void ClusterLabelPanel::work()
{
  std::string failure;
  try {
    followTool();
    followWindow();
    session_->work(commands_->tool() ? commands_->tool()->mesh() : nullptr);
    commands_->work();
    followList();
    continueClosing();
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
    tools->addTool(TOOL);
    find();
  }
}

void ClusterLabelPanel::followWindow()
{
  rviz::WindowManagerInterface* windows = vis_manager_->getWindowManager();
  QWidget* main = windows ? windows->getParentWindow() : window();
  if (main && main != window_) {
    window_ = main;
    window_->installEventFilter(this);
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

void ClusterLabelPanel::showSituation()
{
  if (!commands_) {
    return;
  }
  LabelSituation now = commands_->situation();
  now.name = name_->text().trimmed().toStdString();
  now.labels = model_->labels().size();
  now.chosen = static_cast<std::size_t>(list_->selectionModel()->selectedRows().size());
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
  if (!commands_->news().empty()) {
    text += "<br>" + QString::fromStdString(commands_->news()).toHtmlEscaped() + ".";
  }
  if (status_->text() != text) {
    status_->setText(text);
  }
}

}  // namespace rviz_mesh_plugin
