#include "panel/mesh_navigation_panel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <utility>

#include <ros/console.h>
#include <ros/names.h>
#include <QAbstractItemView>
#include <QComboBox>
#include <QEvent>
#include <QFont>
#include <QFormLayout>
#include <QFrame>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QScrollArea>
#include <QSignalBlocker>
#include <QStringList>
#include <QTimer>
#include <QVBoxLayout>

#include "base/status_lines.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int LOOK_PERIOD = 100;  // milliseconds
const char* const SERVER_KEY = "Server";
const char* const PLANNER_KEY = "Planner";
const char* const CONTROLLER_KEY = "Controller";
const char* const GOOD = "#207020";
const char* const BAD = "#b00000";
const char* const BUSY = "#1050b0";
const char* const UNSURE = "#906000";
/// What was canceled where nothing was known to be busy is told for as long.
constexpr std::chrono::seconds READ_PERIOD(5);
constexpr std::size_t MOST_TEXT = 1000;  // characters; the rest is in the tool tip

void setText(QLabel* label, const QString& text)
{
  if (label->text() != text) {
    label->setText(text);
    label->setVisible(!text.isEmpty());
  }
}

QString escaped(const std::string& text)
{
  return QString::fromStdString(shortened(text, MOST_TEXT)).toHtmlEscaped();
}

QString colored(const char* color, const QString& html)
{
  return QString("<font color=\"%1\">%2</font>").arg(color, html);
}

const char* colorOf(ServerPhase phase)
{
  switch (phase) {
    case ServerPhase::NO_SERVER:
    case ServerPhase::NOT_ANSWERING:
      return BAD;
    case ServerPhase::READY:
      return GOOD;
    case ServerPhase::PLANNING:
    case ServerPhase::DRIVING:
      return BUSY;
    default:
      return UNSURE;
  }
}

/// At the beginning of a sentence.
QString capitalized(const std::string& text)
{
  QString shown = QString::fromStdString(text);
  return shown.isEmpty() ? shown : shown.replace(0, 1, shown[0].toUpper());
}

std::string describeTarget(const NavigationGoal& goal)
{
  if (!goal.target) {
    return "sent before this panel looked";
  }
  const auto& p = goal.target->pose.position;
  char text[128];
  std::snprintf(text, sizeof(text), "(%.2f, %.2f, %.2f) m in ", p.x, p.y, p.z);
  return text + quotedName(goal.target->header.frame_id);
}

/// What it asks for; empty where it asks for nothing.
std::string describePlugins(const NavigationGoal& goal)
{
  std::string text;
  for (const auto& [kind, name] :
       {std::make_pair("planner", goal.planner), std::make_pair("controller", goal.controller)}) {
    if (!name.empty()) {
      text += joined(", ", kind, " ", quotedName(name));
    }
  }
  return text;
}

QString describeTime(double seconds)
{
  if (seconds < 90.0) {
    return QString("about %1 s").arg(std::lround(seconds));
  }
  const long minutes = std::lround(seconds / 60.0);
  return minutes < 90 ? QString("about %1 min").arg(minutes)
                      : QString("about %1 h").arg(seconds / 3600.0, 0, 'f', 1);
}

/// Of names that the server tells, without taking away what is being typed.
void setNames(QComboBox* box, const QStringList& names)
{
  QStringList shown;
  for (int i = 0; i < box->count(); ++i) {
    shown.append(box->itemText(i));
  }
  if (shown != names && !box->view()->isVisible()) {
    const QString text = box->lineEdit()->text();
    const int cursor = box->lineEdit()->cursorPosition();
    const bool modified = box->lineEdit()->isModified();
    const QSignalBlocker quiet(box);
    box->clear();
    box->addItems(names);
    box->setEditText(text);
    box->lineEdit()->setCursorPosition(cursor);
    box->lineEdit()->setModified(modified);
  }
}

QStringList listOf(const std::vector<std::string>& names)
{
  QStringList list;
  for (const std::string& name : names) {
    list.append(QString::fromStdString(name));
  }
  return list;
}

}  // namespace

MeshNavigationPanel::MeshNavigationPanel(QWidget* parent)
    : rviz::Panel(parent), timer_(new QTimer(this))
{
  createWidgets();
  connect(timer_, &QTimer::timeout, this, &MeshNavigationPanel::work);
}

MeshNavigationPanel::~MeshNavigationPanel() = default;

QComboBox* MeshNavigationPanel::createChoice(const char* tip)
{
  auto* box = new QComboBox(this);
  box->setEditable(true);
  box->setInsertPolicy(QComboBox::NoInsert);
  box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box->setMinimumContentsLength(12);
  box->setToolTip(tip);
  box->setFocusPolicy(Qt::StrongFocus);
  box->installEventFilter(this);
  return box;
}

