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

/// The faces that are in the one and not in the other, ascending.
void subtract(const FaceWords& from, const FaceWords& other, std::vector<std::uint32_t>& faces)
{
  std::size_t count = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    count += static_cast<std::size_t>(__builtin_popcountll(from[i] & ~other[i]));
  }
  faces.resize(count);
  std::uint32_t* next = faces.data();
  for (std::size_t i = 0; i < from.size(); ++i) {
    visitBits(from[i] & ~other[i], static_cast<std::uint32_t>(FACE_BITS * i),
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

/// Packs ascending faces into runs: for each the faces left out before it, then its length, as
/// numbers of 7 bits a byte, the lowest first.
class RunWriter
{
 public:
  void add(std::uint32_t begin, std::uint32_t count)
  {
    if (begin != end_ || end_ == begin_) {
      flush();
      begin_ = begin;
    }
    end_ = begin + count;
  }

  std::vector<std::uint8_t> take()
  {
    flush();
    bytes_.shrink_to_fit();
    return std::move(bytes_);
  }

 private:
  void flush()
  {
    if (end_ > begin_) {
      write(begin_ - written_);
      write(end_ - begin_);
      written_ = end_;
    }
  }

  void write(std::uint32_t number)
  {
    for (; number >= 0x80; number >>= 7) {
      bytes_.push_back(static_cast<std::uint8_t>(number | 0x80));
    }
    bytes_.push_back(static_cast<std::uint8_t>(number));
  }

  std::vector<std::uint8_t> bytes_;
  std::uint32_t begin_ = 0;
  std::uint32_t end_ = 0;
  std::uint32_t written_ = 0;
};

/// The next number that a RunWriter has written; @a at goes on behind it.
std::uint32_t readNumber(const std::vector<std::uint8_t>& bytes, std::size_t& at)
{
  std::uint32_t number = 0;
  for (unsigned shift = 0;; shift += 7) {
    const std::uint8_t byte = bytes[at++];
    number |= static_cast<std::uint32_t>(byte & 0x7F) << shift;
    if (byte < 0x80) {
      return number;
    }
  }
}

/// What a step costs besides its bytes.
constexpr std::size_t STEP_BYTES = sizeof(std::vector<std::uint8_t>) + 16;

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
  faces.reserve(count_);
  for (std::size_t i = 0; i < words_.size(); ++i) {
    visitBits(words_[i], static_cast<std::uint32_t>(BITS * i),
              [&](std::uint32_t face) { faces.push_back(face); });
  }
  return faces;
}

const FaceSelection::Change& FaceSelection::select(const Faces& faces)
{
  Faces copy;
  next_.added.clear();
  next_.removed.clear();
  for (const std::uint32_t face : ordered(faces, copy)) {
    if (face < size_ && !contains(face)) {
      next_.added.push_back(face);
    }
  }
  return make();
}

const FaceSelection::Change& FaceSelection::deselect(const Faces& faces)
{
  Faces copy;
  next_.added.clear();
  next_.removed.clear();
  for (const std::uint32_t face : ordered(faces, copy)) {
    if (contains(face)) {
      next_.removed.push_back(face);
    }
  }
  return make();
}

/// What may throw comes first.
const FaceSelection::Change& FaceSelection::make()
{
  if (!next_.empty()) {
    if (!in_stroke_) {
      remember(pack(next_));
    }
    forgetUndone();
    for (const std::uint32_t face : next_.added) {
      words_[face / BITS] |= Word{1} << (face % BITS);
    }
    for (const std::uint32_t face : next_.removed) {
      words_[face / BITS] &= ~(Word{1} << (face % BITS));
    }
    count_ = count_ + next_.added.size() - next_.removed.size();
  }
  std::swap(change_, next_);
  return change_;
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
      remember(pack(words_, wanted));
    }
    forgetUndone();
  }
  return become(wanted);
}

/// What has to be added and removed.
void FaceSelection::compare(const Words& wanted)
{
  subtract(wanted, words_, next_.added);
  subtract(words_, wanted, next_.removed);
}

const FaceSelection::Change& FaceSelection::become(Words& wanted)
{
  words_.swap(wanted);
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
    remember(pack(before, words_));
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
  return become(wanted);
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
    const Step& step = from.back();
    std::uint32_t end = 0;
    for (std::size_t at = 0; at < step.size();) {
      const std::uint32_t begin = end + readNumber(step, at);
      end = begin + readNumber(step, at);
      toggle(wanted, begin, end);
    }
  }
  compare(wanted);
  if (!from.empty()) {
    to.emplace_back();
    to.back().swap(from.back());
    from.pop_back();
  }
  return become(wanted);
}

FaceSelection::Step FaceSelection::pack(const Change& change)
{
  RunWriter runs;
  auto added = change.added.begin();
  auto removed = change.removed.begin();
  while (added != change.added.end() || removed != change.removed.end()) {
    const bool take_added =
        removed == change.removed.end() || (added != change.added.end() && *added < *removed);
    runs.add(take_added ? *added++ : *removed++, 1);
  }
  return runs.take();
}

FaceSelection::Step FaceSelection::pack(const Words& before, const Words& after)
{
  RunWriter runs;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(BITS * i);
    const Word changed = before[i] ^ after[i];
    if (changed == ~Word{0}) {
      runs.add(first, BITS);
    } else {
      visitBits(changed, first, [&](std::uint32_t face) { runs.add(face, 1); });
    }
  }
  return runs.take();
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
