#include <algorithm>
#include <cmath>
#include <sstream>
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

ConfigError Bad(const std::string& source, const std::string& reason, const std::string& allowed) {
  return ConfigError("capture.source = " + source + ": " + reason + "; allowed: " + allowed);
}

int Positive(const std::string& source, const scenes::SourceOption& option) {
  const std::optional<int> number = ParseNumber<int>(option.value);
  if (number && *number > 0) return *number;
  throw Bad(source, "not a number above 0: " + std::string(option.text),
            "?width=PX&height=PX&fps=HZ");
}

int BitsOf(const std::string& source, const scenes::SourceOption& option) {
  const std::optional<int> bits = ParseNumber<int>(option.value);
  if (bits && *bits >= kMinBits && *bits <= kMaxBits) return *bits;
  throw Bad(source, "no number of bits: " + std::string(option.text), "8 to 16");
}

double OffsetOf(const std::string& source, const scenes::SourceOption& option) {
  constexpr double kMaxMs = 1e8;  // a day
  const std::optional<double> offset_ms = ParseNumber<double>(option.value);
  if (offset_ms && std::abs(*offset_ms) <= kMaxMs) return *offset_ms;
  throw Bad(source, "no offset: " + std::string(option.text),
            "how much later the right video begins, ms");
}

// The places of a source: "opencv:" has two, separated by a comma, or one with both views; "v4l2:"
// has one.
std::vector<std::string> PlacesOf(const std::string& source, const std::string& place) {
  const bool is_device = place.starts_with(kV4l2);
  const std::string names = place.substr((is_device ? kV4l2 : kOpenCv).size());
  std::vector<std::string> places;
  std::istringstream text(names + ',');  // so that an empty one at the end counts
  for (std::string name; std::getline(text, name, ',');) places.push_back(name);
  const size_t most = is_device ? 1 : 2;
  if (places.empty() || places.size() > most || std::ranges::count(places, std::string()) > 0) {
    throw Bad(source, "not one or two places",
              "opencv:LEFT,RIGHT, opencv:BOTH or v4l2:DEVICE, ?rig=FILE behind it");
  }
  return places;
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
  VideoSettings settings{.places = PlacesOf(source, place), .loop = loop};
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
      settings.bits = BitsOf(source, option);
    } else if (option.name == "offset_ms") {
      settings.offset_ms = OffsetOf(source, option);
    } else {
      throw Bad(source, "no such option " + std::string(option.text),
                "?rig=FILE, &width=PX, &height=PX, &fps=HZ, &bits=N, &offset_ms=MS");
    }
  }
  opened.cameras = OpenVideo(settings);
  return opened;
}

}  // namespace sprout::capture
