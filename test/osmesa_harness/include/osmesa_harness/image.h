#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

namespace osmesa_harness {

/// One pixel, 0..255 per channel.
struct Rgb
{
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
};

bool operator==(const Rgb& a, const Rgb& b);
bool operator!=(const Rgb& a, const Rgb& b);
std::ostream& operator<<(std::ostream& stream, const Rgb& color);

/// True where no channel differs by more than @a tolerance (0..255).
bool isNear(const Rgb& a, const Rgb& b, int tolerance);

/// A picture of 3 bytes (red, green, blue) a pixel, rows from the top down without padding.
class Image
{
 public:
  Image() = default;

  /// A picture filled with one color. @throw std::invalid_argument where a side is negative.
  Image(int width, int height, const Rgb& color = Rgb());

  /// Reads any format that QImage knows; alpha is dropped.
  /// @throw std::runtime_error naming the file where it cannot be read as a picture.
  static Image load(const std::string& path);

  /// Writes a PNG file, creating the folders above it. @throw std::runtime_error naming the file.
  void save(const std::string& path) const;

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return bytes_.empty(); }

  /// The pixel in column @a x from the left and row @a y from the top.
  /// @throw std::out_of_range outside the picture.
  Rgb at(int x, int y) const;
  void set(int x, int y, const Rgb& color);

  /// The pixel in the middle (of an even number: the one right of and below the middle).
  Rgb center() const { return at(width_ / 2, height_ / 2); }

  /// Number of pixels within @a tolerance of @a color.
  std::size_t count(const Rgb& color, int tolerance = 0) const;

  /// 3 * width * height bytes.
  std::uint8_t* data() { return bytes_.data(); }
  const std::uint8_t* data() const { return bytes_.data(); }

 private:
  std::size_t offset(int x, int y) const;

  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint8_t> bytes_;
};

bool operator==(const Image& a, const Image& b);
bool operator!=(const Image& a, const Image& b);

}  // namespace osmesa_harness
