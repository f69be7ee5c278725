#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cctype>
#include <limits>

#include "common/geometry/projection.h"
#include "common/picture/write_ply.h"
#include "services/depth/cloud.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

namespace fs = std::filesystem;
using namespace py::literals;  // NOLINT: of _a there is no other

constexpr std::string_view kChannelStart = "SPROUT_";

bool Has(const Frame& frame, Part part) {
  return std::visit(
      [&](auto member) {
        const auto& value = frame.*member;
        if constexpr (requires { value.empty(); }) {
          return !value.empty();
        } else {
          return value.has_value();
        }
      },
      RowOf(part).member);
}

cv::Mat1f MetresOf(const DepthImage& depth) {
  cv::Mat1f metres;
  depth.counts.convertTo(metres, CV_32F, depth.metres_per_count);
  metres.setTo(std::numeric_limits<float>::quiet_NaN(), depth.counts == 0);
  return metres;
}

// The map, computed once a frame without the interpreter's lock.
template <typename Make>
py::object Kept(cv::Mat1f& map, const Make& make) {
  if (map.empty()) {
    cv::Mat1f made;
    {
      const Unlocked free;
      made = make();
    }
    map = made;
  }
  return ToArray(map);
}

// A log may have a calibration of another size, which would give wrong depths.
bool HasMapOfRig(const Frame& parts) {
  return parts.disparity && parts.rig && parts.disparity->size() == parts.rig->pair.size();
}

// None when the frame has neither disparities of its calibration nor depths.
py::object DepthArray(PyFrame& frame) {
  return Kept(frame.depth_m, [&parts = frame.frame]() -> cv::Mat1f {
    if (HasMapOfRig(parts)) return DepthMap(parts.rig->pair, *parts.disparity);
    return parts.depth ? MetresOf(*parts.depth) : cv::Mat1f();
  });
}

// None when the frame has no standard deviations.
py::object DepthSigmaArray(const PyFrame& frame) {
  if (frame.depth_of_fused) return py::none();  // the fused map has none
  const Frame& parts = frame.frame;
  cv::Mat1f sigma_m;
  {
    const Unlocked free;
    if (HasMapOfRig(parts) && parts.sigma.size() == parts.disparity->size()) {
      sigma_m = DepthSigmaMap(parts.rig->pair, frame.kept.value_or(*parts.disparity), parts.sigma);
    } else if (parts.depth_sigma) {
      sigma_m = MetresOf(*parts.depth_sigma);
      sigma_m.setTo(std::numeric_limits<float>::infinity(),
                    parts.depth_sigma->counts == kMaxDepthSigmaCounts);
    }
  }
  return ToArray(sigma_m);
}

py::object DisparityArray(PyFrame& frame) {
  return Kept(frame.disparity_px, [&parts = frame.frame] {
    return parts.disparity ? ToPx(*parts.disparity) : cv::Mat1f();
  });
}

py::object SeedArray(const std::optional<SeedSet>& set) {
  return set ? py::object(ToArray(set->seeds)) : py::none();
}

py::object SeedCounts(const PyFrame& frame) {
  if (!frame.frame.seeds) return py::none();
  const SeedSet& set = *frame.frame.seeds;
  return py::dict("raw"_a = set.raw, "outside"_a = set.outside, "dark"_a = set.dark,
                  "loose"_a = set.loose, "background"_a = set.background, "hidden"_a = set.hidden,
                  "contradicted"_a = set.contradicted);
}

py::object DepthCountsOf(const PyFrame& frame) {
  if (!frame.frame.depth_counts) return py::none();
  const DepthCounts& counts = *frame.frame.depth_counts;
  return py::dict("pixels"_a = counts.pixels, "near"_a = counts.near, "far"_a = counts.far,
                  "outside"_a = counts.outside, "unsure"_a = counts.unsure,
                  "flying"_a = counts.flying);
}

