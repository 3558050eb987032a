#ifndef MESH_MSGS_HDF5_SRC_CHUNK_GRID_H
#define MESH_MSGS_HDF5_SRC_CHUNK_GRID_H

#include <cstddef>
#include <vector>

namespace mesh_msgs_hdf5 {

/// The part of a chunk that is within the array: rows of items that lie side by side in the array
/// as well as in the chunk. Has at least one row, and room for no list of them: a file decides how
/// many there are.
class ChunkPart
{
 public:
  /// Where the present row begins, in items.
  std::size_t inArray() const { return in_array_; }
  std::size_t inChunk() const { return in_chunk_; }
  /// Items of each row.
  std::size_t rowItems() const { return row_items_; }

  /// Goes to the next row; false after the last one.
  bool advance();

 private:
  friend class ChunkGrid;

  /// One along which rows repeat.
  struct Axis
  {
    std::size_t count, array_step, chunk_step, index;
  };

  std::size_t in_array_ = 0, in_chunk_ = 0, row_items_ = 1;
  std::vector<Axis> axes_;  // the innermost first
};

/// How HDF5 divides an array (C order) into chunks: all have the same shape; those at the upper
/// edges reach beyond the array. Chunks are numbered in C order.
class ChunkGrid
{
 public:
  /// std::invalid_argument unless both shapes have the same rank (1 or more), no side of a chunk
  /// is 0, and a chunk has at most MOST_BYTES. The array itself has to exist: sizes derived from
  /// its shape are not checked for overflow.
  ChunkGrid(std::vector<std::size_t> shape, std::vector<std::size_t> chunk_shape,
            std::size_t item_size);

  std::size_t chunkCount() const { return chunk_count_; }
  std::size_t itemSize() const { return item_size_; }
  /// Items and bytes of a whole chunk.
  std::size_t chunkItems() const { return chunk_items_; }
  std::size_t chunkBytes() const { return chunk_items_ * item_size_; }

  /// The part of chunk number `chunk` (below chunkCount()) that is within the array.
  ChunkPart part(std::size_t chunk) const;

 private:
  std::vector<std::size_t> shape_, chunk_shape_, grid_shape_;
  std::size_t item_size_;
  std::size_t chunk_items_ = 1;
  std::size_t chunk_count_ = 1;
};

}  // namespace mesh_msgs_hdf5

#endif  // MESH_MSGS_HDF5_SRC_CHUNK_GRID_H
