#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "base/face_bits.h"

namespace rviz_mesh_plugin {

/// What becomes of a selection and of faces that are found.
enum class Combination
{
  REPLACE,    ///< these instead of those that are selected
  ADD,        ///< these, too
  TAKE_AWAY,  ///< these not
  INTERSECT   ///< of those that are selected, these alone
};

/// A set of faces of one mesh, with undo and redo. What is given faces as a list takes time by
/// their number, all else by the number of all faces over 64: about a millisecond of ten million,
/// so that nothing has to wait for it. A change is either made or, where it throws std::bad_alloc,
/// not at all.
class FaceSelection
{
 public:
  using Faces = FaceBits::Faces;
  using Word = FaceBits::Word;

  /// The faces that are new and those that are gone, as bits of the words that have any.
  class Change
  {
   public:
    struct Bits
    {
      std::uint32_t place;  ///< of the word
      Word added;
      Word removed;
    };

    bool empty() const { return words_.empty(); }
    std::size_t addedCount() const { return added_; }
    std::size_t removedCount() const { return removed_; }
    std::size_t count() const { return added_ + removed_; }
    const std::vector<Bits>& words() const { return words_; }  ///< ascending

    /// As lists, ascending: for few.
    Faces added() const { return listed(&Bits::added, added_); }
    Faces removed() const { return listed(&Bits::removed, removed_); }

   private:
    friend class FaceSelection;

    void clear();
    void put(std::size_t place, Word added, Word removed);
    Faces listed(Word Bits::*kind, std::size_t count) const;

    std::vector<Bits> words_;
    std::size_t added_ = 0;
    std::size_t removed_ = 0;
  };

  /// So many bytes of steps are kept by default.
  static constexpr std::size_t HISTORY_BYTES = std::size_t{256} << 20;

  explicit FaceSelection(std::size_t face_count = 0, std::size_t history_bytes = HISTORY_BYTES);

  /// Of another mesh: nothing is selected, nothing can be undone.
  void reset(std::size_t face_count);

  /// Of the mesh.
  std::size_t size() const { return bits_.size(); }
  bool contains(std::uint32_t face) const { return bits_.contains(face); }
  /// Of the selected ones.
  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// The selected ones.
  const FaceBits& bits() const { return bits_; }
  /// The same as a list, ascending.
  Faces faces() const { return bits_.faces(); }

  /// Faces in any order; repeated ones and those that the mesh does not have are left out. They
  /// return what has really changed (valid until the next change), which is one step to undo.
  const Change& select(const Faces& faces);
  const Change& deselect(const Faces& faces);
  const Change& replace(const Faces& faces) { return replaceBits(FaceBits(size(), faces)); }
  /// The same with faces of a mesh of as many. @throw std::invalid_argument for others
  const Change& selectBits(const FaceBits& faces);
  const Change& deselectBits(const FaceBits& faces);
  const Change& replaceBits(const FaceBits& faces);
  const Change& intersectBits(const FaceBits& faces);
  /// Those of these that are selected are not any more, and the others are.
  const Change& toggleBits(const FaceBits& faces);
  const Change& combineBits(const FaceBits& faces, Combination how);
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

  /// Of the step that is undone (redone) next, among those of other histories (step_history.h); 0:
  /// there is none.
  std::uint64_t undoOrder() const { return done_.empty() ? 0 : done_.back().order; }
  std::uint64_t redoOrder() const { return undone_.empty() ? 0 : undone_.back().order; }
  /// The newest step is part of one that is kept elsewhere.
  void joinStep(std::uint64_t order);
  void forgetUndoneBefore(std::uint64_t order);

  /// Of the steps that can be undone and redone. Where they are too many, the oldest are forgotten.
  std::size_t historyBytes() const { return used_bytes_; }

 private:
  /// Faces from begin to before end.
  struct Run
  {
    std::uint32_t begin;
    std::uint32_t end;
  };
  struct Toggled
  {
    std::uint32_t place;
    Word bits;
  };
  /// Which faces have changed: in ascending runs or, where these are many, in words.
  struct Step
  {
    std::vector<Run> runs;
    std::vector<Toggled> words;
    std::uint64_t order = 0;
  };

  static std::size_t bytesOf(const Step& step);
  static Step stepOf(const Change& change);

  template <class Wanted>
  const Change& make(const Wanted& wanted);
  template <class Wanted>
  void compare(const Wanted& wanted);
  const Change& make(const Faces& faces, bool adding);
  void refuseOthers(const FaceBits& faces) const;
  const Change& takeNext();
  const Change& move(std::deque<Step>& from, std::deque<Step>& to);
  void remember();
  void forgetUndone();

  std::size_t history_bytes_;
  FaceBits bits_;
  std::size_t count_ = 0;
  Change change_;
  Change next_;  ///< being found; keeps its memory
  std::deque<Step> done_;
  std::deque<Step> undone_;
  std::size_t used_bytes_ = 0;
  bool in_stroke_ = false;
  FaceBits before_;  ///< the stroke
};

}  // namespace rviz_mesh_plugin
