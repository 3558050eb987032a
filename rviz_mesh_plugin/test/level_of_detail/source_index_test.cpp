#include "level_of_detail/source_index.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

using rviz_mesh_plugin::SourceIndex;

namespace {

std::vector<std::uint32_t> find(const SourceIndex& index, std::uint32_t source)
{
  std::vector<std::uint32_t> vertices;
  index.find(source, &vertices);
  return vertices;
}

std::size_t build(SourceIndex& index)
{
  std::size_t slices = 0;
  for (; !index.complete(); ++slices) {
    index.buildSlice();
  }
  return slices;
}

}  // namespace

TEST(SourceIndex, finds_all_vertices_of_each_source_in_ascending_order)
{
  std::mt19937 random(1);
  for (const std::size_t count : {1u, 2u, 7u, 1000u}) {
    std::vector<std::uint32_t> sources(3 * count);
    for (auto& source : sources) {
      source = random() % count;
    }
    SourceIndex index(sources, count);
    build(index);
    for (std::uint32_t source = 0; source < count; ++source) {
      std::vector<std::uint32_t> expected;
      for (std::uint32_t vertex = 0; vertex < sources.size(); ++vertex) {
        if (sources[vertex] == source) {
          expected.push_back(vertex);
        }
      }
      ASSERT_EQ(find(index, source), expected) << source << " of " << count;
    }
  }
}

TEST(SourceIndex, knows_nothing_of_sources_beyond_the_mesh)
{
  const std::vector<std::uint32_t> sources{2, 0, 1};
  SourceIndex index(sources, 3);
  build(index);
  EXPECT_EQ(find(index, 2), std::vector<std::uint32_t>{0});
  for (const std::uint32_t source : {3u, 4u, 0x7FFFFFFFu, 0xFFFFFFFEu, 0xFFFFFFFFu}) {
    EXPECT_TRUE(find(index, source).empty()) << source;
  }
}

TEST(SourceIndex, an_empty_layout_needs_no_work)
{
  const std::vector<std::uint32_t> sources;
  SourceIndex index(sources, 0);
  EXPECT_TRUE(index.complete());
  EXPECT_TRUE(find(index, 0).empty());
}

TEST(SourceIndex, large_ones_are_built_in_slices)
{
  std::vector<std::uint32_t> sources(1200000);
  for (std::uint32_t vertex = 0; vertex < sources.size(); ++vertex) {
    sources[vertex] = static_cast<std::uint32_t>(sources.size()) - 1 - vertex;
  }
  SourceIndex index(sources, sources.size());
  EXPECT_EQ(build(index), 6u);
  for (const std::uint32_t source : {0u, 499999u, 500000u, 1199999u}) {
    EXPECT_EQ(find(index, source), std::vector<std::uint32_t>{1199999 - source});
  }
}
