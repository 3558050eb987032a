// Reading: libdeflate where it was found (twice as fast as zlib), else zlib. Not isa-l: files come
// from anywhere, and its decoder is assembly that no sanitizer sees.

#include <new>

#include "deflate/deflate.h"

#if defined(MESH_MSGS_HDF5_LIBDEFLATE)
#include <libdeflate.h>
#else
#include <zlib.h>
#endif

namespace mesh_msgs_hdf5 {

#if defined(MESH_MSGS_HDF5_LIBDEFLATE)

const char* const READING_LIBRARY = "libdeflate";

struct Inflater::State
{
  State() : decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor)
  {
    if (!decompressor) {
      throw std::bad_alloc();
    }
  }

  std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor;
};

Inflated Inflater::decompress(const std::uint8_t* input, std::size_t size, std::uint8_t* output,
                              std::size_t output_size)
{
  // Without a place for the size of the output, libdeflate takes exactly output_size bytes.
  switch (libdeflate_zlib_decompress(state_->decompressor.get(), input, size, output, output_size,
                                     nullptr)) {
    case LIBDEFLATE_SUCCESS:
      return Inflated::WHOLE;
    case LIBDEFLATE_SHORT_OUTPUT:
      return Inflated::TOO_SHORT;
    case LIBDEFLATE_INSUFFICIENT_SPACE:
      return Inflated::TOO_LONG;
    default:
      return Inflated::DAMAGED;
  }
}

#else

const char* const READING_LIBRARY = "zlib";

struct Inflater::State
{
  State()
  {
    if (inflateInit(&stream) != Z_OK) {
      throw std::bad_alloc();
    }
  }
  ~State() { inflateEnd(&stream); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  z_stream stream{};
};

Inflated Inflater::decompress(const std::uint8_t* input, std::size_t size, std::uint8_t* output,
                              std::size_t output_size)
{
  z_stream& stream = state_->stream;
  inflateReset(&stream);
  stream.next_in = const_cast<std::uint8_t*>(input);  // zlib does not write there
  stream.avail_in = static_cast<uInt>(size < MOST_BYTES ? size : MOST_BYTES);
  stream.next_out = output;
  stream.avail_out = static_cast<uInt>(output_size);
  const int code = inflate(&stream, Z_FINISH);
  if (code == Z_STREAM_END) {
    return stream.avail_out == 0 ? Inflated::WHOLE : Inflated::TOO_SHORT;
  }
  if (code != Z_BUF_ERROR) {
    return Inflated::DAMAGED;
  }
  // Out of room while there is input left, or out of input.
  return stream.avail_out == 0 && stream.avail_in > 0 ? Inflated::TOO_LONG : Inflated::DAMAGED;
}

#endif

Inflater::Inflater() : state_(std::make_unique<State>()) {}

Inflater::~Inflater() = default;

}  // namespace mesh_msgs_hdf5
