#include "services/tools/evaluate/program.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/app/progress.h"
#include "common/core/joined.h"
#include "common/inputs/check_inputs.h"
#include "services/tools/evaluate/confidence_diagram.h"
#include "services/tools/evaluate/rig_error.h"
#include "services/tools/evaluate/run_pictures.h"
#include "services/tools/evaluate/tables.h"
#include "services/tools/evaluate/truth_check.h"
#include "services/tools/evaluate/video.h"

namespace sprout::evaluate {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> scenes;
  LogChoice log;
  std::string truth;
  std::vector<std::string> methods{"all"};
  std::string preset;
  std::vector<std::string> config_files;
  std::optional<std::string> tof;
  std::optional<std::string> rig_error;
  SeedNoise noise;
  FgsSettings fgs;
  int threads = 1;
  int repeat = 1;
  std::string json;
  std::string csv;
  std::string images;
  bool quiet = false;
  bool wide = false;
  int video_frames = 10;
  double video_rate_hz = 10;
  double image_noise = 0;
};

constexpr char kDescription[] =
    "Measures accuracy: of methods on scenes with ground truth, of a log's answers, of a video. "
    "The same\nflags give the same figures, except times.";

constexpr char kDefinitions[] = R"(
Definitions (as in the Middlebury SDK)
  error       |d - d_gt| of a pixel, px. A pixel without a disparity is wrong for every threshold.
  nonocc      the pixels that are scored: those that both cameras see. The truth is known in both
              views and |d_left(u, v) - d_right(u - d_left, v)| <= 1. Without a right truth, the
              left one is warped into the right image, where the nearest surface is seen.
  all         all pixels with a known left truth.
  away        of these, the ones at least 3 px from every ToF point.
  <= 1, < 1   per cent of pixels with an error of at most / below 1 px. "<= 1" is 100 - "total bad
              1.0". Maps of whole pixels are favoured by <=, so tables show both.
  bad N       per cent of pixels with an error > N px, or without a disparity.
  D1          per cent with an error > 3 px and > 5 % of the true disparity, or no disparity.
  density     per cent of pixels with a disparity; invalid: the others.
  mean, rms   absolute error, over the pixels with a disparity.
  wrong seed  more than 3 px from the truth, or on a pixel that a nearer surface hides from the
              right camera; per cent of all ToF points (before refinement) and of those kept
              (after). A good one is within 3 px on a pixel that both cameras see; lost: refinement
              dropped it.
  confidence  bad 1 of the pixels with the highest confidence; area: mean of that curve over
              the share of pixels kept; oracle: if the wrong pixels came last.
  times       medians over --repeat runs, ms, one run after another. Rivals have one time; that of
              rivals with ToF seeds includes refinement.

)";

std::string MethodsHelp() {
  std::string text = "\nMethods (--methods NAME,NAME,...; groups: paper, all)\n";
  for (const Method& method : AllMethods()) {
    text += "  " + method.name + std::string(15 - method.name.size(), ' ') + method.summary + "\n";
  }
  return text;
}

void AddConfigFlags(Flags& flags, Options& options) {
  flags.Add("--preset NAME", options.preset,
            "Preset with the methods' parameters (default unless --config is given)");
  flags
      .Add("--config FILE", options.config_files,
           "Configuration file; may be given several times, later ones override earlier ones "
           "and all of them the preset")
      .Repeatable();
  flags.Add("--threads", options.threads, "For OpenCV; figures do not depend on it")
      .WithinWhole(1, 1024)
      .ShowDefault();
}

void AddFileFlags(Flags& flags, Options& options) {
  flags.Add("--json FILE", options.json, "Write the results as JSON");
  flags.Add("--csv FILE", options.csv, "Write the results as CSV");
}

void AddQuiet(Flags& flags, Options& options) {
  flags.Add("--quiet", options.quiet, "No tables, no progress: only files and errors");
}

