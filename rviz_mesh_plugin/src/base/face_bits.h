#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace rviz_mesh_plugin {

/// A set of faces of a mesh, a bit each: what is done to all of them takes time by their number
/// over 64.
class FaceBits
{
 public:
  using Word = std::uint64_t;
  using Faces = std::vector<std::uint32_t>;
  static constexpr std::uint32_t BITS = 64;  ///< of a word; the lowest face is the lowest bit

  explicit FaceBits(std::size_t face_count = 0)
      : size_(face_count), words_((face_count + BITS - 1) / BITS, 0)
  {
  }
  /// @param faces those beyond the mesh are left out
  FaceBits(std::size_t face_count, const Faces& faces) : FaceBits(face_count) { add(faces); }

  /// Of the mesh.
  std::size_t size() const { return size_; }
  std::size_t wordCount() const { return words_.size(); }
  Word word(std::size_t place) const { return words_[place]; }
  bool contains(std::uint32_t face) const
  {
    return face < size_ && (words_[face / BITS] >> (face % BITS) & 1) != 0;
  }

  /// Of those in it.
  std::size_t count() const
  {
    return std::accumulate(words_.begin(), words_.end(), std::size_t{0},
                           [](std::size_t sum, Word word) { return sum + countOf(word); });
  }

  void add(const Faces& faces)
  {
    for (const std::uint32_t face : faces) {
      if (face < size_) {
        words_[face / BITS] |= Word{1} << (face % BITS);
      }
    }
  }
  void addAll()
  {
    words_.assign(words_.size(), ~Word{0});
    if (const std::uint32_t rest = size_ % BITS) {
      words_.back() >>= BITS - rest;
    }
  }
  /// Those of another set. @throw std::invalid_argument for faces of a mesh of another size
  void unite(const FaceBits& other)
  {
    refuseOthers(other);
    for (std::size_t place = 0; place < words_.size(); ++place) {
      words_[place] |= other.words_[place];
    }
  }
  void remove(const FaceBits& other)
  {
    refuseOthers(other);
    for (std::size_t place = 0; place < words_.size(); ++place) {
      words_[place] &= ~other.words_[place];
    }
  }
  /// Turns bits round; none beyond the mesh.
  void toggle(std::size_t place, Word bits) { words_[place] ^= bits; }

  /// Calls back with each face, ascending.
  template <class Visit>
  void visit(const Visit& visit) const
  {
    for (std::size_t place = 0; place < words_.size(); ++place) {
      visitBits(words_[place], static_cast<std::uint32_t>(BITS * place), visit);
    }
  }
  Faces faces() const
  {
    Faces faces;
    faces.reserve(count());
    visit([&](std::uint32_t face) { faces.push_back(face); });
    return faces;
  }

  static std::size_t countOf(Word word)
  {
    return static_cast<std::size_t>(__builtin_popcountll(word));
  }

  /// Calls back for each bit that is set, from the lowest.
  /// @param first face of the word
  template <class Visit>
  static void visitBits(Word word, std::uint32_t first, const Visit& visit)
  {
    for (; word != 0; word &= word - 1) {
      visit(first + static_cast<std::uint32_t>(__builtin_ctzll(word)));
    }
  }

  friend bool operator==(const FaceBits& a, const FaceBits& b)
  {
    return a.size_ == b.size_ && a.words_ == b.words_;
  }
  friend bool operator!=(const FaceBits& a, const FaceBits& b) { return !(a == b); }

 private:
  void refuseOthers(const FaceBits& other) const
  {
    if (other.size_ != size_) {
      throw std::invalid_argument("these are faces of another mesh");
    }
  }

  std::size_t size_;
  std::vector<Word> words_;
};

}  // namespace rviz_mesh_plugin
