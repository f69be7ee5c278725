#include "services/tools/log/message_diff.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <opencv2/core.hpp>
#include <vector>

#include "common/core/image.h"
#include "common/messages/message_type.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"

namespace sprout::log {
namespace {

// Compares bits, so that NaN is equal to itself.
int64_t CountDifferent(const cv::Mat& a, const cv::Mat& b) {
  int64_t count = 0;
  const size_t bytes = a.elemSize();
  for (int v = 0; v < a.rows; ++v) {
    for (int u = 0; u < a.cols; ++u) {
      const size_t at = bytes * static_cast<size_t>(u);
      if (std::memcmp(a.ptr(v) + at, b.ptr(v) + at, bytes) != 0) ++count;
    }
  }
  return count;
}

bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && CountDifferent(a, b) == 0;
}

MessageDiff Equal() { return {.equal = true, .text = "", .disparity = {}}; }

MessageDiff Different(std::string text) {
  return {.equal = false, .text = std::move(text), .disparity = {}};
}

MessageDiff CompareValue(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) {
    return Different(fmt::format("{} in {} colours and {} in {}", SizeText(a.size()), a.channels(),
                                 SizeText(b.size()), b.channels()));
  }
  if (SameBits(a, b)) return Equal();
  return Different(fmt::format("{} of {} pixels differ, by at most {:.0f} grey levels",
                               CountDifferent(a, b), a.total(), cv::norm(a, b, cv::NORM_INF)));
}

MessageDiff CompareValue(const TofImage& a, const TofImage& b) {
  if (SameBits(a.depth_m, b.depth_m) && SameBits(a.amplitude, b.amplitude)) return Equal();
  if (a.depth_m.size() != b.depth_m.size()) {
    return Different(SizeText(a.depth_m.size()) + " and " + SizeText(b.depth_m.size()));
  }
  if (SameBits(a.depth_m, b.depth_m)) return Different("amplitudes differ");
  return Different(fmt::format("{} of {} depths differ", CountDifferent(a.depth_m, b.depth_m),
                               a.depth_m.total()));
}

MessageDiff CompareValue(const Rig& a, const Rig& b) {
  return RigId(a) == RigId(b) ? Equal() : Different("calibrations differ");
}

MessageDiff CompareValue(const SeedSet& a, const SeedSet& b) {
  if (a == b) return Equal();
  const auto [in_a, in_b] =
      std::mismatch(a.seeds.begin(), a.seeds.end(), b.seeds.begin(), b.seeds.end());
  if (in_a == a.seeds.end() && in_b == b.seeds.end()) {
    return Different("same seeds, but the counts of dropped points differ");
  }
  return Different(fmt::format("{} and {} seeds, first difference at number {}", a.seeds.size(),
                               b.seeds.size(), in_a - a.seeds.begin()));
}

std::string Text(const DisparityDiff& diff) {
  return fmt::format(
      "{} of {} pixels differ: {} changed (mean {:.3f} px, max {:.3f} px), {} newly valid, {} "
      "newly invalid; first at ({}, {})",
      diff.differing, diff.pixels, diff.changed, diff.mean_px(), diff.max_px, diff.newly_valid,
      diff.newly_invalid, diff.first.x, diff.first.y);
}

MessageDiff CompareValue(const DisparityImage& a, const DisparityImage& b) {
  if (a.size() != b.size()) return Different(SizeText(a.size()) + " and " + SizeText(b.size()));
  const DisparityDiff diff = Compare(a, b);
  if (diff.differing == 0) return Equal();
  return {.equal = false, .text = Text(diff), .disparity = diff};
}

MessageDiff CompareValue(const PriorMap& a, const PriorMap& b) {
  MessageDiff diff = CompareValue(a.disparity, b.disparity);
  if (a.size() != b.size() || SameBits(a.sigma, b.sigma)) return diff;
  const std::string sigma = fmt::format(
      "{} of {} standard deviations differ, by at most {:.3f} px", CountDifferent(a.sigma, b.sigma),
      a.sigma.total(), cv::norm(a.sigma, b.sigma, cv::NORM_INF) / kSigmaCountsPerPx);
  diff.text = diff.equal ? "same disparities, but " + sigma : diff.text + "; " + sigma;
  diff.equal = false;
  return diff;
}