/// The wheel scrolls past a choice, and does not change which robot is meant.
bool MeshNavigationPanel::eventFilter(QObject* watched, QEvent* event)
{
  if (event->type() == QEvent::Wheel) {
    event->ignore();
    return true;
  }
  return rviz::Panel::eventFilter(watched, event);
}

void MeshNavigationPanel::createWidgets()
{
  servers_ = createChoice(
      "Node of the navigation server, as move_base_flex. Empty: the usual one, or the only one "
      "there is.");
  planner_ = createChoice(
      "Planner of goals that are clicked. Empty, and Enter pressed: the server's first.");
  controller_ = createChoice(
      "Controller of goals that are clicked. Empty, and Enter pressed: the server's first.");
  for (auto* box : {planner_, controller_}) {
    box->lineEdit()->setPlaceholderText("the server's first");
    const auto connectTo = [&](auto signal, auto* sender, bool anyway) {
      connect(sender, signal, this,
              [this, anyway] { guarded([this, anyway] { choose(anyway); }); });
    };
    connectTo(QOverload<int>::of(&QComboBox::activated), box, true);
    connectTo(&QLineEdit::returnPressed, box->lineEdit(), true);
    connectTo(&QLineEdit::editingFinished, box->lineEdit(), false);
  }
  connect(servers_, QOverload<int>::of(&QComboBox::activated), this, [this] {
    work();
    Q_EMIT configChanged();
  });
  connect(servers_->lineEdit(), &QLineEdit::editingFinished, this, [this] {
    servers_->lineEdit()->setModified(false);  // it is no longer being typed
    work();
    Q_EMIT configChanged();
  });

  const auto label = [this](const char* name) {
    auto* made = new QLabel(this);
    made->setObjectName(name);
    made->setWordWrap(true);
    made->setTextFormat(Qt::RichText);
    made->setTextInteractionFlags(Qt::TextSelectableByMouse);
    made->setVisible(false);
    return made;
  };
  phase_ = label("phase");
  reason_ = label("reason");
  choice_ = label("choice");
  goal_ = label("goal");
  remaining_ = label("remaining");
  outcome_ = label("outcome");
  before_ = label("before");
  report_ = label("report");
  QFont large = font();
  large.setBold(true);
  large.setPointSizeF(1.3 * large.pointSizeF());
  phase_->setFont(large);

  auto* form = new QFormLayout;
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  form->addRow("Server:", servers_);
  form->addRow("Planner:", planner_);
  form->addRow("Controller:", controller_);
  cancel_ = new QPushButton("Cancel", this);
  clear_ = new QPushButton("Clear Layers", this);
  connect(cancel_, &QPushButton::clicked, this, [this] { guarded([this] { cancel(); }); });
  connect(clear_, &QPushButton::clicked, this, [this] {
    guarded([this] {
      if (server_) {
        server_->clear(directory_.clearServices());
      }
    });
  });
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(cancel_);
  buttons->addWidget(clear_);

  // What servers say may be long: it scrolls, and neither buttons nor window give way to it.
  auto* told = new QWidget(this);
  auto* lines = new QVBoxLayout(told);
  lines->setContentsMargins(0, 0, 0, 0);
  for (auto* line : {phase_, reason_, remaining_, goal_, outcome_, before_, report_}) {
    lines->addWidget(line);
  }
  lines->addStretch(1);
  auto* scroll = new QScrollArea(this);
  scroll->setWidget(told);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  constexpr int LEAST_LINES = 8;
  scroll->setMinimumHeight(LEAST_LINES * fontMetrics().lineSpacing());

  auto* all = new QVBoxLayout(this);
  all->addLayout(form);
  all->addWidget(choice_);
  all->addWidget(scroll, 1);
  all->addLayout(buttons);
}

void MeshNavigationPanel::onInitialize()
{
  timer_->start(LOOK_PERIOD);
  work();
}

void MeshNavigationPanel::load(const rviz::Config& config)
{
  rviz::Panel::load(config);
  const auto read = [&](const char* key, QComboBox* box) {
    QString text;
    if (config.mapGetString(key, &text)) {
      box->setEditText(text);
    }
  };
  read(SERVER_KEY, servers_);
  read(PLANNER_KEY, planner_);
  read(CONTROLLER_KEY, controller_);
  server_.reset();
  work();
}

void MeshNavigationPanel::save(rviz::Config config) const
{
  rviz::Panel::save(config);
  config.mapSetValue(SERVER_KEY, servers_->currentText().trimmed());
  config.mapSetValue(PLANNER_KEY, planner_->currentText().trimmed());
  config.mapSetValue(CONTROLLER_KEY, controller_->currentText().trimmed());
}

