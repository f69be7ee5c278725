#include "services/tools/log/difference_pictures.h"

#include <fmt/core.h>

#include <cstdlib>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <vector>

#include "common/messages/message_type.h"
#include "common/picture/color_map.h"
#include "common/picture/picture.h"
#include "common/picture/write_image.h"
#include "services/tools/log/message_diff.h"

namespace sprout::log {
namespace {

struct Pictures {
  cv::Mat3b a;
  cv::Mat3b b;
  cv::Mat3b difference;
};

// |b − a| as a map of its own, so that it is shown like one. A pixel that has a disparity in one of
// them only differs most; one that has none in both has none here.
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

void Write(const std::filesystem::path& path, const cv::Mat3b& picture) {
  if (const Result<void> written = WritePng(path, picture); !written) {
    throw std::runtime_error(written.error().text);
  }
}

}  // namespace

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
  Write(names.Of(id, channel + "_a.png"), pictures->a);
  Write(names.Of(id, channel + "_b.png"), pictures->b);
  Write(names.Of(id, channel + "_difference.png"), pictures->difference);
}

}  // namespace sprout::log
