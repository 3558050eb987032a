#pragma once

#include <cstddef>
#include <string>

#include <gtest/gtest.h>

#include "osmesa_harness/image.h"

namespace osmesa_harness {

/// How two pictures of the same size differ.
struct ImageDifference
{
  std::size_t differing_pixels = 0;
  /// Mean over all pixels and channels of the squared difference, channels taken as 0..1.
  double mean_squared_error = 0.0;
  /// Largest difference of any channel, 0..255.
  int largest = 0;
  /// The first differing pixel in reading order, -1 where there is none.
  int first_x = -1;
  int first_y = -1;
};

/// @throw std::invalid_argument where the sizes differ.
ImageDifference difference(const Image& a, const Image& b);

/// White where the pictures agree, red where they differ, the darker the more.
/// As large as both together; what only one of them covers is blue.
Image differenceImage(const Image& a, const Image& b);

/// For EXPECT_TRUE: succeeds where the mean squared error (0..1) is at most @a max_error.
///
/// Otherwise writes <name>_actual.png, <name>_expected.png and <name>_diff.png into
/// resultsFolder() and names them in the message. Pictures of different sizes never match.
testing::AssertionResult imagesMatch(const std::string& name, const Image& actual,
                                     const Image& expected, double max_error = 0.0);

/// The same with the expected picture in a file.
testing::AssertionResult imageMatchesFile(const std::string& name, const Image& actual,
                                          const std::string& expected_path, double max_error = 0.0);

/// For EXPECT_TRUE: the picture is the same, bit for bit, whichever back end draws it.
///
/// Saves it as <name>.png in resultsFolder(); where OSMESA_HARNESS_REFERENCE names the folder of an
/// earlier run (osmesa_harness_add_render_test lets the run under Xvfb refer to the one of OSMesa),
/// it must match the picture of that name there.
testing::AssertionResult sameOnAllBackEnds(const std::string& name, const Image& actual,
                                           double max_error = 0.0);

/// Where pictures are written: OSMESA_HARNESS_OUT, or the folder osmesa_harness_results below the
/// current one. Created by the first picture.
std::string resultsFolder();

}  // namespace osmesa_harness