/// Resolved; empty where what is typed is no name.
std::string MeshNavigationPanel::chosenServer() const
{
  std::string name = servers_->currentText().trimmed().toStdString();
  while (name.size() > 1 && name.back() == '/') {
    name.pop_back();
  }
  std::string error;
  if (name.empty()) {
    // It is never changed for another one that comes, or sorts before it: that is another robot.
    const bool stays = server_ && named_.empty() &&
                       (server_->watch().wasHeard() || directory_.lists(server_->watch().server()));
    return stays ? server_->watch().server() : directory_.usualServer();
  }
  return name != "/" && ros::names::validate(name, error) ? ros::names::resolve(name)
                                                          : std::string();
}

void MeshNavigationPanel::followServer()
{
  const std::string name = chosenServer();
  // What is being typed is none yet; a server that is there stays until another one is named.
  if (servers_->lineEdit()->hasFocus() && servers_->lineEdit()->isModified()) {
    return;
  }
  named_ = servers_->currentText().trimmed().toStdString();
  if (name.empty()) {
    server_.reset();
  } else if (!server_ || server_->watch().server() != name) {
    server_ = std::make_unique<NavigationServer>(name);
    report_of_act_ = {};
    told_.reset();
    if (choice() != Choice()) {  // nobody has chosen anything here: another RViz may have
      tellChoice();
    }
  }
}

MeshNavigationPanel::Choice MeshNavigationPanel::choice() const
{
  return {planner_->currentText().trimmed().toStdString(),
          controller_->currentText().trimmed().toStdString()};
}

void MeshNavigationPanel::tellChoice()
{
  told_ = choice();
  server_->connection().choose(told_->first, told_->second);
}

/// @param anyway whether the user has said so, and not only left the field
void MeshNavigationPanel::choose(bool anyway)
{
  if (anyway || choice() != told_.value_or(Choice())) {
    if (server_) {
      tellChoice();
    }
    Q_EMIT configChanged();
  }
}

void MeshNavigationPanel::cancel()
{
  if (server_) {
    report(server_->cancel());
  }
}

void MeshNavigationPanel::report(const std::string& text)
{
  const ServerWatch* watch = server_ ? &server_->watch() : nullptr;
  report_of_act_.text = text;
  report_of_act_.goal = watch && watch->goal() ? watch->goal()->id : std::string();
  report_of_act_.busy = watch && watch->isBusy();
  report_of_act_.since = std::chrono::steady_clock::now();
}

/// Until what was canceled has ended, or another goal has come.
std::string MeshNavigationPanel::reportOfAct(Time now)
{
  const ServerWatch& watch = server_->watch();
  const std::string goal = watch.goal() ? watch.goal()->id : std::string();
  const bool over =
      report_of_act_.busy ? !watch.isBusy() : now - report_of_act_.since > READ_PERIOD;
  if (over || goal != report_of_act_.goal) {
    report_of_act_ = {};
  }
  return report_of_act_.text;
}

/// What a user does: an exception that left it would end RViz.
void MeshNavigationPanel::guarded(const std::function<void()>& act)
{
  try {
    act();
  } catch (const std::exception& error) {
    ROS_ERROR("panel of navigation: %s", error.what());
    report(std::string("This went wrong: ") + error.what());
  }
  work();
}

void MeshNavigationPanel::work()
{
  std::string failure;
  const Time now = std::chrono::steady_clock::now();
  try {
    followServer();
    directory_.update(now, server_ ? server_->watch().server() : std::string());
    if (server_) {
      server_->work(directory_, now);
    }
  } catch (const std::exception& error) {
    failure = std::string("this went wrong: ") + error.what();
    ROS_ERROR_THROTTLE(10, "panel of navigation: %s", failure.c_str());
  }
  failure_ = failure;
  try {
    show(now);
  } catch (const std::exception& error) {
    ROS_ERROR_THROTTLE(10, "panel of navigation: it cannot be shown: %s", error.what());
  }
}

