#include "common/rig/bilinear_remap.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <opencv2/imgproc.hpp>

namespace sprout {
namespace {

// All over an image and beyond it, as a lens would have it.
cv::Mat2f Places(cv::Size size, cv::Size source) {
  cv::Mat2f places(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double x = 1.2 * (u + 0.5) / size.width - 0.1;
      const double y = 1.2 * (v + 0.5) / size.height - 0.1;
      places(v, u) = {static_cast<float>((x + 0.05 * y * y) * source.width - 0.5),
                      static_cast<float>((y - 0.05 * x) * source.height - 0.5)};
    }
  }
  return places;
}

cv::Mat Noise(cv::Size size, int type) {
  cv::Mat image(size, type);
  cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

void ExpectAsOpenCv(cv::Size size, cv::Size source) {
  const cv::Mat2f places = Places(size, source);
  const BilinearRemap remap(places, source);
  cv::Mat whole, fraction;
  cv::convertMaps(places, cv::noArray(), whole, fraction, CV_16SC2);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat image = Noise(source, type);
    cv::Mat expected;
    cv::remap(image, expected, whole, fraction, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const cv::Mat found = remap.Apply(image);
    ASSERT_EQ(found.type(), type);
    EXPECT_EQ(cv::norm(found, expected, cv::NORM_INF), 0) << size << " of " << source;
  }
}

TEST(BilinearRemap, GivesTheBytesOfOpenCv) {
  ExpectAsOpenCv({640, 480}, {640, 480});
  ExpectAsOpenCv({65, 7}, {31, 90});
  ExpectAsOpenCv({3, 200}, {2, 2});
}

TEST(BilinearRemap, GivesTheSameBytesWithEveryInstructionSet) {
  const int64_t all = hwy::SupportedTargets();
  for (int64_t rest = all; rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    hwy::GetChosenTarget().DeInit();  // chosen anew at the next call
    ExpectAsOpenCv({130, 50}, {120, 60});
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(BilinearRemap, TakesAPartOfALargerImage) {
  const BilinearRemap remap(Places({40, 30}, {50, 20}), {50, 20});
  const cv::Mat part = Noise({80, 40}, CV_8UC3)(cv::Rect(7, 9, 50, 20));
  EXPECT_EQ(cv::norm(remap.Apply(part), remap.Apply(part.clone()), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace sprout