void AddSceneFlags(Flags& flags, Options& options) {
  flags
      .Add("SCENE", options.scenes,
           "Folders of Middlebury scenes with ground truth, DIR or middlebury:DIR; synthetic:WxH, "
           "a simulated scene; "
           "kitti:DIR/ID or kitti:DIR, one frame or all in KITTI's layout, with ?beams=N to keep "
           "32, 16, 8 or 4 of the scan's 64 beams")
      .Required();
  flags.Add("--methods LIST", options.methods, "Methods or groups of them, listed below")
      .SplitAtCommas()
      .Repeatable()
      .ShowDefault("all");
  flags
      .Add("--tof", options.tof,
           "ToF camera: grid:auto (every round(rows / 111)th pixel of the truth: 10 at full size, "
           "as in the paper), grid:auto*K (K times that), grid:N (every Nth), sr4000 (a camera at "
           "its own position with the errors of a real one; ?blind=P: without the P % of its "
           "returns with the lowest amplitude; ?wrapped=P: P % are beyond the unambiguous range; "
           "?calibration=PX: its pose is off; ?every=K: only every Kth pixel of its rows and "
           "columns; either of them with ?range=MM, ?wiggle=MM, ?period=M, ?bumps=PX, ?unit=F, "
           "?mirrored: what its ranges are off by; '&' between several), zones:CxR (a multi-zone "
           "sensor such as zones:8x8; ?mode=nearest, &targets=N), or none; for kitti: scan (the "
           "one recorded), or none")
      .ShowDefault("grid:auto, kitti: scan");
  flags.Add("--rig-error", options.rig_error,
            "A right camera that was knocked since the calibration: rows=N (px lower), roll=N, "
            "yaw=N (degrees); ?refined behind it: rectified again with what sprout-calibrate "
            "refine finds in the frame; ?known: with the error itself");
  flags
      .Add("--seed-noise-px", options.noise.disparity_px,
           "Gaussian noise on the disparity of the refined seeds, standard deviation, px")
      .Within(0.0, 1000.0)
      .ShowDefault();
  flags
      .Add("--seed-jitter-px", options.noise.jitter_px,
           "Uniform noise on their position in u and in v, at most, px")
      .Within(0.0, 1000.0)
      .ShowDefault();
  flags.Add("--fgs-lambda", options.fgs.lambda, "Method fgs: how far seeds spread")
      .ShowDefault()
      .Within(0.01, 1e6);
  flags
      .Add("--fgs-sigma", options.fgs.sigma,
           "Method fgs: difference of colours across which they hardly spread, grey levels")
      .ShowDefault()
      .Within(0.1, 255.0);
  flags.Add("--seed", options.noise.seed, "Seed of the random numbers").ShowDefault();
}

void AddRunFlags(Flags& flags, Options& options) {
  AddConfigFlags(flags, options);
  flags.Add("--repeat", options.repeat, "Runs of each method, for the median of its times")
      .WithinWhole(1, 1000)
      .ShowDefault();
  AddFileFlags(flags, options);
  flags.Add("--images DIR", options.images,
            "Write a picture of every map, figure.png and errors.png with all of them, and "
            "confidence.svg: whether confidences hold");
  flags.Add("--wide", options.wide, "Tables with all figures and the time of each step");
  AddQuiet(flags, options);
}

void AddLogFlags(Flags& flags, Options& options) {
  flags.Add("LOG", options.log.file, "With the recorded answers of a graph").Required();
  flags.Add("--truth SOURCE", options.truth,
            "Source that the log was captured from, with the ground truth of its frames: "
            "middlebury:DIR, kitti:DIR, synthetic:WxH; else without truth, as sprout-log rank");
  flags.Add("--frames A:B", options.log.frames, "Frames by number, both included");
  flags.Add("--channel-prefix TEXT", options.log.prefix, "Prefix of the channels");
  AddFileFlags(flags, options);
  AddQuiet(flags, options);
}

void AddVideoFlags(Flags& flags, Options& options) {
  flags
      .Add("SOURCE", options.scenes,
           "As capture has them: kitti:DIR?beams=16, synthetic:640x480?tof=sr4000, middlebury:DIR")
      .Required();
  flags.Add("--frames", options.video_frames, "Of each source, at most")
      .WithinWhole(1, 100000)
      .ShowDefault();
  flags.Add("--rate", options.video_rate_hz, "Frames a second").Within(0.01, 1000.0).ShowDefault();
  flags
      .Add("--image-noise", options.image_noise,
           "Gaussian noise on both images, standard deviation, grey levels")
      .Within(0.0, 100.0)
      .ShowDefault();
  AddConfigFlags(flags, options);
  flags.Add("--images DIR", options.images,
            "Write for each source the errors of some frames, and bad 3 over the frames");
  AddQuiet(flags, options);
}

