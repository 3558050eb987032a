#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// The order in which a user makes steps that can be undone, in whatever history they are kept:
/// the newest is undone first. From 1 on. GUI thread only.
inline std::uint64_t nextStepOrder()
{
  static std::uint64_t last = 0;
  return ++last;
}

/// Steps that are undone and redone together with those of others, in their common order. Steps of
/// one order, as a label and the selection that it was made of, are one step. GUI thread only.
class StepHistory
{
 public:
  virtual ~StepHistory() = default;

  /// Of the step that is undone (redone) next; 0: there is none.
  virtual std::uint64_t undoOrder() const = 0;
  virtual std::uint64_t redoOrder() const = 0;
  /// Why nothing can be undone or redone at the moment; else empty.
  virtual std::string whyNotNow() const = 0;

  /// What to tell the user.
  virtual std::string undo() = 0;
  virtual std::string redo() = 0;

  /// Steps of before this one are not redone any more: it was made after they were undone.
  virtual void forgetUndoneBefore(std::uint64_t order) = 0;
};

/// Histories whose steps are undone and redone in one order.
class StepHistories
{
 public:
  /// Not kept alive.
  void add(const std::shared_ptr<StepHistory>& history);

  /// Undoes the newest step of @a own and the others, or redoes the one undone last; returns what
  /// to tell the user.
  std::string step(bool undo, StepHistory& own);

 private:
  std::vector<std::weak_ptr<StepHistory>> others_;
};

}  // namespace rviz_mesh_plugin
