#include "services/batch/report_pictures.h"

#include <fmt/core.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/picture/color_map.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"

namespace sprout::batch {
namespace {

constexpr int kPictureWidth = 420;  // px; the report has dozens
constexpr int kJpegQuality = 85;

std::string Image(const cv::Mat& picture) {
  cv::Mat small = picture;
  if (picture.cols > kPictureWidth) {
    cv::resize(picture, small, cv::Size(kPictureWidth, picture.rows * kPictureWidth / picture.cols),
               0, 0, cv::INTER_AREA);
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return "<img alt=\"\" src=\"" + DataUrl("image/jpeg", jpeg) + "\">\n";
}

// Grey where both agree, from blue to red (2 px and more) where they differ, white where only one
// has a disparity.
cv::Mat3b DifferencePicture(const DisparityImage& a, const DisparityImage& b) {
  cv::Mat3b picture(a.size());
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const bool in_a = a.IsValid(u, v);
      const bool in_b = b.IsValid(u, v);
      const double px = in_a && in_b ? std::abs(a.Px(u, v) - b.Px(u, v)) : 0;
      picture(v, u) = in_a != in_b ? cv::Vec3b(255, 255, 255)
                      : px == 0    ? cv::Vec3b(64, 64, 64)
                                   : ColorOf(px, {.min = 0, .max = 2});
    }
  }
  return picture;
}

std::string Maps(const std::vector<DisparityImage>& maps, const std::vector<std::string>& names) {
  const ValueRange range = DisparityRange(maps, {});
  std::string html;
  for (size_t i = 0; i < maps.size(); ++i) {
    html += Image(DisparityPicture(maps[i], range, names[i]));
  }
  if (maps.size() == 2 && maps[0].size() == maps[1].size()) {
    html += Image(CameraPicture(DifferencePicture(maps[0], maps[1]), "|A - B|"));
  }
  return html;
}

}  // namespace

FrameLookup& ReportPictures::ResultOf(size_t variant, size_t shard) {
  auto& lookup = results_[{variant, shard}];
  if (!lookup) {
    const BatchHead& head = manifest_.head;
    const std::string key = ResultKey(head, head.variants[variant], manifest_.shards[shard]);
    lookup = std::make_unique<FrameLookup>(head.prefix);
    for (const std::string& stage : head.keep) {
      lookup->Add(folder_.result(key) / (stage + ".lcm"));
    }
  }
  return *lookup;
}

cv::Mat ReportPictures::LeftOf(size_t shard, const FrameId& id) const {
  const Shard& of_shard = manifest_.shards[shard];
  const BatchLog& log = manifest_.logs[static_cast<size_t>(of_shard.log)];
  std::vector<IndexedEvent> events = ReadIndexLines(log.index, of_shard.begin, of_shard.end);
  for (const int64_t line : of_shard.carried) events.push_back(ReadIndexLine(log.index, line));
  FrameLookup input(manifest_.head.prefix);
  input.Add(log.path, events);
  return input.Get(id, {Part::kLeft}).left;
}

std::string ReportPictures::HtmlOf(size_t shard, int64_t seq, int64_t utime) {
  const FrameId id{.utime = utime, .seq = seq, .rig_id = {}};
  try {
    std::string html;
    if (const cv::Mat left = LeftOf(shard, id); !left.empty()) {
      html += Image(CameraPicture(left, "Left image"));
    }
    std::vector<DisparityImage> maps;
    std::vector<std::string> names;
    for (size_t i = 0; i < manifest_.head.variants.size(); ++i) {
      Frame frame = ResultOf(i, shard).Get(id, {Part::kFused, Part::kDisparity, Part::kPrior});
      if (frame.fused) frame.disparity = frame.fused;
      if (!frame.disparity && frame.prior) frame.disparity = frame.prior->disparity;
      if (!frame.disparity || frame.disparity->empty()) continue;
      maps.push_back(*frame.disparity);
      names.emplace_back(i == 0 ? "A: disparity" : "B: disparity");
    }
    if (!maps.empty()) html += Maps(maps, names);
    return "<div class=\"pictures\">" + html + "</div>\n";
  } catch (const LogError& e) {
    return "<p class=\"bad\">No pictures: " + EscapedHtml(e.what()) + "</p>\n";
  }
}

}  // namespace sprout::batch
