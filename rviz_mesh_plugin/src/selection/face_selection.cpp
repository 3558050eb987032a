#include "selection/face_selection.h"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include "base/step_history.h"
#include "labels/label_faces.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t BITS = FaceBits::BITS;
using Word = FaceBits::Word;

/// What a step costs besides its runs or words.
constexpr std::size_t STEP_BYTES = 48;

/// Bits from one to before another.
constexpr Word onesOf(std::uint32_t begin, std::uint32_t end)
{
  const std::uint32_t count = end - begin;
  return (count == BITS ? ~Word{0} : (Word{1} << count) - 1) << begin;
}

/// How many runs of bits begin in a word; one that goes on from the word before does not.
std::size_t runsIn(Word word, bool goes_on)
{
  return FaceBits::countOf(word & ~(word << 1 | (goes_on ? 1 : 0)));
}

}  // namespace

void FaceSelection::Change::clear()
{
  words_.clear();
  added_ = removed_ = 0;
}

void FaceSelection::Change::put(std::size_t place, Word added, Word removed)
{
  if ((added | removed) != 0) {
    words_.push_back({static_cast<std::uint32_t>(place), added, removed});
    added_ += FaceBits::countOf(added);
    removed_ += FaceBits::countOf(removed);
  }
}

FaceSelection::Faces FaceSelection::Change::listed(Word Bits::*kind, std::size_t count) const
{
  Faces faces;
  faces.reserve(count);
  for (const Bits& word : words_) {
    FaceBits::visitBits(word.*kind, BITS * word.place,
                        [&](std::uint32_t face) { faces.push_back(face); });
  }
  return faces;
}

FaceSelection::FaceSelection(std::size_t face_count, std::size_t history_bytes)
    : history_bytes_(history_bytes)
{
  reset(face_count);
}

void FaceSelection::reset(std::size_t face_count)
{
  bits_ = FaceBits(face_count);
  count_ = 0;
  change_ = next_ = Change();
  done_.clear();
  undone_.clear();
  used_bytes_ = 0;
  in_stroke_ = false;
  before_ = FaceBits();
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
  next_.clear();
  for (std::size_t i = 0; i < sorted.size() && sorted[i] < size();) {
    const std::uint32_t place = sorted[i] / BITS;
    Word bits = 0;
    for (; i < sorted.size() && sorted[i] < size() && sorted[i] / BITS == place; ++i) {
      bits |= Word{1} << (sorted[i] % BITS);
    }
    const Word now = bits_.word(place);
    next_.put(place, adding ? bits & ~now : 0, adding ? 0 : bits & now);
  }
  if (!next_.empty()) {
    remember();
  }
  return takeNext();
}

void FaceSelection::refuseOthers(const FaceBits& faces) const
{
  if (faces.size() != size()) {
    throw std::invalid_argument("faces of a mesh of " + std::to_string(faces.size()) +
                                " faces cannot be selected in one of " + std::to_string(size()));
  }
}

const FaceSelection::Change& FaceSelection::selectBits(const FaceBits& faces)
{
  refuseOthers(faces);
  return make([&](std::size_t place) { return bits_.word(place) | faces.word(place); });
}

const FaceSelection::Change& FaceSelection::deselectBits(const FaceBits& faces)
{
  refuseOthers(faces);
  return make([&](std::size_t place) { return bits_.word(place) & ~faces.word(place); });
}

const FaceSelection::Change& FaceSelection::replaceBits(const FaceBits& faces)
{
  refuseOthers(faces);
  return make([&](std::size_t place) { return faces.word(place); });
}

const FaceSelection::Change& FaceSelection::intersectBits(const FaceBits& faces)
{
  refuseOthers(faces);
  return make([&](std::size_t place) { return bits_.word(place) & faces.word(place); });
}

const FaceSelection::Change& FaceSelection::toggleBits(const FaceBits& faces)
{
  refuseOthers(faces);
  return make([&](std::size_t place) { return bits_.word(place) ^ faces.word(place); });
}

const FaceSelection::Change& FaceSelection::combineBits(const FaceBits& faces, Combination how)
{
  switch (how) {
    case Combination::ADD:
      return selectBits(faces);
    case Combination::TAKE_AWAY:
      return deselectBits(faces);
    case Combination::INTERSECT:
      return intersectBits(faces);
    default:
      return replaceBits(faces);
  }
}

const FaceSelection::Change& FaceSelection::invert()
{
  FaceBits all(size());
  all.addAll();
  return make([&](std::size_t place) { return all.word(place) & ~bits_.word(place); });
}

const FaceSelection::Change& FaceSelection::selectAll()
{
  FaceBits all(size());
  all.addAll();
  return replaceBits(all);
}

const FaceSelection::Change& FaceSelection::clear()
{
  return make([](std::size_t) { return Word{0}; });
}

/// @param wanted gives each word as it shall be
template <class Wanted>
const FaceSelection::Change& FaceSelection::make(const Wanted& wanted)
{
  compare(wanted);
  if (!next_.empty()) {
    remember();
  }
  return takeNext();
}

