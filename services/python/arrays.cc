#include "services/python/arrays.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <regex>
#include <vector>

#include "common/core/depth_of_counts.h"
#include "common/core/image.h"
#include "common/core/printable.h"
#include "services/python/gil.h"

namespace sprout::python {
namespace {

// Allocator of matrices that share an array's pixels: releases the array, from any thread.
class ArrayOwner : public cv::MatAllocator {
 public:
  cv::UMatData* allocate(int, const int*, int, void*, size_t*, cv::AccessFlag,
                         cv::UMatUsageFlags) const override {
    CV_Error(cv::Error::StsNotImplemented, "an array's memory is its own");
  }
  bool allocate(cv::UMatData*, cv::AccessFlag, cv::UMatUsageFlags) const override { return false; }
  void deallocate(cv::UMatData* data) const override {
    if (data == nullptr) return;
    if (!IsEnding()) {
      const Locked gil;
      py::handle(static_cast<PyObject*>(data->userdata)).dec_ref();
    }
    delete data;
  }
};

const ArrayOwner& Owner() {
  static const ArrayOwner owner;
  return owner;
}

// A matrix on the pixels of a contiguous array, which it keeps alive.
cv::Mat Share(const py::array& array, int type) {
  cv::Mat mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), type,
              const_cast<void*>(array.data()));
  auto* data = new cv::UMatData(&Owner());
  data->data = data->origdata = mat.data;
  data->size = static_cast<size_t>(array.nbytes());
  data->userdata = py::object(array).release().ptr();
  data->refcount = 1;
  mat.u = data;
  return mat;
}

std::string ShapeText(cv::Size size) {
  return "(" + std::to_string(size.height) + ", " + std::to_string(size.width) + ")";
}

std::string ShapeText(const py::array& array) { return py::str(array.attr("shape")); }

std::string TypeName(const py::array& array) { return py::str(array.dtype()); }

// Whether elements have this kind of NumPy's ('u', 'f', 'b') and so many bytes, in any byte order.
bool IsOf(const py::array& array, char kind, py::ssize_t bytes) {
  return array.dtype().kind() == kind && array.itemsize() == bytes;
}

std::string Expected(const std::string& types, std::optional<cv::Size> size, bool colour) {
  const std::string shape = size ? ShapeText(*size) : "(H, W)";
  if (!colour) return types + " array of shape " + shape;
  const std::string inside = shape.substr(0, shape.size() - 1);
  return types + " array of shape " + shape + " or " + inside + ", 3)";
}

bool HasSides(const py::array& array, std::optional<cv::Size> size) {
  const auto height = array.shape(0);
  const auto width = array.shape(1);
  if (size) return height == size->height && width == size->width;
  return height > 0 && width > 0 && height <= kMaxSide && width <= kMaxSide &&
         height * width <= kMaxPixels;
}

// The array in C order, itself if it is in C order already.
template <typename T>
py::array Contiguous(const py::array& array) {
  return py::array_t<T, py::array::c_style | py::array::forcecast>(array);
}

// An array of two sides, or nothing.
std::optional<py::array> Plane(const py::handle& given, std::optional<cv::Size> size) {
  if (!py::isinstance<py::array>(given)) return std::nullopt;
  const py::array array = Unmasked(py::reinterpret_borrow<py::array>(given));
  if (array.ndim() != 2 || !HasSides(array, size)) return std::nullopt;
  return array;
}

bool IsFloats(const py::array& array) { return IsOf(array, 'f', 4) || IsOf(array, 'f', 8); }

// The array whose pixels a matrix shares.
py::object ArrayOf(const cv::Mat& image) {
  if (image.u == nullptr || image.u->currAllocator != &Owner()) return {};
  auto array = py::reinterpret_borrow<py::array>(static_cast<PyObject*>(image.u->userdata));
  const bool whole = image.data == array.data() && array.shape(0) == image.rows &&
                     array.shape(1) == image.cols &&
                     array.nbytes() == static_cast<py::ssize_t>(image.total() * image.elemSize());
  return whole ? py::object(array) : py::object();
}

py::dtype TypeOf(int depth) {
  switch (depth) {
    case CV_8U:
      return py::dtype("u1");
    case CV_16S:
      return py::dtype("i2");
    default:
      return py::dtype("f4");
  }
}

