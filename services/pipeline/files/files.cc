#include "services/pipeline/files/files.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <future>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <system_error>
#include <utility>

#include "common/app/output_paths.h"
#include "common/app/progress.h"
#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/core/joined.h"
#include "common/core/output_file.h"
#include "common/core/printable.h"
#include "common/geometry/projection.h"
#include "common/inputs/check_inputs.h"
#include "common/inputs/hang_watch.h"
#include "common/picture/write_image.h"
#include "services/pipeline/files/believe_nothing.h"
#include "services/pipeline/files/write_results.h"
#include "services/pipeline/pipeline.h"
#include "services/refine/stereo/search_reach.h"
#include "services/refine/unwrapping/range_unwrapper.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;

double Percent(int64_t part, int64_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

// How sure the depths are in the mean; and how many there are, where some are missing.
std::string SurenessText(const DepthFrame& depth) {
  const cv::Mat known = depth.depth_m == depth.depth_m;
  const int count = cv::countNonZero(known);
  const cv::Mat1b& confidence =
      depth.fused_confidence.empty() ? depth.confidence : depth.fused_confidence;
  std::string text;
  if (!confidence.empty() && count > 0) {
    text = fmt::format("mean confidence {:.2f}", cv::mean(confidence, known)[0] / 255);
    if (count == static_cast<int>(known.total())) return text;
    text += ", ";
  }
  return text + fmt::format("{:.1f} % of the pixels have a depth",
                            Percent(count, static_cast<int64_t>(known.total())));
}

// Whether temporal says that it forgot earlier frames, as where a video is cut: nothing is wrong
// with such a pair, and motion.csv has it, too.
bool IsFromTemporal(const std::string& warning) { return warning.starts_with("temporal: "); }

// What is wrong with a pair that was computed, in one line; empty if nothing seems to be.
// @param input_problem  what CheckInputs() found wrong; empty: nothing.
std::string ProblemOf(const DepthFrame& depth, std::string input_problem) {
  constexpr double kNoPercent = 0.05;  // less is printed as 0.0
  std::string problem = std::move(input_problem);
  for (const std::string& warning : depth.warnings) {
    if (!IsFromTemporal(warning)) problem = JoinedTexts(problem, warning);
  }
  const int count = cv::countNonZero(depth.depth_m == depth.depth_m);
  const auto all = static_cast<int64_t>(depth.depth_m.total());
  if (problem.empty() && Percent(count, all) < kNoPercent) {
    problem = fmt::format("{} of {} pixels have a depth", count, all);
  }
  return problem;
}

// The line that is printed of a pair.
std::string LineOf(const fs::path& folder, const DepthFrame& depth, double ms) {
  std::string line = fmt::format("{}: {}, {} seeds, {}, {:.0f} ms", folder.string(),
                                 SizeText(depth.depth_m.size()), depth.seeds.seeds.size(),
                                 SurenessText(depth), ms);
  if (const int far = cv::countNonZero(depth.depth_m > kMaxPngDepthM); far > 0) {
    line += fmt::format("; {} of them more than {:.1f} m, which depth.png leaves out", far,
                        kMaxPngDepthM);
  }
  if (const int negative = cv::countNonZero((depth.disparity.counts() < 0) &
                                            (depth.disparity.counts() != DisparityImage::kInvalid));
      negative > 0) {
    line += fmt::format("; {} have a negative disparity, which disparity.png leaves out", negative);
  }
  for (const std::string& warning : depth.warnings) {
    if (IsFromTemporal(warning)) line += "; " + warning;
  }
  if (!depth.range_error.empty()) line += "; refine: " + depth.range_error;
  return line;
}

constexpr char kMotionHeader[] = "left,reset,resets,tracked,inliers,x_m,y_m,z_m,qw,qx,qy,qz\n";

// The pose of the left camera in the frame of the newest reset.
std::string MotionRow(const fs::path& left, const CameraMotion& motion) {
  const Pose& pose = motion.start_from_left;
  std::ostringstream name;
  name << std::quoted(left.filename().string(), '"', '"');
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", name.str(), NameOf(motion.reset),
                     motion.resets, motion.tracked, motion.inliers, pose.translation_m.x(),
                     pose.translation_m.y(), pose.translation_m.z(), pose.rotation.w(),
                     pose.rotation.x(), pose.rotation.y(), pose.rotation.z());
}

Result<void> WriteMotions(const fs::path& path, const std::string& rows) {
  OutputFile file(path);
  file.Write(kMotionHeader);
  file.Write(rows);
  return file.Commit();
}

// A pair that was computed, and is being written.
struct Writing {
  fs::path left;
  fs::path folder;
  bool is_folder_new = false;
  std::string line;     // to print when it is written
  std::string problem;  // what is wrong with the pair; empty: nothing that can be told
  std::string motion;   // a row, of a pipeline with memory
  std::future<Result<void>> written;
};

struct Computed {
  Frame frame;
  DepthFrame depth;
  double ms;
  std::string problem;
};

