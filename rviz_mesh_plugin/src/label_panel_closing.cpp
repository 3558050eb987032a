// Closing RViz with labels that are not saved: a part of the panel.
#include <exception>
#include <iostream>
#include <memory>
#include <string>

#include <QCloseEvent>
#include <QEvent>
#include <QString>
#include <QTimer>

#include <ros/console.h>
#include <ros/init.h>

#include "rviz_mesh_plugin/cluster_label_panel.h"
#include "rviz_mesh_plugin/label_dialogs.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int PERIOD = 50;  // milliseconds

using SharedSession = std::shared_ptr<LabelSession>;

std::string describeLoss(const LabelSession& session)
{
  LabelSituation situation;
  situation.unsaved = session.unsaved();
  situation.unstored = session.unstored();
  const std::string failure = session.failure();
  return describeLoss(situation) + (failure.empty() ? "" : "\n\n" + failure);
}

void askWithoutPanel(const SharedSession& session, QWidget* window, const std::string& problem);

/// Stores what is not stored, then saves; asks once more where that fails.
void saveWithoutPanel(const SharedSession& session, QWidget* window)
{
  auto* timer = new QTimer(window);
  QObject::connect(timer, &QTimer::timeout, window, [=, saving = false]() mutable {
    try {
      session->work(nullptr);
      const bool failed = session->failed() > 0;  // others may wait for that one
      if (session->isSaving() || (!failed && session->unstored() > 0)) {
        return;
      }
      std::string problem;
      if (!saving && !failed) {
        saving = true;
        problem = session->save();
        if (problem.empty()) {
          return;
        }
      }
      timer->deleteLater();
      timer->stop();
      if (session->unstored() + session->unsaved() > 0) {
        askWithoutPanel(session, window, problem);
      }
    } catch (const std::exception& error) {
      timer->stop();
      ROS_ERROR("labels are not saved: %s", error.what());
    }
  });
  session->sendAgain();
  timer->start(PERIOD);
}

void askWithoutPanel(const SharedSession& session, QWidget* window, const std::string& problem)
{
  askButton(
      window, "Labels Not Saved",
      QString::fromStdString("The panel of labels is gone. " + describeLoss(*session) + problem),
      {"Save"}, [session, window](int) { saveWithoutPanel(session, window); }, "Discard");
}

}  // namespace

/// Nobody can be asked before RViz removes a panel. The window that is closed is asked before.
void ClusterLabelPanel::askWhenGone()
{
  if (!session_ || session_->unstored() + session_->unsaved() == 0) {
    return;
  }
  if (!loss_told_) {
    ROS_WARN("The panel of labels is gone. %s", describeLoss(*session_).c_str());
  }
  if (window_ && window_ != this && window_->isVisible() && ros::ok()) {
    askWithoutPanel(SharedSession(std::move(session_)), window_, {});
  }
}

bool ClusterLabelPanel::eventFilter(QObject* object, QEvent* event)
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
  return rviz::Panel::eventFilter(object, event);
}

bool ClusterLabelPanel::mayClose()
{
  if (closing_ == Closing::NOW || !session_ || session_->unstored() + session_->unsaved() == 0) {
    return true;
  }
  if (ros::ok()) {
    return false;
  }
  // Ctrl+C, or somebody ends the node: RViz closes its windows until they are gone. ROS_WARN says
  // nothing any more.
  if (!loss_told_) {
    loss_told_ = true;
    std::cerr << "RViz ends. " << describeLoss(*session_) << std::endl;
  }
  return true;
}

void ClusterLabelPanel::askToClose()
{
  closing_ = Closing::NO;
  if (question_ && question_->isVisible()) {
    return;
  }
  question_ = askButton(this, "Labels Not Saved", QString::fromStdString(describeLoss(*session_)),
                        {"Save", "Discard"}, [this](int button) {
                          if (button == 0) {
                            session_->sendAgain();
                            closing_ = Closing::STORING;
                          } else {
                            closing_ = Closing::NOW;
                            QMetaObject::invokeMethod(
                                this, [this] { continueClosing(); }, Qt::QueuedConnection);
                          }
                        });
}

/// Where something fails, it is asked once more.
void ClusterLabelPanel::continueClosing()
{
  if (closing_ == Closing::STORING) {
    if (session_->failed() > 0) {
      askToClose();
    } else if (session_->unstored() == 0 && !session_->isSaving()) {
      closing_ = Closing::SAVING;
      commands_->say(session_->save());
    }
  } else if (closing_ == Closing::SAVING && !session_->isSaving()) {
    if (session_->unstored() + session_->unsaved() > 0) {
      askToClose();
    } else {
      closing_ = Closing::NOW;
    }
  }
  if (closing_ == Closing::NOW && window_) {
    const QPointer<ClusterLabelPanel> self(this);
    window_->close();
    if (self) {  // somebody else may have been against it
      closing_ = Closing::NO;
    }
  }
}

}  // namespace rviz_mesh_plugin
