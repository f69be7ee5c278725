#include <charconv>
#include <optional>
#include <string_view>

#include "services/capture/frame_source.h"
#include "services/capture/middlebury_source.h"
#include "services/capture/synthetic_source.h"

namespace sprout {
namespace {

ConfigError BadSource(const CaptureConfig& config, const std::string& reason,
                      const std::string& allowed) {
  return ConfigError("capture.source = " + config.source() + ": " + reason +
                     "; allowed: " + allowed);
}

std::optional<int> ParseInt(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

std::unique_ptr<FrameSource> OpenSyntheticText(std::string_view size_text,
                                               const CaptureConfig& config) {
  const std::string allowed = "synthetic:WxH with " + std::to_string(kMinSyntheticSide) + " to " +
                              std::to_string(kMaxSyntheticSide) + " px a side";
  const size_t cross = size_text.find('x');
  if (cross == std::string_view::npos) throw BadSource(config, "no size", allowed);
  const std::optional<int> width = ParseInt(size_text.substr(0, cross));
  const std::optional<int> height = ParseInt(size_text.substr(cross + 1));
  if (!width || !height) throw BadSource(config, "not a size", allowed);
  for (int side : {*width, *height}) {
    if (side < kMinSyntheticSide || side > kMaxSyntheticSide) {
      throw BadSource(config, "size out of range", allowed);
    }
  }
  return OpenSynthetic({*width, *height}, config);
}

// Applies what stands behind the '?' of a source.
void ApplyOptions(std::string_view options, CaptureConfig& config) {
  constexpr std::string_view kTof = "tof=";
  if (!options.starts_with(kTof)) {
    throw BadSource(config, "no such option ?" + std::string(options),
                    "?tof=grid, ?tof=sr4000 behind the source");
  }
  config.set_tof(std::string(options.substr(kTof.size())));
}

}  // namespace

std::unique_ptr<FrameSource> OpenFrameSource(const CaptureConfig& original) {
  RequireInRange(original, "capture");
  CaptureConfig config = original;
  const std::string& source = config.source();
  // The last one, as a folder's name may hold one too.
  const size_t question = source.rfind('?');
  if (question != std::string::npos) {
    ApplyOptions(std::string_view(source).substr(question + 1), config);
  }
  if (config.tof() != "grid" && config.tof() != "sr4000") {
    throw ConfigError("capture.tof = " + config.tof() +
                      ": no such ToF camera; allowed: grid, sr4000");
  }
  const std::string place = source.substr(0, question);
  const size_t colon = place.find(':');
  const std::string kind = place.substr(0, colon);
  const std::string argument = colon == std::string::npos ? "" : place.substr(colon + 1);
  if (kind == "middlebury") return OpenMiddlebury(argument, config);
  if (kind == "synthetic") return OpenSyntheticText(argument, config);
  const std::string allowed = "middlebury:DIR, synthetic:WxH, and for sprout-capture log:FILE";
  throw BadSource(config, kind == "log" ? "only sprout-capture plays logs" : "no such source",
                  allowed);
}

}  // namespace sprout
