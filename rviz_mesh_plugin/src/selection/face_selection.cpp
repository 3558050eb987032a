#include "selection/face_selection.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "labels/label_faces.h"

namespace rviz_mesh_plugin {
namespace {

/// Sets of faces as bits, the lowest face in the lowest bit of the first word.
using FaceWord = std::uint64_t;
using FaceWords = std::vector<FaceWord>;
constexpr std::uint32_t FACE_BITS = 64;

/// Calls back for each bit that is set, from the lowest.
template <class Visit>
void visitBits(FaceWord word, std::uint32_t first, const Visit& visit)
{
  if (word == ~FaceWord{0}) {
    for (std::uint32_t bit = first; bit != first + FACE_BITS; ++bit) {
      visit(bit);
    }
    return;
  }
  for (; word != 0; word &= word - 1) {
    visit(first + static_cast<std::uint32_t>(__builtin_ctzll(word)));
  }
}

/// The faces whose bits are set, ascending.
/// @param wordAt gives each word
template <class WordAt>
void listFaces(std::size_t words, const WordAt& wordAt, std::vector<std::uint32_t>& faces)
{
  std::size_t count = 0;
  for (std::size_t i = 0; i < words; ++i) {
    count += static_cast<std::size_t>(__builtin_popcountll(wordAt(i)));
  }
  faces.resize(count);
  std::uint32_t* next = faces.data();
  for (std::size_t i = 0; i < words; ++i) {
    visitBits(wordAt(i), static_cast<std::uint32_t>(FACE_BITS * i),
              [&](std::uint32_t face) { *next++ = face; });
  }
}

/// Turns the bits of [begin, end) round.
void toggle(FaceWords& words, std::uint32_t begin, std::uint32_t end)
{
  while (begin < end) {
    const std::uint32_t bit = begin % FACE_BITS;
    const std::uint32_t count = std::min(end - begin, FACE_BITS - bit);
    const FaceWord ones = count == FACE_BITS ? ~FaceWord{0} : (FaceWord{1} << count) - 1;
    words[begin / FACE_BITS] ^= ones << bit;
    begin += count;
  }
}

/// What a step costs besides its runs.
constexpr std::size_t STEP_BYTES = 40;

}  // namespace

FaceSelection::FaceSelection(std::size_t face_count, std::size_t history_bytes)
    : history_bytes_(history_bytes)
{
  reset(face_count);
}

void FaceSelection::reset(std::size_t face_count)
{
  words_.assign((face_count + BITS - 1) / BITS, 0);
  words_.shrink_to_fit();
  size_ = face_count;
  count_ = 0;
  change_ = next_ = Change();
  done_.clear();
  undone_.clear();
  used_bytes_ = 0;
  in_stroke_ = false;
  before_ = Words();
}

FaceSelection::Faces FaceSelection::faces() const
{
  Faces faces;
  listFaces(
      words_.size(), [&](std::size_t i) { return words_[i]; }, faces);
  return faces;
}

const FaceSelection::Change& FaceSelection::select(const Faces& faces)
{
  return make(faces, true);
}

const FaceSelection::Change& FaceSelection::deselect(const Faces& faces)
{
  return make(faces, false);
}

/// What may throw comes first.
const FaceSelection::Change& FaceSelection::make(const Faces& faces, bool adding)
{
  Faces sorted = faces;
  sortFaces(sorted);
  next_.added.clear();
  next_.removed.clear();
  Faces& changed = adding ? next_.added : next_.removed;
  for (const std::uint32_t face : sorted) {
    if (face < size_ && contains(face) != adding) {
      changed.push_back(face);
    }
  }
  if (!changed.empty()) {
    remember();
    for (const std::uint32_t face : changed) {
      words_[face / BITS] ^= Word{1} << (face % BITS);
    }
  }
  return take();
}

const FaceSelection::Change& FaceSelection::replace(const Faces& faces)
{
  Words wanted(words_.size(), 0);
  for (const std::uint32_t face : faces) {
    if (face < size_) {
      wanted[face / BITS] |= Word{1} << (face % BITS);
    }
  }
  return make(wanted);
}

const FaceSelection::Change& FaceSelection::invert()
{
  Words wanted(words_);
  toggle(wanted, 0, static_cast<std::uint32_t>(size_));
  return make(wanted);
}

const FaceSelection::Change& FaceSelection::selectAll()
{
  Words wanted(words_.size(), 0);
  toggle(wanted, 0, static_cast<std::uint32_t>(size_));
  return make(wanted);
}

const FaceSelection::Change& FaceSelection::clear()
{
  Words wanted(words_.size(), 0);
  return make(wanted);
}

const FaceSelection::Change& FaceSelection::make(Words& wanted)
{
  compare(wanted);
  if (!next_.empty()) {
    remember();
  }
  words_.swap(wanted);
  return take();
}

/// What has to be added and removed.
void FaceSelection::compare(const Words& wanted)
{
  const auto added = [&](std::size_t i) { return wanted[i] & ~words_[i]; };
  const auto removed = [&](std::size_t i) { return words_[i] & ~wanted[i]; };
  listFaces(words_.size(), added, next_.added);
  listFaces(words_.size(), removed, next_.removed);
}

/// What has been found is the change now.
const FaceSelection::Change& FaceSelection::take()
{
  count_ = count_ + next_.added.size() - next_.removed.size();
  std::swap(change_, next_);
  return change_;
}

void FaceSelection::beginStroke()
{
  if (!in_stroke_) {
    before_ = words_;
    in_stroke_ = true;
  }
}

void FaceSelection::endStroke()
{
  if (!in_stroke_) {
    return;
  }
  in_stroke_ = false;
  const Words before = std::exchange(before_, {});
  if (before == words_) {
    return;
  }
  try {
    compare(before);
    remember();
  } catch (const std::bad_alloc&) {  // what was before cannot be returned to
    done_.clear();
    used_bytes_ = 0;
  }
}

const FaceSelection::Change& FaceSelection::giveUpStroke()
{
  Words wanted(in_stroke_ ? before_ : words_);
  compare(wanted);
  in_stroke_ = false;
  before_ = Words();
  words_.swap(wanted);
  return take();
}

bool FaceSelection::canUndo() const
{
  return !done_.empty() || (in_stroke_ && before_ != words_);
}

const FaceSelection::Change& FaceSelection::undo()
{
  endStroke();
  return move(done_, undone_);
}

const FaceSelection::Change& FaceSelection::redo()
{
  endStroke();
  return move(undone_, done_);
}

/// A step there and back is the same: its faces change sides.
const FaceSelection::Change& FaceSelection::move(std::deque<Step>& from, std::deque<Step>& to)
{
  Words wanted(words_);
  if (!from.empty()) {
    for (const Run& run : from.back()) {
      toggle(wanted, run.begin, run.end);
    }
  }
  compare(wanted);
  if (!from.empty()) {
    to.push_back(std::move(from.back()));
    from.pop_back();
  }
  words_.swap(wanted);
  return take();
}

std::size_t FaceSelection::bytesOf(const Step& step)
{
  return step.capacity() * sizeof(Run) + STEP_BYTES;
}

/// What has been found can be undone from now on, but in a stroke, which is remembered as a whole.
void FaceSelection::remember()
{
  if (!in_stroke_) {
    Faces changed;
    changed.reserve(next_.added.size() + next_.removed.size());
    std::merge(next_.added.begin(), next_.added.end(), next_.removed.begin(), next_.removed.end(),
               std::back_inserter(changed));
    Step step;
    for (const std::uint32_t face : changed) {
      if (step.empty() || step.back().end != face) {
        step.push_back({face, face});
      }
      ++step.back().end;
    }
    step.shrink_to_fit();
    done_.push_back(std::move(step));
    used_bytes_ += bytesOf(done_.back());
  }
  forgetUndone();
  while (used_bytes_ > history_bytes_ && !done_.empty()) {
    used_bytes_ -= bytesOf(done_.front());
    done_.pop_front();
  }
}

void FaceSelection::forgetUndone()
{
  for (const Step& step : undone_) {
    used_bytes_ -= bytesOf(step);
  }
  undone_.clear();
}

}  // namespace rviz_mesh_plugin
