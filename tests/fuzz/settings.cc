// Files that people write: configurations and rig files.
#include <filesystem>

#include "common/config/config.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "tests/common/logfile/sample_log.h"
#include "tests/common/rig/tilted_rig.h"
#include "tests/fuzz/targets.h"

namespace sprout::fuzz {
namespace {

// Larger images only take time.
constexpr int kMaxRectifiedSide = 128;

RawRig SmallRig() {
  RawRig rig = TiltedRig();
  for (Lens* lens : {&rig.left, &rig.right, &rig.tof}) {
    lens->width /= 10;
    lens->height /= 10;
    for (double* px : {&lens->fx, &lens->fy, &lens->cx, &lens->cy}) *px /= 10;
  }
  return rig;
}

}  // namespace

void ReadConfig(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  std::string text;
  try {
    text = ConfigText(LoadConfig({file.path()}));
  } catch (const ConfigError&) {
    return;
  }
  // What a program prints as its configuration can be given to it.
  const MemoryFile printed(BytesOf(text));
  Check(ConfigText(LoadConfig({printed.path()})) == text, "printed and read, it is another one");
}

std::vector<Bytes> ConfigSeeds() {
  const std::filesystem::path source(SPROUT_SOURCE_DIR);
  std::vector<Bytes> seeds{{}};
  for (const char* preset : {"default", "paper", "fast"}) {
    seeds.push_back(ReadBytes(source / "scripts/presets" / (std::string(preset) + ".textproto")));
  }
  seeds.push_back(ReadBytes(source / "logs/sample.textproto"));
  seeds.push_back(BytesOf(ConfigText(LoadConfig({}))));
  return seeds;
}

void ReadRig(std::span<const uint8_t> bytes) {
  const MemoryFile file(bytes);
  std::optional<RawRig> rig;
  try {
    rig = CalibrationOf(LoadRigFile(file.path()));
  } catch (const ConfigError&) {
    return;
  }
  if (!rig || std::max({rig->left.width, rig->left.height, rig->tof.width, rig->tof.height}) >
                  kMaxRectifiedSide) {
    return;
  }
  const Rectifier rectifier(*rig);
  const cv::Mat image(rig->left.height, rig->left.width, CV_8UC1, cv::Scalar(7));
  Check(rectifier.RectifyLeft(image).size() == image.size(), "an image changed its size");
  Check(rectifier.RectifyRight(image).size() == image.size(), "an image changed its size");
}

std::vector<Bytes> RigSeeds() {
  RigDescription small;
  *small.mutable_calibration() = ToCalibration(SmallRig());
  RigDescription large;
  *large.mutable_calibration() = ToCalibration(TiltedRig());
  return {BytesOf(ConfigText(small)), BytesOf(ConfigText(large)),
          BytesOf("left { serial: \"1\" }\nright { serial: \"2\" }\ntof { serial: \"3\" }\n")};
}

}  // namespace sprout::fuzz
