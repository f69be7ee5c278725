#include "common/ros/from_ros.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <span>

#include "common/core/checks.h"
#include "common/core/depth_of_counts.h"
#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/geometry/lens.h"

namespace sprout {
namespace {

constexpr bool kIsBigEndian = std::endian::native == std::endian::big;

struct Encoding {
  std::string_view name;
  int type;         // OpenCV's
  int to_bgr = -1;  // colour conversion; −1: none
};
// A Bayer pattern is called by its first two pixels in ROS, and by those in the second row and
// column in OpenCV.
constexpr Encoding kPictures[] = {
    {"mono8", CV_8UC1},
    {"8UC1", CV_8UC1},
    {"mono16", CV_16UC1},
    {"16UC1", CV_16UC1},  // of thermal cameras
    {"nv12", CV_8UC1},    // grey; below it stand colours of a coarser grid, which are left out
    {"nv21", CV_8UC1},
    {"nv24", CV_8UC1},
    {"bgr8", CV_8UC3},
    {"8UC3", CV_8UC3},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgr16", CV_16UC3},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"uyvy", CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2BGR},
};
constexpr Encoding kRanges[] = {{"16UC1", CV_16UC1}, {"mono16", CV_16UC1}, {"32FC1", CV_32FC1}};

int32_t SideOf(uint32_t value) {
  return static_cast<int32_t>(std::min<uint32_t>(value, std::numeric_limits<int32_t>::max()));
}

Result<Encoding> FindEncoding(const RosImage& ros, std::span<const Encoding> known) {
  const std::string_view name = RosText(ros.encoding);
  const auto found = std::ranges::find(known, name, &Encoding::name);
  if (found != known.end()) return *found;
  return Fail("encoding = '" + std::string(name.substr(0, 64)) + "': allowed is " +
              Joined(", ", known, &Encoding::name));
}

// A view of its bytes, in this machine's byte order.
Result<cv::Mat> ViewOf(const RosImage& ros, int type) {
  const int64_t least = int64_t{CV_ELEM_SIZE(type)} * SideOf(ros.width);
  // Colour that is called grey would be stretched rows of every third column.
  constexpr int64_t kMaxPadding = 256;
  const bool is_colour = ros.step == 3 * least || ros.step == 4 * least;
  const bool is_other = is_colour && CV_ELEM_SIZE(type) == 1 && least > kMaxPadding;
  const uint64_t bytes_needed = uint64_t{ros.step} * ros.height;
  const bool has_more = RosText(ros.encoding).starts_with("nv");
  Checks checks;
  checks.Side("width", SideOf(ros.width))
      .Side("height", SideOf(ros.height))
      .Pixels("width × height", SideOf(ros.width), SideOf(ros.height))
      .Require(ros.step >= least, "step", ros.step, "at least " + std::to_string(least))
      .Require(!is_other, "step", ros.step,
               fmt::format("{}, or little more: are there more channels than in '{}'?", least,
                           RosText(ros.encoding)))
      .Require(has_more ? ros.data._length >= bytes_needed : ros.data._length == bytes_needed,
               "data length", ros.data._length, "step × height");
  if (!checks.ok()) return checks.error();
  const cv::Mat view(SideOf(ros.height), SideOf(ros.width), type, ros.data._buffer, ros.step);
  if (CV_ELEM_SIZE1(type) == 1 || (ros.is_bigendian != 0) == kIsBigEndian) return view;
  cv::Mat swapped(view.size(), type);
  const size_t bytes = CV_ELEM_SIZE1(type);
  for (int v = 0; v < view.rows; ++v) {
    const uint8_t* const from = view.ptr(v);
    uint8_t* const to = swapped.ptr(v);
    for (size_t i = 0; i < static_cast<size_t>(view.cols) * bytes; ++i) {
      to[i] = from[i / bytes * bytes + (bytes - 1 - i % bytes)];
    }
  }
  return swapped;
}

// A number of a point, FLOAT32 or FLOAT64.
struct Coordinate {
  uint32_t offset;
  bool is_double;

  double At(const uint8_t* point, bool swap) const {
    return is_double ? Number<double>(point + offset, swap) : Number<float>(point + offset, swap);
  }

