#include <fmt/core.h>

#include <cmath>
#include <vector>

#include "common/picture/html.h"
#include "services/tools/calibrate/report.h"
#include "services/tools/calibrate/scene/scene_checks.h"

namespace sprout::calibrate {
namespace {

// Colours of the rows' errors: what `check` allows is in the middle.
constexpr double kReddestPx = 2;

using Table = std::vector<std::vector<std::string>>;

std::string Number(double value, int digits, const char* unit) {
  return std::isnan(value) ? "unknown" : fmt::format("{:+.{}f} {}", value, digits, unit);
}

Table FitTable(const SceneRefinement& refinement) {
  const SceneFit& before = refinement.before;
  const SceneFit& after = refinement.after;
  Table rows = {{"how the frames fit", "before", "after"}};
  const auto add = [&](const char* name, double SceneFit::*value, double per_unit, int digits,
                       const char* unit) {
    rows.push_back({name, Number(per_unit * before.*value, digits, unit),
                    Number(per_unit * after.*value, digits, unit)});
  };
  add("rows, right less left, median", &SceneFit::rows_median_px, 1, 3, "px");
  add("size of that, median", &SceneFit::rows_abs_median_px, 1, 3, "px");
  add("size of that, 95 %", &SceneFit::rows_abs_95_px, 1, 3, "px");
  if (refinement.tof_matches == 0) return rows;
  add("ToF less stereo, median", &SceneFit::tof_px, 1, 2, "px");
  add("size of that, median", &SceneFit::tof_abs_px, 1, 2, "px");
  add("ToF less stereo, median", &SceneFit::tof_m, 1000, 1, "mm");
  add("size of that, median", &SceneFit::tof_abs_m, 1000, 1, "mm");
  return rows;
}

std::string Deviation(const RigNumberRow& row, double sigma) {
  return fmt::format("{:.{}f} {}", row.per_unit * sigma, row.digits, row.unit);
}

// A remark on a change that the frames need, but that something else would explain as well.
std::string AttributionText(const AdjustedScene& adjusted, size_t number) {
  if (std::abs(adjusted.change[number]) >= kSureChangeSigmas * adjusted.sigma[number]) return "";
  if (number == kYaw) return "or ToF ranges: the scene does not tell which";
  if (number == kRangeOffset) return "or a yaw, or moved some mm: the scene does not tell which";
  return number < kTofPitch ? "" : "or moved some mm: the scene does not tell which";
}

Table NumberTable(const SceneRefinement& refinement) {
  Table rows = {{"what changes", "by", "standard deviation", ""}};
  for (size_t i = 0; i < kRigNumbers; ++i) {
    const RigNumberRow& row = RowOf(static_cast<RigNumber>(i));
    const AdjustedScene& adjusted = refinement.adjusted;
    const bool has_tof = refinement.rig.tof.width > 0 && i >= kTofPitch;
    if (!refinement.wanted[i] && !has_tof) {
      rows.push_back({row.name, "", "", "kept"});
    } else if (!refinement.wanted[i] || !adjusted.seen[i]) {
      rows.push_back({row.name, "", "", "stays: the scene does not show it"});
    } else if (adjusted.change[i] == 0) {
      rows.push_back({row.name, "", Deviation(row, adjusted.sigma[i]), "stays: no change is sure"});
    } else {
      rows.push_back({row.name, Number(row.per_unit * adjusted.change[i], row.digits, row.unit),
                      Deviation(row, adjusted.sigma[i]), AttributionText(adjusted, i)});
    }
  }
  return rows;
}

Table CurveTable(const SceneRefinement& refinement) {
  Table rows;
  const AmplitudeCorrection& light = refinement.light;
  if (refinement.curve.empty() && light.empty()) return rows;
  rows.push_back({"ranges are corrected at", "by", "standard deviation"});
  for (const CorrectionKnot& knot : refinement.curve) {
    rows.push_back({fmt::format("{:.2f} m", knot.range_m), Number(1000 * knot.offset_m, 1, "mm"),
                    fmt::format("{:.1f} mm", 1000 * knot.sigma_m)});
  }
  if (!light.empty()) {
    rows.push_back({"bright surfaces, less dark ones", Number(1000 * light.offset_m, 1, "mm"),
                    fmt::format("{:.1f} mm", 1000 * light.sigma_m)});
  }
  return rows;
}

std::string CountsText(const SceneRefinement& refinement) {
  std::string text = fmt::format("{} frames, {} matches", refinement.views, refinement.matches);
  if (refinement.rig.tof.width > 0) {
    text += fmt::format(", {} of them on surfaces of the ToF camera; depth edges in {} frames",
                        refinement.tof_matches, refinement.edge_views);
  }
  return text;
}

std::string TableText(const Table& table) {
  std::string text;
  for (const std::vector<std::string>& row : table) {
    std::string line = fmt::format("{:<32}", row[0]);
    for (size_t i = 1; i < row.size(); ++i) line += fmt::format("{:<20}", row[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string RowsPicture(const SceneRefinement& refinement, const cv::Mat& left, bool after) {
  std::vector<cv::Point2d> places;
  std::vector<double> sizes_px;
  for (const ShownMatch& match : refinement.shown) {
    places.push_back(match.left);
    sizes_px.push_back(std::abs(after ? match.rows_after_px : match.rows_before_px));
  }
  return FigureHtml(DotsPicture(left, places, sizes_px, kReddestPx), after ? "after" : "before");
}

}  // namespace

std::string SceneSummaryText(const SceneRefinement& refinement) {
  std::string text = fmt::format("{}\ncalibration: {}\n", CountsText(refinement),
                                 VerdictText(refinement.is_good()));
  for (const std::string& reason : refinement.reasons) text += "  * " + reason + "\n";
  return text + TableText(FitTable(refinement)) + TableText(NumberTable(refinement)) +
         TableText(CurveTable(refinement));
}

std::string SceneCheckText(const SceneRefinement& refinement, const RectifiedPair& pair) {
  const SceneFit& fit = refinement.before;
  std::string text =
      fmt::format("{:<30} {}\n", "rows, right less left", Number(fit.rows_median_px, 2, "px"));
  const cv::Mat1f cells = RowsOverImage(refinement, pair);
  for (int row = 0; row < cells.rows; ++row) {
    text += fmt::format("{:<30}", row == 0 ? "  over the image" : "");
    for (const float cell : cv::Mat1f(cells.row(row))) {
      text += std::isnan(cell) ? "      -" : fmt::format(" {:+6.2f}", cell);
    }
    text += "\n";
  }
  if (refinement.tof_matches == 0) return text;
  const cv::Point2d shift = TofShift(refinement, pair);
  text +=
      fmt::format("{:<30} {}, {} (depth edges in {} frames)\n", "ToF points belong, right, down",
                  Number(shift.x, 1, "px"), Number(shift.y, 1, "px"), refinement.edge_views);
  text += fmt::format("{:<30} {}, {}\n", "ToF ranges less stereo", Number(fit.tof_px, 2, "px"),
                      Number(1000 * fit.tof_m, 0, "mm"));
  return text;
}

std::string SceneReportHtml(const SceneRefinement& refinement, const SceneRefiner& refiner) {
  std::string html = ReportStart("Calibration, refined without a board", refinement.reasons);
  html += "<p>" + EscapedHtml(CountsText(refinement)) + ".</p>\n" + TableHtml(FitTable(refinement));
  html +=
      "<h2>What changes</h2>\n<p>Standard deviations from the scatter and the number of "
      "the matches.</p>\n" +
      TableHtml(NumberTable(refinement));
  if (const Table rows = CurveTable(refinement); !rows.empty()) html += TableHtml(rows);

  const SceneRefiner::View& view = refiner.best_view();
  html +=
      "<h2>Rows of all matches</h2>\n<p>A dot each: how far its row in the right image is "
      "off.</p>\n" +
      RowsPicture(refinement, view.left, false) + RowsPicture(refinement, view.left, true);
  const Rectification after = RectificationOf(refinement.rig);
  const cv::Mat1b left = refiner.LeftAgain(refinement.rig, after).Apply(view.left);
  html += "<h2>The rectified pair</h2>\n" +
          FigureHtml(PairPicture(view.left, view.right), "before") +
          FigureHtml(PairPicture(left, refiner.RightAgain(refinement.rig, after).Apply(view.right)),
                     "after: a point lies on the same row in both images");
  if (refinement.tof_matches > 0) {
    html += "<h2>ToF points on the left image</h2>\n" +
            FigureHtml(TofPicture(view.left, view.tof, refiner.RigBefore()), "before") +
            FigureHtml(TofPicture(left, view.tof, RectifiedRig(refinement.rig, after)),
                       "after: red is near, blue is far");
  }
  return html + PageEnd();
}

}  // namespace sprout::calibrate