/// What has to be added and removed.
template <class Wanted>
void FaceSelection::compare(const Wanted& wanted)
{
  next_.clear();
  for (std::size_t place = 0; place < bits_.wordCount(); ++place) {
    const Word now = bits_.word(place), then = wanted(place);
    next_.put(place, then & ~now, now & ~then);
  }
}

/// What has been found is the change now.
const FaceSelection::Change& FaceSelection::takeNext()
{
  for (const Change::Bits& word : next_.words()) {
    bits_.toggle(word.place, word.added | word.removed);
  }
  count_ = count_ + next_.addedCount() - next_.removedCount();
  std::swap(change_, next_);
  return change_;
}

void FaceSelection::beginStroke()
{
  if (!in_stroke_) {
    before_ = bits_;
    in_stroke_ = true;
  }
}

void FaceSelection::endStroke()
{
  if (!in_stroke_) {
    return;
  }
  in_stroke_ = false;
  const FaceBits before = std::exchange(before_, FaceBits());
  if (before == bits_) {
    return;
  }
  try {
    compare([&](std::size_t place) { return before.word(place); });
    remember();
  } catch (const std::bad_alloc&) {  // what was before cannot be returned to
    done_.clear();
    used_bytes_ = 0;
  }
}

const FaceSelection::Change& FaceSelection::giveUpStroke()
{
  const bool was_in_stroke = in_stroke_;
  compare([&](std::size_t place) { return (was_in_stroke ? before_ : bits_).word(place); });
  in_stroke_ = false;
  before_ = FaceBits();
  return takeNext();
}

bool FaceSelection::canUndo() const
{
  return !done_.empty() || (in_stroke_ && before_ != bits_);
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
  next_.clear();
  if (from.empty()) {
    return takeNext();
  }
  std::uint32_t place = 0;
  Word bits = 0;  // of that place, so far
  const auto toggle = [&](std::uint32_t next_place, Word next_bits) {
    if (next_place != place) {
      next_.put(place, bits & ~bits_.word(place), bits & bits_.word(place));
      place = next_place;
      bits = 0;
    }
    bits |= next_bits;
  };
  for (const Toggled& word : from.back().words) {
    toggle(word.place, word.bits);
  }
  for (const Run& run : from.back().runs) {
    for (std::uint32_t face = run.begin; face < run.end;) {
      const std::uint32_t end = std::min(run.end, face / BITS * BITS + BITS);
      toggle(face / BITS, onesOf(face % BITS, face % BITS + end - face));
      face = end;
    }
  }
  next_.put(place, bits & ~bits_.word(place), bits & bits_.word(place));
  to.push_back(std::move(from.back()));
  from.pop_back();
  return takeNext();
}

std::size_t FaceSelection::bytesOf(const Step& step)
{
  return step.runs.capacity() * sizeof(Run) + step.words.capacity() * sizeof(Toggled) + STEP_BYTES;
}

FaceSelection::Step FaceSelection::stepOf(const Change& change)
{
  const auto toggledIn = [](const Change::Bits& word) { return word.added | word.removed; };
  std::size_t runs = 0;
  const Change::Bits* before = nullptr;
  for (const Change::Bits& word : change.words()) {
    const bool goes_on =
        before && before->place + 1 == word.place && toggledIn(*before) >> (BITS - 1) != 0;
    runs += runsIn(toggledIn(word), goes_on);
    before = &word;
  }
  Step step;
  if (runs * sizeof(Run) > change.words().size() * sizeof(Toggled)) {
    step.words.reserve(change.words().size());
    for (const Change::Bits& word : change.words()) {
      step.words.push_back({word.place, toggledIn(word)});
    }
    return step;
  }
  step.runs.reserve(runs);
  for (const Change::Bits& word : change.words()) {
    const std::uint32_t first = BITS * word.place;
    for (Word left = toggledIn(word); left != 0;) {
      const auto begin = static_cast<std::uint32_t>(__builtin_ctzll(left));
      const Word ended = ~(left >> begin);
      const std::uint32_t end =
          ended == 0 ? BITS : begin + static_cast<std::uint32_t>(__builtin_ctzll(ended));
      if (!step.runs.empty() && step.runs.back().end == first + begin) {
        step.runs.back().end = first + end;
      } else {
        step.runs.push_back({first + begin, first + end});
      }
      left &= ~onesOf(begin, end);
    }
  }
  return step;
}

/// What has been found can be undone from now on, but in a stroke, which is remembered as a whole.
void FaceSelection::remember()
{
  if (!in_stroke_) {
    done_.push_back(stepOf(next_));
    done_.back().order = nextStepOrder();
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

void FaceSelection::joinStep(std::uint64_t order)
{
  if (!done_.empty()) {
    done_.back().order = order;
  }
}

void FaceSelection::forgetUndoneBefore(std::uint64_t order)
{
  while (!undone_.empty() && undone_.back().order < order) {
    used_bytes_ -= bytesOf(undone_.back());
    undone_.pop_back();
  }
}

}  // namespace rviz_mesh_plugin
