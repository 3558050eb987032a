#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "distance/fast_marching/fast_marching_triangle.h"

namespace mesh_map {

/// Slowness at the ends of the base, and at the corner.
struct FastMarchingSlowness
{
  double u, v, corner;

  double onBase() const { return 0.5 * (u + v); }
};

/// The update where costs change within the faces: the least way over points of the base
/// (F. Bornemann, C. Rasch: Finite-Element Discretization of Static Hamilton-Jacobi Equations Based
/// on a Local Variational Principle, 2006). From the part t of the base, it takes the mean slowness
/// of that point and the corner. Labels between those at the ends of the base are either linear, or
/// distances from a source (theorem of Stewart): a front that bends may look as if its source were
/// right behind the base.
///
/// The least is found to rounding, so what follows is monotone in the labels. At the ends, it is
/// what comes along the edges.
///
/// Most of it is inlined where it is asked: else its numbers go through memory each time.
class FastMarchingUneven
{
 public:
  /// `round`: labels on the base are distances from a source. `low` is the least slowness.
  [[gnu::always_inline]] FastMarchingUneven(double u, double v,
                                            const FastMarchingTriangle& triangle,
                                            const FastMarchingSlowness& slowness, bool round,
                                            double low)
      : u_(u),
        v_(v),
        base_(triangle.base),
        along_(triangle.along),
        height_(triangle.height),
        squared_height_(height_ * height_),
        slowness_(0.5 * (slowness.u + slowness.corner)),
        rise_(0.5 * (slowness.v - slowness.u))
  {
    if (rise_ < 0.0) {
      std::swap(u_, v_);
      along_ = base_ - along_;
      slowness_ += rise_;
      rise_ = -rise_;
    }
    // What is later by more than the base takes gets a front along it.
    const double time = slowness.onBase() * base_;
    u_ = std::min(u_, v_ + time);
    v_ = std::min(v_, u_ + time);
    if (!round || height_ < FLAT * base_) {
      return;
    }
    const bool is_low = height_ < HIGH * base_;
    scale_ = is_low ? low : slowness.onBase();
    time_ = scale_ * base_;
    if (std::fabs(u_ - v_) < time_) {
      const bool is_near = is_low && std::min(u_, v_) < NEAR * time_;
      share_ = is_near ? SHARE : 0.0;
      labels_ = is_near || u_ + v_ < time_ ? KINKED : ROUND;
    }
  }

  /// The least that is not at an end. Infinite where there is none, or none below `label`.
  [[gnu::always_inline]] double least(double label = NOT_REACHED)
  {
    const double precise = PRECISE * (slowness_ + 0.5 * rise_) * height_;
    if (labels_ != KINKED && bendAt(0.0) >= 0.0) {
      if (labels_ == ROUND && isLeastAtEarlierEnd()) {
        return NOT_REACHED;
      }
      const double start = labels_ == ROUND ? startOfRound() : startOfStraight();
      return leastBetween(0.0, 1.0, start, precise, label);
    }
    return leastOfMany(precise);
  }

 private:
  /// As a part of the way beyond the base: what is as near to the least, is so by Newton's method.
  static constexpr double PRECISE = 1e-6;
  /// A corner is high over its base from this part of the base on. A low one is near to a source
  /// that seems to be on the base, and gets a label of almost nothing, and from it all that is
  /// beyond: so sources may only seem to be there that are as near by the least slowness, and no
  /// label on the base is below this share of the mean of its ends. Which cannot be where both are
  /// farther than this part of the base. Over flat ones, labels are linear.
  static constexpr double HIGH = 0.45, SHARE = 0.5, NEAR = 0.58, FLAT = 0.1;

  /// Between the ends of the base, labels are linear, distances from a source, or the same with
  /// what keeps them up.
  enum Labels
  {
    STRAIGHT,
    ROUND,
    KINKED
  };

  /// A way through a point of the base, and how it changes along the base.
  struct Through
  {
    double time, slope, bend;
  };

  [[gnu::always_inline]] Through at(double t) const
  {
    const double x = t * base_ - along_;
    const double length = std::max(std::sqrt(x * x + squared_height_), 1e-300);
    const double inverse = 1.0 / length;
    const double slow = slowness_ + rise_ * t, turn = base_ * x * inverse;
    Through way = {slow * length, rise_ * length + slow * turn,
                   2.0 * rise_ * turn + slow * (base_ * base_ - turn * turn) * inverse};
    if (labels_ == STRAIGHT) {
      way.time += u_ + (v_ - u_) * t;
      way.slope += v_ - u_;
      return way;
    }
    const double squared = u_ * u_ * (1.0 - t) + v_ * v_ * t - time_ * time_ * t * (1.0 - t);
    double label = std::sqrt(std::max(0.0, squared)), slope = t < 0.5 ? time_ : -time_;
    if (label > 0.0) {  // else the source is at an end
      const double inverse_label = 1.0 / label;
      slope = 0.5 * ((v_ - u_) * (v_ + u_) - time_ * time_ * (1.0 - 2.0 * t)) * inverse_label;
      way.bend += std::max(0.0, time_ * time_ - slope * slope) * inverse_label;
    }
    if (labels_ == KINKED) {
      way.bend = 0.0;  // of no use
      if (u_ + v_ < time_) {
        const double to_first = u_ - time_ * t, to_last = v_ - time_ * (1.0 - t);
        label = std::max(0.0, std::max(to_first, to_last));
        slope = to_first > 0.0 ? -time_ : to_last > 0.0 ? time_ : 0.0;
      }
      const double least = share_ * (u_ + (v_ - u_) * t);
      slope = label < least ? share_ * (v_ - u_) : slope;
      label = std::max(label, least);
    }
    way.time += label;
    way.slope += slope;
    return way;
  }

