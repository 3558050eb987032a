#include "rendering/labels/index_slots.h"

#include <algorithm>
#include <utility>

namespace rviz_mesh_plugin {
namespace {

/// An upload of its own costs about as much as this many unchanged faces.
constexpr std::size_t GAP = 64;

constexpr std::uint32_t NO_PLACE = 0xFFFFFFFF;

}  // namespace

void IndexSlots::assign(std::shared_ptr<const Faces> faces)
{
  wanted_ = std::move(faces);
  places_ = std::vector<std::uint32_t>();
  missing_.assign(wanted_->empty() ? 0 : std::size_t{wanted_->back()} + 1, false);
  holes_.clear();
  filled_ = 0;
  next_ = 0;
  step_ = Step::MARK;
}

std::size_t IndexSlots::work(std::size_t limit)
{
  std::size_t looked = 0;
  while (step_ != Step::NONE && looked < limit) {
    const std::size_t end = std::min(length(), next_ + limit - looked);
    look(next_, end);
    looked += end - next_;
    next_ = end;
    if (next_ < length()) {
      continue;
    }
    next_ = 0;
    if (step_ == Step::CLOSE) {
      step_ = Step::NONE;
      wanted_.reset();
      missing_ = std::vector<bool>();
      holes_ = std::vector<std::uint32_t>();
      filled_ = 0;
    } else {
      step_ = static_cast<Step>(static_cast<int>(step_) + 1);
    }
    ++looked;
  }
  return looked;
}

/// Of the step.
std::size_t IndexSlots::length() const
{
  switch (step_) {
    case Step::MARK:
    case Step::FILL:
      return wanted_->size();
    case Step::SEARCH:
      return faces_.size();
    default:
      return next_ + holes_.size() - filled_;
  }
}

void IndexSlots::look(std::size_t begin, std::size_t end)
{
  for (std::size_t i = begin; i < end; ++i) {
    if (step_ == Step::MARK) {
      missing_[(*wanted_)[i]] = true;
    } else if (step_ == Step::SEARCH) {
      const std::uint32_t face = faces_[i];
      if (face < missing_.size() && missing_[face]) {
        missing_[face] = false;
      } else {
        holes_.push_back(static_cast<std::uint32_t>(i));
      }
    } else if (step_ == Step::FILL) {
      if (missing_[(*wanted_)[i]]) {
        fill((*wanted_)[i]);
      }
    } else {
      closeHole();
    }
  }
}

/// Puts a face that has no place into the first hole, or behind all others.
void IndexSlots::fill(std::uint32_t face)
{
  if (filled_ < holes_.size()) {
    put(holes_[filled_++], face);
  } else {
    faces_.push_back(face);
    put(faces_.size() - 1, face);
  }
}

/// Ends with the last face in it: each call takes one face off the end.
void IndexSlots::closeHole()
{
  if (holes_.back() == faces_.size() - 1) {
    holes_.pop_back();
  } else {
    put(holes_[filled_++], faces_.back());
  }
  faces_.pop_back();
}

void IndexSlots::put(std::size_t place, std::uint32_t face)
{
  faces_[place] = face;
  if (face < places_.size()) {
    places_[face] = static_cast<std::uint32_t>(place);
  }
  if (!changed_.empty() && place <= changed_.back().end + GAP) {
    changed_.back().end = place + 1;
  } else {
    changed_.push_back({place, place + 1});
  }
}

/// Has a place in places_ for these faces (ascending).
void IndexSlots::makeRoom(const Faces& faces)
{
  const std::size_t length = faces.empty() ? 0 : std::size_t{faces.back()} + 1;
  if (places_.size() < length) {
    places_.resize(std::max(length, 2 * places_.size()), NO_PLACE);
  }
}

void IndexSlots::change(const Faces& added, const Faces& removed)
{
  if (places_.empty() && !faces_.empty()) {
    makeRoom({*std::max_element(faces_.begin(), faces_.end())});
    for (std::size_t place = 0; place < faces_.size(); ++place) {
      places_[faces_[place]] = static_cast<std::uint32_t>(place);
    }
  }
  makeRoom(added);
  makeRoom(removed);
  for (const std::uint32_t face : removed) {
    if (places_[face] != NO_PLACE) {
      holes_.push_back(std::exchange(places_[face], NO_PLACE));
    }
  }
  if (!std::is_sorted(holes_.begin(), holes_.end())) {  // many are in order already
    std::sort(holes_.begin(), holes_.end());
  }
  for (const std::uint32_t face : added) {
    if (places_[face] == NO_PLACE) {
      fill(face);
    }
  }
  while (filled_ < holes_.size()) {
    closeHole();
  }
  holes_.clear();
  filled_ = 0;
}

std::vector<IndexSlots::Range> IndexSlots::takeChanged()
{
  std::vector<Range> changed;
  changed.swap(changed_);
  while (!changed.empty() && changed.back().begin >= faces_.size()) {
    changed.pop_back();
  }
  if (!changed.empty()) {
    changed.back().end = std::min(changed.back().end, faces_.size());
  }
  return changed;
}

}  // namespace rviz_mesh_plugin