MessageDiff CompareValue(const DepthImage& a, const DepthImage& b) {
  if (a.size() != b.size()) return Different(SizeText(a.size()) + " and " + SizeText(b.size()));
  if (a.metres_per_count != b.metres_per_count || a.focal_px != b.focal_px || a.cx != b.cx ||
      a.cy != b.cy) {
    return Different("intrinsics or units differ");
  }
  if (SameBits(a.counts, b.counts)) return Equal();
  return Different(
      fmt::format("{} of {} depths differ", CountDifferent(a.counts, b.counts), a.counts.total()));
}

MessageDiff CompareValue(const PointCloud& a, const PointCloud& b) {
  if (a == b) return Equal();
  const auto [in_a, in_b] =
      std::mismatch(a.points.begin(), a.points.end(), b.points.begin(), b.points.end());
  return Different(fmt::format("{} and {} points, first difference at number {}", a.points.size(),
                               b.points.size(), in_a - a.points.begin()));
}

MessageDiff CompareValue(const CameraMotion& a, const CameraMotion& b) {
  if (a == b) return Equal();
  const Pose difference = a.last_from_left.Inverse() * b.last_from_left;
  return Different(fmt::format("motions differ by {:.6f} m; {} and {} inliers",
                               difference.translation_m.norm(), a.inliers, b.inliers));
}

MessageDiff CompareValue(const DepthCounts& a, const DepthCounts& b) {
  if (a == b) return Equal();
  return Different(fmt::format("{} of {} and {} of {} pixels left out", a.LeftOut(), a.pixels,
                               b.LeftOut(), b.pixels));
}

MessageDiff CompareValue(const TofZones& a, const TofZones& b) {
  if (a == b) return Equal();
  if (a.targets.size() != b.targets.size() || a.views != b.views) {
    return Different(
        fmt::format("{}×{} and {}×{} zones, or others", a.columns, a.rows, b.columns, b.rows));
  }
  size_t differing = 0;
  for (size_t i = 0; i < a.targets.size(); ++i) differing += a.targets[i] != b.targets[i];
  return Different(fmt::format("{} of {} targets differ", differing, a.targets.size()));
}

std::string HeaderText(const FrameId& a, const FrameId& b) {
  if (a.rig_id != b.rig_id) return "rig_id " + a.rig_id + " and " + b.rig_id;
  return "headers differ";
}

struct Pictures {
  cv::Mat3b a;
  cv::Mat3b b;
  cv::Mat3b difference;
};

// |b − a| as a disparity map. A pixel that is valid in one map only has the largest difference; one
// that is valid in neither is invalid.
DisparityImage Difference(const DisparityImage& a, const DisparityImage& b) {
  DisparityImage difference(a.size());
  for (int v = 0; v < a.height(); ++v) {
    for (int u = 0; u < a.width(); ++u) {
      if (!a.IsValid(u, v) && !b.IsValid(u, v)) continue;
      const int counts = a.IsValid(u, v) && b.IsValid(u, v)
                             ? std::abs(b.counts()(v, u) - a.counts()(v, u))
                             : INT16_MAX;
      difference.counts()(v, u) = static_cast<int16_t>(std::min(counts, int{INT16_MAX}));
    }
  }
  return difference;
}

// The range begins at 0, so that equal pixels have one colour in all pictures.
ValueRange DifferenceRange(const DisparityImage& a, const DisparityImage& b) {
  std::vector<float> changed;
  for (int v = 0; v < a.height(); ++v) {
    for (int u = 0; u < a.width(); ++u) {
      const float difference = std::abs(b.Px(u, v) - a.Px(u, v));
      if (difference > 0) changed.push_back(difference);  // NaN is not
    }
  }
  return {.min = 0, .max = RobustRange(std::move(changed)).max};
}