  /// Has the sign of the second derivative of the way beyond the base: grows along it.
  double bendAt(double t) const
  {
    const double x = t * base_ - along_;
    return 2.0 * rise_ * x * (x * x + squared_height_) +
           (slowness_ + rise_ * t) * base_ * squared_height_;
  }

  /// Do ways through round labels, convex along the base, become longer from its earlier end on?
  bool isLeastAtEarlierEnd() const
  {
    const bool is_first = u_ < v_;
    const double early = is_first ? u_ : v_, late = is_first ? v_ : u_;
    const double x = is_first ? along_ : base_ - along_, squared = x * x + squared_height_;
    const double slow = is_first ? slowness_ : slowness_ + rise_;
    const double rise = is_first ? rise_ : -rise_;
    // The slope there is (labels / early + way / length) with the length of the way as square root.
    const double labels = 0.5 * ((late - early) * (late + early) - time_ * time_);
    const double way = early * (rise * squared - slow * base_ * x);
    const double difference = way * std::fabs(way) + labels * std::fabs(labels) * squared;
    return difference > 0.0;
  }

  double beginOfConvex() const
  {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 24; ++i) {
      const double middle = 0.5 * (low + high);
      (bendAt(middle) < 0.0 ? low : high) = middle;
    }
    return high;
  }

  /// Where the straight way from the source crosses the base.
  double startOfRound() const
  {
    // Times twice the base: less is divided.
    const double longest = 2.0 * time_ * u_, foot = time_ * time_ + (u_ - v_) * (u_ + v_);
    const double depth = std::sqrt(std::max(0.0, (longest - foot) * (longest + foot)));
    const double height = scale_ * height_, sum = time_ * (depth + 2.0 * time_ * height);
    return sum > 0.0 ? (foot * height + scale_ * along_ * depth) / sum : 0.5;
  }

  /// The same of a straight front, with the slowness of the middle.
  double startOfStraight() const
  {
    const double part = (u_ - v_) / ((slowness_ + 0.5 * rise_) * base_);
    const double off = 1.0 - part * part;
    return off > 0.0 ? (along_ + part * height_ / std::sqrt(off)) / base_ : part > 0.0 ? 1.0 : 0.0;
  }

  /// Newton's method, kept within what is known. `start` may be anywhere.
  double leastBetween(double first, double last, double start, double precise,
                      double label = NOT_REACHED) const
  {
    double low = first, high = last;
    bool is_low_known = false, is_high_known = false;
    const bool is_bounded = label < NOT_REACHED;  // then this is convex, and above its tangents
    double t =
        std::min(std::max(start, first + 0.02 * (last - first)), last - 0.02 * (last - first));
    for (int i = 0; i < 100 && high - low > 1e-15; ++i) {
      const Through way = at(t);
      const double most = way.slope < 0.0 ? high - t : t - low;
      if (is_bounded && way.time - std::fabs(way.slope) * most >= label) {
        return NOT_REACHED;
      }
      const double step = way.slope / way.bend, excess = 0.5 * way.slope * step;
      if (way.bend > 0.0 && excess <= precise) {
        return way.time - excess;
      }
      (way.slope < 0.0 ? low : high) = t;
      const double next = way.bend > 0.0 ? t - step : 0.5 * (low + high);
      if (way.slope < 0.0) {
        is_low_known = true;
        if (next >= high && !is_high_known) {
          if (at(high).slope <= 0.0) {
            return NOT_REACHED;
          }
          is_high_known = true;
        }
      } else {
        is_high_known = true;
        if (next <= low && !is_low_known) {
          if (at(low).slope >= 0.0) {
            return NOT_REACHED;
          }
          is_low_known = true;
        }
      }
      t = next > low && next < high ? next : 0.5 * (low + high);
    }
    return at(t).time;
  }

  /// Where slowness changes a lot along a thin triangle, ways beyond the base are convex behind
  /// some point only. Before it, labels that are distances may leave more than one least.
  [[gnu::noinline]] double leastOfMany(double precise) const
  {
    if (labels_ == STRAIGHT) {
      if (at(1.0).slope <= 0.0) {
        return NOT_REACHED;
      }
      if (at(0.0).slope < 0.0) {
        return leastBetween(0.0, 1.0, startOfStraight(), precise);
      }
    }
    const int parts = labels_ == STRAIGHT ? 1 : 8;
    const double convex = labels_ == KINKED ? 1.0 : beginOfConvex();
    double best = NOT_REACHED, last = 0.0;
    bool falls = at(0.0).slope < 0.0;
    for (int i = 1; i <= parts + 1; ++i) {
      const double next = i > parts ? 1.0 : i * convex / parts;
      const bool falls_next = at(next).slope < 0.0;
      if (falls && !falls_next) {
        best = std::min(best, leastBetween(last, next, 0.5 * (last + next), precise));
      }
      falls = falls_next;
      last = next;
    }
    return best;
  }

  double u_, v_, base_, along_, height_, squared_height_, slowness_, rise_;
  double scale_ = 0.0, time_ = 0.0, share_ = 0.0;
  Labels labels_ = STRAIGHT;
};

}  // namespace mesh_map
