#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rviz_mesh_plugin {

/// Finds the vertices of a layout that have their color from one vertex (or face) of the mesh: the
/// inverse of LayoutOutline::sources. Built in slices of a few milliseconds.
class SourceIndex
{
 public:
  /// @param sources has to outlive the index
  /// @param source_count all sources are below
  SourceIndex(const std::vector<std::uint32_t>& sources, std::size_t source_count);

  bool complete() const { return filled_ == sources_.size(); }
  void buildSlice();

  /// Appends the vertices of a source; none where it is not below source_count.
  void find(std::uint32_t source, std::vector<std::uint32_t>* vertices) const;

 private:
  const std::vector<std::uint32_t>& sources_;
  std::vector<std::uint32_t> starts_;  ///< of each source's run in vertices_
  std::vector<std::uint32_t> vertices_;
  std::size_t counted_ = 0;
  std::size_t filled_ = 0;
};

}  // namespace rviz_mesh_plugin
