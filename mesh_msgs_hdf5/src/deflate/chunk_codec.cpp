#include "deflate/chunk_codec.h"

#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "deflate/deflate.h"
#include "deflate/parallel.h"
#include "deflate/shuffle.h"

namespace mesh_msgs_hdf5 {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// True if the whole chunk lies in the array as it lies in the file, byte for byte.
bool isInPlace(const ChunkGrid& grid, const ChunkPart& part, bool shuffled)
{
  return part.rowItems() == grid.chunkItems() && (!shuffled || grid.itemSize() == 1);
}

/// Compresses the chunks of an array, one at a time.
class Writer
{
 public:
  Writer(const ChunkGrid& grid, const std::uint8_t* array, bool shuffled)
      : grid_(grid), array_(array), shuffled_(shuffled), output_(Deflater::bound(grid.chunkBytes()))
  {
  }

  Bytes compress(std::size_t chunk)
  {
    ChunkPart part = grid_.part(chunk);
    const std::size_t item = grid_.itemSize();
    const std::uint8_t* input = array_ + part.inArray() * item;
    if (!isInPlace(grid_, part, shuffled_)) {
      scratch_.assign(grid_.chunkBytes(), 0);
      do {
        const std::uint8_t* const from = array_ + part.inArray() * item;
        if (shuffled_) {
          shuffle(from, part.rowItems(), item, scratch_.data() + part.inChunk(),
                  grid_.chunkItems());
        } else {
          std::memcpy(scratch_.data() + part.inChunk() * item, from, part.rowItems() * item);
        }
      } while (part.advance());
      input = scratch_.data();
    }
    const std::size_t size = deflater_.compress(input, grid_.chunkBytes(), output_.data());
    return Bytes(output_.data(), output_.data() + size);
  }

 private:
  const ChunkGrid& grid_;
  const std::uint8_t* array_;
  bool shuffled_;
  Deflater deflater_;
  Bytes scratch_, output_;
};

/// Decompresses chunks into an array, one at a time.
class Reader
{
 public:
  Reader(const ChunkGrid& grid, std::uint8_t* array) : grid_(grid), array_(array) {}

  void decompress(const StoredChunk& stored, std::size_t chunk)
  {
    ChunkPart part = grid_.part(chunk);
    const std::size_t item = grid_.itemSize();
    if (isInPlace(grid_, part, stored.shuffled)) {
      unpack(stored, chunk, array_ + part.inArray() * item);
      return;
    }
    scratch_.resize(grid_.chunkBytes());
    unpack(stored, chunk, scratch_.data());
    do {
      std::uint8_t* const to = array_ + part.inArray() * item;
      if (stored.shuffled) {
        unshuffle(scratch_.data() + part.inChunk(), grid_.chunkItems(), part.rowItems(), item, to);
      } else {
        std::memcpy(to, scratch_.data() + part.inChunk() * item, part.rowItems() * item);
      }
    } while (part.advance());
  }

 private:
  void unpack(const StoredChunk& stored, std::size_t chunk, std::uint8_t* output)
  {
    const std::size_t size = grid_.chunkBytes();
    Inflated result = Inflated::WHOLE;
    if (stored.deflated) {
      result = inflater_.decompress(stored.data, stored.size, output, size);
    } else if (stored.size != size) {
      result = stored.size < size ? Inflated::TOO_SHORT : Inflated::TOO_LONG;
    } else {
      std::memcpy(output, stored.data, size);
    }
    if (result != Inflated::WHOLE) {
      const std::string bytes = std::to_string(size) + " bytes";
      throw std::runtime_error("chunk " + std::to_string(chunk) +
                               (result == Inflated::TOO_SHORT ? " holds less than its " + bytes
                                : result == Inflated::TOO_LONG
                                    ? " holds more than its " + bytes
                                    : " is damaged: its checksum or stream is wrong"));
    }
  }

  const ChunkGrid& grid_;
  std::uint8_t* array_;
  Inflater inflater_;
  Bytes scratch_;
};

}  // namespace

std::vector<Bytes> compressChunks(const ChunkGrid& grid, const std::uint8_t* array, bool shuffled,
                                  std::size_t first, std::size_t count, unsigned threads)
{
  std::vector<Bytes> result(count);
  forEach(count, threads, [&]() {
    return [&result, first, writer = std::make_unique<Writer>(grid, array, shuffled)](
               std::size_t i) { result[i] = writer->compress(first + i); };
  });
  return result;
}

void decompressChunks(const ChunkGrid& grid, const std::vector<StoredChunk>& chunks,
                      std::size_t first, std::uint8_t* array, unsigned threads)
{
  forEach(chunks.size(), threads, [&]() {
    return [&chunks, first, reader = std::make_unique<Reader>(grid, array)](std::size_t i) {
      reader->decompress(chunks[i], first + i);
    };
  });
}

}  // namespace mesh_msgs_hdf5