// The range image of a frame, unwrapped if its parts have the calibrated sizes.
TofImage RangesOf(const Frame& frame, double unambiguous_range_m) {
  const cv::Size size = frame.rig->pair.size();
  const bool fits = frame.left.size() == size && frame.right.size() == size &&
                    CheckTofSize(*frame.rig, *frame.tof).has_value();
  if (unambiguous_range_m == 0 || frame.tof->depth_m.empty() || !fits) return *frame.tof;
  return refine::RangeUnwrapper().Unwrap(ToGrey(frame.left), ToGrey(frame.right), *frame.tof,
                                         TofProjector(*frame.rig), unambiguous_range_m);
}

Result<Computed> ComputePair(PairReader& reader, const ImagePair& pair, Pipeline& pipeline,
                             inputs::RepeatWatch& repeat_watch, const SproutConfig& config) {
  using Clock = std::chrono::steady_clock;
  try {
    Result<Frame> frame = reader.Read(pair);
    if (!frame) return tl::unexpected(frame.error());
    const auto begun = Clock::now();
    inputs::Findings findings =
        inputs::CheckInputs(frame->left, frame->right,
                            RangesOf(*frame, config.refine().unambiguous_range_m()), *frame->rig);
    for (inputs::Finding& finding : findings) {
      if (!finding.flag.empty()) finding.text += " " + finding.flag;
    }
    const std::string repeats = repeat_watch.Add(frame->left, frame->right);
    std::string problem = JoinedTexts(repeats, BadText(findings));
    problem +=
        LeaveOutRanges(findings, config.refine().stereo_seeds(), frame->left.cols, *frame->tof);
    problem =
        JoinedTexts(problem, refine::BeyondSearch(findings, config.refine(), frame->rig->pair,
                                                  /*has_ranges=*/!frame->tof->depth_m.empty()));
    Result<DepthFrame> depth =
        pipeline.Compute(frame->left, frame->right, *frame->tof, *frame->rig);
    if (!depth) return tl::unexpected(depth.error());
    using inputs::Question;
    if (!repeats.empty() || AnyIsBad(findings, {Question::kScene, Question::kSides})) {
      BelieveNothing(config, *depth);
    }
    // A pair that does not fit its calibration is not fused with others.
    if (!repeats.empty() || AnyIsBad(findings, {Question::kScene, Question::kSides, Question::kRows,
                                                Question::kTime})) {
      pipeline.Reset();
    }
    const std::chrono::duration<double, std::milli> time = Clock::now() - begun;
    return Computed{*std::move(frame), *std::move(depth), time.count(), std::move(problem)};
  } catch (const std::exception& e) {
    return Fail(e.what());
  }
}

// All pairs, one after the other; each is written while the next one is computed.
class FilesRun {
 public:
  FilesRun(const FilesOptions& options, const SproutConfig& config)
      : options_(options),
        config_(config),
        reader_(options.rig, options.pixels),
        found_(ListPairs(options.left, options.right, options.tof, options.max_spread_ms)),
        pipeline_(config) {}

  void Run(const std::stop_token& stop) {
    for (const std::string& note : found_.notes) Say(note);
    for (const ImagePair& pair : found_.pairs) {
      if (stop.stop_requested()) break;
      ShowProgress(pair, "computing");
      Result<Computed> computed = ComputePair(reader_, pair, pipeline_, repeat_watch_, config_);
      FinishWriting();
      if (const std::string note = reader_.TakeNote(); !note.empty()) {
        progress_.Clear();
        Say(pair.left.string() + ": " + note);
      }
      if (computed) {
        StartWriting(pair, *std::move(computed));
      } else {
        LeaveOut(pair.left, computed.error());
      }
      ++done_;
    }
    if (writing_) ShowProgress(found_.pairs[done_ - 1], "writing");
    FinishWriting();
  }

  const ImagePairs& found() const { return found_; }
  size_t done() const { return done_; }
  size_t left_out() const { return left_out_; }
  size_t wrong() const { return wrong_; }
  const std::string& motions() const { return motions_; }

 private:
  static void Say(const std::string& text) {
    std::cerr << "sprout-pipeline: " << Printable(text) << "\n";
  }

  void ShowProgress(const ImagePair& pair, const char* what) {
    const size_t all = found_.pairs.size();
    const std::string of_many =
        all > 1 ? fmt::format("pair {} of {}: ", std::min(done_ + 1, all), all) : "";
    progress_.ShowTime(fmt::format("{}{} {}", of_many, what, pair.left.string()));
  }

  void StartWriting(const ImagePair& pair, Computed computed) {
    const fs::path out = options_.out;
    const fs::path folder = pair.folder.empty() ? out : out / pair.folder;
    const DepthFrame& depth = computed.depth;
    Writing& writing = writing_.emplace();
    writing.left = pair.left;
    writing.folder = folder;
    std::error_code ignored;
    writing.is_folder_new = !fs::exists(folder, ignored);
    writing.line = LineOf(folder, depth, computed.ms);
    writing.problem = ProblemOf(depth, std::move(computed.problem));
    if (depth.motion) writing.motion = MotionRow(pair.left, *depth.motion);
    writing.written = std::async(
        std::launch::async, [this, folder, computed = std::move(computed)]() -> Result<void> {
          try {
            return WriteResults(computed.frame, computed.depth, config_.depth().input(),
                                options_.only, folder);
          } catch (const std::exception& e) {
            return Fail(e.what());
          }
        });
  }