// Pictures have no value for a missing pixel, so masked ones are refused.
void RefuseMasked(const std::string& name, const py::array& array) {
  if (!py::hasattr(array, "mask")) return;
  const auto masked = array.attr("mask").attr("sum")().cast<py::ssize_t>();
  if (masked == 0) return;
  throw py::value_error(fmt::format(
      "{}: expected an array without a mask, given one of numpy.ma that masks {} of {} elements; "
      "allowed: {}.filled(...)",
      name, masked, array.size(), name));
}

}  // namespace

py::array Unmasked(const py::array& array) {
  if (!py::hasattr(array, "filled")) return array;
  const bool is_float = array.dtype().kind() == 'f';
  return py::array(array.attr("filled")(is_float ? std::numeric_limits<double>::quiet_NaN() : 0));
}

std::string ReprInOneLine(const py::handle& given) {
  return std::regex_replace(std::string(py::repr(given)), std::regex("\\n *"), " ");
}

void Refuse(const std::string& name, const std::string& expected, const py::handle& given) {
  std::string text = name + ": expected " + expected + ", given ";
  if (py::isinstance<py::array>(given)) {
    const auto array = py::reinterpret_borrow<py::array>(given);
    text += TypeName(array) + " array of shape " + ShapeText(array);
  } else if (given.is_none()) {
    text += "None";
  } else {
    text += std::string(py::str(py::type::handle_of(given).attr("__name__"))) + " " +
            Shortened(Printable(std::string(py::repr(given))), 60);
  }
  throw py::value_error(text);
}

CameraImage TakeCameraImage(const std::string& name, const py::handle& given,
                            std::optional<cv::Size> size) {
  const auto refuse = [&] {
    Refuse(name, Expected("uint8 or uint16", size, /*colour=*/true), given);
  };
  if (!py::isinstance<py::array>(given)) refuse();
  const auto array = py::reinterpret_borrow<py::array>(given);
  const bool colour = array.ndim() == 3 && array.shape(2) == 3;
  const bool grey = array.ndim() == 2 || (array.ndim() == 3 && array.shape(2) == 1);
  const bool is_number = IsOf(array, 'u', 1) || IsOf(array, 'u', 2);
  if (!is_number || !(colour || grey) || !HasSides(array, size)) refuse();
  RefuseMasked(name, array);
  if (array.itemsize() == 1) {
    return {.pixels = Share(Contiguous<uint8_t>(array), colour ? CV_8UC3 : CV_8UC1)};
  }
  return {.pixels = Share(Contiguous<uint16_t>(array), colour ? CV_16UC3 : CV_16UC1)};
}

cv::Mat1f TakeDepth(const std::string& name, const py::handle& given,
                    std::optional<cv::Size> size) {
  const std::optional<py::array> array = Plane(given, size);
  if (array && IsFloats(*array)) return Share(Contiguous<float>(*array), CV_32FC1);
  if (!array || !IsOf(*array, 'u', 2)) {
    Refuse(name, Expected("float32 (m) or uint16 (mm)", size, false), given);
  }
  return DepthOfCounts(Share(Contiguous<uint16_t>(*array), CV_16UC1), kMetresPerMillimetre);
}

cv::Mat1f TakeFloats(const std::string& name, const py::handle& given,
                     std::optional<cv::Size> size) {
  const std::optional<py::array> array = Plane(given, size);
  if (!array || !IsFloats(*array)) Refuse(name, Expected("float32", size, false), given);
  return Share(Contiguous<float>(*array), CV_32FC1);
}

DisparityImage TakeDisparities(const std::string& name, const py::handle& given,
                               std::optional<cv::Size> size) {
  const cv::Mat1f px = TakeFloats(name, given, size);
  const auto beyond = std::ranges::find_if(
      px, [](float d) { return std::isfinite(d) && std::abs(d) > DisparityImage::kMaxPx; });
  if (beyond == px.end()) return FromPx(px);
  throw py::value_error(fmt::format("{}: expected -{:.2f} to {:.2f} px, NaN: none; given {:g}",
                                    name, DisparityImage::kMaxPx, DisparityImage::kMaxPx, *beyond));
}

cv::Mat1b TakeBytes(const std::string& name, const py::handle& given, std::optional<cv::Size> size,
                    bool mask) {
  const std::optional<py::array> array = Plane(given, size);
  const bool is_mask = mask && array && IsOf(*array, 'b', 1);
  if (!array || !(is_mask || IsOf(*array, 'u', 1))) {
    Refuse(name, Expected(mask ? "bool or uint8" : "uint8", size, false), given);
  }
  const cv::Mat1b bytes = Share(Contiguous<uint8_t>(*array), CV_8UC1);
  return is_mask ? cv::Mat1b(bytes != 0) : bytes;
}

