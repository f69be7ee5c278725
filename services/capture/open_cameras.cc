#include <algorithm>
#include <climits>
#include <string_view>
#include <utility>

#include "common/core/number_text.h"
#include "common/picture/eight_bits.h"
#include "common/rig/rig_file.h"
#include "common/scenes/source_options.h"
#include "services/capture/genicam/genicam_source.h"
#include "services/capture/raw_source.h"
#include "services/capture/video_source.h"

namespace sprout::capture {
namespace {

constexpr std::string_view kGenicam = "genicam:";
constexpr std::string_view kOpenCv = "opencv:";
constexpr std::string_view kV4l2 = "v4l2:";
constexpr double kMaxOffsetMs = 1e8;  // a day

template <typename Number>
Number NumberOf(const std::string& source, const scenes::SourceOption& option, Number least,
                Number most, const std::string& allowed) {
  const std::optional<Number> number = ParseNumber<Number>(option.value);
  if (number && *number >= least && *number <= most) return *number;
  throw scenes::BadSource(source, "cannot be used: " + std::string(option.text), allowed);
}

int Positive(const std::string& source, const scenes::SourceOption& option) {
  return NumberOf(source, option, 1, INT_MAX, "?width=PX&height=PX&fps=HZ, each a number above 0");
}

// The places of a source: "opencv:" has two, separated by a comma, or one with both views; "v4l2:"
// has one.
std::vector<std::string> PlacesOf(const std::string& source, const std::string& place) {
  const bool is_device = place.starts_with(kV4l2);
  const auto names =
      SplitAt(',', std::string_view(place).substr((is_device ? kV4l2 : kOpenCv).size()));
  const size_t most = is_device ? 1 : 2;
  if (names.size() > most || std::ranges::count(names, std::string_view()) > 0) {
    throw scenes::BadSource(source, "not one or two places",
                            "opencv:LEFT,RIGHT, opencv:BOTH or v4l2:DEVICE, ?rig=FILE behind it");
  }
  if (names.size() == 2 && names[0] == names[1]) {
    throw scenes::BadSource(source, "left and right are both " + std::string(names[0]),
                            "opencv:LEFT,RIGHT, or opencv:BOTH with both views side by side");
  }
  return {names.begin(), names.end()};
}

}  // namespace

bool NamesCameras(const std::string& source) {
  return source.starts_with(kGenicam) || source.starts_with(kOpenCv) || source.starts_with(kV4l2);
}

OpenedCameras OpenCameras(const std::string& source, bool loop, scenes::Waiting waiting,
                          bool calibrated) {
  if (source.starts_with(kGenicam)) {
    const std::string path = source.substr(kGenicam.size());
    const RigDescription rig = LoadRigFile(path);
    OpenedCameras opened;
    if (calibrated && rig.has_calibration()) opened.rig = std::make_shared<CurrentRig>(rig, path);
    opened.cameras = OpenGenicam(rig, path, std::move(waiting));
    return opened;
  }
  const auto [place, options] = scenes::SplitSource(source);
  VideoSettings settings{
      .places = PlacesOf(source, place), .loop = loop, .waiting = std::move(waiting)};
  OpenedCameras opened;
  for (const scenes::SourceOption& option : options) {
    if (option.name == "rig") {
      RigDescription rig = LoadRigFile(option.value);
      if (calibrated) opened.rig = std::make_shared<CurrentRig>(std::move(rig), option.value);
    } else if (option.name == "width") {
      settings.device.width = Positive(source, option);
    } else if (option.name == "height") {
      settings.device.height = Positive(source, option);
    } else if (option.name == "fps") {
      settings.device.fps = Positive(source, option);
    } else if (option.name == "bits") {
      settings.bits = NumberOf(source, option, kMinBits, kMaxBits, "?bits=8 to 16");
    } else if (option.name == "offset_ms") {
      settings.offset_ms = NumberOf(source, option, -kMaxOffsetMs, kMaxOffsetMs,
                                    "?offset_ms=MS, how much later the right video begins");
    } else {
      throw scenes::BadSource(source, "no such option " + std::string(option.text),
                              "?rig=FILE, &width=PX, &height=PX, &fps=HZ, &bits=N, &offset_ms=MS");
    }
  }
  opened.cameras = OpenVideo(settings);
  return opened;
}

}  // namespace sprout::capture