// The configuration and its name in the results.
struct Preset {
  std::vector<std::string> files;
  std::string name;
};

Preset PresetOf(const Options& options) {
  Preset preset;
  if (!options.preset.empty()) {
    preset.files.push_back(options.preset);
  } else if (options.config_files.empty()) {
    preset.files.push_back("default");
  }
  preset.files.insert(preset.files.end(), options.config_files.begin(), options.config_files.end());
  preset.name =
      Joined("+", preset.files, [](const fs::path& file) { return file.stem().string(); });
  return preset;
}

// Two scenes of one name would write the same pictures.
void RequireDifferentNames(const std::vector<Scene>& scenes) {
  std::set<std::string> names;
  for (const Scene& scene : scenes) {
    if (names.insert(scene.name).second) continue;
    throw ConfigError("--images: two scenes have the name " + scene.name +
                      "; allowed: scenes of different names");
  }
}

void RequireWritable(const Options& options) {
  if (!options.json.empty()) RequireWritableFile("--json", options.json);
  if (!options.csv.empty()) RequireWritableFile("--csv", options.csv);
  if (!options.images.empty())
    RequireWritableFolder("--images", options.images,
                          {"figure.png", "errors.png", "confidence.svg"});
}

// @param inputs_fit  set to false when something is wrong with the inputs of a scene.
std::vector<SceneResult> ResultsOf(const Options& options, const std::vector<Scene>& scenes,
                                   const std::vector<Method>& methods,
                                   const ChainSettings& settings, bool& inputs_fit) {
  std::vector<SceneResult> results;
  RunPictures pictures(options.images);
  Progress progress(options.quiet);
  for (const Scene& scene : scenes) {
    const std::string place = "scene " + std::to_string(results.size() + 1) + " of " +
                              std::to_string(scenes.size()) + ", " + scene.name + ": ";
    SceneResult result =
        EvaluateScene(scene, methods, settings, options.repeat,
                      [&](const Method& method) { progress.Show(place + method.name); });
    std::string wrong = BadText(inputs::CheckInputs(
        scene.left_grey, scene.right_grey, scene.frame.tof, scene.projector.rig().pair,
        scene.frame.tof.depth_m.empty() ? nullptr : &scene.projector));
    if (wrong.empty()) wrong = WrongTruthText(scene);
    if (!options.images.empty()) pictures.Add(scene, result);
    for (MethodResult& method : result.methods) method.map_px.release();
    progress.Clear();
    if (!options.quiet) std::cout << SceneTable(result, options.wide) << std::endl;
    if (!wrong.empty()) std::cerr << "sprout-evaluate: " << scene.name << ": " << wrong << "\n";
    inputs_fit &= wrong.empty();
    results.push_back(std::move(result));
  }
  if (options.images.empty()) return results;
  pictures.WriteFigures();
  if (const std::string svg = ConfidenceSvg(results); !svg.empty()) {
    WriteWhole((fs::path(options.images) / "confidence.svg").string(), svg);
  }
  return results;
}

