#include "services/pipeline/files/pair_reader.h"

#include <opencv2/imgcodecs.hpp>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/read_image.h"
#include "common/rig/rig_file.h"
#include "services/datasets/pfm.h"

namespace sprout {
namespace {

constexpr double kMetresPerCount = 0.001;  // of a 16-bit image, as most cameras' programs write

Result<void> CheckSize(const std::string& what, cv::Size size, cv::Size calibrated) {
  if (size == calibrated) return {};
  return Fail(what + " is " + SizeText(size) + ": allowed is the calibrated size " +
              SizeText(calibrated));
}

Result<cv::Mat> ReadCameraImage(const std::filesystem::path& path) {
  return DecodeImageFile(path, cv::IMREAD_ANYCOLOR, kCameraFormats);
}

// m.
Result<cv::Mat1f> ReadDepth(const std::filesystem::path& path) {
  if (path.extension() == ".pfm") {
    try {
      return datasets::ReadPfm(path);
    } catch (const ConfigError& e) {
      return Fail(e.what());
    }
  }
  const Result<cv::Mat> image = DecodeImageFile(path, cv::IMREAD_UNCHANGED, kCameraFormats);
  if (!image) return tl::unexpected(image.error());
  if (image->type() != CV_16UC1) {
    return Fail("ToF image " + path.string() +
                ": not of one channel with 16 bits; allowed: such an image in mm, or a PFM in m");
  }
  cv::Mat1f depth_m;
  image->convertTo(depth_m, CV_32F, kMetresPerCount);
  return depth_m;
}

Rig RigOfPair(const RigOptions& options, cv::Size size, cv::Size tof_size) {
  Rig rig;
  const double cx = options.cx.value_or((size.width - 1) / 2.0);
  rig.pair = {.width = size.width,
              .height = size.height,
              .focal_px = *options.focal_px,
              .cx = cx,
              .cy = (size.height - 1) / 2.0,
              .cx_right = options.cx_right.value_or(cx),
              .baseline_m = *options.baseline_m};
  rig.tof = TofOverLeft(rig.pair, tof_size);
  return rig;
}

}  // namespace

PairReader::PairReader(const RigOptions& options) : options_(options) {
  if (!options.rig_file.empty()) {
    rectifier_.emplace(RequireCalibration(LoadRigFile(options.rig_file), options.rig_file));
  } else if (!options.focal_px || !options.baseline_m) {
    throw ConfigError(
        "no calibration; allowed: --rig FILE, or --focal-px and --baseline-m of a rectified pair");
  }
}

Result<void> PairReader::Rectify(Frame& frame) const {
  const RawRig& raw = rectifier_->raw();
  Result<void> fits = CheckSize("the left image", frame.left.size(), raw.left.size());
  if (fits) fits = CheckSize("the right image", frame.right.size(), raw.right.size());
  if (fits && !frame.tof->depth_m.empty()) {
    fits = CheckSize("the ToF image", frame.tof->depth_m.size(), raw.tof.size());
  }
  if (!fits) return fits;
  frame.left = rectifier_->RectifyLeft(frame.left);
  frame.right = rectifier_->RectifyRight(frame.right);
  rectifier_->CorrectRanges(*frame.tof);
  frame.rig = rectifier_->rig();
  return {};
}

Result<Frame> PairReader::Read(const ImagePair& pair) const {
  const Result<cv::Mat> left = ReadCameraImage(pair.left);
  if (!left) return tl::unexpected(left.error());
  const Result<cv::Mat> right = ReadCameraImage(pair.right);
  if (!right) return tl::unexpected(right.error());
  Frame frame;
  frame.left = *left;
  frame.right = *right;
  frame.tof = TofImage();
  if (!pair.tof.empty()) {
    const Result<cv::Mat1f> depth_m = ReadDepth(pair.tof);
    if (!depth_m) return tl::unexpected(depth_m.error());
    frame.tof->depth_m = *depth_m;
  }
  if (!rectifier_) {
    frame.rig = RigOfPair(options_, frame.left.size(), frame.tof->depth_m.size());
  } else if (const Result<void> fits = Rectify(frame); !fits) {
    return tl::unexpected(fits.error());
  }
  return frame;
}

}  // namespace sprout
