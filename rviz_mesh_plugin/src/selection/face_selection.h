#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace rviz_mesh_plugin {

/// A set of faces of one mesh, with undo and redo. select() and deselect() take time by the faces
/// given, the others by those that change, and the number of all over 64. A change is either made
/// or, where it throws std::bad_alloc, not at all.
class FaceSelection
{
 public:
  using Faces = std::vector<std::uint32_t>;

  /// Both ascending, each face once.
  struct Change
  {
    Faces added;
    Faces removed;

    bool empty() const { return added.empty() && removed.empty(); }
  };

  /// So many bytes of steps are kept by default.
  static constexpr std::size_t HISTORY_BYTES = std::size_t{256} << 20;

  explicit FaceSelection(std::size_t face_count = 0, std::size_t history_bytes = HISTORY_BYTES);

  /// Of another mesh: nothing is selected, nothing can be undone.
  void reset(std::size_t face_count);

  /// Of the mesh.
  std::size_t size() const { return size_; }
  bool contains(std::uint32_t face) const
  {
    return face < size_ && (words_[face / BITS] >> (face % BITS) & 1) != 0;
  }
  /// Of the selected ones.
  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// The selected ones, ascending.
  Faces faces() const;

  /// Faces in any order; repeated ones and those that the mesh does not have are left out. They
  /// return what has really changed (valid until the next change), which is one step to undo.
  const Change& select(const Faces& faces);
  const Change& deselect(const Faces& faces);
  const Change& replace(const Faces& faces);
  const Change& invert();
  const Change& clear();
  const Change& selectAll();

  /// All changes between these are one step. undo() and redo() end it, too.
  void beginStroke();
  void endStroke();
  /// Takes back the changes since beginStroke(): they are no step, not even to redo.
  const Change& giveUpStroke();
  bool inStroke() const { return in_stroke_; }

  bool canUndo() const;
  bool canRedo() const { return !undone_.empty(); }
  /// Nothing changes where there is nothing to undo.
  const Change& undo();
  const Change& redo();

  /// Of the steps that can be undone and redone. Where they are too many, the oldest are forgotten.
  std::size_t historyBytes() const { return used_bytes_; }

 private:
  using Word = std::uint64_t;
  using Words = std::vector<Word>;
  static constexpr std::uint32_t BITS = 64;

  /// Faces from begin to before end.
  struct Run
  {
    std::uint32_t begin;
    std::uint32_t end;
  };
  /// Which faces have changed: ascending runs of them.
  using Step = std::vector<Run>;

  static std::size_t bytesOf(const Step& step);

  const Change& make(const Faces& faces, bool adding);
  const Change& make(Words& wanted);
  void compare(const Words& wanted);
  const Change& take();
  const Change& move(std::deque<Step>& from, std::deque<Step>& to);
  void remember();
  void forgetUndone();

  std::size_t size_ = 0;
  std::size_t history_bytes_;
  Words words_;
  std::size_t count_ = 0;
  Change change_;
  Change next_;  ///< being found; keeps its memory
  std::deque<Step> done_;
  std::deque<Step> undone_;
  std::size_t used_bytes_ = 0;
  bool in_stroke_ = false;
  Words before_;  ///< the stroke
};

}  // namespace rviz_mesh_plugin