// Everything that can be wrong with the flags is found out before the first method runs.
int RunScenes(const Options& options) {
  const std::vector<Method> methods = SelectMethods(options.methods);
  std::vector<std::string> names;
  for (const std::string& scene : options.scenes)
    std::ranges::move(ScenesOf(scene), std::back_inserter(names));
  const bool recorded = std::ranges::all_of(names, IsKitti);
  const TofChoice tof(options.tof.value_or(recorded ? TofChoice::kScan : "grid:auto"));
  const auto rig_error =
      options.rig_error ? std::optional<RigError>(*options.rig_error) : std::nullopt;
  const Preset preset = PresetOf(options);
  const ChainSettings settings{
      .config = LoadConfig(preset.files), .noise = options.noise, .fgs = options.fgs};
  std::vector<Scene> scenes;
  scenes.reserve(names.size());
  for (const std::string& scene : names) {
    scenes.push_back(LoadScene(scene, tof, settings.config.capture()));
    if (rig_error) rig_error->Apply(scenes.back());
  }
  if (!options.images.empty()) RequireDifferentNames(scenes);
  RequireWritable(options);

  cv::setNumThreads(options.threads);
  bool inputs_fit = true;
  const RunResult run{.preset = preset.name,
                      .tof = tof.text(),
                      .scenes = ResultsOf(options, scenes, methods, settings, inputs_fit)};
  if (!options.json.empty()) WriteWhole(options.json, ToJson(run));
  if (!options.csv.empty()) WriteWhole(options.csv, ToCsv(run));
  if (!options.quiet && options.preset == "paper") std::cout << PaperTable(run.scenes);
  return inputs_fit ? 0 : 1;
}

int RunVideo(const Options& options) {
  cv::setNumThreads(options.threads);
  const VideoSettings settings{.config = LoadConfig(PresetOf(options).files),
                               .frames = options.video_frames,
                               .rate_hz = options.video_rate_hz,
                               .image_noise = options.image_noise,
                               .images = options.images};
  if (!options.images.empty()) RequireWritableFolder("--images", options.images, {"video.svg"});
  Progress progress(options.quiet);
  std::vector<VideoResult> results;
  for (const std::string& source : options.scenes) {
    results.push_back(EvaluateVideo(source, settings, [&](int frame) {
      progress.Show(source + ": frame " + std::to_string(frame));
    }));
  }
  progress.Clear();
  if (!options.quiet) std::cout << VideoTable(results);
  bool inputs_fit = true;
  for (const VideoResult& result : results) {
    if (result.wrong_inputs.empty()) continue;
    std::cerr << "sprout-evaluate: " << result.source << ": " << result.wrong_inputs << "\n";
    inputs_fit = false;
  }
  return inputs_fit ? 0 : 1;
}

int RunLog(const Options& options, const ReadLog& read_log) {
  RequireWritable(options);
  std::unique_ptr<scenes::Dataset> truth;
  if (!options.truth.empty()) truth = scenes::OpenDataset(options.truth);
  LogEvaluation evaluation(std::move(truth));
  read_log(options.log, [&](const Frame& frame) { evaluation.Add(frame); });
  if (evaluation.answered() == 0) {
    throw ConfigError(options.log.file +
                      ": no frame with SPROUT_DISPARITY; allowed: a log with the answers of grow");
  }
  if (!options.json.empty()) WriteWhole(options.json, evaluation.Json());
  if (!options.csv.empty()) WriteWhole(options.csv, evaluation.Csv());
  if (!options.quiet) std::cout << evaluation.Table();
  if (evaluation.wrong_truth().empty()) return 0;
  std::cerr << "sprout-evaluate: --truth " << options.truth << ": " << evaluation.wrong_truth()
            << "\n";
  return 1;
}

}  // namespace

int EvaluateMain(int argc, const char* const* argv, const ReadLog& read_log) {
  Flags flags("sprout-evaluate", kDescription);
  Options options;
  flags.RequireCommand();
  Flags& of_scenes =
      flags.AddCommand("scenes", "Runs methods on scenes with ground truth: accuracy and times",
                       [&] { return RunScenes(options); });
  AddSceneFlags(of_scenes, options);
  AddRunFlags(of_scenes, options);
  of_scenes.SetFooter(MethodsHelp());
  AddLogFlags(flags.AddCommand("log", "Evaluates the recorded answers of a log",
                               [&] { return RunLog(options, read_log); }),
              options);
  AddVideoFlags(flags.AddCommand(
                    "video", "Frame after frame: what sprout-temporal gains, and a running average",
                    [&] { return RunVideo(options); }),
                options);
  flags.SetFooter(kDefinitions);
  return RunProgram(flags, argc, argv,
                    [&] { return RefusingLogs([&] { return flags.RunCommand(); }); });
}

}  // namespace sprout::evaluate