TofImage TakeTof(const py::handle& given, cv::Size size) {
  if (given.is_none()) return {};
  if (size.empty()) Refuse("tof", "None, since the rig has no ToF camera (Rig.with_tof)", given);
  if (!py::isinstance<TofImage>(given))
    return {.depth_m = TakeDepth("tof", given, size), .amplitude = {}};
  auto tof = given.cast<TofImage>();
  if (tof.depth_m.size() != size) {
    Refuse("tof.depth_m", Expected("float32 (m)", size, false), ToArray(tof.depth_m));
  }
  return tof;
}

std::vector<Seed> TakeSeeds(const std::string& name, const py::handle& given) {
  if (py::isinstance<py::array>(given)) {
    const auto array = py::reinterpret_borrow<py::array>(given);
    // Compares names only: NumPy may lay out the same fields with other offsets.
    const bool has_fields = array.dtype().attr("names").equal(py::dtype::of<Seed>().attr("names"));
    if (py::hasattr(array, "mask")) Refuse(name, "an array of sprout.SEED without a mask", given);
    if (array.ndim() == 1 && has_fields) {
      const py::array_t<Seed, py::array::c_style | py::array::forcecast> seeds(array);
      return {seeds.data(), seeds.data() + seeds.size()};
    }
  }
  Refuse(name, "sprout.SEED array of shape (N,)", given);
}

py::object ToArray(const cv::Mat& image) {
  if (image.empty()) return py::none();
  if (py::object array = ArrayOf(image)) return array;
  auto kept = std::make_unique<cv::Mat>(image);
  const py::capsule owner(kept.get(), [](void* p) { delete static_cast<cv::Mat*>(p); });
  const cv::Mat& held = *kept.release();
  const auto step = static_cast<py::ssize_t>(held.step[0]);
  const auto item = static_cast<py::ssize_t>(held.elemSize1());
  const int channels = held.channels();
  if (channels == 1) {
    return py::array(TypeOf(held.depth()), {held.rows, held.cols}, {step, item}, held.data, owner);
  }
  return py::array(TypeOf(held.depth()), {held.rows, held.cols, channels},
                   {step, channels * item, item}, held.data, owner);
}

py::object ToArray(const DisparityImage& disparity) {
  if (disparity.empty()) return py::none();
  cv::Mat1f px;
  {
    const Unlocked free;
    px = ToPx(disparity);
  }
  return ToArray(px);
}

py::array ToArray(const std::vector<Seed>& seeds) {
  py::array_t<Seed> array(static_cast<py::ssize_t>(seeds.size()));
  Seed* copy = array.mutable_data();
  // Clears the bytes between the fields, which would otherwise be random in a saved array.
  std::memset(static_cast<void*>(copy), 0, seeds.size() * sizeof(Seed));
  for (const Seed& seed : seeds) {
    copy->u = seed.u;
    copy->v = seed.v;
    copy->u_right = seed.u_right;
    copy->sigma_px = seed.sigma_px;
    copy->origin = seed.origin;
    copy->tof_u = seed.tof_u;
    copy->tof_v = seed.tof_v;
    ++copy;
  }
  return array;
}

uint8_t TakeSigma(const std::string& name, double sigma_px) {
  if (!(sigma_px < 0)) return SigmaToCounts(sigma_px);
  throw py::value_error(name + ": expected 0 and more, or NaN: not known; given " +
                        std::string(py::repr(py::float_(sigma_px))));
}

cv::Mat1b TakeSigmas(const std::string& name, const py::handle& array,
                     std::optional<cv::Size> size) {
  const cv::Mat1f px = TakeFloats(name, array, size);
  cv::Mat1b counts(px.size());
  std::transform(px.begin(), px.end(), counts.begin(),
                 [&](float sigma_px) { return TakeSigma(name, double{sigma_px}); });
  return counts;
}

py::object SigmaArray(const cv::Mat1b& counts) {
  if (counts.empty()) return py::none();
  cv::Mat1f px;
  counts.convertTo(px, CV_32F, 1.0 / kSigmaCountsPerPx);
  return ToArray(px);
}

}  // namespace sprout::python