void MeshNavigationPanel::show(Time now)
{
  showServers();
  showChoice(now);
  showGoal(now);
  showButtons();
  if (!server_) {
    const std::string typed = servers_->currentText().trimmed().toStdString();
    setText(phase_, colored(BAD, "No server"));
    setText(report_, QString());
    setText(reason_, !failure_.empty() ? escaped(failure_)
                     : typed.empty()
                         ? escaped(joined("There are ", directory_.servers().size(),
                                          " navigation servers: choose one above. Nothing is "
                                          "chosen, since each may drive another robot."))
                         : escaped(quotedName(typed) +
                                   " cannot be the name of a node: letters, digits, _ and / are in "
                                   "those."));
    return;
  }
  const ServerWatch& watch = server_->watch();
  const ServerPhase phase = watch.phase(now);
  setText(phase_, colored(colorOf(phase), capitalized(nameOf(phase))));
  setText(reason_, failure_.empty() ? capitalized(escaped(watch.reason(now)).toStdString())
                                    : escaped(failure_));
  std::string report = server_->clearReport(now);
  const std::string of_act = reportOfAct(now);
  if (!of_act.empty()) {
    report = of_act + (report.empty() ? "" : " ") + report;
  }
  setText(report_, escaped(report));
}

void MeshNavigationPanel::showServers()
{
  setNames(servers_, listOf(directory_.servers()));
  servers_->lineEdit()->setPlaceholderText(
      server_ ? QString::fromStdString(server_->watch().server()) : "choose one");
}

void MeshNavigationPanel::showChoice(Time now)
{
  setNames(planner_, listOf(directory_.planners()));
  setNames(controller_, listOf(directory_.controllers()));
  std::string text;
  const auto look = [&](const char* kind, QComboBox* box, const std::vector<std::string>& names) {
    const std::string chosen = box->currentText().trimmed().toStdString();
    if (!chosen.empty() && !names.empty() &&
        std::find(names.begin(), names.end(), chosen) == names.end()) {
      text += joined("The server has no ", kind, " ", quotedName(chosen), ". ");
    }
    return !chosen.empty();
  };
  const bool planner = look("planner", planner_, directory_.planners());
  const bool controller = look("controller", controller_, directory_.controllers());
  const bool there = server_ && !server_->watch().isSilent(now);
  if ((planner || controller) && there && server_->connection().choiceReceivers() == 0) {
    text +=
        "Nobody takes this choice: it counts for goals that the node goal_bridge of "
        "mesh_navigation sends on.";
  }
  setText(choice_, text.empty() ? QString() : colored(UNSURE, escaped(text)));
}

void MeshNavigationPanel::showGoal(Time now)
{
  const NavigationGoal* goal = server_ ? server_->watch().goal() : nullptr;
  const NavigationGoal* before = server_ ? server_->watch().goalBefore() : nullptr;
  if (!goal) {
    for (auto* label : {goal_, remaining_, outcome_, before_}) {
      setText(label, QString());
    }
    return;
  }
  setText(goal_,
          "<b>Goal:</b> " + escaped(describeTarget(*goal)) + escaped(describePlugins(*goal)));
  QString remaining;
  if (const auto left = server_->watch().remaining()) {
    remaining = QString("<b>Remaining:</b> %1 m %2")
                    .arg(left->length, 0, 'f', left->length < 10.0 ? 2 : 1)
                    .arg(left->along_path ? "along the path" : "to the goal (no path is known)");
    if (left->seconds) {
      remaining += ", " + describeTime(*left->seconds);
    }
  }
  setText(remaining_, remaining);
  const auto tell = [](const Outcome& outcome) {
    return colored(outcome.succeeded ? GOOD : BAD, "<b>" + escaped(outcome.name) + "</b>") +
           (outcome.message.empty() ? QString() : ": " + escaped(outcome.message));
  };
  QString outcome;
  if (goal->outcome) {
    outcome = "<b>Outcome:</b> " + tell(*goal->outcome);
  } else if (server_->watch().isSilent(now)) {
    outcome = "<b>Outcome:</b> " + colored(BAD, "not known: the server says nothing any more");
  }
  setText(outcome_, outcome);
  outcome_->setToolTip(goal->outcome ? QString::fromStdString(goal->outcome->message) : QString());
  setText(before_, before && before->outcome
                       ? "<small>The goal before: " + tell(*before->outcome) + "</small>"
                       : QString());
}

void MeshNavigationPanel::showButtons()
{
  const bool can_cancel = server_ && server_->canCancel();
  cancel_->setEnabled(can_cancel);
  cancel_->setToolTip(can_cancel
                          ? "Ends all that the server does, whoever asked for it: the robot stops."
                          : "Not now: nobody would hear it.");
  const bool can_clear = server_ && !directory_.clearServices().empty();
  clear_->setEnabled(can_clear && !server_->isClearing());
  std::string services;
  for (const std::string& service : directory_.clearServices()) {
    services += (services.empty() ? "" : ", ") + service;
  }
  clear_->setToolTip(
      can_clear ? QString::fromStdString("Layers forget what sensors have seen: " + services)
                : "Not now: the server has no service clear_mesh or "
                  "clear_costmaps.");
}

}  // namespace rviz_mesh_plugin
