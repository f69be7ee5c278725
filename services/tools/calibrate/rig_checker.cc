#include "services/tools/calibrate/rig_checker.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "common/core/image.h"
#include "common/core/quantile.h"
#include "common/inputs/check_inputs.h"

namespace sprout::calibrate {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Beyond these Sprout loses accuracy that can be measured: 2 px of vertical error cost it 0.7
// points, ToF points that land 3 px beside their place three (services/refine/NOTES.md).
constexpr double kMaxVerticalPx = 1;
constexpr double kMaxTofOffsetPx = 1.5;
constexpr double kMaxTofDisparityPx = 1;
// Fewer frames that are sure may agree by chance.
constexpr int kFewTofFrames = 3;
constexpr size_t kFewRanges = 200;
// What MeasureVerticalDisparity() finds is true up to this, px.
constexpr double kFarRowsPx = 2;

// Median of the values that are known.
double MedianOf(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  return values.empty() ? kUnknown : Median(values);
}

template <typename Items, typename Get>
double MedianOf(const Items& items, Get get) {
  std::vector<double> values;
  for (const auto& item : items) values.push_back(get(item));
  return MedianOf(std::move(values));
}

// Disparity by semi-global matching, with the settings of OpenCV's own example.
cv::Mat1f StereoDisparity(const cv::Mat1b& left, const cv::Mat1b& right, int first, int count) {
  constexpr int kBlock = 5;
  const auto matcher = cv::StereoSGBM::create(
      first, count, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock, /*disp12MaxDiff=*/1,
      /*preFilterCap=*/63, /*uniquenessRatio=*/10,
      /*speckleWindowSize=*/100, /*speckleRange=*/2, cv::StereoSGBM::MODE_SGBM_3WAY);
  cv::Mat1s counts;
  matcher->compute(left, right, counts);
  cv::Mat1f disparity;
  counts.convertTo(disparity, CV_32F, 1.0 / int{cv::StereoMatcher::DISP_SCALE});
  return disparity;
}

// Windows are searched a few rows up and down only, CheckInputs() searches many.
bool RowsAreFarOff(const inputs::Findings& findings) {
  return std::ranges::any_of(findings, [](const inputs::Finding& finding) {
    return finding.question == inputs::Question::kRows &&
           finding.verdict == inputs::Verdict::kBad && std::abs(finding.value) > kFarRowsPx;
  });
}

std::vector<std::string> ReasonsOf(const RigCheck& check) {
  std::vector<std::string> reasons;
  const bool rows_known = std::abs(check.vertical_px) > kMaxVerticalPx;
  for (const inputs::Finding& finding : check.findings) {
    if (finding.verdict != inputs::Verdict::kBad) continue;
    if (finding.question == inputs::Question::kRows && rows_known) continue;  // said below
    reasons.push_back(finding.text);
  }
  if (rows_known) {
    reasons.push_back(
        fmt::format("rows of the right image lie {:+.2f} px off those of the left "
                    "one ({} are allowed)",
                    check.vertical_px, kMaxVerticalPx));
  } else if (!check.vertical_cells_px.empty()) {
    double worst = 0;
    for (const float cell : check.vertical_cells_px) {
      if (std::abs(cell) > std::abs(worst)) worst = cell;
    }
    if (std::abs(worst) > kMaxVerticalPx) {
      reasons.push_back(
          fmt::format("rows of the right image lie up to {:+.2f} px off those of the "
                      "left one in parts of the image ({} are allowed)",
                      worst, kMaxVerticalPx));
    }
  }
  if (check.tof_frames >= kFewTofFrames && cv::norm(check.tof_offset_px) > kMaxTofOffsetPx) {
    reasons.push_back(
        fmt::format("ToF points are {:.1f} px beside the objects they were measured on ({} are "
                    "allowed): was the ToF camera knocked?",
                    cv::norm(check.tof_offset_px), kMaxTofOffsetPx));
  }
  if (std::abs(check.tof_disparity_px) > kMaxTofDisparityPx) {
    reasons.push_back(
        fmt::format("the ToF camera's ranges differ from stereo by {:+.0f} mm, "
                    "{:+.1f} px of disparity ({} are allowed)",
                    1000 * check.tof_range_m, check.tof_disparity_px, kMaxTofDisparityPx));
  }
  return reasons;
}

std::string Number(double value, const char* unit, int digits) {
  return std::isnan(value) ? "unknown" : fmt::format("{:+.{}f} {}", value, digits, unit);
}

}  // namespace

RigChecker::RigChecker() : refiner_(LoadConfig({}).refine()) {}

Result<void> RigChecker::Add(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                             const Rig& rig) {
  const Rig of_frame = RigOfFrame(rig, tof);
  if (const Result<void> size = CheckTofSize(of_frame, tof); !size) return size;
  const std::string rig_id = RigId(of_frame);
  if (!projector_ || projector_rig_id_ != rig_id) {
    projector_.emplace(of_frame);
    projector_rig_id_ = rig_id;
  }
  const cv::Mat1b left_grey = ToGrey(left);
  const cv::Mat1b right_grey = ToGrey(right);
  const Result<SeedSet> seeds = refiner_.Compute(left_grey, right_grey, tof, *projector_);
  if (!seeds) return tl::unexpected(seeds.error());
  ++frames_;
  findings_.push_back(inputs::CheckInputs(left_grey, right_grey, tof, of_frame.pair,
                                          tof.depth_m.empty() ? nullptr : &*projector_));
  vertical_.push_back(MeasureVerticalDisparity(left_grey, right_grey, seeds->seeds));
  if (tof.depth_m.empty()) return {};

  has_tof_ = true;
  int behind = 0;
  const std::vector<ProjectedPoint> points = projector_->Project(tof, behind);
  const refine::TofOffset offset =
      aligner_.Estimate(left_grey, right_grey, points, tof, *projector_);
  if (offset.sure) offsets_px_.emplace_back(offset.du_px, offset.dv_px);
  CompareRanges(left_grey, right_grey, points, rig.pair);
  return {};
}

