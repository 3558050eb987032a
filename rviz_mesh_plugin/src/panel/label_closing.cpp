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

constexpr int SAVING_PERIOD = 50;  // milliseconds
const char* const TITLE = "Labels Not Saved";

using SharedSession = std::shared_ptr<LabelSession>;

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

void askInWindow(const SharedSession& session, QWidget* window, const std::string& problem);

/// Asks once more where that fails.
void saveInWindow(const SharedSession& session, QWidget* window)
{
  auto* timer = new QTimer(window);
  QObject::connect(timer, &QTimer::timeout, window, [=, saving = false]() mutable {
    try {
      session->work(nullptr);
      if (const auto problem = storeAndSave(*session, saving)) {
        timer->deleteLater();
        timer->stop();
        if (hasUnsaved(*session)) {
          askInWindow(session, window, *problem);
        }
      }
    } catch (const std::exception& error) {
      timer->deleteLater();
      timer->stop();
      askInWindow(session, window, error.what());
    }
  });
  session->sendAgain();
  timer->start(SAVING_PERIOD);
}

void askInWindow(const SharedSession& session, QWidget* window, const std::string& problem)
{
  askButton(
      window, TITLE,
      QString::fromStdString("The panel of labels is gone. " + lossOf(*session) + problem),
      {"Save"}, [session, window](int) { saveInWindow(session, window); }, "Discard");
}

}  // namespace

LabelClosing::LabelClosing(SharedSession session, QWidget* panel,
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

void LabelClosing::askWithoutPanel()
{
  if (!hasUnsaved(*session_)) {
    return;
  }
  if (!loss_told_) {
    ROS_WARN("The panel of labels is gone. %s", lossOf(*session_).c_str());
  }
  if (window_ && window_ != panel_ && window_->isVisible() && ros::ok()) {
    askInWindow(session_, window_, {});
  }
}

bool LabelClosing::eventFilter(QObject* object, QEvent* event)
{
  try {
    if (object == window_ && event->type() == QEvent::Close && !mayClose()) {
      event->ignore();
      ask();
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

void LabelClosing::ask()
{
  state_ = State::OPEN;
  if (question_ && question_->isVisible()) {
    return;
  }
  question_ = askButton(panel_, TITLE, QString::fromStdString(lossOf(*session_)),
                        {"Save", "Discard"}, [this](int button) {
                          if (button == 0) {
                            session_->sendAgain();
                            saving_ = false;
                            state_ = State::SAVING;
                          } else {
                            state_ = State::CLOSES;
                            QMetaObject::invokeMethod(
                                this, [this] { work(); }, Qt::QueuedConnection);
                          }
                        });
}

/// Where something fails, it is asked once more.
void LabelClosing::work()
{
  if (state_ == State::SAVING) {
    if (const auto problem = storeAndSave(*session_, saving_)) {
      say_(*problem);
      state_ = State::CLOSES;
      if (hasUnsaved(*session_)) {
        ask();
      }
    }
  }
  if (state_ == State::CLOSES && window_) {
    const QPointer<LabelClosing> self(this);
    window_->close();
    if (self) {  // somebody else may have been against it
      state_ = State::OPEN;
    }
  }
}

}  // namespace rviz_mesh_plugin
