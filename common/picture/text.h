#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace sprout {

/// Width (px) of a line of text whose capital letters are `cap_height` px high. ASCII only, as
/// OpenCV's fonts are.
int TextWidth(const std::string& text, int cap_height);

/// Writes a line of text, smooth even when small.
/// @param baseline_left  where the first letter begins; text outside the picture is cut off.
/// @param cap_height  height of capital letters, px; 9 and more is legible.
void DrawText(cv::Mat3b& picture, const std::string& text, cv::Point baseline_left, int cap_height,
              const cv::Vec3b& color);

}  // namespace sprout
