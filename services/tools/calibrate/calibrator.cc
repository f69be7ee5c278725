#include "services/tools/calibrate/calibrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/tools/calibrate/range_points.h"
#include "services/tools/calibrate/rig_model.h"
#include "services/tools/calibrate/rig_refinement.h"

namespace sprout::calibrate {
namespace {

bool IsUsable(const Board& board, const BoardCorners& corners) {
  return corners.size() >= kMinCorners && !IsOneLine(board, corners);
}

// Removes corners of cameras that see too few, and views of which nothing is left.
void DropUnusable(const Board& board, std::vector<BoardView>& views) {
  for (BoardView& view : views) {
    for (BoardCorners& corners : view.corners) {
      if (!IsUsable(board, corners)) corners = {};
    }
  }
  std::erase_if(views, [](const BoardView& view) {
    return std::ranges::all_of(view.corners,
                               [](const auto& corners) { return corners.ids.empty(); });
  });
}

// The board's corners in the ToF image by the model.
BoardCorners ExpectedInTof(const Board& board, const RigModel& model, size_t view) {
  const cv::Rect2d image({0, 0}, cv::Size2d(model.lenses[kTof].size()));
  BoardCorners expected;
  for (int id = 0; id < board.corner_count(); ++id) {
    const Eigen::Vector2d pixel = PixelOfCorner(model, kTof, view, board.corner(id));
    if (!image.contains({pixel.x(), pixel.y()})) continue;
    expected.ids.push_back(id);
    expected.pixels.emplace_back(pixel.x(), pixel.y());
  }
  return expected;
}

void FindMoreInTof(const Board& board, const RigModel& model, std::vector<BoardView>& views) {
  for (size_t i = 0; i < views.size(); ++i) {
    // Without another camera's corners the model knows no more corners than were found.
    if (views[i].corners[kLeft].ids.empty() && views[i].corners[kRight].ids.empty()) continue;
    BoardCorners corners =
        FindCornersNear(board, ExpectedInTof(board, model, i), views[i].tof.amplitude);
    if (IsUsable(board, corners)) views[i].corners[kTof] = std::move(corners);
  }
}

RawRig ToRawRig(const RigModel& model) {
  return {.left = model.lenses[kLeft],
          .right = model.lenses[kRight],
          .left_from_right = model.left_from_camera[kRight],
          .tof = model.lenses[kTof],
          .left_from_tof = model.left_from_camera[kTof],
          .range_scale = model.range_scale,
          .range_offset_m = model.range_offset_m};
}

}  // namespace

Result<void> CheckFoundRig(const RawRig& rig) {
  return CheckRawRig(rig).map_error([&](const Error& error) {
    const Eigen::Vector3d& place_m = rig.left_from_right.translation_m;
    const bool is_swapped = place_m.x() < -std::abs(place_m.y());
    return Error{"the calibration cannot be used: " + error.text +
                 (is_swapped ? "; are the left and the right camera swapped?" : "")};
  });
}

Result<Calibration> Calibrate(const Board& board, const std::array<cv::Size, kCameraCount>& sizes,
                              std::vector<BoardView> views) {
  DropUnusable(board, views);
  Result<RigModel> first = InitialModel(board, sizes, views);
  if (!first) return tl::unexpected(first.error());
  Result<RefinedModel> refined = RefineModel(board, views, {}, *first);
  if (!refined) return tl::unexpected(refined.error());
  if (!sizes[kTof].empty()) {
    const RigModel corners_only = refined->model;
    FindMoreInTof(board, corners_only, views);
    refined =
        RefineModel(board, views, CollectRangePoints(board, views, corners_only), corners_only);
    if (!refined) return tl::unexpected(refined.error());
  }
  Calibration calibration{.rig = ToRawRig(refined->model), .quality = {}};
  if (const Result<void> usable = CheckFoundRig(calibration.rig); !usable) {
    const Eigen::Vector3d& place_m = calibration.rig.left_from_right.translation_m;
    std::string cause;
    if (place_m.norm() < 1e-4) {
      cause = "; are left and right images of one camera?";
    } else if (place_m.x() > 0) {
      cause = "; do left and right images of one name show one moment?";
    }
    return Fail(usable.error().text + cause);
  }
  calibration.quality = QualityOf(*refined, calibration.rig, views);
  return calibration;
}

}  // namespace sprout::calibrate