 private:
  template <typename T>
  static T Number(const uint8_t* at, bool swap) {
    std::array<uint8_t, sizeof(T)> bytes{};
    std::copy_n(at, bytes.size(), bytes.begin());
    if (swap) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }
};

std::optional<Coordinate> CoordinateOf(const RosPointCloud& ros, std::string_view name) {
  for (const RosPointField& field : RosSpan(ros.fields)) {
    if (RosText(field.name) != name) continue;
    const bool is_double = field.datatype == kRosFloat64;
    const uint32_t size = is_double ? 8 : 4;
    const bool fits = field.offset <= ros.point_step && ros.point_step - field.offset >= size;
    if ((field.datatype != kRosFloat32 && !is_double) || !fits) return std::nullopt;
    return Coordinate{field.offset, is_double};
  }
  return std::nullopt;
}

template <size_t kSize>
bool AllFinite(const double (&values)[kSize]) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

// Largest error of a fitted lens, in pixels of the range image, which are several of the left
// image's.
constexpr double kWorstFitPx = 0.5;

constexpr char kFocalLength[] = "a focal length > 0 (0: the camera is not calibrated)";

// Size, K and P of the image itself, which may be a part (roi) of what was calibrated, and binned;
// d stays that of `whole`. As everywhere in ROS, c becomes c over the binning.
RosCameraInfo OfTheImage(const RosCameraInfo& whole) {
  RosCameraInfo image = whole;
  const auto shrink = [&](uint32_t& side, uint32_t part, uint32_t offset, uint32_t binning,
                          size_t row) {
    const uint32_t pixels = std::max<uint32_t>(binning, 1);
    side = (part > 0 ? part : side) / pixels;
    image.k[3 * row + 2] -= offset;
    image.p[4 * row + 2] -= offset;
    for (size_t i = 0; i < 3; ++i) image.k[3 * row + i] /= pixels;
    for (size_t i = 0; i < 4; ++i) image.p[4 * row + i] /= pixels;
  };
  shrink(image.width, whole.roi.width, whole.roi.x_offset, whole.binning_x, 0);
  shrink(image.height, whole.roi.height, whole.roi.y_offset, whole.binning_y, 1);
  return image;
}

// Whether a part, in px of the whole side, lies within it; 0: it is the whole side.
bool IsWithin(uint32_t part, uint32_t offset, uint32_t side) {
  return part > 0 ? uint64_t{part} + offset <= side : offset == 0;
}

// K and D as Brown's model has them, or comes near them; without coefficients every model is a
// pinhole.
Result<Lens> LensOf(const RosCameraInfo& ros) {
  const Lens lens{.width = SideOf(ros.width),
                  .height = SideOf(ros.height),
                  .fx = ros.k[0],
                  .fy = ros.k[4],
                  .cx = ros.k[2],
                  .cy = ros.k[5]};
  const std::string_view model = RosText(ros.distortion_model);
  const std::span d = RosSpan(ros.d);
  const bool is_pinhole = std::ranges::all_of(d, [](double value) { return value == 0; });
  const bool is_fisheye = model == "equidistant" || model == "fisheye";
  const bool is_opencvs = model.empty() || model == "plumb_bob" || model == "rational_polynomial";
  Checks checks;
  checks.Require(ros.k[0] > 0, "k[0]", ros.k[0], kFocalLength)
      .Require(ros.k[4] > 0, "k[4]", ros.k[4], kFocalLength)
      .Require(AllFinite(ros.k), "k", "not finite", "finite numbers")
      .Require(std::ranges::all_of(d, [](double value) { return std::isfinite(value); }), "d",
               "not finite", "finite numbers")
      .Require(is_pinhole || is_fisheye || is_opencvs, "distortion_model", model.substr(0, 64),
               "plumb_bob, rational_polynomial or equidistant, or an image that is rectified")
      .Require(!is_fisheye || is_pinhole || d.size() == 4, "d", d.size(),
               "4 coefficients of equidistant")
      .Require(is_fisheye || d.size() <= 5 || d.size() == 8 || d.size() == 12 || d.size() == 14,
               "d", d.size(), "up to 5, 8, 12 or 14 coefficients");
  if (!checks.ok()) return checks.error();
  if (is_pinhole) return lens;
  const LensFit fit = FitBrown(lens, d, is_fisheye);
  checks.Require(fit.worst_px <= kWorstFitPx, "distortion_model", model.substr(0, 64),
                 fmt::format("plumb_bob, or a lens like one of its: this one is up to {:.2g} px "
                             "from any, {} are allowed; or an image that is rectified",
                             fit.worst_px, kWorstFitPx));
  if (!checks.ok()) return checks.error();
  return fit.lens;
}

// R; drivers that rectify by themselves may leave it out, which is zeros.
Result<Eigen::Matrix3d> RectificationOf(const RosCameraInfo& ros) {
  constexpr double kRounding = 1e-4;  // of files with five decimals
  const Eigen::Matrix3d turn =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(ros.r);
  if (turn.isZero(0)) return Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  if ((turn * turn.transpose()).isIdentity(kRounding) && turn.determinant() > 0) {
    return Eigen::Quaterniond(turn).normalized().toRotationMatrix();
  }
  return Fail("r = no rotation: allowed is a rotation, or zeros for none");
}

}  // namespace

Result<int64_t> FromRosStamp(const RosHeader& header) {
  constexpr uint32_t kPerSecond = 1'000'000'000;
  if (header.stamp.nanosec >= kPerSecond) {
    return Fail("header.stamp.nanosec = " + std::to_string(header.stamp.nanosec) +
                ": allowed is 0 to 999999999");
  }
  return int64_t{header.stamp.sec} * 1'000'000 + header.stamp.nanosec / 1000;
}

Result<cv::Mat> FromRosImage(const RosImage& ros) {
  const Result<Encoding> encoding = FindEncoding(ros, kPictures);
  if (!encoding) return tl::unexpected(encoding.error());
  const Result<cv::Mat> view = ViewOf(ros, encoding->type);
  if (!view) return view;
  cv::Mat image;
  if (encoding->type == CV_8UC2 && view->cols % 2 != 0) {
    return Fail("width = " + std::to_string(view->cols) + ": allowed with " +
                std::string(encoding->name) + " are even ones");
  }
  if (encoding->to_bgr >= 0) {
    cv::cvtColor(*view, image, encoding->to_bgr);
  } else {
    image = view->clone();
  }
  return image;
}

Result<cv::Mat> ToPicture(const cv::Mat& stored, std::string_view encoding) {
  cv::Mat image = stored;
  const auto known = std::ranges::find(kPictures, encoding, &Encoding::name);
  const bool is_mosaic = encoding.starts_with("bayer_") && known != std::end(kPictures);
  if (image.channels() == 4) {
    cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  } else if (image.channels() == 1 && is_mosaic) {
    cv::cvtColor(image, image, known->to_bgr);
  }
  const bool has_depth = image.depth() == CV_8U || image.depth() == CV_16U;
  const bool is_picture = has_depth && (image.channels() == 1 || image.channels() == 3);
  if (!is_picture) return Fail("data: a picture of other than 1, 3 or 4 channels of 8 or 16 bits");
  return image;
}

Result<cv::Mat1f> FromRosDepth(const RosImage& ros) {
  const Result<Encoding> encoding = FindEncoding(ros, kRanges);
  if (!encoding) return tl::unexpected(encoding.error());
  const Result<cv::Mat> view = ViewOf(ros, encoding->type);
  if (!view) return tl::unexpected(view.error());
  if (encoding->type == CV_16UC1) return DepthOfCounts(*view, kMetresPerMillimetre);
  return cv::Mat1f(view->clone());
}

Result<std::vector<Eigen::Vector3d>> FromRosCloud(const RosPointCloud& ros) {
  constexpr uint64_t kMaxPoints = 20'000'000;
  constexpr double kMaxPointM = 1000;
  const uint64_t count = uint64_t{ros.width} * ros.height;
  const std::optional<Coordinate> x = CoordinateOf(ros, "x");
  const std::optional<Coordinate> y = CoordinateOf(ros, "y");
  const std::optional<Coordinate> z = CoordinateOf(ros, "z");
  Checks checks;
  checks
      .Require(x && y && z, "fields", RosSpan(ros.fields).size(),
               "fields x, y and z of FLOAT32 or FLOAT64 within point_step")
      .Require(count <= kMaxPoints, "width × height", count,
               "up to " + std::to_string(kMaxPoints) + " points")
      .Require(ros.row_step >= uint64_t{ros.width} * ros.point_step, "row_step", ros.row_step,
               "at least width × point_step")
      .Require(ros.data._length >= uint64_t{ros.row_step} * ros.height, "data length",
               ros.data._length, "at least row_step × height");
  if (!checks.ok()) return checks.error();
  const bool swap = ros.is_bigendian != kIsBigEndian;
  std::vector<Eigen::Vector3d> points;
  if (count == 0) return points;  // its rows, which take no bytes, may be 4 billion
  points.reserve(count);
  for (uint32_t v = 0; v < ros.height; ++v) {
    const uint8_t* at = ros.data._buffer + size_t{v} * ros.row_step;
    for (uint32_t u = 0; u < ros.width; ++u, at += ros.point_step) {
      const Eigen::Vector3d point(x->At(at, swap), y->At(at, swap), z->At(at, swap));
      if (point.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kMaxPointM) points.push_back(point);
    }
  }
  return points;
}

Result<RosPose> FromRosTransform(const RosTransform& ros) {
  const auto& place = ros.transform.translation;
  const auto& turn = ros.transform.rotation;
  const Eigen::Quaterniond rotation(turn.w, turn.x, turn.y, turn.z);
  const Eigen::Vector3d place_m(place.x, place.y, place.z);
  Checks checks;
  checks
      .Require(std::abs(rotation.norm() - 1) < 1e-3, "transform.rotation norm", rotation.norm(),
               "1")
      .Require(place_m.allFinite(), "transform.translation", "not finite", "finite numbers");
  if (!checks.ok()) return tl::unexpected(checks.error());
  return RosPose{.parent = std::string(RosText(ros.header.frame_id)),
                 .child = std::string(RosText(ros.child_frame_id)),
                 .parent_from_child = {rotation, place_m}};
}

Result<RosCamera> FromRosInfo(const RosCameraInfo& whole, bool is_rectified) {
  constexpr double kMaxSkew = 1e-3;  // half a pixel over 500 rows
  const auto& roi = whole.roi;
  const RosCameraInfo ros = OfTheImage(whole);
  Checks checks;
  checks.Side("width", SideOf(ros.width))
      .Side("height", SideOf(ros.height))
      .Pixels("width × height", SideOf(ros.width), SideOf(ros.height))
      .Require(AllFinite(ros.r), "r", "not finite", "finite numbers")
      .Require(AllFinite(ros.p), "p", "not finite", "finite numbers")
      .Require(!is_rectified || ros.p[0] > 0, "p[0]", ros.p[0], kFocalLength)
      .Require(!is_rectified || ros.p[5] > 0, "p[5]", ros.p[5], kFocalLength)
      .Require(!is_rectified || std::abs(ros.p[1]) <= kMaxSkew * ros.p[0], "p[1]", ros.p[1],
               "0: P of rectified images is no camera matrix times a rotation")
      .Require(IsWithin(roi.width, roi.x_offset, whole.width), "roi.x_offset", roi.x_offset,
               fmt::format("a part of the {} columns", whole.width))
      .Require(IsWithin(roi.height, roi.y_offset, whole.height), "roi.y_offset", roi.y_offset,
               fmt::format("a part of the {} rows", whole.height));
  if (!checks.ok()) return checks.error();
  RosCamera camera{.width = SideOf(ros.width),
                   .height = SideOf(ros.height),
                   .lens = LensOf(ros),
                   .focal_px = ros.p[0],
                   .focal_v_px = ros.p[5],
                   .cx = ros.p[2],
                   .cy = ros.p[6],
                   .tx = ros.p[3]};
  const Result<Eigen::Matrix3d> turn = RectificationOf(ros);
  if (!turn) return tl::unexpected(turn.error());
  camera.rectification = *turn;
  return camera;
}

Result<RectifiedPair> PairOf(const RosCamera& left, const RosCamera& right) {
  constexpr double kSamePx = 1e-3;
  // How many rows off the upper and the lower edge may be when f_y stands for f_x: they belong to
  // points of the range sensor, which are not known better.
  constexpr double kMaxRowsOff = 0.5;
  const double from_middle = std::max(std::abs(left.cy), std::abs(left.height - 1 - left.cy));
  const double rows_off = std::abs(left.focal_v_px / left.focal_px - 1) * from_middle;
  Checks checks;
  checks
      .Require(left.size() == right.size(), "right width × height", SizeText(right.size()),
               "that of the left camera, " + SizeText(left.size()))
      .Require(rows_off <= kMaxRowsOff, "left p[5]", left.focal_v_px,
               fmt::format("p[0] = {:g}: square pixels", left.focal_px))
      .Require(std::abs(left.focal_px - right.focal_px) < kSamePx, "right p[0]", right.focal_px,
               "that of the left camera: a rectified pair")
      .Require(std::abs(left.focal_v_px - right.focal_v_px) < kSamePx, "right p[5]",
               right.focal_v_px, "that of the left camera: a rectified pair")
      .Require(std::abs(left.cy - right.cy) < kSamePx, "right p[6]", right.cy,
               "that of the left camera: a rectified pair")
      .Require(right.tx != left.tx, "right p[3]", right.tx,
               "−f·b, other than the left camera's: no baseline is known of cameras that were "
               "calibrated one by one, and none can be used of cameras above each other")
      .Require(right.tx < left.tx, "right p[3]", right.tx,
               fmt::format("−f·b, below the left camera's, {:g}; are they swapped?", left.tx));
  if (!checks.ok()) return checks.error();
  const RectifiedPair pair{.width = left.width,
                           .height = left.height,
                           .focal_px = left.focal_px,
                           .cx = left.cx,
                           .cy = left.cy,
                           .cx_right = right.cx,
                           .baseline_m = (left.tx - right.tx) / left.focal_px};
  if (const Result<void> usable = CheckRig({.pair = pair, .tof = {}}); !usable) {
    return tl::unexpected(usable.error());
  }
  return pair;
}

}  // namespace sprout
