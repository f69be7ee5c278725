#pragma once

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "common/core/seed.h"
#include "tests/common/testing/worst_case.h"

namespace sprout {

struct WorstSeeds {
  std::string name;
  std::vector<Seed> seeds;
};

/// Seeds that crowd where a sensor has few, inside both images; their disparities are random.
/// @param size  of the images, px; at least 100×100.
inline std::vector<WorstSeeds> MakeWorstSeeds(cv::Size size, int count = kWorstCount) {
  std::mt19937 random(1);
  const auto share = [&] { return static_cast<float>(random() % 65536) / 65536; };  // in [0, 1)
  const auto width = static_cast<float>(size.width - 1);
  const auto height = static_cast<float>(size.height - 1);
  const float middle_u = width / 2;
  const float middle_v = height / 2;
  const auto make = [&](const std::string& name, const auto& position) {
    WorstSeeds made{name, {}};
    made.seeds.reserve(static_cast<size_t>(count));
    for (int i = 0; i < count; ++i) {
      const cv::Point2f at = position(i);
      made.seeds.push_back({at.x, at.y, at.x * share()});
    }
    return made;
  };
  const auto on_circle = [&](int i, int of) {
    const double angle = 2 * std::numbers::pi * i / of;
    const double radius = std::min(middle_u, middle_v);
    return cv::Point2f(static_cast<float>(middle_u + radius * std::cos(angle)),
                       static_cast<float>(middle_v + radius * std::sin(angle)));
  };
  return {
      make("one position", [&](int) { return cv::Point2f(middle_u, middle_v); }),
      make("one pixel", [&](int) { return cv::Point2f(middle_u + share(), middle_v + share()); }),
      make("one row", [&](int) { return cv::Point2f(width * share(), middle_v); }),
      make("one column", [&](int) { return cv::Point2f(middle_u, height * share()); }),
      make("a row and a point",
           [&](int i) {
             return i == 0 ? cv::Point2f(middle_u, height) : cv::Point2f(width * share(), 1);
           }),
      make("two rows",
           [&](int i) { return cv::Point2f(width * share(), i % 2 == 0 ? 1 : height); }),
      make("a diagonal",
           [&](int) {
             const float along = share();
             return cv::Point2f(width * along, height * along);
           }),
      make("a circle", [&](int i) { return on_circle(i, count); }),
      make("a circle and its centre",
           [&](int i) { return i == 0 ? cv::Point2f(middle_u, middle_v) : on_circle(i, count); }),
      make("everywhere", [&](int) { return cv::Point2f(width * share(), height * share()); }),
  };
}

}  // namespace sprout
