#include "osmesa_harness/image.h"

#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <QDir>
#include <QFileInfo>
#include <QImage>
#include <QString>

namespace osmesa_harness {

bool operator==(const Rgb& a, const Rgb& b)
{
  return a.red == b.red && a.green == b.green && a.blue == b.blue;
}

bool operator!=(const Rgb& a, const Rgb& b)
{
  return !(a == b);
}

std::ostream& operator<<(std::ostream& stream, const Rgb& color)
{
  return stream << "rgb(" << int(color.red) << ", " << int(color.green) << ", " << int(color.blue)
                << ")";
}

bool isNear(const Rgb& a, const Rgb& b, int tolerance)
{
  return std::abs(a.red - b.red) <= tolerance && std::abs(a.green - b.green) <= tolerance &&
         std::abs(a.blue - b.blue) <= tolerance;
}

Image::Image(int width, int height, const Rgb& color) : width_(width), height_(height)
{
  if (width < 0 || height < 0) {
    throw std::invalid_argument("a picture of " + std::to_string(width) + " x " +
                                std::to_string(height) + " pixels cannot be");
  }
  bytes_.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (std::size_t pixel = 0; pixel < bytes_.capacity() / 3; ++pixel) {
    bytes_.insert(bytes_.end(), {color.red, color.green, color.blue});
  }
}

Image Image::load(const std::string& path)
{
  const QImage file = QImage(QString::fromStdString(path)).convertToFormat(QImage::Format_RGB888);
  if (file.isNull()) {
    throw std::runtime_error(path + " cannot be read as a picture");
  }
  Image image(file.width(), file.height());
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(image.width_);
  for (int y = 0; y < image.height_; ++y) {
    // QImage pads its rows.
    std::memcpy(image.data() + image.offset(0, y), file.constScanLine(y), row_bytes);
  }
  return image;
}

void Image::save(const std::string& path) const
{
  const QString name = QString::fromStdString(path);
  QDir().mkpath(QFileInfo(name).path());
  const QImage file(data(), width_, height_, 3 * width_, QImage::Format_RGB888);
  if (!file.save(name, "PNG")) {
    throw std::runtime_error("a picture of " + std::to_string(width_) + " x " +
                             std::to_string(height_) + " pixels cannot be written to " + path);
  }
}

std::size_t Image::offset(int x, int y) const
{
  if (x < 0 || x >= width_ || y < 0 || y >= height_) {
    throw std::out_of_range("pixel (" + std::to_string(x) + ", " + std::to_string(y) +
                            ") is outside a picture of " + std::to_string(width_) + " x " +
                            std::to_string(height_));
  }
  return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
              static_cast<std::size_t>(x));
}

Rgb Image::at(int x, int y) const
{
  const std::uint8_t* pixel = data() + offset(x, y);
  return Rgb{pixel[0], pixel[1], pixel[2]};
}

void Image::set(int x, int y, const Rgb& color)
{
  std::uint8_t* pixel = data() + offset(x, y);
  pixel[0] = color.red;
  pixel[1] = color.green;
  pixel[2] = color.blue;
}

std::size_t Image::count(const Rgb& color, int tolerance) const
{
  std::size_t found = 0;
  for (std::size_t at = 0; at < bytes_.size(); at += 3) {
    found += isNear(Rgb{bytes_[at], bytes_[at + 1], bytes_[at + 2]}, color, tolerance);
  }
  return found;
}

bool operator==(const Image& a, const Image& b)
{
  return a.width() == b.width() && a.height() == b.height() &&
         (a.empty() || std::memcmp(a.data(), b.data(),
                                   3 * static_cast<std::size_t>(a.width()) *
                                       static_cast<std::size_t>(a.height())) == 0);
}

bool operator!=(const Image& a, const Image& b)
{
  return !(a == b);
}

}  // namespace osmesa_harness