// The points as an array (N, 3) of float32.
py::array_t<float> PositionsOf(const PointCloud& cloud) {
  py::array_t<float> positions({static_cast<int>(cloud.points.size()), 3});
  float* to = positions.mutable_data();
  for (const CloudPoint& point : cloud.points) {
    for (const float value : {point.position_m.x, point.position_m.y, point.position_m.z}) {
      *to++ = value;
    }
  }
  return positions;
}

py::object PositionsOf(const std::optional<PointCloud>& cloud) {
  return cloud ? py::object(PositionsOf(*cloud)) : py::none();
}

template <typename T>
py::object OrNone(const std::optional<T>& value) {
  return value ? py::cast(*value) : py::none();
}

// The disparities that give depths and points.
const std::optional<DisparityImage>& MapOf(const PyFrame& frame) {
  if (frame.kept) return frame.kept;
  return frame.depth_of_fused ? frame.frame.fused : frame.frame.disparity;
}

void RequireMap(const PyFrame& frame, const char* what) {
  const auto& map = MapOf(frame);
  const auto& rig = frame.frame.rig;
  if (map && rig && map->size() == rig->pair.size()) return;
  throw py::value_error(std::string(what) + ": the frame has no disparity map with a calibration");
}

void RequireColours(const PyFrame& frame, const char* what) {
  if (frame.frame.left.size() == MapOf(frame)->size()) return;
  throw py::value_error(std::string(what) + ": the frame has no left image of the map's size");
}

py::object Points(const PyFrame& frame, bool colors) {
  const Frame& parts = frame.frame;
  PointCloud cloud;
  if (!parts.disparity && parts.cloud) {
    cloud = *parts.cloud;
  } else {
    RequireMap(frame, "points()");
    if (colors) RequireColours(frame, "points(colors=True)");
    const Unlocked free;
    const DisparityImage& map = *MapOf(frame);
    const cv::Mat left = colors ? parts.left : cv::Mat(cv::Mat1b::zeros(map.size()));
    cloud = depth::CloudOf(map, parts.rig->pair, left, {}, {});
  }
  const py::object positions = PositionsOf(cloud);
  if (!colors) return positions;
  py::array_t<uint8_t> bgr({static_cast<int>(cloud.points.size()), 3});
  uint8_t* to = bgr.mutable_data();
  for (const CloudPoint& point : cloud.points) to = std::copy_n(point.bgr.val, 3, to);
  return py::make_tuple(positions, bgr);
}

void WritePly(const PyFrame& frame, const fs::path& path, bool mesh) {
  const Frame& parts = frame.frame;
  RequireMap(frame, "write_ply()");
  RequireColours(frame, "write_ply()");
  Result<void> written;
  {
    const Unlocked free;
    const cv::Mat& confidence = frame.depth_of_fused ? parts.fused_confidence : parts.confidence;
    written = (mesh ? WriteMeshPly : WriteCloudPly)(path, parts.rig->pair, *MapOf(frame),
                                                    parts.left, confidence);
  }
  if (written) return;
  SetError(PyExc_OSError, written.error().text);
  throw py::error_already_set();
}

py::object IntrinsicsOf(const PyFrame& frame) {
  const Frame& parts = frame.frame;
  const bool from_map = HasMapOfRig(parts);
  if (!from_map && !parts.depth) return py::none();
  if (from_map) return py::cast(*parts.rig).attr("K");
  return Intrinsics(parts.depth->focal_px, parts.depth->cx, parts.depth->cy);
}

std::vector<std::string> PartNames(const PyFrame& frame) {
  std::vector<std::string> names;
  for (const Part part : kAllParts) {
    if (Has(frame.frame, part)) names.push_back(NameOf(part));
  }
  return names;
}

std::string Repr(const PyFrame& frame) {
  std::string text = "<sprout.Frame";
  if (frame.frame.id.seq >= 0) text += " " + std::to_string(frame.frame.id.seq);
  for (const std::string& name : PartNames(frame)) text += " " + name;
  return text + ">";
}

}  // namespace

