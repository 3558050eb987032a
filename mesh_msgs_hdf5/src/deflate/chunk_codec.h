#ifndef MESH_MSGS_HDF5_SRC_CHUNK_CODEC_H
#define MESH_MSGS_HDF5_SRC_CHUNK_CODEC_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "deflate/chunk_grid.h"

namespace mesh_msgs_hdf5 {

/// Compresses chunks first, first + 1, ... of an array, `count` of them: shuffled if wanted, padded
/// with zeros at the upper edges, in the zlib format. On `threads` threads (0 = all cores).
std::vector<std::vector<std::uint8_t>> compressChunks(const ChunkGrid& grid,
                                                      const std::uint8_t* array, bool shuffled,
                                                      std::size_t first, std::size_t count,
                                                      unsigned threads);

/// A chunk as it lies in a file, of any content, and the filters that it went through.
struct StoredChunk
{
  const std::uint8_t* data;
  std::size_t size;
  bool shuffled;
  bool deflated;
};

/// Reverses compressChunks for chunks first, first + 1, ... of an array. Never writes outside of
/// it. std::runtime_error that names a chunk which does not hold exactly its bytes or has a wrong
/// checksum; then the content of the array is undefined.
void decompressChunks(const ChunkGrid& grid, const std::vector<StoredChunk>& chunks,
                      std::size_t first, std::uint8_t* array, unsigned threads);

}  // namespace mesh_msgs_hdf5

#endif  // MESH_MSGS_HDF5_SRC_CHUNK_CODEC_H
