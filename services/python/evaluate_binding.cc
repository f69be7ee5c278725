#include <fmt/core.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/core/printable.h"
#include "common/measure/score.h"
#include "common/measure/sparsification.h"
#include "common/scenes/dataset.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

namespace fs = std::filesystem;

// The figures of an evaluation, with the names of sprout-evaluate's JSON.
struct Evaluation {
  Accuracy accuracy;
  std::optional<Sparsification> confidence;
};

Evaluation Evaluate(const py::object& disparity, const py::object& truth,
                    const py::object& right_truth, const py::object& mask,
                    const py::object& confidence) {
  const cv::Mat1f map = TakeFloats("disparity", disparity, {});
  const cv::Mat1f left = TakeFloats("truth", truth, map.size());
  const auto optional = [&](const py::object& given, auto take) {
    return given.is_none() ? std::decay_t<decltype(take())>() : take();
  };
  const cv::Mat1f right =
      optional(right_truth, [&] { return TakeFloats("right_truth", right_truth, map.size()); });
  cv::Mat1b scored =
      optional(mask, [&] { return TakeBytes("mask", mask, map.size(), /*mask=*/true); });
  const cv::Mat1b trust =
      optional(confidence, [&] { return TakeBytes("confidence", confidence, map.size()); });
  const Unlocked free;
  if (scored.empty()) scored = NonOccludedMask(left, right).value();
  Evaluation evaluation{Score(map, left, scored).value(), {}};
  if (!trust.empty()) evaluation.confidence = Sparsify(map, left, scored, trust);
  return evaluation;
}

template <auto kFigure>
double Figure(const Evaluation& evaluation) {
  return (evaluation.accuracy.*kFigure)();
}

std::string Repr(const Evaluation& evaluation) {
  const Accuracy& score = evaluation.accuracy;
  return fmt::format(
      "<sprout.Evaluation correct_le1={:.2f} % bad2={:.2f} % density={:.2f} % mean_abs_px={:.3f} "
      "scored={}>",
      score.correct_le1_percent(), score.bad2_percent(), score.density_percent(),
      score.mean_abs_px(), score.scored);
}

class PyDataset {
 public:
  PyDataset(const fs::path& source, const py::object& config) : source_(source) {
    SproutConfig whole = config.is_none() ? LoadConfig({}) : TakeConfig(config);
    whole.mutable_capture()->set_source(source_);
    if (whole.capture().rate_hz() > 0) period_us_ = 1e6 / whole.capture().rate_hz();
    const Unlocked free;
    dataset_ = scenes::OpenDataset(whole.capture());
  }

  PyFrame Get(int64_t number) {
    const std::optional<int64_t> count = dataset_->frame_count();
    const int64_t at = number < 0 && count ? number + *count : number;
    if (at < 0 || (count && at >= *count)) {
      throw py::index_error("frame " + std::to_string(number) + ": not in " + Printable(source_));
    }
    const Turn turn(taken_, "Dataset");
    const Unlocked free;
    scenes::DatasetFrame got = dataset_->Get(at);
    PyFrame result;
    constexpr double kLatestUs = 9e18;  // what an int64_t holds
    // Data sets have no times. A stage with a memory needs some, so frames begin at 0.
    result.frame.id = {
        .utime = std::llround(std::min(period_us_ * (static_cast<double>(at) + 1), kLatestUs)),
        .seq = at,
        .rig_id = RigId(dataset_->rig())};
    result.frame.left = std::move(got.left);
    result.frame.right = std::move(got.right);
    result.frame.tof = std::move(got.tof);
    result.frame.tof_zones = std::move(got.tof_zones);
    result.frame.rig = dataset_->rig();
    result.truth = std::move(got.truth);
    return result;
  }

  int64_t Count() const {
    if (const auto count = dataset_->frame_count()) return *count;
    throw py::type_error(Printable(source_) + " has no end");
  }

  const Rig& rig() const { return dataset_->rig(); }
  const std::string& source() const { return source_; }

 private:
  std::string source_;
  double period_us_ = 1e3;  // where no rate is set: that of the highest rate allowed
  std::unique_ptr<scenes::Dataset> dataset_;
  std::atomic_flag taken_;
};

}  // namespace