std::string NameOf(Part part) {
  std::string name(ChannelOf(part).substr(kChannelStart.size()));
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

Part TakePart(const std::string& name) {
  std::string allowed;
  for (const Part part : kAllParts) {
    if (NameOf(part) == name) return part;
    allowed += (allowed.empty() ? "" : ", ") + NameOf(part);
  }
  throw py::value_error("part: expected one of " + allowed + ", given '" + name + "'");
}

PartSet TakeParts(const py::handle& names) {
  if (names.is_none()) return AllParts();
  if (py::isinstance<py::str>(names) || !py::isinstance<py::sequence>(names)) {
    throw py::value_error("parts: expected names of parts in a list or tuple, given " +
                          std::string(py::repr(names)));
  }
  PartSet parts;
  for (const py::handle name : names) parts.Add(TakePart(py::str(name)));
  return parts;
}

void BindFrame(py::module_& module) {
  py::class_<PyFrame> bound(module, "Frame",
                            R"(Everything that one capture led to; None for what is not there.

Maps are of the left image's size and in its pixels. Arrays own their memory and stay valid without the
frame; of compute() left, right and tof are the arrays that it was given.)");
  const auto add = PropertiesOf(bound);
  add("utime", "int: time of the capture, us since 1970 (UTC); 0: not known.",
      [](const PyFrame& f) { return f.frame.id.utime; });
  add("seq", "int: number of the capture; -1: it has none.",
      [](const PyFrame& f) { return f.frame.id.seq; });
  add("rig_id", "str: digest of the calibration.",
      [](const PyFrame& f) { return TextOfBytes(f.frame.id.rig_id); });
  add("parts", "List[str]: names of what is there.", &PartNames);
  add("left", "Optional[numpy.ndarray]: (H, W) or (H, W, 3) BGR, uint8, rectified.",
      [](const PyFrame& f) { return ToArray(f.frame.left); });
  add("right", "Optional[numpy.ndarray]: (H, W) or (H, W, 3) BGR, uint8, rectified.",
      [](const PyFrame& f) { return ToArray(f.frame.right); });
  add("tof", "Optional[Tof]: the range image.", [](const PyFrame& f) {
    const auto& tof = f.frame.tof;
    return tof && !tof->depth_m.empty() ? py::cast(*tof) : py::none();
  });
  add("tof_zones", "Optional[Zones]: what a multi-zone sensor measured.",
      [](const PyFrame& f) { return OrNone(f.frame.tof_zones); });
  add("rig", "Optional[Rig]: the calibration.",
      [](const PyFrame& f) { return OrNone(f.frame.rig); });
  add("seeds", "Optional[numpy.ndarray]: (N,) SEED: what growth started from.",
      [](const PyFrame& f) { return SeedArray(f.frame.seeds); });
  add("left_seeds",
      "Optional[numpy.ndarray]: (N,) SEED: range points that the left camera alone sees.",
      [](const PyFrame& f) { return SeedArray(f.frame.left_seeds); });
  add("seed_counts",
      "Optional[Dict[str, int]]: range points with a return (raw), and those dropped, by why.",
      &SeedCounts);
  add("prior", "Optional[PriorMap]: what growth was told to expect.",
      [](const PyFrame& f) { return OrNone(f.frame.prior); });
  add("unfilled",
      "Optional[numpy.ndarray]: (H, W) float32, px, before gaps were filled; NaN: none.",
      [](const PyFrame& f) { return ToArray(f.frame.unfilled.value_or(DisparityImage())); });
  add("disparity", "Optional[numpy.ndarray]: (H, W) float32, px, multiples of 1/32; NaN: none.",
      &DisparityArray);
  add("confidence",
      "Optional[numpy.ndarray]: (H, W) uint8, 255 times the probability that the disparity is "
      "within 1 px of the true one.",
      [](const PyFrame& f) { return ToArray(f.frame.confidence); });
  add("sigma_px",
      "Optional[numpy.ndarray]: (H, W) float32, standard deviation of the disparity, px.",
      [](const PyFrame& f) { return SigmaArray(f.frame.sigma); });
  add("fused", "Optional[numpy.ndarray]: (H, W) float32, px, fused with earlier frames; NaN: none.",
      [](const PyFrame& f) { return ToArray(f.frame.fused.value_or(DisparityImage())); });
  add("fused_confidence",
      "Optional[numpy.ndarray]: (H, W) uint8, 255 times the probability that fused is within 1 "
      "px of the true one.",
      [](const PyFrame& f) { return ToArray(f.frame.fused_confidence); });
  add("motion", "Optional[Motion]: how the left camera moved since the last frame.",
      [](const PyFrame& f) { return OrNone(f.frame.motion); });
  add("odometry", "Optional[Motion]: the same as somebody else knows it.",
      [](const PyFrame& f) { return OrNone(f.frame.odometry); });
  add("depth_m",
      "Optional[numpy.ndarray]: (H, W) float32, z, m; NaN: none. Of disparity where rig is of "
      "its size, or of fused where compute() was told so (depth { input: FUSED }).",
      &DepthArray);
  add("depth_sigma_m",
      "Optional[numpy.ndarray]: (H, W) float32, standard deviation of "
      "depth_m where it is of disparity, m; NaN: none, inf: not known.",
      &DepthSigmaArray);
  add("intrinsics", "Optional[numpy.ndarray]: (3, 3) float64, of depth_m, px.", &IntrinsicsOf);
  add("depth_counts",
      "Optional[Dict[str, int]]: pixels that sprout-depth left out, by why, of all (pixels).",
      &DepthCountsOf);
  add("target_depth_m",
      "Optional[numpy.ndarray]: (H, W) float32, z, m, as sprout-depth's target sees it; NaN: "
      "none.",
      [](const PyFrame& f) {
        return f.frame.target_depth ? ToArray(MetresOf(*f.frame.target_depth))
                                    : py::object(py::none());
      });
  add("target_points",
      "Optional[numpy.ndarray]: (N, 3) float32, m, its points, in the target's frame.",
      [](const PyFrame& f) { return PositionsOf(f.frame.target_cloud); });
  add("base_points",
      "Optional[numpy.ndarray]: (N, 3) float32, m, the points of SPROUT_BASE_CLOUD, in the "
      "robot's frame.",
      [](const PyFrame& f) { return PositionsOf(f.frame.base_cloud); });
  add("warnings", "List[str]: which stage had nothing to give, and why.", &PyFrame::warnings);
  add("range_error",
      "str: how far the range sensor is off, its ranges or its pose, as the images show it; "
      "empty: not at all, or they do not show it.",
      &PyFrame::range_error);
  add("truth", "Optional[numpy.ndarray]: (H, W) float32, px, of a data set; NaN: not known.",
      [](const PyFrame& f) { return ToArray(f.truth.left); });
  add("right_truth", "Optional[numpy.ndarray]: the same at the pixels of the right image.",
      [](const PyFrame& f) { return ToArray(f.truth.right); });
  add("nonoccluded",
      "Optional[numpy.ndarray]: (H, W) uint8, 255 where the data set says that the right "
      "camera sees the pixel, too; the mask of evaluate(). None: it says nothing.",
      [](const PyFrame& f) { return ToArray(f.truth.nonoccluded); });
  bound.def("write_ply", &WritePly, py::arg("path"), py::arg("mesh") = false,
            R"(write_ply(self, path: Union[str, os.PathLike[str]], mesh: bool = ...) -> None

Writes the coloured points, or with mesh a surface cut at depth edges; m, as points(). With the property
"confidence" when the frame has one.)");
  AddRepr(bound, [](const PyFrame& f) { return Repr(f); });
  bound.def("points", &Points, py::arg("colors") = false,
            R"(points(*args, **kwargs)
Overloaded function.

1. points(self, colors: Literal[False] = ...) -> numpy.ndarray

2. points(self, colors: Literal[True]) -> Tuple[numpy.ndarray, numpy.ndarray]

Points of the depth map, (N, 3) float32, m, in the left rectified camera's frame: x right, y down, z
forward; row by row. With colors also those of the left image, (N, 3) uint8, BGR.)");
}

}  // namespace sprout::python
