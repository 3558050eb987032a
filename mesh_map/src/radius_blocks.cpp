#include "radius_blocks.h"

#include <mesh_map/parallel.h>

#include <memory>
#include <vector>

#include "radius_attributes.h"
#include "radius_block.h"
#include "radius_block_search.h"
#include "radius_grid.h"

namespace mesh_map {
namespace {

/// A thread's share of the cells.
class BlockWorker
{
 public:
  BlockWorker(const RadiusGrid& grid, const OrderedMesh& mesh, double radius, RadiusWriter writer)
      : grid_(grid), writer_(writer), radius_(radius), block_(mesh), search_(block_, radius)
  {
  }

  void work(std::size_t begin, std::size_t end)
  {
    for (std::size_t cell = begin; cell < end; ++cell) {
      around_.clear();
      grid_.around(cell, radius_, around_);
      block_.gather(around_);
      search_.begin();
      const auto [first, last] = grid_.cell(cell);
      for (std::uint32_t place = first; place < last; ++place) {
        const std::uint32_t center = block_.localOf(place);
        writer_.write(block_.attributes, center, search_.find(center), grid_.order()[place]);
      }
    }
  }

 private:
  const RadiusGrid& grid_;
  RadiusWriter writer_;
  double radius_;
  Block block_;
  BlockSearch search_;
  std::vector<RadiusGrid::Range> around_;
};

}  // namespace

void radiusStatisticsByGrid(const RadiusQuery& query, double cell_size, RadiusStatistics& results)
{
  constexpr std::size_t cells_per_chunk = 16;
  const RadiusGrid grid(query.positions, cell_size, query.threads);
  const OrderedMesh mesh = inOrderOf(grid, query);
  const RadiusWriter writer(query, results);
  parallelFor(grid.cellCount(), cells_per_chunk, query.threads, [&]() -> RangeBody {
    const auto worker = std::make_shared<BlockWorker>(grid, mesh, query.radius, writer);
    return [worker](std::size_t begin, std::size_t end) { worker->work(begin, end); };
  });
}

}  // namespace mesh_map
