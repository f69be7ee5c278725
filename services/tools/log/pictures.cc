// sprout-log images: the frames of a log as pictures.
#include <fmt/core.h>

#include <array>
#include <cstdint>
#include <iostream>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/config/required.h"
#include "common/core/frame.h"
#include "common/measure/score.h"
#include "common/picture/frame_pictures.h"
#include "common/scenes/dataset.h"
#include "common/scenes/same_picture.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/log_frames.h"

namespace sprout::log {
namespace {

struct ImagesOptions : PicturesOptions {
  std::string truth;
};

// Ground truth for the frames of a log that capture sent from a scene, and the accuracy of their
// maps.
class LogTruth {
 public:
  // @param source  capture's, such as "middlebury:DIR"; empty: no truth.
  // @throws ConfigError when it cannot be opened.
  explicit LogTruth(const std::string& source);
  ~LogTruth();

  // Records the frame's seeds and scores its maps.
  // @returns the truth of frame `seq`: if capture repeated the scene, of its frame `seq` modulo
  //          the number of frames. Empty without a source.
  // @throws ConfigError when a map of the frame has another size, or its left image is another
  //         picture.
  const FrameTruth& Add(const Frame& frame);

  // Text for people: the newest frame's seeds by refinement rule, and a table of each map's
  // density and, with a source, share of correct pixels (≤ 1 px, of those that both cameras see),
  // as means over the frames. Empty without seeds and maps.
  std::string Text() const;

 private:
  struct MapSum {
    int64_t frames = 0;
    double density_percent = 0;
    double correct_percent = 0;
  };

  void AddMap(MapSum& sum, const DisparityImage& map);
  void Load(int64_t seq);

  std::string source_;
  std::unique_ptr<scenes::Dataset> dataset_;
  std::optional<int64_t> loaded_;  // the frame of the dataset in truth_
  FrameTruth truth_;
  cv::Mat left_;                // left image of that frame
  std::array<MapSum, 3> maps_;  // in the order of kMapNames
  std::optional<SeedSet> newest_seeds_;
  int64_t newest_seq_ = 0;
};

constexpr std::array kMapNames = {"prior", "as grown", "filled"};

FrameTruth TruthOf(const scenes::GroundTruth& truth, const std::string& source) {
  if (truth.left.empty()) throw ConfigError("--truth " + source + ": has no ground truth");
  if (!truth.nonoccluded.empty()) return {truth.left, truth.nonoccluded};
  return {truth.left,
          Required(NonOccludedMask(truth.left, truth.right), "--truth " + source + ": ")};
}

LogTruth::LogTruth(const std::string& source) : source_(source) {
  if (!source.empty()) dataset_ = scenes::OpenDataset(source);
}

LogTruth::~LogTruth() = default;

void LogTruth::Load(int64_t seq) {
  if (dataset_ == nullptr) return;
  const std::optional<int64_t> count = dataset_->frame_count();
  const int64_t index = count ? seq % *count : seq;
  if (loaded_ == index) return;
  const scenes::DatasetFrame captured = dataset_->Get(index);
  truth_ = TruthOf(captured.truth, source_);
  left_ = captured.left;
  loaded_ = index;
}

void LogTruth::AddMap(MapSum& sum, const DisparityImage& map) {
  ++sum.frames;
  sum.density_percent +=
      100.0 * static_cast<double>(map.CountValid()) / static_cast<double>(map.counts().total());
  if (dataset_ == nullptr) return;
  const Accuracy accuracy =
      Required(Score(map, truth_.disparity_px, truth_.non_occluded), "--truth " + source_ + ": ");
  sum.correct_percent += accuracy.correct_le1_percent();
}

const FrameTruth& LogTruth::Add(const Frame& frame) {
  Load(frame.id.seq);
  if (frame.seeds) {
    newest_seeds_ = frame.seeds;
    newest_seq_ = frame.id.seq;
  }
  if (frame.prior) AddMap(maps_[0], frame.prior->disparity);
  if (frame.unfilled) AddMap(maps_[1], *frame.unfilled);
  if (frame.disparity) AddMap(maps_[2], *frame.disparity);
  if (dataset_ != nullptr && !frame.left.empty() && !scenes::IsSamePicture(frame.left, left_)) {
    throw ConfigError(fmt::format(
        "--truth {}: frame {} of the log is another picture; allowed: the source that the log was "
        "captured from",
        source_, frame.id.seq));
  }
  return truth_;
}

std::string LogTruth::Text() const {
  std::string text;
  if (newest_seeds_) {
    const SeedSet& seeds = *newest_seeds_;
    const int32_t kept = CountTofSeeds(seeds.seeds);
    text += fmt::format(
        "seeds of frame {}: {} ToF points, dropped {} outside, {} dark, {} loose, {} background, "
        "{} hidden, {} contradicted; {} kept, {} from stereo\n",
        newest_seq_, seeds.raw, seeds.outside, seeds.dark, seeds.loose, seeds.background,
        seeds.hidden, seeds.contradicted, kept, std::ssize(seeds.seeds) - kept);
  }
  if (maps_[0].frames + maps_[1].frames + maps_[2].frames == 0) return text;
  const bool scored = dataset_ != nullptr;
  text += fmt::format("{:<10}{:>8}{:>12}{}\n", "map", "frames", "density %",
                      scored ? "     correct <= 1 px %" : "");
  for (size_t i = 0; i < maps_.size(); ++i) {
    const MapSum& sum = maps_[i];
    if (sum.frames == 0) continue;
    const auto frames = static_cast<double>(sum.frames);
    text +=
        fmt::format("{:<10}{:>8}{:>12.2f}", kMapNames[i], sum.frames, sum.density_percent / frames);
    text += scored ? fmt::format("{:>22.2f}\n", sum.correct_percent / frames) : "\n";
  }
  if (!scored) return text;
  return text + "(correct: of the pixels that both cameras see; no disparity counts as wrong)\n";
}

int RunImages(const ImagesOptions& options) {
  LogTruth truth(options.truth);
  FrameFileNames names(options.folder);
  const std::string complaint = ReadFrames(options, AllParts(), [&](const Frame& frame) {
    WriteFramePictures(frame, truth.Add(frame), names.For(frame.id));
  });
  FinishFiles(complaint, names, options, "no message of these frames that can be shown");
  std::cout << truth.Text();
  return 0;
}

}  // namespace

void AddImages(Flags& program) {
  const auto options = std::make_shared<ImagesOptions>();
  Flags& flags = program.AddCommand(
      "images",
      "Writes left and right image, ToF depth, seeds, prior, disparity, the cloud from the side "
      "and\n"
      "an overview of each frame as PNG, as far as the log has them; colours of a frame share one\n"
      "scale. Prints how many seeds and pixels there are",
      [options] { return RunImages(*options); });
  flags.Add("FILE", options->file, "Log").Required();
  flags.Add("DIR", options->folder, "Folder to write to: 000042_left.png, ...").Required();
  flags.Add("--truth SOURCE", options->truth,
            "The source that capture sent, for its ground truth: a picture of the errors, and "
            "the share of correct pixels");
  AddFrames(flags, options->frames);
  AddPrefix(flags, options->prefix);
}

}  // namespace sprout::log
