#include "panel/label_closing.h"

#include <exception>
#include <iostream>
#include <optional>
#include <utility>

#include <ros/console.h>
#include <ros/init.h>
#include <QEvent>
#include <QString>
#include <QTimer>

#include "panel/label_commands.h"
#include "panel/label_dialogs.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int WORK_PERIOD = 50;  // milliseconds
const char* const TITLE = "Labels Not Saved";
const char* const GONE = "The panel of labels is gone. ";

bool hasUnsaved(const LabelSession& session)
{
  return session.unstored() + session.unsaved() > 0;
}

std::string lossOf(const LabelSession& session)
{
  const std::string failure = session.failure();
  return describeLoss(session.unsaved(), session.unstored()) +
         (failure.empty() ? "" : "\n\n" + failure);
}

/// Stores what is not stored, then saves: to be called until that is over.
/// @param saving whether it has come to that
/// @return why it could not be saved, or an empty string; nothing while it goes on
std::optional<std::string> storeAndSave(LabelSession& session, bool& saving)
{
  const bool failed = session.failed() > 0;  // others may wait for that one
  if (session.isSaving() || (!failed && session.unstored() > 0)) {
    return std::nullopt;
  }
  if (saving || failed) {
    return std::string();
  }
  saving = true;
  std::string problem = session.save();
  return problem.empty() ? std::nullopt : std::make_optional(problem);
}

}  // namespace

LabelClosing::LabelClosing(std::shared_ptr<LabelSession> session, QWidget* panel,
                           std::function<void(const std::string& problem)> say)
    : session_(std::move(session)), panel_(panel), say_(std::move(say))
{
}

void LabelClosing::watch(QWidget* window)
{
  if (window && window != window_) {
    window_ = window;
    window_->installEventFilter(this);
  }
}

void LabelClosing::goOnWithoutPanel(std::unique_ptr<LabelClosing> closing)
{
  LabelClosing& self = *closing;
  if (!hasUnsaved(*self.session_)) {
    return;
  }
  if (!self.loss_told_) {
    ROS_WARN("%s%s", GONE, lossOf(*self.session_).c_str());
  }
  if (self.window_ && self.window_ != self.panel_ && self.window_->isVisible() && ros::ok()) {
    closing.release()->setParent(self.window_);
    self.beginWithoutPanel();
  }
}

void LabelClosing::beginWithoutPanel()
{
  panel_ = nullptr;
  question_ = nullptr;  // which goes with the panel
  say_ = [](const std::string& /*problem*/) {};
  auto* timer = new QTimer(this);
  QObject::connect(timer, &QTimer::timeout, this, &LabelClosing::workWithoutPanel);
  timer->start(WORK_PERIOD);
  if (state_ == State::OPEN) {
    askWithoutPanel({});
  }
}

void LabelClosing::workWithoutPanel()
{
  const QPointer<LabelClosing> self(this);
  try {
    session_->work(nullptr);
    work();
  } catch (const std::exception& error) {
    if (self) {
      askWithoutPanel(error.what());
    }
  }
  if (self && state_ == State::OPEN && !isAsking()) {  // all is saved, or given up
    deleteLater();
  }
}

/// There is no panel to go back to.
void LabelClosing::askWithoutPanel(const std::string& problem)
{
  state_ = State::OPEN;
  delete question_;
  question_ = askButton(
      window_, TITLE, QString::fromStdString(GONE + lossOf(*session_) + problem), {"Save"},
      [this](int) { save(closes_then_); }, "Discard");
}

bool LabelClosing::eventFilter(QObject* object, QEvent* event)
{
  try {
    if (object == window_ && event->type() == QEvent::Close && !mayClose()) {
      event->ignore();
      askToClose();
      return true;
    }
  } catch (const std::exception& error) {
    ROS_ERROR("panel of labels: %s", error.what());
  }
  return QObject::eventFilter(object, event);
}

bool LabelClosing::mayClose()
{
  if (state_ == State::CLOSES || !hasUnsaved(*session_)) {
    return true;
  }
  if (ros::ok()) {
    return false;
  }
  // Ctrl+C, or somebody ends the node: RViz closes its windows until they are gone. ROS_WARN says
  // nothing any more.
  if (!loss_told_) {
    loss_told_ = true;
    std::cerr << "RViz ends. " << lossOf(*session_) << std::endl;
  }
  return true;
}

void LabelClosing::askToClose()
{
  if (isAsking()) {
    return;
  }
  closes_then_ = false;
  if (panel_) {  // which tells what becomes of what is being saved
    state_ = State::OPEN;
  }
  question_ = askButton(panel_ ? panel_ : window_.data(), TITLE,
                        QString::fromStdString((panel_ ? "" : GONE) + lossOf(*session_)),
                        {"Save", "Discard"}, [this](int button) {
                          if (button == 0) {
                            save(true);
                          } else {
                            discard();
                          }
                        });
}

void LabelClosing::save(bool closes_then)
{
  session_->sendAgain();
  saving_ = false;
  closes_then_ = closes_then;
  state_ = State::SAVING;
}

void LabelClosing::discard()
{
  state_ = State::CLOSES;
  QMetaObject::invokeMethod(
      this, [this] { work(); }, Qt::QueuedConnection);
}

/// Where something fails, it is asked once more.
void LabelClosing::work()
{
  if (state_ == State::SAVING) {
    if (const auto problem = storeAndSave(*session_, saving_)) {
      say_(*problem);
      state_ = closes_then_ ? State::CLOSES : State::OPEN;
      if (hasUnsaved(*session_)) {
        state_ = State::OPEN;
        panel_ ? askToClose() : askWithoutPanel(*problem);
      }
    }
  }
  if (state_ == State::CLOSES && window_) {
    const QPointer<LabelClosing> self(this);
    window_->close();
    if (self) {  // somebody else may have been against it
      state_ = State::OPEN;
      if (!panel_ && window_ && window_->isVisible() && hasUnsaved(*session_)) {
        askWithoutPanel({});
      }
    }
  }
}

}  // namespace rviz_mesh_plugin
