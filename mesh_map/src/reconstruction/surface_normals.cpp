#include "reconstruction/surface_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/require.h"
#include "base/vector3.h"

namespace mesh_map {
namespace {

constexpr float FEWEST = 5;         // points; fewer say nothing
constexpr float GROWN = 1.125f;     // more points than before by which a normal is computed anew
constexpr double ROUGHNESS = 10.0;  // 1 / of the ratio of variances at which nothing is flat
constexpr double SMALLEST = 0.04;   // variance along the surface in cells^2 from which it counts
constexpr std::size_t POINTS = 4096, CHUNK = 32;  // points and cells that a thread takes at a time

/// The eigenvector of the least eigenvalue of a symmetric matrix (xx, xy, xz, yy, yz, zz), and the
/// eigenvalues in ascending order: O. Smith, Eigenvalues of a symmetric 3 x 3 matrix (1961); the
/// vector is at right angles to two rows of what is left without its eigenvalue.
struct Least
{
  Vector3 vector;
  std::array<double, 3> values;
};

Least leastEigenvector(const std::array<double, 6>& m)
{
  const double mean = (m[0] + m[3] + m[5]) / 3;
  const double a = m[0] - mean, b = m[3] - mean, c = m[5] - mean;
  const double off = m[1] * m[1] + m[2] * m[2] + m[4] * m[4];
  const double p = std::sqrt((a * a + b * b + c * c + 2 * off) / 6);
  Least least{{0, 0, 0}, {mean, mean, mean}};
  if (!(p > 0)) {
    return least;
  }
  const double determinant =
      a * (b * c - m[4] * m[4]) - m[1] * (m[1] * c - m[4] * m[2]) + m[2] * (m[1] * m[4] - b * m[2]);
  const double angle = std::acos(std::clamp(determinant / (2 * p * p * p), -1.0, 1.0)) / 3;
  least.values[2] = mean + 2 * p * std::cos(angle);
  least.values[0] = mean + 2 * p * std::cos(angle + 2 * PI / 3);
  least.values[1] = 3 * mean - least.values[0] - least.values[2];

  const double low = least.values[0];
  const std::array<Vector3, 3> rows = {Vector3{m[0] - low, m[1], m[2]},
                                       Vector3{m[1], m[3] - low, m[4]},
                                       Vector3{m[2], m[4], m[5] - low}};
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 candidate = cross(rows[i], rows[(i + 1) % 3]);
    const double length = norm(candidate);
    if (length > longest) {
      longest = length;
      least.vector = candidate / length;
    }
  }
  return least;
}

}  // namespace

std::vector<std::uint32_t> SurfaceNormals::add(ArrayView<float> points,
                                               ArrayView<std::uint8_t> is_used, Run& run)
{
  const std::vector<std::uint32_t> cells = cellsOf(points, is_used, run);
  try {
    addSums(points, cells, run);
  } catch (...) {  // canceled: cells that were listed are to be listed again
    for (const std::uint32_t cell : cells) {
      if (cell != NO_CELL && cells_[cell].count_before < 0) {
        cells_[cell].count_before = 0;
      }
    }
    throw;
  }
  return cells;
}

void SurfaceNormals::addSums(ArrayView<float> points, const std::vector<std::uint32_t>& cells,
                             Run& run)
{
  // Each thread sums up cells of its own, in the order of their points.
  std::vector<std::vector<std::uint32_t>> stale(run.threads());
  run.each(stale.size(), 1, 0.0, [&](std::size_t part) {
    std::vector<std::uint32_t> own;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i] == NO_CELL || cells[i] / CHUNK % stale.size() != part) {
        continue;
      }
      Cell& sums = cells_[cells[i]];
      sums.add(fromMiddle(points.data() + 3 * i));
      if (sums.count_before >= 0 && sums.count > std::max(FEWEST, GROWN * sums.count_before)) {
        sums.count_before = -1;  // in the list
        own.push_back(cells[i]);
      }
    }
    stale[part] = std::move(own);
  });
  std::vector<std::uint32_t> anew;
  for (const auto& part : stale) {
    anew.insert(anew.end(), part.begin(), part.end());
  }
  run.each(anew.size(), CHUNK, 0.0, [this, &anew](std::size_t i) {
    Cell& cell = cells_[anew[i]];
    cell.normal = normalOf(anew[i]);
    cell.count_before = cell.count;
  });
}

