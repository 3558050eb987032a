#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace mesh_map {

/// Memory for large arrays: in huge pages where the system has them, which makes both the first
/// writing and random reading cheaper. Throws std::bad_alloc.
void* allocateLarge(std::size_t bytes, std::size_t alignment);
void releaseLarge(void* memory, std::size_t bytes, std::size_t alignment) noexcept;

/// Allocator of LargeArray.
template <class T>
struct LargeAllocator
{
  using value_type = T;

  LargeAllocator() = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&)
  {
  }

  T* allocate(std::size_t count)
  {
    if (count > static_cast<std::size_t>(-1) / sizeof(T)) {
      throw std::bad_alloc();
    }
    return static_cast<T*>(allocateLarge(count * sizeof(T), alignof(T)));
  }
  void deallocate(T* memory, std::size_t count) noexcept
  {
    releaseLarge(memory, count * sizeof(T), alignof(T));
  }

  /// Values that nobody gives are left uninitialized: several threads fill the array soon.
  template <class U>
  void construct(U* value)
  {
    ::new (static_cast<void*>(value)) U;
  }
  template <class U, class... Arguments>
  void construct(U* value, Arguments&&... arguments)
  {
    ::new (static_cast<void*>(value)) U(std::forward<Arguments>(arguments)...);
  }
};

template <class T, class U>
bool operator==(const LargeAllocator<T>&, const LargeAllocator<U>&)
{
  return true;
}
template <class T, class U>
bool operator!=(const LargeAllocator<T>&, const LargeAllocator<U>&)
{
  return false;
}

/// A vector of many numbers or plain structures. LargeArray<T>(n) does not initialize them.
template <class T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

}  // namespace mesh_map
