// mesh_msgs_hdf5._deflate: HDF5's filters shuffle and deflate for many whole chunks at a time, on
// all cores. Private: mesh_msgs_hdf5.map_file.hdf5.chunks stores and loads with it. Arguments are
// checked here (ValueError), and the GIL is released while threads work.
//
// Writing: isa-l where it was found (four times as fast as libdeflate and ten times as zlib on
// shuffled floats, for files 4 % larger), else libdeflate, else zlib; each at the level that was
// the best deal. Reading: libdeflate where it was found (twice as fast as zlib), else zlib. Not
// isa-l: files come from anywhere, and its decoder is assembly that no sanitizer sees.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <tuple>
#include <vector>

#if defined(MESH_MSGS_HDF5_ISAL)
#include <isa-l/igzip_lib.h>
#endif
#if defined(MESH_MSGS_HDF5_LIBDEFLATE)
#include <libdeflate.h>
#else
#include <zlib.h>
#endif

namespace mesh_msgs_hdf5 {
namespace {

namespace py = pybind11;

/// Most bytes of a chunk; HDF5 allows no larger one, and 32 bits hold its compressed size.
constexpr std::size_t MOST_BYTES = 0xF0000000u;

/// Threads at most, whatever the machine has: beyond that, memory is the limit.
constexpr std::size_t MOST_THREADS = 8;

/// Memory that is not set to zero first.
struct Bytes
{
  Bytes() = default;
  explicit Bytes(std::size_t room) : data(new std::uint8_t[room]) {}

  std::unique_ptr<std::uint8_t[]> data;
  std::size_t size = 0;  ///< of what was written
};

[[noreturn]] void fail(const char* library)
{
  throw std::runtime_error(std::string(library) + " cannot compress a chunk");
}

// Each library has deflate(): `size` bytes (at most MOST_BYTES) in the zlib format (RFC 1950).
// std::runtime_error if the library fails.

#if defined(MESH_MSGS_HDF5_ISAL)

Bytes deflate(const std::uint8_t* input, std::size_t size)
{
  // Where a block does not shrink it is stored, with 5 bytes before each 64 KiB of it.
  const std::size_t bound = size + size / 1024 + 1024;
  Bytes output(bound);
  const Bytes level_memory(ISAL_DEF_LVL2_EXTRA_LARGE);
  isal_zstream stream;
  isal_deflate_stateless_init(&stream);
  stream.level = 2;
  stream.level_buf = level_memory.data.get();
  stream.level_buf_size = ISAL_DEF_LVL2_EXTRA_LARGE;
  stream.gzip_flag = IGZIP_ZLIB;
  stream.flush = NO_FLUSH;
  stream.end_of_stream = 1;
  stream.next_in = const_cast<std::uint8_t*>(input);  // isa-l does not write there
  stream.avail_in = static_cast<std::uint32_t>(size);
  stream.next_out = output.data.get();
  stream.avail_out = static_cast<std::uint32_t>(bound);
  if (isal_deflate_stateless(&stream) != COMP_OK || stream.avail_in != 0) {
    fail("isa-l");
  }
  output.size = stream.total_out;
  return output;
}

#elif defined(MESH_MSGS_HDF5_LIBDEFLATE)

Bytes deflate(const std::uint8_t* input, std::size_t size)
{
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(1), &libdeflate_free_compressor);
  if (!compressor) {
    throw std::bad_alloc();
  }
  const std::size_t bound = libdeflate_zlib_compress_bound(compressor.get(), size);
  Bytes output(bound);
  output.size = libdeflate_zlib_compress(compressor.get(), input, size, output.data.get(), bound);
  if (output.size == 0) {
    fail("libdeflate");
  }
  return output;
}

#else

Bytes deflate(const std::uint8_t* input, std::size_t size)
{
  uLongf written = compressBound(size);
  Bytes output(written);
  if (compress2(output.data.get(), &written, input, size, 1) != Z_OK) {
    fail("zlib");
  }
  output.size = written;
  return output;
}

#endif

enum class Inflated
{
  WHOLE,      ///< exactly as many bytes as asked for, and the checksum is right
  TOO_SHORT,  ///< the stream ends before that
  TOO_LONG,   ///< the stream goes on after that
  DAMAGED     ///< no zlib stream, or its checksum is wrong
};

// Each library has inflate(): fills `output` with `output_size` bytes, never more, from a stream in
// the zlib format from any source. What follows the stream in `input` is ignored, as HDF5 does. If
// the result is not WHOLE, the content of `output` is undefined.

#if defined(MESH_MSGS_HDF5_LIBDEFLATE)

Inflated inflate(const std::uint8_t* input, std::size_t size, std::uint8_t* output,
                 std::size_t output_size)
{
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!decompressor) {
    throw std::bad_alloc();
  }
  // Without a place for the size of the output, libdeflate takes exactly output_size bytes.
  switch (
      libdeflate_zlib_decompress(decompressor.get(), input, size, output, output_size, nullptr)) {
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

Inflated inflate(const std::uint8_t* input, std::size_t size, std::uint8_t* output,
                 std::size_t output_size)
{
  z_stream stream{};
  stream.next_in = const_cast<std::uint8_t*>(input);  // zlib does not write there
  stream.avail_in = static_cast<uInt>(std::min(size, MOST_BYTES));
  stream.next_out = output;
  stream.avail_out = static_cast<uInt>(output_size);
  if (inflateInit(&stream) != Z_OK) {
    throw std::bad_alloc();
  }
  const int code = ::inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  if (code == Z_STREAM_END) {
    return stream.avail_out == 0 ? Inflated::WHOLE : Inflated::TOO_SHORT;
  }
  // Out of room while there is input left, or out of input.
  const bool too_long = code == Z_BUF_ERROR && stream.avail_out == 0 && stream.avail_in > 0;
  return too_long ? Inflated::TOO_LONG : Inflated::DAMAGED;
}

#endif

// HDF5's shuffle filter: `count` items of SIZE bytes become SIZE planes of `count` bytes, first all
// first bytes, then all second ones. The size known to the compiler lets it use vector
// instructions.

template <std::size_t SIZE>
void shuffle(const std::uint8_t* items, std::size_t count, std::uint8_t* planes)
{
  constexpr std::size_t BLOCK = 1024;  // items and planes of as many stay in the first cache
  for (std::size_t begin = 0; begin < count; begin += BLOCK) {
    const std::size_t end = std::min(count, begin + BLOCK);
    for (std::size_t byte = 0; byte < SIZE; ++byte) {
      const std::uint8_t* const from = items + byte;
      std::uint8_t* const to = planes + byte * count;
      for (std::size_t i = begin; i < end; ++i) {
        to[i] = from[i * SIZE];
      }
    }
  }
}

template <std::size_t SIZE>
void unshuffle(const std::uint8_t* planes, std::size_t count, std::uint8_t* items)
{
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t byte = 0; byte < SIZE; ++byte) {
      items[i * SIZE + byte] = planes[byte * count + i];
    }
  }
}

