#include "deflate/chunk_grid.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "deflate/deflate.h"

namespace mesh_msgs_hdf5 {

bool ChunkPart::advance()
{
  for (Axis& axis : axes_) {
    in_array_ += axis.array_step;
    in_chunk_ += axis.chunk_step;
    if (++axis.index < axis.count) {
      return true;
    }
    in_array_ -= axis.count * axis.array_step;
    in_chunk_ -= axis.count * axis.chunk_step;
    axis.index = 0;
  }
  return false;
}

ChunkGrid::ChunkGrid(std::vector<std::size_t> shape, std::vector<std::size_t> chunk_shape,
                     std::size_t item_size)
    : shape_(std::move(shape)), chunk_shape_(std::move(chunk_shape)), item_size_(item_size)
{
  if (shape_.empty() || shape_.size() != chunk_shape_.size()) {
    throw std::invalid_argument("an array and its chunks need the same rank, 1 or more");
  }
  for (std::size_t axis = 0; axis < shape_.size(); ++axis) {
    const std::size_t side = chunk_shape_[axis];
    if (side == 0 || item_size_ == 0 || side > MOST_BYTES / item_size_ / chunk_items_) {
      throw std::invalid_argument("a chunk is empty or larger than HDF5 allows");
    }
    chunk_items_ *= side;
    grid_shape_.push_back(shape_[axis] / side + (shape_[axis] % side > 0 ? 1 : 0));
    chunk_count_ *= grid_shape_[axis];
  }
}

ChunkPart ChunkGrid::part(std::size_t chunk) const
{
  ChunkPart part;
  std::size_t array_step = 1, chunk_step = 1;
  bool joined = true;  // rows follow each other without a gap, in the array and in the chunk
  for (std::size_t axis = shape_.size(); axis-- > 0;) {
    const std::size_t start = chunk % grid_shape_[axis] * chunk_shape_[axis];
    const std::size_t count = std::min(chunk_shape_[axis], shape_[axis] - start);
    chunk /= grid_shape_[axis];
    part.in_array_ += start * array_step;
    if (joined) {
      part.row_items_ *= count;
    } else if (count > 1) {
      part.axes_.push_back({count, array_step, chunk_step, 0});
    }
    joined = joined && chunk_shape_[axis] == shape_[axis];
    array_step *= shape_[axis];
    chunk_step *= chunk_shape_[axis];
  }
  return part;
}

}  // namespace mesh_msgs_hdf5