std::optional<Pictures> PicturesOf(const DisparityImage& a, const DisparityImage& b,
                                   const std::string& title) {
  if (a.size() != b.size() || a.empty()) return std::nullopt;
  const ValueRange range_px = DisparityRange(std::vector{a, b}, {});
  const DisparityDiff diff = Compare(a, b);
  return Pictures{
      .a = DisparityPicture(a, range_px, "A: " + title),
      .b = DisparityPicture(b, range_px, "B: " + title),
      .difference = DisparityPicture(
          Difference(a, b), DifferenceRange(a, b),
          fmt::format("|B - A|: {:.2f} % differ, {} newly valid, {} newly invalid (most)",
                      100 * static_cast<double>(diff.differing) / static_cast<double>(diff.pixels),
                      diff.newly_valid, diff.newly_invalid))};
}

std::optional<Pictures> PicturesOf(const cv::Mat& a, const cv::Mat& b, const std::string& title) {
  if (a.size() != b.size() || a.type() != b.type() || a.empty()) return std::nullopt;
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  const double most = cv::norm(a, b, cv::NORM_INF);
  if (most > 0) difference.convertTo(difference, -1, 255 / most);
  return Pictures{.a = CameraPicture(a, "A: " + title),
                  .b = CameraPicture(b, "B: " + title),
                  .difference = CameraPicture(
                      difference, fmt::format("|B - A|, white = {:.0f} grey levels", most))};
}

std::optional<Pictures> PicturesOf(const PriorMap& a, const PriorMap& b, const std::string& title) {
  return PicturesOf(a.disparity, b.disparity, title);
}

template <typename Value>
std::optional<Pictures> PicturesOf(const Value& /*a*/, const Value& /*b*/,
                                   const std::string& /*title*/) {
  return std::nullopt;
}

}  // namespace

MessageDiff Compare(std::span<const uint8_t> a, std::span<const uint8_t> b) {
  const auto type_a = TypeOf(a);
  if (type_a != TypeOf(b)) return Different("types differ");
  if (!type_a) return Different(fmt::format("{} and {} bytes differ", a.size(), b.size()));
  const auto message_a = DecodeAs(*type_a, a);
  const auto message_b = DecodeAs(*type_a, b);
  if (!message_a) return Different("undecodable in A: " + message_a.error().text);
  if (!message_b) return Different("undecodable in B: " + message_b.error().text);
  const PartValue* const value_a = std::get_if<PartValue>(&message_a->value);
  const PartValue* const value_b = std::get_if<PartValue>(&message_b->value);
  if (value_a == nullptr || value_b == nullptr) return Different(NameOf(*type_a) + " differs");
  MessageDiff diff = std::visit(
      [&](const auto& value) {
        return CompareValue(value, std::get<std::decay_t<decltype(value)>>(*value_b));
      },
      *value_a);
  // A calibration names the newest frame, which does not belong to it.
  const bool same_header = message_a->id == message_b->id || type_a == MessageType::kRig;
  if (diff.equal && !same_header) return Different(HeaderText(message_a->id, message_b->id));
  return diff;
}

void WriteDifferencePictures(std::span<const uint8_t> a, std::span<const uint8_t> b,
                             const std::string& channel, FrameFileNames& names) {
  const auto type = TypeOf(a);
  if (!type || type != TypeOf(b)) return;
  const auto message_a = DecodeAs(*type, a);
  const auto message_b = DecodeAs(*type, b);
  if (!message_a || !message_b) return;
  const PartValue* const value_a = std::get_if<PartValue>(&message_a->value);
  const PartValue* const value_b = std::get_if<PartValue>(&message_b->value);
  if (value_a == nullptr || value_b == nullptr) return;
  const FrameId& id = message_a->id;
  const std::string title = fmt::format("{}, frame {}", channel, id.seq);
  const std::optional<Pictures> pictures = std::visit(
      [&](const auto& value) {
        return PicturesOf(value, std::get<std::decay_t<decltype(value)>>(*value_b), title);
      },
      *value_a);
  if (!pictures) return;
  RequireWritten(WritePng(names.Of(id, channel + "_a.png"), pictures->a));
  RequireWritten(WritePng(names.Of(id, channel + "_b.png"), pictures->b));
  RequireWritten(WritePng(names.Of(id, channel + "_difference.png"), pictures->difference));
}

}  // namespace sprout::log
