#include <fmt/core.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>

#include "common/inputs/check_inputs.h"
#include "common/picture/eight_bits.h"
#include "services/pipeline/pipeline.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

// A pose from an array (4, 4).
Pose TakePose(const py::object& given) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!array || array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) {
    PyErr_Clear();
    Refuse("pose", "float64 array of shape (4, 4)", given);
  }
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(array.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool is_rotation = (rotation * rotation.transpose()).isIdentity(1e-6) &&
                           rotation.determinant() > 0 && matrix.allFinite();
  if (!is_rotation || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw py::value_error("pose: expected a rotation R, a place t and 0, 0, 0, 1, given " +
                          ReprInOneLine(given));
  }
  return {Eigen::Quaterniond(rotation).normalized(), matrix.topRightCorner<3, 1>()};
}

const Rig& TakeRig(const py::object& given) {
  if (!py::isinstance<Rig>(given)) Refuse("rig", "a Rig", given);
  return given.cast<const Rig&>();
}

class PyPipeline {
 public:
  explicit PyPipeline(const SproutConfig& config) : config_(config), pipeline_(config) {}

  PyFrame Compute(const py::object& left, const py::object& right, const py::object& tof,
                  const py::object& given_rig, std::optional<int64_t> seq,
                  std::optional<int64_t> utime, const py::object& pose, const py::object& zones) {
    PyFrame result;
    const Rig& rig = TakeRig(given_rig);
    Frame& frame = result.frame;
    CameraImage left_image = TakeCameraImage("left", left, rig.pair.size());
    CameraImage right_image = TakeCameraImage("right", right, rig.pair.size());
    eight_bits_.Convert({&left_image, &right_image});
    frame.left = left_image.pixels;
    frame.right = right_image.pixels;
    frame.tof = TakeTof(tof, cv::Size(rig.tof.width, rig.tof.height));
    frame.rig = rig;
    if (!zones.is_none()) {
      if (!py::isinstance<TofZones>(zones)) Refuse("zones", "Zones or None", zones);
      frame.tof_zones = zones.cast<TofZones>();
    }
    if (seq.has_value() != utime.has_value()) {
      throw py::value_error("seq, utime: expected both or neither");
    }
    std::optional<FrameTime> time;
    if (seq) time = FrameTime{.utime = *utime, .seq = *seq};
    if (!pose.is_none()) {
      if (!time) throw py::value_error("pose: expected with seq and utime only");
      time->pose = TakePose(pose);
    }
    frame.id = {.utime = utime.value_or(0), .seq = seq.value_or(-1), .rig_id = RigId(rig)};
    DepthFrame depth = Work(frame, time);
    result.warnings = std::move(depth.warnings);
    result.range_error = std::move(depth.range_error);
    if (std::string note = eight_bits_.TakeNote(); !note.empty()) result.warnings.push_back(note);
    result.depth_m = depth.depth_m;
    result.kept = std::move(depth.kept);
    result.depth_of_fused = config_.depth().input() == DepthConfig::FUSED;
    frame.disparity = depth.disparity;
    frame.confidence = depth.confidence;
    frame.sigma = depth.sigma;
    if (!depth.prior.empty()) frame.prior = depth.prior;
    frame.seeds = std::move(depth.seeds);
    frame.left_seeds = std::move(depth.left_seeds);
    if (depth.motion) frame.fused = depth.fused;
    frame.fused_confidence = depth.fused_confidence;
    frame.motion = depth.motion;
    return result;
  }

  void Reset() {
    const Turn turn(taken_, "Pipeline");
    pipeline_.Reset();
  }

  const SproutConfig& config() const { return config_; }

 private:
  DepthFrame Work(const Frame& frame, const std::optional<FrameTime>& time) {
    const Turn turn(taken_, "Pipeline");
    Result<DepthFrame> depth;
    {
      const Unlocked free;
      depth = pipeline_.Compute(frame.left, frame.right, *frame.tof, *frame.rig, time,
                                frame.tof_zones.value_or(TofZones()));
    }
    return Unwrap(std::move(depth));
  }

  SproutConfig config_;
  Pipeline pipeline_;
  EightBits eight_bits_;  // used only with the interpreter's lock
  std::atomic_flag taken_;
};

inputs::Findings CheckInputsOf(const py::object& left, const py::object& right,
                               const py::object& tof, const py::object& given_rig) {
  const Rig& rig = TakeRig(given_rig);
  CameraImage left_image = TakeCameraImage("left", left, rig.pair.size());
  CameraImage right_image = TakeCameraImage("right", right, rig.pair.size());
  EightBits().Convert({&left_image, &right_image});
  const TofImage ranges = TakeTof(tof, cv::Size(rig.tof.width, rig.tof.height));
  const Unlocked free;
  return inputs::CheckInputs(left_image.pixels, right_image.pixels, ranges, rig);
}

}  // namespace

