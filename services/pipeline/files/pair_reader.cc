#include "services/pipeline/files/pair_reader.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/rig/rig_file.h"
#include "common/scenes/middlebury_calibration.h"
#include "common/scenes/pfm.h"

namespace sprout {

PairReader::PairReader(const RigOptions& options, const PixelOptions& pixels)
    : options_(options), eight_bits_(pixels.bits) {
  if (const Result<void> usable = CheckBits(pixels.bits); !usable) {
    throw ConfigError("--bits " + usable.error().text);
  }
  if (!pixels.tof_unit.empty()) {
    tof_unit_m_ = scenes::ParseRangeUnit(pixels.tof_unit);
    if (!tof_unit_m_) {
      throw ConfigError("--tof-unit " + pixels.tof_unit + ": allowed: " + scenes::kRangeUnits);
    }
  }
  if (!options.rig_file.empty()) {
    rectifier_.emplace(RequireCalibration(LoadRigFile(options.rig_file), options.rig_file));
  } else if (!options.calib_file.empty()) {
    calibration_ = scenes::OpenCalibFile(options.calib_file);
  } else if ((!options.focal_px || !options.baseline_m)) {
    throw ConfigError(
        "no calibration; allowed: --rig FILE, or of a rectified pair --calib FILE, or --focal-px "
        "and --baseline-m");
  }
  if (!options.tof_rig_file.empty()) {
    const RigDescription rig = LoadRigFile(options.tof_rig_file);
    if (rig.calibration().has_left()) {
      tof_rectifier_.emplace(RequireCalibration(rig, options.tof_rig_file));
      tof_camera_ = tof_rectifier_->rig().tof;
    } else {
      tof_camera_ = TofCameraOf(rig, options.tof_rig_file);
    }
  }
}

// A focal length in px holds for images of one size and crops of them, not for scaled ones. Images
// of a data set may differ by some columns.
Result<void> PairReader::CheckFirstSize(cv::Size size) {
  if (first_size_.empty()) first_size_ = size;
  constexpr double kAlike = 1.1;
  const auto are_alike = [](double a, double b) { return a < kAlike * b && b < kAlike * a; };
  const double across = static_cast<double>(size.width) / first_size_.width;
  const double down = static_cast<double>(size.height) / first_size_.height;
  if (are_alike(across, 1) || !are_alike(across, down)) return {};
  return Fail("the left image is " + SizeText(size) + ": allowed is the size of the first, " +
              SizeText(first_size_) + ", as all have one --focal-px");
}

Result<RectifiedPair> PairReader::PairOf(const cv::Mat& left) {
  const cv::Size size = left.size();
  if (calibration_) {
    try {
      return calibration_(size, /*grey=*/left.channels() == 1);
    } catch (const ConfigError& e) {
      return Fail(e.what());
    }
  }
  if (const Result<void> fits = CheckFirstSize(size); !fits) return tl::unexpected(fits.error());
  const double cx = options_.cx.value_or((size.width - 1) / 2.0);
  return RectifiedPair{.width = size.width,
                       .height = size.height,
                       .focal_px = *options_.focal_px,
                       .cx = cx,
                       .cy = options_.cy.value_or((size.height - 1) / 2.0),
                       .cx_right = options_.cx_right.value_or(cx),
                       .baseline_m = *options_.baseline_m};
}

// A range image that shows just what the left image shows has pixels as wide as high.
void PairReader::NoteOblong(cv::Size tof, cv::Size left) {
  const double columns_a_row = static_cast<double>(left.width) / left.height;
  const double columns = tof.height * columns_a_row;
  constexpr double kMaxShare = 0.01;  // the nearest whole number of columns or rows is square, too
  const bool is_square =
      std::abs(tof.width - columns) <= std::max({1.0, columns_a_row, kMaxShare * columns});
  if (noted_oblong_ || tof.empty() || is_square) return;
  noted_oblong_ = true;
  note_ = fmt::format(
      "pixels of range images of {} are {:.2f} times as wide as high over left images of {}: do "
      "they show just what these show (was one cropped)? If not: --tof-rig",
      SizeText(tof), columns / tof.width, SizeText(left));
}

// Gives a pair that is already rectified its calibration.
Result<void> PairReader::Calibrate(Frame& frame) {
  const Result<RectifiedPair> pair = PairOf(frame.left);
  if (!pair) return tl::unexpected(pair.error());
  const cv::Size tof_size = frame.tof->depth_m.size();
  frame.rig = Rig{.pair = *pair, .tof = tof_camera_.value_or(TofOverLeft(*pair, tof_size))};
  if (!tof_camera_) NoteOblong(tof_size, pair->size());
  if (!tof_camera_ || tof_size.empty()) return {};
  const Result<void> fits = CheckTofSize(*frame.rig, *frame.tof);
  if (fits && tof_rectifier_) tof_rectifier_->CorrectRanges(*frame.tof);
  return fits;
}

Result<void> PairReader::Rectify(Frame& frame) const {
  frame.rig = rectifier_->rig();
  return rectifier_->Rectify(frame.left, frame.right, *frame.tof);
}

// @param number  of the picture in a video; −1: an image.
Result<CameraImage> PairReader::ReadView(const std::filesystem::path& path, int64_t number,
                                         OpenVideo& video) {
  if (number < 0) return ReadCameraImage(path);
  if (!video.pictures || video.next > number) {
    video = {.pictures = capture::OpenVideoPictures(path), .next = 0};
  }
  for (; video.pictures && video.next <= number; ++video.next) {
    if (!video.pictures->Grab()) video.pictures.reset();
  }
  CameraImage picture = video.pictures ? video.pictures->Retrieve() : CameraImage();
  if (picture.pixels.empty()) {
    return Fail("video " + path.string() + ": picture " + std::to_string(number) +
                " cannot be decoded");
  }
  return picture;
}

Result<Frame> PairReader::Read(const ImagePair& pair) {
  Result<CameraImage> left = ReadView(pair.left, pair.left_frame, left_video_);
  if (!left) return tl::unexpected(left.error());
  Result<CameraImage> right = ReadView(pair.right, pair.right_frame, right_video_);
  if (!right) return tl::unexpected(right.error());
  eight_bits_.Convert({&*left, &*right});
  Frame frame;
  frame.left = left->pixels;
  frame.right = right->pixels;
  frame.tof = TofImage();
  if (!pair.tof.empty()) {
    const Result<cv::Mat1f> depth_m = scenes::ReadRangeFile(pair.tof, tof_unit_m_);
    if (!depth_m) return tl::unexpected(depth_m.error());
    frame.tof->depth_m = *depth_m;
  }
  const Result<void> fits = rectifier_ ? Rectify(frame) : Calibrate(frame);
  if (!fits) return tl::unexpected(fits.error());
  return frame;
}

std::string PairReader::TakeNote() {
  std::string note = eight_bits_.TakeNote();
  return note.empty() ? std::exchange(note_, {}) : note;
}

}  // namespace sprout
