#include <pybind11/stl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/app/log.h"
#include "common/app/run_stage.h"
#include "common/config/stage_parts.h"
#include "common/core/answer_values.h"
#include "common/geometry/widened_frame.h"
#include "common/messages/convert.h"
#include "services/python/arrays.h"
#include "services/python/bindings.h"

namespace sprout::python {
namespace {

constexpr std::array<std::string_view, 3> kStages = {"refine", "prior", "grow"};

// Refuses an answer that later stages would reject: the caller learns the reason here.
void RequireRight(const std::string& name, const std::optional<std::string>& wrong) {
  if (wrong) throw py::value_error(name + ": " + *wrong);
}

// Smallest disparity that an answer may have, px: as far below 0 as the calibration or the seeds
// reach, less a pixel for rounding.
double MinDisparity(const Frame& frame) {
  int columns = frame.rig ? ColumnsBelowZero(frame.rig->pair) : 0;
  if (frame.seeds) columns = std::max(columns, ColumnsBelowZero(frame.seeds->seeds));
  if (!frame.rig && !frame.seeds) columns = kMaxColumns;
  return -1.0 - columns;
}

// Converts what the function returned to a part, of the size of LEFT.
PartValue TakeValue(Part part, const py::handle& given, const Frame& frame) {
  const std::string name = NameOf(part);
  const cv::Size size = frame.left.size();
  const double least_px = MinDisparity(frame);
  switch (part) {
    case Part::kPrior: {
      if (!py::isinstance<PriorMap>(given)) Refuse(name, "a PriorMap", given);
      auto prior = given.cast<PriorMap>();
      if (prior.size() != size) {
        Refuse(name,
               "a map of shape (" + std::to_string(size.height) + ", " +
                   std::to_string(size.width) + ") as left",
               ToArray(prior.disparity));
      }
      RequireRight(name, WrongDisparity(prior.disparity, least_px));
      return prior;
    }
    case Part::kSeeds:
    case Part::kLeftSeeds: {
      SeedSet set{.seeds = TakeSeeds(name, given)};
      set.raw = CountTofSeeds(set.seeds);
      if (const auto sent = FromMessage(ToMessage(FrameId(), set)); !sent) {
        RequireRight(name, sent.error().text);
      }
      if (part == Part::kSeeds) RequireRight(name, WrongSeed(set.seeds, size, least_px));
      return set;
    }
    case Part::kConfidence:
      return cv::Mat(TakeBytes(name, given, size));
    case Part::kSigma:
      return cv::Mat(TakeSigmas(name, given, size));
    default: {
      DisparityImage map = TakeDisparities(name, given, size);
      RequireRight(name, WrongDisparity(map, least_px));
      return map;
    }
  }
}

// Why an answer is empty ("no seeds"); empty when it is not.
std::string EmptyText(const PartValue& value) {
  if (const auto* set = std::get_if<SeedSet>(&value)) {
    return set->seeds.empty() ? "the stage's function gives no seeds" : "";
  }
  const auto* prior = std::get_if<PriorMap>(&value);
  const DisparityImage& map = prior ? prior->disparity : std::get<DisparityImage>(value);
  return map.AnyValid() ? "" : "the stage's function gives a map without any disparity";
}

PartValue EmptyValue(Part part, cv::Size size) {
  switch (part) {
    case Part::kPrior:
      return PriorMap(size);
    case Part::kSeeds:
    case Part::kLeftSeeds:
      return SeedSet();
    case Part::kConfidence:
      return cv::Mat(cv::Mat1b::zeros(size));
    case Part::kSigma:
      return cv::Mat(cv::Mat1b(size, kMaxSigmaCounts));
    default:
      return DisparityImage(size);
  }
}

// One line of pybind11's text of an exception, which is the message, an empty line and a traceback.
std::string InOneLine(std::string text) {
  constexpr std::string_view kPlaces = "\n\nAt:\n  ";
  const size_t places = text.rfind(kPlaces);
  if (places != std::string::npos) text.replace(places, kPlaces.size(), " at ");
  text.resize(text.find_last_not_of('\n') + 1);
  for (size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end)) {
    text.replace(end, text.find_first_not_of("\n ", end) - end, "; ");
  }
  return text;
}

// A stage whose work a function in Python does. Called by the thread that runs the stage, without
// the interpreter's lock.
class PyStage : public StageAdapter {
 public:
  // @param ending  gets an exception that ends the program, such as SystemExit.
  PyStage(const std::string& stage, const SproutConfig& config, PartSet inputs, py::object function,
          std::optional<py::error_already_set>& ending)
      : stage_(stage),
        inputs_(inputs),
        outputs_(OutputsOf(stage, config)),
        config_(config),
        function_(std::move(function)),
        ending_(ending) {}

  PartSet Inputs() const override { return inputs_; }