void BindPipeline(py::module_& module) {
  py::class_<PyPipeline> bound(module, "Pipeline",
                               R"(Range image and rectified pair to depth: refine, prior and grow.

    pipeline = sprout.Pipeline("default")
    frame = pipeline.compute(left, right, tof, rig)

The same bytes as the processes of these names, whatever the threads and the CPU. With temporal {
in_pipeline: true } it also does what sprout-temporal does: frame.fused and frame.motion depend on all
frames since the newest reset, everything else on the frame alone. Keeps its memory from
frame to frame, so it serves one thread at a time; another one that calls meanwhile gets a RuntimeError.
compute() works without the interpreter's lock.)");
  bound
      .def(py::init([](const py::args& config) {
             return std::make_unique<PyPipeline>(TakeConfig(config));
           }),
           R"(__init__(self, *config: Union[str, os.PathLike[str], Config]) -> None

As Config(): presets, files, texts, merged; none: all defaults.)")
      .def(
          "compute", &PyPipeline::Compute, py::arg("left"), py::arg("right"),
          py::arg("tof") = py::none(), py::arg("rig") = py::none(), py::arg("seq") = py::none(),
          py::arg("utime") = py::none(), py::arg("pose") = py::none(),
          py::arg("zones") = py::none(),
          R"(compute(self, left: numpy.ndarray, right: numpy.ndarray, tof: Union[numpy.ndarray, Tof, None], rig: Rig, seq: Optional[int] = ..., utime: Optional[int] = ..., pose: Optional[numpy.ndarray] = ..., zones: Optional[Zones] = ...) -> Frame

left, right: rectified, uint8, (rig.height, rig.width) or with 3 colours (BGR); or uint16, of which the
bits that the first pair uses count, for all pairs; no masked pixels (numpy.ma).
tof: (rig.tof.height, rig.tof.width) float32 in m along the optical axis, or uint16 in mm; no return: 0,
NaN, negative, infinite, 65535 mm, masked (numpy.ma); None: no range image, then stereo does the work.
Contiguous arrays are taken as they are, not copied; others, and float64, are converted. What does not
fit is a ValueError that names argument, type and shape, expected and given. A frame in which nothing
can be found is no error: it has an empty map, and warnings.
seq, utime: number and time (us) of the frame, for the memory of a pipeline with temporal { in_pipeline:
true }; both, or neither: then it is the frame after the last one, without a gap.
pose: with temporal { motion: CHANNEL }, and only then, that of the left camera in a frame that does not move, (4, 4)
float64, m; None: not known, and earlier frames are forgotten.
zones: with refine { zones: true } what a multi-zone sensor measured; None: nothing.)")
      .def("reset", &PyPipeline::Reset,
           R"(reset(self) -> None

Forgets all frames, where the pipeline has a memory (temporal { in_pipeline: true }).)")
      .def_property_readonly("config", &PyPipeline::config, "Config: all of it.");
  AddRepr(bound, [](const PyPipeline& pipeline) {
    return "Pipeline(" + std::string(py::repr(py::cast(pipeline.config()))) + ")";
  });
}

void BindInputs(py::module_& module) {
  py::class_<inputs::Finding> bound(module, "Finding",
                                    "The answer to one question of check_inputs().");
  const auto add = PropertiesOf(bound);
  add("question",
      "str: 'scene', 'time', 'sides', 'rows', 'bits', 'contrast', 'hits', 'place', 'scale' or "
      "'moment'.",
      [](const inputs::Finding& f) { return std::string(NameOf(f.question)); });
  add("verdict", "str: 'good', 'bad' or 'cannot tell'.",
      [](const inputs::Finding& f) { return std::string(NameOf(f.verdict)); });
  add("value", "float: the figure that decided, in `unit`; NaN: not known.",
      &inputs::Finding::value);
  add("sigma", "float: its standard deviation; NaN: not known.", &inputs::Finding::sigma);
  add("unit", "str: of value and sigma: '%', 'px', or '1' for a factor.",
      [](const inputs::Finding& f) { return std::string(UnitOf(f.question)); });
  add("text", "str: one line: what was found, and where it is bad, the cure.",
      &inputs::Finding::text);
  AddRepr(bound, [](const inputs::Finding& f) {
    return fmt::format("<sprout.Finding {}: {}: {}>", NameOf(f.question), NameOf(f.verdict),
                       f.text);
  });
  module.def(
      "check_inputs", &CheckInputsOf, py::arg("left"), py::arg("right"), py::arg("tof"),
      py::arg("rig"),
      R"(check_inputs(left: numpy.ndarray, right: numpy.ndarray, tof: Union[numpy.ndarray, Tof, None], rig: Rig) -> List[Finding]

Whether the parts of a frame fit each other: one finding a question. Arguments as of
Pipeline.compute().

    for finding in findings:
        if finding.verdict == "bad":
            print(finding.text))");
}

}  // namespace sprout::python
