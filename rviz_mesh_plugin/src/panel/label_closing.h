#pragma once

#include <functional>
#include <memory>
#include <string>

#include <QObject>
#include <QPointer>
#include <QWidget>

#include "label_editing/label_session.h"

namespace rviz_mesh_plugin {

/// Asks before RViz is closed, or when the panel is gone, with labels that are not saved: to save
/// them first, or not at all. Without the panel it belongs to the window and works for the session,
/// until they are saved or given up.
class LabelClosing : public QObject
{
 public:
  /// @param panel has the questions, as long as there is one
  /// @param say is told why labels could not be saved, or nothing
  LabelClosing(std::shared_ptr<LabelSession> session, QWidget* panel,
               std::function<void(const std::string& problem)> say);

  /// That this main window is not closed without asking; null: it is not known.
  void watch(QWidget* window);

  /// Goes on with what was answered: to be called often, by who works for the session.
  void work();

  /// The panel is going: nobody can be asked before RViz removes one.
  static void goOnWithoutPanel(std::unique_ptr<LabelClosing> closing);

 protected:
  bool eventFilter(QObject* object, QEvent* event) override;

 private:
  enum class State
  {
    OPEN,
    SAVING,  ///< once edits are stored
    CLOSES
  };

  bool mayClose();
  bool isAsking() const { return question_ && question_->isVisible(); }
  void askToClose();
  void save(bool closes_then);
  void discard();
  void beginWithoutPanel();
  void workWithoutPanel();
  void askWithoutPanel(const std::string& problem);

  std::shared_ptr<LabelSession> session_;
  QWidget* panel_;  ///< null: it is gone
  std::function<void(const std::string&)> say_;
  State state_ = State::OPEN;
  bool saving_ = false;  ///< they are stored
  bool closes_then_ = false;
  bool loss_told_ = false;
  QPointer<QWidget> window_;    ///< the main one
  QPointer<QWidget> question_;  ///< that is open
};

}  // namespace rviz_mesh_plugin
