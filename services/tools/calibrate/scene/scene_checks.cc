#include "services/tools/calibrate/scene/scene_checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/quantile.h"
#include "services/tools/calibrate/scene/scene_deviations.h"

namespace sprout::calibrate {
namespace {

// 150 matches that are good to 0.1 px give a mean to a hundredth of a pixel, and a slope over the
// image to 0.03 px.
constexpr int kMinMatches = 150;
// Cells of the left image, and how many of them must have how many matches.
constexpr int kColumns = 4;
constexpr int kBands = 3;
constexpr int kMinCells = 6;
constexpr int kMinInCell = 5;
// Disparities off the common plane: what a scene needs to tell a rotation from a shift. px.
constexpr double kMinReliefPx = 1;
constexpr double kReliefShare = 0.8;  // of the matches; the others may be wrong
// Matches whose rows are off by more than this are wrong, px.
constexpr double kOffRowsPx = 2;
constexpr double kMaxOff = 0.25;
// Largest difference between the medians of frames that one calibration fits, px.
constexpr double kMaxSpreadPx = 0.4;
constexpr size_t kMinInView = 30;
// Beyond these Sprout loses accuracy that can be measured: 2 px of vertical error cost it 0.7
// points, ToF points that land 3 px beside their place three (services/refine/NOTES.md).
constexpr double kMaxRowsPx = 1;
constexpr double kMaxTofPx = 1;
constexpr double kMaxTofShiftPx = 1.5;
// What the median of all matches may get worse by, px: the scatter of a median.
constexpr double kMaxWorsePx = 0.02;
// Larger changes, in units of what is expected of a knock, are not believed.
constexpr double kMaxExpected = 4;

// The number of a pixel's cell, row by row.
size_t CellOf(const cv::Point2d& pixel, const RectifiedPair& pair) {
  const int column = std::clamp(static_cast<int>(pixel.x * kColumns / pair.width), 0, kColumns - 1);
  const int row = std::clamp(static_cast<int>(pixel.y * kBands / pair.height), 0, kBands - 1);
  return static_cast<size_t>(row * kColumns + column);
}

// Disparities without their plane over the image: what is left of 80 % of the matches.
double Relief(const std::vector<SceneMatch>& matches, const std::vector<cv::Point2d>& left_px,
              const RectifiedPair& pair) {
  const auto count = static_cast<Eigen::Index>(matches.size());
  Eigen::MatrixX3d places(count, 3);
  Eigen::VectorXd disparities(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    places.row(i) << (left_px[k].x - pair.cx) / pair.focal_px,
        (left_px[k].y - pair.cy) / pair.focal_px, 1;
    disparities[i] = pair.focal_px * pair.baseline_m * matches[k].inverse_depth;
  }
  // Iteratively reweighted: single wrong matches do not turn the plane.
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(count);
  Eigen::VectorXd off;
  for (int round = 0; round < 10; ++round) {
    const Eigen::MatrixX3d weighted = weights.asDiagonal() * places;
    const Eigen::Matrix3d normal = weighted.transpose() * places;
    const Eigen::Vector3d right = weighted.transpose() * disparities;
    off = (disparities - places * normal.ldlt().solve(right)).cwiseAbs();
    weights = (off.array().max(0.1)).inverse();
  }
  return Quantile(std::vector<double>(off.begin(), off.end()), kReliefShare);
}

// What ranges may be off by, three standard deviations, as disparity in the middle of the scene.
double MaxRangeErrorPx(const SceneRefinement& refinement) {
  std::vector<double> per_m = refinement.adjusted.inverse_depths;
  const double middle_per_m = per_m.empty() ? 0 : Median(std::move(per_m));
  return refinement.rig.left.fx * refinement.rig.left_from_right.translation_m.norm() *
         middle_per_m * middle_per_m * kSureChangeSigmas * kRangeErrorM;
}

}  // namespace

std::vector<double> Depths(const std::vector<SceneMatch>& matches) {
  std::vector<double> depths;
  for (const SceneMatch& match : matches) depths.push_back(match.inverse_depth);
  return depths;
}

Result<void> CheckScene(const std::vector<SceneRefiner::View>& views,
                        const std::vector<SceneMatch>& matches,
                        const std::vector<cv::Point2d>& left_px, const RectifiedPair& pair) {
  int features = 0;
  for (const SceneRefiner::View& view : views) features += view.features;
  if (static_cast<int>(matches.size()) < kMinMatches) {
    return Fail(fmt::format(
        "too little to see: {} matches of {} features in {} frames ({} matches are needed): show "
        "more of a scene with texture, and are both images of one scene?",
        matches.size(), features, views.size(), kMinMatches));
  }
  std::array<int, static_cast<size_t>(kColumns * kBands)> cells{};
  for (const cv::Point2d& pixel : left_px) ++cells[CellOf(pixel, pair)];
  const auto covered = std::ranges::count_if(cells, [](int count) { return count >= kMinInCell; });
  if (covered < kMinCells) {
    return Fail(fmt::format(
        "matches in {} of {} parts of the image only ({} are needed): show a scene with texture "
        "everywhere",
        covered, kColumns * kBands, kMinCells));
  }
  const double relief_px = Relief(matches, left_px, pair);
  if (relief_px < kMinReliefPx) {
    return Fail(
        fmt::format("the scene is too flat: disparities lie within {:.1f} px of one plane ({:g} px "
                    "are needed): "
                    "show things near and far",
                    relief_px, kMinReliefPx));
  }
  return {};
}

Result<void> CheckAgreement(const std::vector<SceneMatch>& matches,
                            const std::vector<MatchResidual>& residuals, size_t views) {
  const auto off = std::ranges::count_if(residuals, [](const MatchResidual& residual) {
    return !(std::abs(residual.rows_px) < kOffRowsPx);
  });
  const double share = static_cast<double>(off) / static_cast<double>(residuals.size());
  if (share > kMaxOff) {
    return Fail(fmt::format(
        "{:.0f} % of {} matches fit no calibration ({:.0f} % are allowed): do both images show one "
        "scene, taken at one time?",
        100 * share, residuals.size(), 100 * kMaxOff));
  }
  std::vector<std::vector<double>> of_view(views);
  for (size_t i = 0; i < matches.size(); ++i) {
    of_view[matches[i].view].push_back(residuals[i].rows_px);
  }
  std::vector<double> medians;
  for (std::vector<double>& rows : of_view) {
    if (rows.size() >= kMinInView) medians.push_back(std::abs(Median(rows)));
  }
  if (!medians.empty() && Median(medians) > kMaxSpreadPx) {
    return Fail(fmt::format(
        "frames contradict one another: with one calibration for all, their rows are {:.2f} px off "
        "in the median ({:g} are allowed): are the cameras synchronised, and did nothing move in "
        "the rig?",
        Median(medians), kMaxSpreadPx));
  }
  return {};
}

std::vector<std::string> ReasonsAgainst(const SceneRefinement& refinement) {
  std::vector<std::string> reasons;
  const SceneFit& after = refinement.after;
  if (after.rows_abs_95_px > kMaxRowsPx) {
    reasons.push_back(
        fmt::format("rows of the pair still differ by up to {:.2f} px (95 %; {:g} are "
                    "allowed)",
                    after.rows_abs_95_px, kMaxRowsPx));
  }
  if (std::abs(after.tof_px) > kMaxTofPx) {
    reasons.push_back(
        fmt::format("ToF ranges still differ from stereo by {:+.2f} px ({:g} are "
                    "allowed)",
                    after.tof_px, kMaxTofPx));
  }
  const auto worse = [&](const char* what, double SceneFit::*px, double most_px) {
    if (!(after.*px > refinement.before.*px + most_px)) return;
    reasons.push_back(fmt::format("{} fit worse than before: {:.2f} instead of {:.2f} px", what,
                                  after.*px, refinement.before.*px));
  };
  worse("rows", &SceneFit::rows_abs_median_px, kMaxWorsePx);
  worse("ToF points", &SceneFit::tof_abs_px, std::max(kMaxWorsePx, MaxRangeErrorPx(refinement)));
  for (size_t number = 0; number < kRigNumbers; ++number) {
    const RigNumberRow& row = RowOf(static_cast<RigNumber>(number));
    const double change = refinement.adjusted.change[number];
    if (std::abs(change) <= kMaxExpected * row.expected) continue;
    reasons.push_back(fmt::format(
        "{} changed by {:+.{}f} {}, which is no knock any more: calibrate with the board", row.name,
        row.per_unit * change, row.digits, row.unit));
  }
  if (const double yaw = refinement.adjusted.change[kYaw]; yaw != 0 && !refinement.curve.empty()) {
    const RigNumberRow& row = RowOf(kYaw);
    reasons.push_back(fmt::format(
        "{} by {:+.{}f} {} would leave errors of the ToF ranges that it cannot make: is the range "
        "sensor right (scale, offset)?",
        row.name, row.per_unit * yaw, row.digits, row.unit));
  }
  const auto most = std::ranges::max_element(
      refinement.curve, {}, [](const CorrectionKnot& knot) { return std::abs(knot.offset_m); });
  if (most != refinement.curve.end() &&
      std::abs(most->offset_m) > kMaxExpected * kExpectedRangeErrorM) {
    reasons.push_back(fmt::format(
        "ToF ranges at {:.2f} m changed by {:+.1f} mm, which is no error of a sensor any more: is "
        "the range image of the same moment, and does nothing move?",
        most->range_m, 1000 * most->offset_m));
  }
  if (std::abs(refinement.light.offset_m) > kMaxExpected * kExpectedRangeErrorM) {
    reasons.push_back(fmt::format(
        "ToF ranges of bright and of dark surfaces changed by {:+.1f} mm against each other, which "
        "is no error of a sensor any more",
        1000 * refinement.light.offset_m));
  }
  return reasons;
}

cv::Mat1f RowsOverImage(const SceneRefinement& refinement, const RectifiedPair& pair) {
  std::array<std::vector<double>, static_cast<size_t>(kColumns * kBands)> rows;
  for (const ShownMatch& match : refinement.shown) {
    rows[CellOf(match.left, pair)].push_back(match.rows_before_px);
  }
  cv::Mat1f cells(kBands, kColumns, std::numeric_limits<float>::quiet_NaN());
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].size() < kMinInCell) continue;
    cells(static_cast<int>(i)) = static_cast<float>(Median(std::move(rows[i])));
  }
  return cells;
}

