#include "osmesa_harness/image_compare.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <sstream>
#include <stdexcept>

namespace osmesa_harness {
namespace {

int largestDifference(const Rgb& a, const Rgb& b)
{
  return std::max(
      {std::abs(a.red - b.red), std::abs(a.green - b.green), std::abs(a.blue - b.blue)});
}

double squaredDifference(const Rgb& a, const Rgb& b)
{
  const double red = (a.red - b.red) / 255.0;
  const double green = (a.green - b.green) / 255.0;
  const double blue = (a.blue - b.blue) / 255.0;
  return red * red + green * green + blue * blue;
}

bool covers(const Image& image, int x, int y)
{
  return x < image.width() && y < image.height();
}

std::string size(const Image& image)
{
  return std::to_string(image.width()) + " x " + std::to_string(image.height());
}

testing::AssertionResult failure(const std::string& name, const Image& actual,
                                 const Image& expected, const std::string& reason)
{
  const std::string stem = resultsFolder() + "/" + name;
  auto result = testing::AssertionFailure() << "picture '" << name << "' " << reason;
  try {
    actual.save(stem + "_actual.png");
    expected.save(stem + "_expected.png");
    differenceImage(actual, expected).save(stem + "_diff.png");
  } catch (const std::runtime_error& error) {
    return result << "; and " << error.what();
  }
  return result << "; see " << stem << "_actual.png, " << stem << "_expected.png and " << stem
                << "_diff.png";
}

}  // namespace

ImageDifference difference(const Image& a, const Image& b)
{
  if (a.width() != b.width() || a.height() != b.height()) {
    throw std::invalid_argument("pictures of " + size(a) + " and " + size(b) +
                                " cannot be compared pixel by pixel");
  }
  ImageDifference found;
  double sum = 0.0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const Rgb one = a.at(x, y);
      const Rgb other = b.at(x, y);
      if (one == other) {
        continue;
      }
      if (found.differing_pixels++ == 0) {
        found.first_x = x;
        found.first_y = y;
      }
      found.largest = std::max(found.largest, largestDifference(one, other));
      sum += squaredDifference(one, other);
    }
  }
  if (!a.empty()) {
    found.mean_squared_error = sum / (3.0 * a.width() * a.height());
  }
  return found;
}

Image differenceImage(const Image& a, const Image& b)
{
  const Rgb same{255, 255, 255};
  const Rgb uncovered{0, 0, 255};
  Image image(std::max(a.width(), b.width()), std::max(a.height(), b.height()), same);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (!covers(a, x, y) || !covers(b, x, y)) {
        image.set(x, y, uncovered);
      } else if (const int largest = largestDifference(a.at(x, y), b.at(x, y))) {
        // From bright red to dark: even a difference of 1 stands out from white.
        image.set(x, y, Rgb{static_cast<std::uint8_t>(255 - largest / 2), 0, 0});
      }
    }
  }
  return image;
}

testing::AssertionResult imagesMatch(const std::string& name, const Image& actual,
                                     const Image& expected, double max_error)
{
  if (actual.width() != expected.width() || actual.height() != expected.height()) {
    return failure(name, actual, expected, "is " + size(actual) + ", expected " + size(expected));
  }
  const ImageDifference found = difference(actual, expected);
  if (found.mean_squared_error <= max_error) {
    return testing::AssertionSuccess();
  }
  std::ostringstream reason;
  reason << "differs in " << found.differing_pixels << " pixels, first at (" << found.first_x
         << ", " << found.first_y << "): " << actual.at(found.first_x, found.first_y)
         << ", expected " << expected.at(found.first_x, found.first_y) << "; mean squared error "
         << found.mean_squared_error << ", allowed " << max_error << ", largest difference "
         << found.largest << " of 255";
  return failure(name, actual, expected, reason.str());
}

testing::AssertionResult imageMatchesFile(const std::string& name, const Image& actual,
                                          const std::string& expected_path, double max_error)
{
  try {
    return imagesMatch(name, actual, Image::load(expected_path), max_error);
  } catch (const std::runtime_error& error) {
    const std::string drawn = resultsFolder() + "/" + name + "_actual.png";
    actual.save(drawn);
    return testing::AssertionFailure()
           << "picture '" << name << "' has nothing to be compared with: " << error.what()
           << "; what was drawn is in " << drawn;
  }
}

testing::AssertionResult sameOnAllBackEnds(const std::string& name, const Image& actual,
                                           double max_error)
{
  actual.save(resultsFolder() + "/" + name + ".png");
  const char* reference = std::getenv("OSMESA_HARNESS_REFERENCE");
  if (!reference || !*reference) {
    return testing::AssertionSuccess();
  }
  return imageMatchesFile(name, actual, std::string(reference) + "/" + name + ".png", max_error);
}

std::string resultsFolder()
{
  const char* folder = std::getenv("OSMESA_HARNESS_OUT");
  return folder && *folder ? folder : "osmesa_harness_results";
}

}  // namespace osmesa_harness