void RigChecker::CompareRanges(const cv::Mat1b& left, const cv::Mat1b& right,
                               const std::vector<ProjectedPoint>& points,
                               const RectifiedPair& pair) {
  std::vector<double> disparities;
  for (const ProjectedPoint& point : points) disparities.push_back(point.seed.disparity());
  if (disparities.empty()) return;
  // Disparities that occur, and as many pixels again that a wrong range would lead to. SGBM wants
  // multiples of 16, and fewer than the image has columns.
  constexpr int kAround = 16;
  constexpr int kStep = 16;
  const double nearly_all = 0.98 * static_cast<double>(disparities.size() - 1);
  const int first =
      static_cast<int>(std::floor(OrderStatistic(disparities, disparities.size() / 50))) - kAround;
  const int last =
      static_cast<int>(std::ceil(OrderStatistic(disparities, static_cast<size_t>(nearly_all)))) +
      kAround;
  const int count = std::min((last - first) / kStep + 1, left.cols / 2 / kStep) * kStep;
  if (count < kStep) return;
  const cv::Mat1f stereo = StereoDisparity(left, right, first, count);
  for (const ProjectedPoint& point : points) {
    const cv::Point pixel(static_cast<int>(std::lround(point.seed.u)),
                          static_cast<int>(std::lround(point.seed.v)));
    if (!cv::Rect({0, 0}, stereo.size()).contains(pixel)) continue;
    const double disparity_px = stereo(pixel);
    if (disparity_px < first) continue;  // none
    const double range_m = pair.DepthFromDisparity(point.seed.disparity());
    disparities_px_.push_back(point.seed.disparity() - disparity_px);
    ranges_m_.push_back(range_m - pair.DepthFromDisparity(disparity_px));
  }
}

RigCheck RigChecker::Summary() const {
  RigCheck check{.frames = frames_,
                 .vertical_px = MedianOf(vertical_, [](const auto& v) { return v.median_px; }),
                 .vertical_cells_px = {},
                 .has_tof = has_tof_,
                 .tof_frames = static_cast<int>(offsets_px_.size()),
                 .tof_offset_px = {MedianOf(offsets_px_, [](const auto& o) { return o.x; }),
                                   MedianOf(offsets_px_, [](const auto& o) { return o.y; })},
                 .tof_disparity_px = kUnknown,
                 .tof_range_m = kUnknown,
                 .findings = inputs::Combine(findings_),
                 .reasons = {}};
  if (RowsAreFarOff(check.findings)) {
    check.vertical_px = kUnknown;
  } else if (!vertical_.empty() && !vertical_.front().cells_px.empty()) {
    check.vertical_cells_px.create(vertical_.front().cells_px.size());
    for (int row = 0; row < check.vertical_cells_px.rows; ++row) {
      for (int column = 0; column < check.vertical_cells_px.cols; ++column) {
        check.vertical_cells_px(row, column) = static_cast<float>(
            MedianOf(vertical_, [&](const auto& v) { return v.cells_px(row, column); }));
      }
    }
  }
  if (disparities_px_.size() >= kFewRanges) {
    check.tof_disparity_px = MedianOf(disparities_px_);
    check.tof_range_m = MedianOf(ranges_m_);
  }
  check.reasons = ReasonsOf(check);
  return check;
}

std::string CheckText(const RigCheck& check) {
  std::string text = fmt::format("{} frames: {}\n", check.frames,
                                 check.reasons.empty() ? "good" : "has to be calibrated again");
  for (const std::string& reason : check.reasons) text += "  * " + reason + "\n";
  text += fmt::format("{:<30} {}\n", "rows, right less left", Number(check.vertical_px, "px", 2));
  for (int row = 0; row < check.vertical_cells_px.rows; ++row) {
    text += fmt::format("{:<30}", row == 0 ? "  over the image" : "");
    for (int column = 0; column < check.vertical_cells_px.cols; ++column) {
      const float cell = check.vertical_cells_px(row, column);
      text += std::isnan(cell) ? "      -" : fmt::format(" {:+6.2f}", cell);
    }
    text += "\n";
  }
  for (const inputs::Finding& finding : check.findings) {
    text += fmt::format("{:<30} {}: {}\n", inputs::NameOf(finding.question),
                        inputs::NameOf(finding.verdict), finding.text);
  }
  if (!check.has_tof) return text;
  text += fmt::format("{:<30} {}, {} ({} frames are sure)\n", "ToF points belong, right, down",
                      Number(check.tof_offset_px.x, "px", 1),
                      Number(check.tof_offset_px.y, "px", 1), check.tof_frames);
  text += fmt::format("{:<30} {}, {}\n", "ToF ranges less stereo",
                      Number(check.tof_disparity_px, "px", 2),
                      Number(1000 * check.tof_range_m, "mm", 0));
  return text;
}

}  // namespace sprout::calibrate
