#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "common/config/config.h"
#include "common/core/image.h"
#include "common/inputs/check_inputs.h"
#include "common/scenes/dataset.h"

namespace sprout::inputs {

// A scene of planes, boxes and a sphere with exact range points.
struct Parts {
  cv::Mat1b left, right;
  TofImage tof;
  Rig rig;

  Findings Check() const { return CheckInputs(left, right, tof, rig); }
  Finding Answer(Question question) const { return Check()[static_cast<size_t>(question)]; }
};

inline Parts SceneOf(const std::string& source = "synthetic:640x480?tof=grid", int64_t index = 0) {
  const auto dataset = scenes::OpenDataset(source);
  const scenes::DatasetFrame frame = dataset->Get(index);
  return {ToGrey(frame.left).clone(), ToGrey(frame.right).clone(), frame.tof, dataset->rig()};
}

// The scene with its right image moved.
inline Parts Moved(const cv::Matx23d& motion) {
  Parts parts = SceneOf();
  cv::Mat1b moved;
  cv::warpAffine(parts.right, moved, motion, parts.right.size(), cv::INTER_CUBIC,
                 cv::BORDER_REFLECT);
  parts.right = moved;
  return parts;
}

inline void ExpectBad(const Parts& parts, Question question, const std::string& text) {
  const Finding finding = parts.Answer(question);
  EXPECT_EQ(finding.verdict, Verdict::kBad) << finding.text;
  EXPECT_THAT(finding.text, testing::HasSubstr(text));
}

}  // namespace sprout::inputs