/// The numbers of a whole chunk.
struct Numbers
{
  /// py::value_error unless they are such as HDF5 allows, contiguous in C order.
  explicit Numbers(const py::array& chunk)
      : data(static_cast<const std::uint8_t*>(chunk.data())),
        count(chunk.size()),
        item_size(chunk.itemsize()),
        size(chunk.nbytes())
  {
    const char kind = chunk.dtype().kind();
    if ((kind != 'f' && kind != 'i' && kind != 'u') || item_size > 8 ||
        (chunk.flags() & py::array::c_style) == 0) {
      throw py::value_error("a chunk has to hold numbers, contiguous in C order");
    }
    if (size == 0 || size > MOST_BYTES) {
      throw py::value_error("a chunk is empty or larger than HDF5 allows");
    }
  }

  const std::uint8_t* data;
  std::size_t count, item_size, size;
};

Bytes compressChunk(const Numbers& chunk)
{
  if (chunk.item_size == 1) {
    return deflate(chunk.data, chunk.size);
  }
  const std::size_t item = chunk.item_size;
  const auto shuffle_items = item == 2 ? shuffle<2> : item == 4 ? shuffle<4> : shuffle<8>;
  const Bytes planes(chunk.size);
  shuffle_items(chunk.data, chunk.count, planes.data.get());
  return deflate(planes.data.get(), chunk.size);
}

/// A chunk as it lies in a file, of any content, the filters that it went through, and its place.
struct StoredChunk
{
  const std::uint8_t* data;
  std::size_t size;
  bool shuffled, deflated;
  Numbers numbers;
  std::uint8_t* place;  ///< numbers.data, to be written to
};

