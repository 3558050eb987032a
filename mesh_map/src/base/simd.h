#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#ifdef __SSE__
#include <immintrin.h>
#endif

namespace mesh_map {

/// Four floats side by side, on any processor; comparisons give Ints4 of 0 and -1.
typedef float Floats4 __attribute__((vector_size(16)));
typedef std::int32_t Ints4 __attribute__((vector_size(16)));

/// The same in memory at any place.
inline Floats4 load4(const float* from)
{
  Floats4 result;
  std::memcpy(&result, from, sizeof(result));
  return result;
}

inline Floats4 all4(float value)
{
  return Floats4{value, value, value, value};
}

/// Where one is NaN: the second.
inline Floats4 minimum(Floats4 a, Floats4 b)
{
  return a < b ? a : b;
}

inline Floats4 maximum(Floats4 a, Floats4 b)
{
  return a > b ? a : b;
}

inline Floats4 absolute(Floats4 a)
{
  return reinterpret_cast<Floats4>(reinterpret_cast<Ints4>(a) & 0x7FFFFFFF);
}

inline Floats4 squareRoot(Floats4 a)
{
#ifdef __SSE__
  return reinterpret_cast<Floats4>(_mm_sqrt_ps(reinterpret_cast<__m128>(a)));
#else
  return {std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
#endif
}

/// Bit k is set where element k is.
inline unsigned bits(Ints4 mask)
{
#ifdef __SSE__
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<Floats4>(mask)));
#else
  return (mask[0] & 1u) | (mask[1] & 2u) | (mask[2] & 4u) | (mask[3] & 8u);
#endif
}

/// Rows become columns.
inline void transpose(Floats4& a, Floats4& b, Floats4& c, Floats4& d)
{
#ifdef __SSE__
  __m128 rows[] = {reinterpret_cast<__m128>(a), reinterpret_cast<__m128>(b),
                   reinterpret_cast<__m128>(c), reinterpret_cast<__m128>(d)};
  _MM_TRANSPOSE4_PS(rows[0], rows[1], rows[2], rows[3]);
  a = reinterpret_cast<Floats4>(rows[0]);
  b = reinterpret_cast<Floats4>(rows[1]);
  c = reinterpret_cast<Floats4>(rows[2]);
  d = reinterpret_cast<Floats4>(rows[3]);
#else
  const Floats4 rows[] = {a, b, c, d};
  a = {rows[0][0], rows[1][0], rows[2][0], rows[3][0]};
  b = {rows[0][1], rows[1][1], rows[2][1], rows[3][1]};
  c = {rows[0][2], rows[1][2], rows[2][2], rows[3][2]};
  d = {rows[0][3], rows[1][3], rows[2][3], rows[3][3]};
#endif
}

/// Two doubles side by side.
typedef double Doubles2 __attribute__((vector_size(16)));
typedef std::int64_t Ints2 __attribute__((vector_size(16)));

inline Doubles2 maximum(Doubles2 a, Doubles2 b)
{
  return a > b ? a : b;
}

inline Doubles2 minimum(Doubles2 a, Doubles2 b)
{
  return a < b ? a : b;
}

inline Doubles2 absolute(Doubles2 a)
{
  return reinterpret_cast<Doubles2>(reinterpret_cast<Ints2>(a) & INT64_MAX);
}

/// -a where the sign of `other` is negative, else a.
inline Doubles2 timesSign(Doubles2 a, Doubles2 other)
{
  return reinterpret_cast<Doubles2>(reinterpret_cast<Ints2>(a) ^
                                    (reinterpret_cast<Ints2>(other) & INT64_MIN));
}

inline bool both(Ints2 mask)
{
#ifdef __SSE2__
  return _mm_movemask_pd(reinterpret_cast<Doubles2>(mask)) == 3;
#else
  return (mask[0] & mask[1]) != 0;
#endif
}

/// Index of the lowest bit that is set, of which there is one.
inline unsigned lowestBit(unsigned mask)
{
  return static_cast<unsigned>(__builtin_ctz(mask));
}

}  // namespace mesh_map