void BindEvaluate(py::module_& module) {
  py::class_<Evaluation> bound(
      module, "Evaluation",
      R"(How well a disparity map matches the truth, as sprout-evaluate says it.

Shares are per cent of the scored pixels; a pixel without a disparity is wrong. NaN when none is scored.)");
  const auto add = PropertiesOf(bound);
  add("scored", "int: pixels whose truth is known, in the mask.",
      [](const Evaluation& e) { return e.accuracy.scored; });
  add("correct_le1", "float: error <= 1 px, %.", &Figure<&Accuracy::correct_le1_percent>);
  add("correct_lt1", "float: error < 1 px, %.", &Figure<&Accuracy::correct_lt1_percent>);
  add("bad05", "float: error > 0.5 px or no disparity, %.", &Figure<&Accuracy::bad05_percent>);
  add("bad2", "float: error > 2 px or no disparity, %.", &Figure<&Accuracy::bad2_percent>);
  add("bad4", "float: error > 4 px or no disparity, %.", &Figure<&Accuracy::bad4_percent>);
  add("d1", "float: error > 3 px and > 5 % of the truth, or no disparity, %.",
      &Figure<&Accuracy::d1_percent>);
  add("density", "float: with a disparity, %.", &Figure<&Accuracy::density_percent>);
  add("mean_abs_px", "float: of pixels with a disparity, px.", &Figure<&Accuracy::mean_abs_px>);
  add("rms_px", "float: of pixels with a disparity, px.", &Figure<&Accuracy::rms_px>);
  add("confidence_bad1",
      "Optional[List[float]]: bad 1 of the most trusted 5, 10, ... 100 % of the pixels, %.",
      [](const Evaluation& e) {
        return e.confidence ? py::cast(e.confidence->bad1_percent) : py::none();
      });
  add("confidence_area", "Optional[float]: area under that curve, %; less is better.",
      [](const Evaluation& e) {
        return e.confidence ? py::cast(e.confidence->area_percent) : py::none();
      });
  add("confidence_oracle_area", "Optional[float]: the same had the wrong pixels come last.",
      [](const Evaluation& e) {
        return e.confidence ? py::cast(e.confidence->oracle_area_percent) : py::none();
      });
  AddRepr(bound, [](const Evaluation& e) { return Repr(e); });
  module.def(
      "evaluate", &Evaluate, py::arg("disparity"), py::arg("truth"),
      py::arg("right_truth") = py::none(), py::arg("mask") = py::none(),
      py::arg("confidence") = py::none(),
      R"(evaluate(disparity: numpy.ndarray, truth: numpy.ndarray, right_truth: Optional[numpy.ndarray] = ..., mask: Optional[numpy.ndarray] = ..., confidence: Optional[numpy.ndarray] = ...) -> Evaluation

The measures of sprout-evaluate. disparity, truth: (H, W) float32, px; NaN or infinite: none, not known.
Scored are the pixels of mask ((H, W) bool or uint8); without it those that both cameras see, found from
truth and, if it is there, right_truth. confidence: (H, W) uint8, what sorting by it is worth.)");
}

void BindDataset(py::module_& module) {
  py::class_<PyDataset> bound(module, "Dataset",
                              R"(Frames with ground truth: a data set, or a simulation.

    Dataset("middlebury:DIR?tof=sr4000")    a scene of 2005, 2006 or 2014; tof: grid, sr4000, zones:8x8 or none
    Dataset("kitti:DIR")                    frames in KITTI's layout, the scan as range image
    Dataset("synthetic:640x480")            a moving scene without an end)");
  bound
      .def(py::init<const fs::path&, const py::object&>(), py::arg("source"),
           py::arg("config") = py::none(),
           R"(__init__(self, source: str, config: Optional[Config] = ...) -> None

source: as sprout-capture --source has it for data sets. config: for the capture part.)")
      .def("__getitem__", &PyDataset::Get, py::arg("number"),
           R"(__getitem__(self, number: int) -> Frame

The same number gives the same bytes. Its utime is that of a capture that began at 0, with capture {
rate_hz }: the first frame's is 200000 us by default.)")
      .def("__len__", &PyDataset::Count, "__len__(self) -> int")
      .def_property_readonly("rig", &PyDataset::rig, "Rig: of all its frames.");
  AddRepr(bound, [](const PyDataset& dataset) {
    return "Dataset(" + std::string(py::repr(TextOfBytes(dataset.source()))) + ")";
  });
}

}  // namespace sprout::python
