#include "selection/face_selection.h"

#include <algorithm>
#include <functional>
#include <new>
#include <utility>

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

using Bytes = std::vector<std::uint8_t>;

/// Appends a number as LEB128: 7 bits a byte, the lowest first, the last byte below 0x80.
void appendNumber(Bytes& bytes, std::uint32_t number)
{
  for (; number >= 0x80; number >>= 7) {
    bytes.push_back(static_cast<std::uint8_t>(number | 0x80));
  }
  bytes.push_back(static_cast<std::uint8_t>(number));
}

/// Takes the next number off; @a at goes on behind it.
std::uint32_t takeNumber(Bytes::const_iterator& at)
{
  std::uint32_t number = 0;
  for (unsigned shift = 0;; shift += 7) {
    const std::uint8_t byte = *at++;
    number |= static_cast<std::uint32_t>(byte & 0x7F) << shift;
    if (byte < 0x80) {
      return number;
    }
  }
}

/// Ascending faces as runs: for each the faces left out before it, then its length.
Bytes packRuns(const std::vector<std::uint32_t>& faces)
{
  Bytes bytes;
  std::uint32_t end = 0;
  for (std::size_t first = 0, next = 0; first < faces.size(); first = next) {
    for (next = first + 1; next < faces.size() && faces[next] == faces[next - 1] + 1;) {
      ++next;
    }
    appendNumber(bytes, faces[first] - end);
    appendNumber(bytes, static_cast<std::uint32_t>(next - first));
    end = faces[next - 1] + 1;
  }
  bytes.shrink_to_fit();
  return bytes;
}

/// What a step costs besides its bytes.
constexpr std::size_t STEP_BYTES = sizeof(Bytes) + 16;

/// The faces ascending and each once: themselves where they are so, else a copy.
const FaceSelection::Faces& ordered(const FaceSelection::Faces& faces, FaceSelection::Faces& copy)
{
  if (std::adjacent_find(faces.begin(), faces.end(), std::greater_equal<>()) == faces.end()) {
    return faces;
  }
  copy = faces;
  std::sort(copy.begin(), copy.end());
  copy.erase(std::unique(copy.begin(), copy.end()), copy.end());
  return copy;
}

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
  Faces copy;
  next_.added.clear();
  next_.removed.clear();
  Faces& changed = adding ? next_.added : next_.removed;
  for (const std::uint32_t face : ordered(faces, copy)) {
    if (face < size_ && contains(face) != adding) {
      changed.push_back(face);
    }
  }
  if (!changed.empty()) {
    if (!in_stroke_) {
      remember(packRuns(changed));
    }
    forgetUndone();
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
    if (!in_stroke_) {
      remember(stepTo(wanted));
    }
    forgetUndone();
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
  Words before;
  before.swap(before_);
  if (before == words_) {
    return;
  }
  try {
    remember(stepTo(before));
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
  Words().swap(before_);
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
    std::uint32_t end = 0;
    for (auto at = from.back().cbegin(); at != from.back().cend();) {
      const std::uint32_t begin = end + takeNumber(at);
      end = begin + takeNumber(at);
      toggle(wanted, begin, end);
    }
  }
  compare(wanted);
  if (!from.empty()) {
    to.emplace_back();
    to.back().swap(from.back());
    from.pop_back();
  }
  words_.swap(wanted);
  return take();
}

/// There and back: its faces change sides.
FaceSelection::Step FaceSelection::stepTo(const Words& other) const
{
  Faces changed;
  listFaces(
      words_.size(), [&](std::size_t i) { return words_[i] ^ other[i]; }, changed);
  return packRuns(changed);
}

std::size_t FaceSelection::bytesOf(const Step& step)
{
  return step.capacity() + STEP_BYTES;
}

void FaceSelection::remember(Step step)
{
  done_.push_back(std::move(step));
  used_bytes_ += bytesOf(done_.back());
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
