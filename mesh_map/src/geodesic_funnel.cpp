#include "geodesic_funnel.h"

#include <algorithm>

namespace mesh_map {
namespace {

constexpr std::size_t NONE = static_cast<std::size_t>(-1);

/// Angles below are rounding.
constexpr double STRAIGHT = 1e-12;

/// What can be seen so far: two taut strings from one apex, to the left and the right end of a
/// portal. They lie in one array: left end ... apex ... right end.
class Funnel
{
 public:
  explicit Funnel(std::size_t portal_count)
      : chain_(2 * portal_count + 5), begin_(portal_count + 2), end_(begin_), apex_(begin_)
  {
    points_.reserve(portal_count + 3);
    points_.push_back({{}, {NO_INDEX, 0, 0}, NONE});
  }

  void start(const Vector2& at)
  {
    points_[0].at = at;
    chain_[apex_] = 0;
  }

  void addLeft(const Vector2& at, const Bend& bend)
  {
    while (begin_ < end_ && isHiddenLeft(at)) {
      ++begin_;
      apex_ = std::max(apex_, begin_);
    }
    points_.push_back({at, bend, chain_[begin_]});
    chain_[--begin_] = points_.size() - 1;
  }

  void addRight(const Vector2& at, const Bend& bend)
  {
    while (begin_ < end_ && isHiddenRight(at)) {
      --end_;
      apex_ = std::min(apex_, end_);
    }
    points_.push_back({at, bend, chain_[end_]});
    chain_[++end_] = points_.size() - 1;
  }

  /// The ends of the two strings go on to the next portal.
  void keepLeft() { ++points_[chain_[begin_]].bend.last; }
  void keepRight() { ++points_[chain_[end_]].bend.last; }

  /// The bends on the way to what was added last.
  std::vector<Bend> way() const
  {
    std::vector<Bend> bends;
    for (std::size_t i = points_.back().before; i != 0; i = points_[i].before) {
      bends.push_back(points_[i].bend);
    }
    std::reverse(bends.begin(), bends.end());
    return bends;
  }

 private:
  struct Point
  {
    Vector2 at;
    Bend bend;
    std::size_t before;  // on the way here
  };

  const Vector2& at(std::size_t i) const { return points_[chain_[i]].at; }

  // Whether the way to a point leaves out the end of the string on its side.
  bool isHiddenLeft(const Vector2& point) const
  {
    const Vector2 &p = at(begin_), &q = at(begin_ + 1);
    return begin_ < apex_ ? turn(q, p, point) <= 0 : isPast(p, q, point, -1);
  }
  bool isHiddenRight(const Vector2& point) const
  {
    const Vector2 &p = at(end_), &q = at(end_ - 1);
    return end_ > apex_ ? turn(q, p, point) >= 0 : isPast(p, q, point, 1);
  }

  // Whether the way from p to a point leads around q, from where `side` (1 left, -1 right) of it is
  // hidden. What is straight beyond q is: a face without area may turn the next point right back.
  static bool isPast(const Vector2& p, const Vector2& q, const Vector2& point, int side)
  {
    const int turned = turn(p, q, point);
    return turned == side || (turned == 0 && dot(q - p, point - q) >= 0.0);
  }

  // Of the way from p over q: 1 to the left, -1 to the right, 0 straight on or back.
  static int turn(const Vector2& p, const Vector2& q, const Vector2& point)
  {
    const Vector2 a = q - p, b = point - q;
    const double sine = cross(a, b), least = STRAIGHT * STRAIGHT * dot(a, a) * dot(b, b);
    return sine * sine <= least ? 0 : sine > 0.0 ? 1 : -1;
  }

  std::vector<Point> points_;
  std::vector<std::size_t> chain_;
  std::size_t begin_, end_, apex_;
};

}  // namespace

std::vector<Bend> funnel(const Unfolding& strip)
{
  const std::vector<Portal>& portals = strip.portals;
  Funnel taut(portals.size());
  taut.start(strip.from);
  taut.addLeft(portals[0].at_left, {portals[0].left, 0, 0});
  taut.addRight(portals[0].at_right, {portals[0].right, 0, 0});
  for (std::size_t i = 1; i < portals.size(); ++i) {
    if (portals[i].left != portals[i - 1].left) {
      taut.keepRight();
      taut.addLeft(portals[i].at_left, {portals[i].left, i, i});
    } else {
      taut.keepLeft();
      taut.addRight(portals[i].at_right, {portals[i].right, i, i});
    }
  }
  taut.addLeft(strip.to, {NO_INDEX, portals.size(), portals.size()});
  return taut.way();
}

}  // namespace mesh_map
