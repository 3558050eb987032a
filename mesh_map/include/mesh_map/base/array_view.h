#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Stands for "no vertex, face or edge" in index arrays.
constexpr std::uint32_t NO_INDEX = 0xFFFFFFFFu;

/// Read-only view of a contiguous array that somebody else owns (C++17 has no std::span).
template <class T>
class ArrayView
{
 public:
  ArrayView() = default;
  ArrayView(const T* data, std::size_t size) : data_(data), size_(size) {}
  ArrayView(const std::vector<T>& values) : data_(values.data()), size_(values.size()) {}

  const T& operator[](std::size_t index) const { return data_[index]; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }

 private:
  const T* data_ = nullptr;
  std::size_t size_ = 0;
};

/// A triangle mesh as flat arrays: x, y, z per vertex and three vertex indices per face.
struct MeshView
{
  ArrayView<float> positions;
  ArrayView<std::uint32_t> faces;

  std::size_t vertexCount() const { return positions.size() / 3; }
  std::size_t faceCount() const { return faces.size() / 3; }

  /// The 3 coordinates of a vertex, and of corner k of a face.
  const float* vertex(std::size_t v) const { return positions.data() + 3 * v; }
  const float* corner(std::size_t face, std::size_t k) const { return vertex(faces[3 * face + k]); }
};

/// Adjacency in compressed rows: row i holds values[offsets[i]] to values[offsets[i + 1] - 1].
struct RowsView
{
  ArrayView<std::uint32_t> offsets;
  ArrayView<std::uint32_t> values;

  std::size_t rowCount() const { return offsets.empty() ? 0 : offsets.size() - 1; }
};

}  // namespace mesh_map