Inflated decompressChunk(const StoredChunk& stored)
{
  const std::size_t size = stored.numbers.size, item = stored.numbers.item_size;
  const bool shuffled = stored.shuffled && item > 1;
  const Bytes planes(shuffled ? size : 0);
  std::uint8_t* const output = shuffled ? planes.data.get() : stored.place;
  if (stored.deflated) {
    const Inflated result = inflate(stored.data, stored.size, output, size);
    if (result != Inflated::WHOLE) {
      return result;
    }
  } else if (stored.size != size) {
    return stored.size < size ? Inflated::TOO_SHORT : Inflated::TOO_LONG;
  } else {
    std::memcpy(output, stored.data, size);
  }
  if (shuffled) {
    const auto unshuffle_items = item == 2 ? unshuffle<2> : item == 4 ? unshuffle<4> : unshuffle<8>;
    unshuffle_items(output, stored.numbers.count, stored.place);
  }
  return Inflated::WHOLE;
}

/// Calls work(i) once for each i below count, on all cores. The first exception is rethrown when
/// all threads have ended; where the system gives no more threads, the ones that run do the work.
template <class Work>
void forEach(std::size_t count, const Work& work)
{
  std::atomic<std::size_t> next{0};
  std::mutex error_mutex;
  std::exception_ptr error;
  const auto run = [&]() {
    try {
      for (std::size_t i = next++; i < count; i = next++) {
        work(i);
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(error_mutex);
      error = error ? error : std::current_exception();
      next = count;
    }
  };
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t threads = std::min({cores, MOST_THREADS, count});
  std::vector<std::thread> others;
  others.reserve(threads);
  try {
    while (others.size() + 1 < threads) {
      others.emplace_back(run);
    }
  } catch (const std::system_error&) {
    // The ones that run, and this one, take all.
  }
  run();
  for (std::thread& thread : others) {
    thread.join();
  }
  if (error) {
    std::rethrow_exception(error);
  }
}

/// The bytes to store of each chunk, shuffled and deflated.
py::list compress(const std::vector<py::array>& arrays)
{
  const std::vector<Numbers> chunks(arrays.begin(), arrays.end());
  std::vector<Bytes> compressed(chunks.size());
  {
    const py::gil_scoped_release release;
    forEach(chunks.size(), [&](std::size_t i) { compressed[i] = compressChunk(chunks[i]); });
  }
  py::list result;
  for (const Bytes& chunk : compressed) {
    result.append(py::bytes(reinterpret_cast<const char*>(chunk.data.get()), chunk.size));
  }
  return result;
}

/// Fills the array of each (bytes, shuffled, deflated, array), the first of which is chunk number
/// `first`, and never writes outside of it. std::runtime_error that names a chunk which does not
/// hold exactly its bytes or has a wrong checksum; then the content of the arrays is undefined.
void decompress(std::vector<std::tuple<py::bytes, bool, bool, py::array>> chunks, std::size_t first)
{
  std::vector<StoredChunk> stored;
  for (auto& [data, shuffled, deflated, array] : chunks) {
    stored.push_back({reinterpret_cast<const std::uint8_t*>(PyBytes_AS_STRING(data.ptr())),
                      static_cast<std::size_t>(PyBytes_GET_SIZE(data.ptr())), shuffled, deflated,
                      Numbers(array), static_cast<std::uint8_t*>(array.mutable_data())});
  }
  const py::gil_scoped_release release;
  forEach(stored.size(), [&](std::size_t i) {
    const Inflated result = decompressChunk(stored[i]);
    if (result == Inflated::WHOLE) {
      return;
    }
    const std::string bytes = std::to_string(stored[i].numbers.size) + " bytes";
    throw std::runtime_error("chunk " + std::to_string(first + i) +
                             (result == Inflated::TOO_SHORT ? " holds less than its " + bytes
                              : result == Inflated::TOO_LONG
                                  ? " holds more than its " + bytes
                                  : " is damaged: its checksum or stream is wrong"));
  });
}

}  // namespace

PYBIND11_MODULE(_deflate, module)
{
  module.def("_compress", &compress, py::arg("chunks"));
  module.def("_decompress", &decompress, py::arg("chunks"), py::arg("first"));
}

}  // namespace mesh_msgs_hdf5
