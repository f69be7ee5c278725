#include <memory>

#include "common/scenes/dataset.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

class PyDataset {
 public:
  PyDataset(const std::string& source, const py::object& config) : source_(source) {
    SproutConfig whole = config.is_none() ? LoadConfig({}) : TakeConfig(config);
    whole.mutable_capture()->set_source(source);
    const Unlocked free;
    dataset_ = scenes::OpenDataset(whole.capture());
  }

  PyFrame Get(int64_t number) {
    const std::optional<int64_t> count = dataset_->frame_count();
    const int64_t at = number < 0 && count ? number + *count : number;
    if (at < 0 || (count && at >= *count)) {
      throw py::index_error("frame " + std::to_string(number) + ": not in " + source_);
    }
    const Turn turn(taken_, "Dataset");
    const Unlocked free;
    scenes::DatasetFrame got = dataset_->Get(at);
    PyFrame result;
    result.frame.id = {.utime = got.utime.value_or(0), .seq = at, .rig_id = RigId(dataset_->rig())};
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
    throw py::type_error(source_ + " has no end");
  }

  const Rig& rig() const { return dataset_->rig(); }
  const std::string& source() const { return source_; }

 private:
  std::string source_;
  std::unique_ptr<scenes::Dataset> dataset_;
  std::atomic_flag taken_;
};

}  // namespace

void BindDataset(py::module_& module) {
  py::class_<PyDataset>(module, "Dataset",
                        R"(Frames with ground truth: a data set, or a simulation.

    Dataset("middlebury:DIR?tof=sr4000")    a scene of 2005, 2006 or 2014; tof: grid, sr4000, zones:8x8 or none
    Dataset("kitti:DIR")                    frames in KITTI's layout, the scan as range image
    Dataset("synthetic:640x480")            a moving scene without an end)")
      .def(py::init<const std::string&, const py::object&>(), py::arg("source"),
           py::arg("config") = py::none(),
           R"(__init__(self, source: str, config: Optional[Config] = ...) -> None

source: as sprout-capture --source has it for data sets. config: for the capture part.)")
      .def("__getitem__", &PyDataset::Get, py::arg("number"),
           "__getitem__(self, number: int) -> Frame\n\nThe same number gives the same bytes.")
      .def("__len__", &PyDataset::Count, "__len__(self) -> int")
      .def_property_readonly("rig", &PyDataset::rig, "Rig: of all its frames.")
      .def(
          "__repr__",
          [](const PyDataset& dataset) {
            return "Dataset(" + std::string(py::repr(py::str(dataset.source()))) + ")";
          },
          "__repr__(self) -> str");
}

}  // namespace sprout::python