/// New ones are numbered in the order of their points.
std::vector<std::uint32_t> SurfaceNormals::cellsOf(ArrayView<float> points,
                                                   ArrayView<std::uint8_t> is_used, Run& run)
{
  std::vector<std::uint32_t> cells(is_used.size());
  run.each(cells.size(), POINTS, 0.0, [&](std::size_t i) {
    cells[i] = is_used[i] != 0 ? index_.find(placeOf(points.data() + 3 * i).key()) : NO_CELL;
  });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] == NO_CELL && is_used[i] != 0) {
      cells[i] = index_.add(placeOf(points.data() + 3 * i).key());
      if (cells[i] == cells_.size()) {
        cells_.emplace_back();
      }
    }
  }
  return cells;
}

GridPlace SurfaceNormals::placeOf(const float* point) const
{
  const auto cellOf = [this](float at) {
    return static_cast<std::int32_t>(std::floor(at * per_meter_));
  };
  return {cellOf(point[0]), cellOf(point[1]), cellOf(point[2])};
}

/// Of the point's cell, in cells.
std::array<float, 3> SurfaceNormals::fromMiddle(const float* point) const
{
  std::array<float, 3> from;
  for (std::size_t k = 0; k < 3; ++k) {
    const float at = point[k] * per_meter_;
    from[k] = at - std::floor(at) - 0.5f;
  }
  return from;
}

void SurfaceNormals::Cell::add(const std::array<float, 3>& from_middle)
{
  const auto& [x, y, z] = from_middle;
  count += 1;
  sum[0] += x;
  sum[1] += y;
  sum[2] += z;
  const std::array<float, 6> products = {x * x, x * y, x * z, y * y, y * z, z * z};
  for (std::size_t k = 0; k < products.size(); ++k) {
    square[k] += products[k];
  }
}

std::vector<float> SurfaceNormals::numbers() const
{
  std::vector<float> all(cells_.size() * NUMBERS);
  if (!cells_.empty()) {
    std::memcpy(all.data(), cells_.data(), all.size() * sizeof(float));
  }
  return all;
}

void SurfaceNormals::restore(ArrayView<std::uint64_t> keys, ArrayView<float> numbers)
{
  require(numbers.size() == keys.size() * NUMBERS, "cells have other numbers than keys");
  index_ = KeyIndex();
  for (const std::uint64_t key : keys) {
    index_.add(key);
  }
  require(index_.size() == keys.size(), "two cells have one key");
  cells_.assign(keys.size(), Cell());
  if (!keys.empty()) {
    std::memcpy(static_cast<void*>(cells_.data()), numbers.data(), numbers.size() * sizeof(float));
  }
}

PointNormal SurfaceNormals::normalOf(std::uint32_t cell) const
{
  constexpr std::array<double, 4> WEIGHTS = {1.0, 0.5, 0.25, 0.125};  // middle to corners
  const GridPlace place = GridPlace::of(index_.keys()[cell]);
  double count = 0;
  Vector3 sum = {0, 0, 0};
  std::array<double, 6> square{};
  for (std::int32_t z = -1; z <= 1; ++z) {
    for (std::int32_t y = -1; y <= 1; ++y) {
      for (std::int32_t x = -1; x <= 1; ++x) {
        const GridPlace beside = place + GridPlace{x, y, z};
        const std::uint32_t number = beside.isInside() ? index_.find(beside.key()) : KeyIndex::NONE;
        if (number == KeyIndex::NONE) {
          continue;
        }
        const Cell& one = cells_[number];
        const double weight = WEIGHTS[static_cast<std::size_t>(x * x + y * y + z * z)];
        const double n = weight * one.count;
        const Vector3 shift = {double(x), double(y), double(z)};
        const Vector3 s = weight * Vector3{one.sum[0], one.sum[1], one.sum[2]};
        count += n;
        sum = sum + s + n * shift;
        std::size_t k = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t j = i; j < 3; ++j, ++k) {
            square[k] += weight * one.square[k] + s[i] * shift[j] + s[j] * shift[i] +
                         n * shift[i] * shift[j];
          }
        }
      }
    }
  }
  const Vector3 mean = sum / count;
  std::array<double, 6> covariance;
  std::size_t k = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j, ++k) {
      covariance[k] = square[k] / count - mean[i] * mean[j];
    }
  }
  const Least least = leastEigenvector(covariance);
  if (!(least.values[1] > SMALLEST)) {
    return {};
  }
  const double ratio = std::max(least.values[0], 0.0) / least.values[1];
  const double flatness = std::max(0.0, 1 - ROUGHNESS * ratio);
  return {static_cast<float>(least.vector[0]), static_cast<float>(least.vector[1]),
          static_cast<float>(least.vector[2]), static_cast<float>(flatness)};
}

}  // namespace mesh_map