cv::Point2d TofShift(const SceneRefinement& refinement, const RectifiedPair& pair) {
  const auto shift = [&](RigNumber number) {
    if (!refinement.is_good() || !refinement.wanted[number] || !refinement.adjusted.seen[number]) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    return pair.focal_px * refinement.adjusted.change[number];
  };
  return {shift(kTofYaw), -shift(kTofPitch)};  // as the turn of refine::ApplyOffset()
}

std::vector<std::string> ReasonsToCalibrate(const SceneRefinement& refinement,
                                            const inputs::Findings& findings,
                                            const RectifiedPair& pair) {
  std::vector<std::string> reasons;
  const SceneFit& fit = refinement.before;
  const bool rows_differ = std::abs(fit.rows_median_px) > kMaxRowsPx;
  for (const inputs::Finding& finding : findings) {
    if (finding.verdict != inputs::Verdict::kBad) continue;
    if (finding.question == inputs::Question::kRows && rows_differ) continue;  // said below
    reasons.push_back(finding.text);
  }
  float worst = 0;
  for (const float cell : RowsOverImage(refinement, pair)) {
    if (std::abs(cell) > std::abs(worst)) worst = cell;
  }
  if (rows_differ) {
    reasons.push_back(fmt::format(
        "rows of the right image lie {:+.2f} px off those of the left one ({} are allowed)",
        fit.rows_median_px, kMaxRowsPx));
  } else if (std::abs(worst) > kMaxRowsPx) {
    reasons.push_back(
        fmt::format("rows of the right image lie up to {:+.2f} px off those of the left one in "
                    "parts of the image ({} are allowed)",
                    worst, kMaxRowsPx));
  }
  const cv::Point2d shift = TofShift(refinement, pair);
  if (const double px = cv::norm(shift); px > kMaxTofShiftPx) {
    reasons.push_back(
        fmt::format("ToF points are {:.1f} px beside the objects they were measured on ({} are "
                    "allowed): was the ToF camera knocked?",
                    px, kMaxTofShiftPx));
  }
  if (std::abs(fit.tof_px) > kMaxTofPx) {
    reasons.push_back(
        fmt::format("the ToF camera's ranges differ from stereo by {:+.0f} mm, "
                    "{:+.1f} px of disparity ({} are allowed)",
                    1000 * fit.tof_m, fit.tof_px, kMaxTofPx));
  }
  return reasons;
}

}  // namespace sprout::calibrate
