#include "services/pipeline/files/files.h"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "common/app/progress.h"
#include "common/core/image.h"
#include "common/core/input_files.h"
#include "common/core/output_file.h"
#include "common/core/printable.h"
#include "services/inputs/check_inputs.h"
#include "services/pipeline/files/write_results.h"
#include "services/pipeline/pipeline.h"

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

// What was found, in one line.
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
  for (const std::string& warning : depth.warnings) line += "; " + warning;
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

struct PairOutcome {
  std::string line;       // to print
  std::string complaint;  // what is wrong with the pair; empty: nothing that can be told
};

// Computes one pair and writes it.
// @param motions  gets a row of a pipeline with memory.
Result<PairOutcome> ComputePair(PairReader& reader, const ImagePair& pair, const fs::path& folder,
                                DepthConfig::Input input, Pipeline& pipeline,
                                std::string& motions) {
  using Clock = std::chrono::steady_clock;
  try {
    const Result<Frame> frame = reader.Read(pair);
    if (!frame) return tl::unexpected(frame.error());
    const auto begun = Clock::now();
    const Result<DepthFrame> depth =
        pipeline.Compute(frame->left, frame->right, *frame->tof, *frame->rig);
    if (!depth) return tl::unexpected(depth.error());
    const std::chrono::duration<double, std::milli> time = Clock::now() - begun;
    if (const Result<void> written = WriteResults(*frame, *depth, input, folder); !written) {
      return tl::unexpected(written.error());
    }
    if (depth->motion) motions += MotionRow(pair.left, *depth->motion);
    return PairOutcome{.line = LineOf(folder, *depth, time.count()),
                       .complaint = BadText(inputs::CheckInputs(frame->left, frame->right,
                                                                *frame->tof, *frame->rig))};
  } catch (const std::exception& e) {
    return Fail(e.what());
  }
}

void CreateFolder(const std::string& out) {
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw ConfigError("--out " + out + ": cannot be written (" + error.message() + ")");
}

// Nothing that is read may be replaced, be it the next pair's.
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
  config.mutable_refine()->set_check_inputs_every(0);  // each pair is checked here
  if (options.min_confidence_percent) {
    config.mutable_grow()->set_min_confidence(
        static_cast<int>(std::ceil(2.55 * *options.min_confidence_percent)));
  }
  PairReader reader(options.rig, options.pixels);
  const ImagePairs found =
      ListPairs(options.left, options.right, options.tof, options.max_spread_ms);
  const std::vector<ImagePair>& pairs = found.pairs;
  RequireInputsStay(pairs, options.out);
  Pipeline pipeline(config);
  CreateFolder(options.out);
  for (const std::string& note : found.notes) {
    std::cerr << "sprout-pipeline: " << Printable(note) << "\n";
  }
  Progress progress(/*quiet=*/false);
  size_t done = 0;
  size_t left_out = 0;
  size_t wrong = 0;
  std::string motions;
  for (const ImagePair& pair : pairs) {
    if (stop.stop_requested()) break;
    if (pairs.size() > 1) {
      progress.Show(fmt::format("pair {} of {}: {}", done + 1, pairs.size(), pair.left.string()));
    }
    const fs::path out = options.out;
    const auto line = ComputePair(reader, pair, pair.folder.empty() ? out : out / pair.folder,
                                  config.depth().input(), pipeline, motions);
    progress.Clear();
    if (const std::string note = reader.TakeNote(); !note.empty()) {
      std::cerr << "sprout-pipeline: " << Printable(pair.left.string() + ": " + note) << "\n";
    }
    if (line) {
      std::cout << Printable(line->line) << std::endl;
      if (!line->complaint.empty()) {
        ++wrong;
        std::cerr << "sprout-pipeline: " << Printable(pair.left.string() + ": " + line->complaint)
                  << "\n";
      }
    } else {
      ++left_out;
      std::cerr << "sprout-pipeline: " << Printable(pair.left.string() + ": " + line.error().text)
                << "\n";
    }
    ++done;
  }
  if (done < pairs.size()) {
    std::cerr << fmt::format("sprout-pipeline: stopped after {} of {} pairs\n", done, pairs.size());
  } else if (left_out > 0 && pairs.size() > 1) {
    std::cerr << fmt::format("sprout-pipeline: {} of {} pairs left out\n", left_out, pairs.size());
  }
  if (wrong > 0 && pairs.size() > 1) {
    std::cerr << fmt::format("sprout-pipeline: something is wrong with {} of {} pairs\n", wrong,
                             pairs.size());
  }
  if (config.temporal().in_pipeline()) {
    const auto written = WriteMotions(fs::path(options.out) / "motion.csv", motions);
    if (!written) {
      std::cerr << "sprout-pipeline: " << written.error().text << "\n";
      return 1;
    }
  }
  return left_out == 0 && wrong == 0 && found.left_out == 0 && done == pairs.size() ? 0 : 1;
}

}  // namespace sprout
