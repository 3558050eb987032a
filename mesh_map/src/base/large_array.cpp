#include <mesh_map/base/large_array.h>

#include <algorithm>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace mesh_map {

namespace {

constexpr std::size_t HUGE_PAGE = std::size_t{1} << 21;

/// Small arrays stay in the heap's own pages: a huge page would be mostly empty.
std::align_val_t alignmentOf(std::size_t bytes, std::size_t alignment)
{
  return std::align_val_t{bytes >= 2 * HUGE_PAGE ? HUGE_PAGE
                                                 : std::max<std::size_t>(alignment, 64)};
}

}  // namespace

void* allocateLarge(std::size_t bytes, std::size_t alignment)
{
  void* const memory = ::operator new(bytes, alignmentOf(bytes, alignment));
#ifdef MADV_HUGEPAGE
  if (bytes >= 2 * HUGE_PAGE) {
    // Only whole huge pages, so that no more memory is taken than asked for. Where the system
    // declines, ordinary pages do.
    madvise(memory, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
  }
#endif
  return memory;
}

void releaseLarge(void* memory, std::size_t bytes, std::size_t alignment) noexcept
{
  ::operator delete(memory, alignmentOf(bytes, alignment));
}

}  // namespace mesh_map