  void FinishWriting() {
    if (!writing_) return;
    const Result<void> written = writing_->written.get();
    progress_.Clear();
    if (written) {
      motions_ += writing_->motion;
      std::cout << Printable(writing_->line) << std::endl;
      if (!writing_->problem.empty()) {
        ++wrong_;
        Say(writing_->left.string() + ": " + writing_->problem);
      }
    } else {
      LeaveOut(writing_->left, written.error());
      if (writing_->is_folder_new) rmdir(writing_->folder.c_str());  // if it is empty
    }
    writing_.reset();
  }

  void LeaveOut(const fs::path& left, const Error& error) {
    progress_.Clear();
    ++left_out_;
    Say(left.string() + ": " + error.text);
  }

  const FilesOptions& options_;
  const SproutConfig& config_;
  PairReader reader_;
  ImagePairs found_;
  Pipeline pipeline_;
  inputs::RepeatWatch repeat_watch_;
  Progress progress_{/*quiet=*/false};
  size_t done_ = 0;
  size_t left_out_ = 0;
  size_t wrong_ = 0;
  std::string motions_;
  std::optional<Writing> writing_;  // last: ends before the rest is destroyed
};

// Settings of what sprout-depth publishes would be believed to hold for files, too.
void RequireAllApplied(const DepthConfig& config) {
  const DepthConfig usual;
  const auto reject = [](bool is_given, const std::string& name) {
    if (!is_given) return;
    throw ConfigError("depth." + name +
                      ": is of what sprout-depth publishes, `files` does not apply it; allowed: "
                      "without it");
  };
  reject(config.every() != usual.every(), "every");
  reject(config.mm_per_count() != usual.mm_per_count(), "mm_per_count");
  reject(config.scale() != usual.scale(), "scale");
  reject(config.cloud_stride() != usual.cloud_stride(), "cloud_stride");
  reject(config.cloud_voxel_m() != usual.cloud_voxel_m(), "cloud_voxel_m");
  reject(config.publish_scan(), "publish_scan");
  reject(!config.target().empty(), "target");
}

// Creates the output folder. @returns whether it is new.
bool CreateFolder(const std::string& out) {
  std::error_code ignored;
  const bool is_new = !fs::exists(out, ignored);
  RequireWritableFolder("--out", out, {"camera.json"});
  return is_new;
}

// No result may replace an input of this run, be it the next pair's.
void RequireInputsStay(const std::vector<ImagePair>& pairs, const fs::path& out) {
  for (const ImagePair& pair : pairs) {
    for (const fs::path& input : {pair.left, pair.right, pair.tof}) NoteInputFile(input);
  }
  for (const ImagePair& pair : pairs) {
    for (const std::string_view name : kResultNames) {
      const fs::path result = out / pair.folder / name;
      if (!IsInputFile(result)) continue;
      throw ConfigError(fmt::format("--out {}: {} is an input of this run; allowed: another folder",
                                    out.string(), result.string()));
    }
  }
}

}  // namespace

int RunFiles(const FilesOptions& options, SproutConfig config, const std::stop_token& stop) {
  RequireAllApplied(config.depth());
  config.mutable_refine()->set_check_inputs_every(0);  // each pair is checked here
  if (options.min_confidence_percent) {
    config.mutable_grow()->set_min_confidence(
        static_cast<int>(std::ceil(2.55 * *options.min_confidence_percent)));
  }
  FilesRun run(options, config);
  const size_t pairs = run.found().pairs.size();
  RequireInputsStay(run.found().pairs, options.out);
  const bool is_new = CreateFolder(options.out);
  run.Run(stop);
  if (run.done() < pairs) {
    std::cerr << fmt::format("sprout-pipeline: stopped after {} of {} pairs\n", run.done(), pairs);
  } else if (run.left_out() > 0 && pairs > 1) {
    std::cerr << fmt::format("sprout-pipeline: {} of {} pairs left out\n", run.left_out(), pairs);
  }
  if (run.wrong() > 0 && pairs > 1) {
    std::cerr << fmt::format("sprout-pipeline: something is wrong with {} of {} pairs\n",
                             run.wrong(), pairs);
  }
  if (is_new && run.left_out() == pairs) {
    rmdir(options.out.c_str());  // if it is empty
    return 1;
  }
  if (config.temporal().in_pipeline()) {
    const auto written = WriteMotions(fs::path(options.out) / "motion.csv", run.motions());
    if (!written) {
      std::cerr << "sprout-pipeline: " << written.error().text << "\n";
      return 1;
    }
  }
  const bool all_done = run.left_out() == 0 && run.found().left_out == 0 && run.done() == pairs;
  return all_done && run.wrong() == 0 ? 0 : 1;
}

}  // namespace sprout