  StageResult Process(const Frame& frame) override {
    const Locked gil;
    // The program ends some time after the signal; until then the function is not called again.
    if (ending_) throw std::runtime_error("the stage's function has ended the program");
    try {
      return Answer(frame);
    } catch (const py::error_already_set& error) {  // must not outlive the lock
      if (!error.matches(PyExc_Exception)) EndProgram(error);
      throw std::runtime_error(InOneLine(error.what()));
    } catch (const py::builtin_exception& error) {
      throw std::runtime_error(error.what());
    }
  }

 private:
  // SystemExit and the like are no errors of a frame: the program is asked to end, as by a signal,
  // and Run() raises them again.
  void EndProgram(const py::error_already_set& error) {
    if (ending_) return;
    ending_.emplace(error);
    kill(getpid(), SIGTERM);
  }

  StageResult Answer(const Frame& frame) {
    const py::object given = function_(PyFrame{.frame = frame}, config_);
    const cv::Size size = frame.left.size();
    StageResult outcome;
    if (py::isinstance<py::str>(given)) {
      outcome.degenerate = InOneLine(BytesOfText(given));
      if (outcome.degenerate.empty()) outcome.degenerate = "the stage's function gives no reason";
      for (const Part part : kAllParts) {
        if (outputs_.Has(part)) outcome.outputs.push_back({part, EmptyValue(part, size)});
      }
      return outcome;
    }
    py::dict parts;
    if (py::isinstance<py::dict>(given)) {
      parts = given;
    } else {
      parts[py::str(NameOf(MainPart()))] = given;
    }
    RequireKnown(parts);
    for (const Part part : kAllParts) {
      const py::str name(NameOf(part));
      if (!outputs_.Has(part)) {
        if (parts.contains(name))
          WarnOnce(part, "is not sent: the configuration does not ask for it");
      } else if (parts.contains(name)) {
        outcome.outputs.push_back({part, TakeValue(part, parts[name], frame)});
        if (part == MainPart()) outcome.degenerate = EmptyText(outcome.outputs.back().value);
      } else if (part == Part::kLeftSeeds) {
        outcome.outputs.push_back({part, SeedSet()});
      } else if (part == MainPart()) {
        Refuse(std::string(name), "a value in the dict", py::none());
      } else {
        WarnOnce(part, "is missing, and the configuration asks for it");
      }
    }
    return outcome;
  }

  Part MainPart() const {
    if (stage_ == "refine") return Part::kSeeds;
    return stage_ == "prior" ? Part::kPrior : Part::kDisparity;
  }

  void RequireKnown(const py::dict& parts) const {
    for (const auto& item : parts) {
      const Part part = TakePart(py::str(item.first));
      if (OutputsOf(stage_, AllPublished()).Has(part)) continue;
      throw py::value_error(NameOf(part) + ": " + stage_ + " does not answer that");
    }
  }

  static SproutConfig AllPublished() {
    SproutConfig config;
    config.mutable_grow()->set_publish_unfilled(true);
    config.mutable_grow()->set_publish_confidence(true);
    return config;
  }

  void WarnOnce(Part part, std::string_view what) {
    if (warned_.Has(part)) return;
    warned_.Add(part);
    LogLine(LogLevel::kWarning, "{} {}", NameOf(part), what);
  }

  std::string stage_;
  PartSet inputs_;
  PartSet outputs_;
  SproutConfig config_;
  py::object function_;
  PartSet warned_;
  std::optional<py::error_already_set>& ending_;
};

int Run(const std::string& stage, const py::object& function, const py::object& inputs,
        const std::string& description, std::vector<std::string> arguments) {
  const std::optional<PartSet> chosen =
      inputs.is_none() ? std::nullopt : std::optional(TakeParts(inputs));
  if (std::ranges::find(kStages, stage) == kStages.end()) {
    throw py::value_error("stage: expected one of refine, prior, grow, given '" + stage + "'");
  }
  // `python -c` has "-c" in its place.
  const std::string script =
      arguments.empty() ? "" : std::filesystem::path(arguments[0]).filename().string();
  const std::string program = script.empty() || script == "-c" ? "python" : script;
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::optional<py::error_already_set> ending;
  const auto make_stage = [&](const SproutConfig& config) -> std::unique_ptr<StageAdapter> {
    PartSet needed = chosen.value_or(InputsOf(stage, config));
    needed.Add(Part::kLeft);  // an answer has its size
    const Locked gil;
    return std::make_unique<PyStage>(stage, config, needed, function, ending);
  };
  int exit_code = 0;
  {
    const Unlocked free;
    exit_code = RunStage(static_cast<int>(arguments.size()), argv.data(), stage, description,
                         make_stage, program);
  }
  if (ending) throw py::error_already_set(*ending);
  return exit_code;
}

}  // namespace

void BindStage(py::module_& module) {
  module.def(
      "_run_stage", &Run, py::arg("stage"), py::arg("function"), py::arg("inputs"),
      py::arg("description"), py::arg("arguments"),
      R"(_run_stage(stage: str, function: Callable[[Frame, Config], Any], inputs: Optional[Sequence[str]], description: str, arguments: List[bytes]) -> int

The whole of a stage's program; its exit code.)");
}

}  // namespace sprout::python
