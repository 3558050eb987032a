#ifndef MESH_MSGS_HDF5_SRC_DEFLATE_H
#define MESH_MSGS_HDF5_SRC_DEFLATE_H

#include <cstddef>
#include <cstdint>
#include <memory>

namespace mesh_msgs_hdf5 {

/// The libraries that this was built with, for reports: "isa-l", "libdeflate" or "zlib".
extern const char* const WRITING_LIBRARY;
extern const char* const READING_LIBRARY;

/// Most bytes of a block; HDF5 allows no larger chunk, and 32 bits hold its compressed size.
constexpr std::size_t MOST_BYTES = 0xF0000000u;

/// Compresses blocks of bytes into the zlib format (RFC 1950), fast rather than small. For one
/// thread at a time: it owns the memory that the library works in.
class Deflater
{
 public:
  Deflater();
  ~Deflater();
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  /// Room that compress() may need for this many bytes.
  static std::size_t bound(std::size_t size);

  /// Compresses `size` bytes (at most MOST_BYTES) into `output`, which has room for bound(size);
  /// returns how many bytes were written. std::runtime_error if the library fails.
  std::size_t compress(const std::uint8_t* input, std::size_t size, std::uint8_t* output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

enum class Inflated
{
  WHOLE,      ///< exactly as many bytes as asked for, and the checksum is right
  TOO_SHORT,  ///< the stream ends before that
  TOO_LONG,   ///< the stream goes on after that
  DAMAGED     ///< no zlib stream, or its checksum is wrong
};

/// Decompresses blocks in the zlib format from any source. For one thread at a time.
class Inflater
{
 public:
  Inflater();
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Fills `output` with `output_size` bytes (at most MOST_BYTES), never more. What follows the
  /// stream in `input` is ignored, as HDF5 does. If the result is not WHOLE, the content of
  /// `output` is undefined.
  Inflated decompress(const std::uint8_t* input, std::size_t size, std::uint8_t* output,
                      std::size_t output_size);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mesh_msgs_hdf5

#endif  // MESH_MSGS_HDF5_SRC_DEFLATE_H
