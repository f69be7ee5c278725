#include <algorithm>
#include <array>
#include <cassert>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/app/live.h"
#include "common/app/replay.h"
#include "common/app/service.h"
#include "common/app/stage_monitor.h"
#include "common/core/digest.h"
#include "common/core/tof_coverage.h"
#include "services/pipeline/chain.h"
#include "services/pipeline/files/files.h"
#include "services/pipeline/files/write_results.h"
#include "services/pipeline/pipeline_adapter.h"

namespace sprout {
namespace {

constexpr std::array<std::string_view, 4> kStages = {"refine", "prior", "grow", "temporal"};

// Counts and times refine, prior, grow and temporal inside a chain under these names, as if they
// were processes: for capture's --wait-for, sprout-top and the like. A frame that fails, or is
// lost before the chain, is counted only by the process that runs the chain.
class StepMonitors : public ChainObserver {
 public:
  // @param temporal  whether the chain has that step.
  StepMonitors(const std::string& config_digest, bool temporal)
      : monitors_{StageMonitor("refine", config_digest), StageMonitor("prior", config_digest),
                  StageMonitor("grow", config_digest), StageMonitor("temporal", config_digest)},
        count_(temporal ? 4 : 3) {}

  std::span<StageMonitor> all() { return std::span(monitors_).first(count_); }

  void Begins(ChainStep step) override {
    // Filling gaps is a part of growth.
    if (step != ChainStep::kFinish) begun_ = StageMonitor::Clock::now();
  }

  void Answered(std::string_view stage, const Frame& frame, const StageResult& outcome) override {
    const auto it = std::ranges::find(kStages, stage);
    assert(it != kStages.end());
    StageMonitor& monitor = monitors_[static_cast<size_t>(it - kStages.begin())];
    monitor.FrameIn(/*skipped=*/false);
    monitor.SetRig(frame.id.rig_id);
    monitor.SetTofOffset(outcome.tof_offset);
    monitor.SetFinding(outcome.finding);
    monitor.FrameOut(frame.id, begun_, outcome.degenerate,
                     stage == "temporal" ? kUnknownCoverage
                                         : TofCoverage(frame.seeds->seeds, frame.left.size()));
  }

 private:
  std::array<StageMonitor, 4> monitors_;
  size_t count_;
  StageMonitor::Clock::time_point begun_{};
};

constexpr char kFilesDescription[] =
    "Depth of image files, without any bus: a pair, or folders or patterns of many";

constexpr char kFilesFooter[] = R"(
Examples
  sprout-pipeline files left.png right.png --focal-px 1733 --baseline-m 0.11 --out out
  sprout-pipeline files l.png r.png --tof tof.png --focal-px 1733 --baseline-m 0.11 --out out
  sprout-pipeline files raw/left raw/right --tof raw/tof --rig rig.textproto --out out --config fast
  sprout-pipeline files '*/im0.png' '*/im1.png' --calib art/calib.txt --out out
  sprout-pipeline files l.png r.png --calib calib.txt --out out --only depth,cloud

Files of folders and patterns belong together by the times in their names (digits since 1970, as
EuRoC and TUM have them), otherwise by equal names or numbers. What has no partner is named and left
out. Where names say nothing, and there are as many, their order counts (2 before 10). Pictures of two
videos (.mp4, .avi, .mkv and others) belong together by their times.

With --rig the images are as the cameras gave them, and are rectified. With --calib, or --focal-px and
--baseline-m, they are rectified already, and the ToF image shows what the left one shows, at any
resolution, or has the lens and pose of --tof-rig. --tof is a PNG of 16 bits in mm, or a PFM or TIFF in m (other units: --tof-unit). No return: 0, 65535,
negative, NaN, infinite. Without it stereo does the work.

Writes to DIR, and of many pairs to DIR/NAME, where NAME is the left image's
  disparity.pfm    px, +inf: none              disparity.png   16 bit, 32 counts a px, 0: none
  depth.pfm        m, NaN: none                depth.png       16 bit, mm, 0: none
  confidence.png   255 * P(error <= 1 px)      overview.png    to look at
  depth_sigma.pfm  m, standard deviation of the depth; NaN: no depth, +inf: not known
  cloud.ply        m, coloured points          mesh.ply        the same as a surface
  left.png         the image that all belong to, rectified
  camera.json      its focal length and principal point, and the baseline
  calib.txt        the same in Middlebury's format, for --calib and sprout-quality

--config 'depth { max_m: 4 min_confidence: 204 }' leaves pixels out of depth, cloud, mesh and overview,
but not out of disparity and confidence; so do min_m, region and remove_flying.

With --config default --config 'temporal { in_pipeline: true }' the pairs are frames of a video in
their order, and each folder gets fused.pfm, fused.png and fused_confidence.png, too: maps fused with
those of earlier pairs. DIR/motion.csv says how the left camera moved. 'depth { input: FUSED }': depth,
cloud and mesh of the fused map.

The flags of `sprout-pipeline --help` hold here, too: --config, --threads, --log-level.
Exit codes: 0; 1 a pair could not be computed, the others were, or something is wrong with a pair
(another scene, swapped, not rectified, ranges of another unit ...): it was computed all the same,
and a line says what and the cure; 2 a flag or file that cannot be used, nothing was done.
)";

// Adds the command `files`. The options must outlive the flags.
Flags& AddFilesCommand(Flags& flags, FilesOptions& options) {
  Flags& files = flags.AddCommand("files", kFilesDescription);
  files.InheritExcept({"--lcm-url", "--channel-prefix", "--replay", "--record", "--frames"});
  files.SetFooter(kFilesFooter);
  files.Add("LEFT", options.left, "Left image, folder, 'pattern' or video").Required();
  files.Add("RIGHT", options.right, "Right image, folder, 'pattern' or video").Required();
  const Flag tof = files.Add("--tof TOF", options.tof, "ToF image, folder or 'pattern'");
  files
      .Add("--tof-unit UNIT", options.pixels.tof_unit,
           "Unit of the ToF image: mm, cm, m, or metres a count, such as 1/256 or 1/5000 "
           "(default: integers mm, floating point m)")
      .Needs(tof);
  files
      .Add("--bits N", options.pixels.bits,
           "Bits that pixels of 16 bits use: 8 to 16; 0: as the format or the first pair says")
      .WithinWhole(0, kMaxBits);
  files
      .Add("--max-spread-ms MS", options.max_spread_ms,
           "Files named after their times belong together when these differ by at most so much")
      .Within(0, 1e6);
  files.Add("--out DIR", options.out, "Folder to write to").Required();
  files.Add("--only NAME,NAME,...", options.only, "Write only these (default: all)")
      .SplitAtCommas()
      .OneOf({kOutputs.begin(), kOutputs.end()});
  files
      .Add("--min-confidence P", options.min_confidence_percent,
           "Leave out disparities that are less than P % sure to be within 1 px")
      .Within(0, 100);
  const Flag rig =
      files.Add("--rig FILE", options.rig.rig_file, "Calibration, as sprout-calibrate writes it");
  Flag calib =
      files.Add("--calib FILE", options.rig.calib_file,
                "Calibration of a rectified pair: a calib.txt of Middlebury, ETH3D or KITTI");
  calib.Excludes(rig);
  files
      .Add("--tof-rig FILE", options.rig.tof_rig_file,
           "Rig file with the lens and pose of the ToF camera of a rectified pair; without it the "
           "ToF image shows what the left one shows")
      .Needs(tof)
      .Excludes(rig);
  const auto add = [&](const char* name, std::optional<double>& value, const char* text, double low,
                       double high) {
    return files.Add(name, value, text).Within(low, high).Excludes(rig);
  };
  Flag focal =
      add("--focal-px", options.rig.focal_px, "Focal length of a rectified pair, px", 1e-3, 1e6);
  Flag baseline =
      add("--baseline-m", options.rig.baseline_m, "Distance of its cameras, m", 1e-6, 1e6);
  focal.Needs(baseline);
  baseline.Needs(focal);
  focal.Excludes(calib);
  Flag cx = add("--cx", options.rig.cx,
                "Column of the left principal point, px (default: the middle)", -1e6, 1e6);
  cx.Needs(focal);
  add("--cx-right", options.rig.cx_right,
      "Of the right one, px (default: as --cx); Middlebury's doffs is their difference", -1e6, 1e6)
      .Needs(focal);
  add("--cy", options.rig.cy, "Row of both principal points, px (default: the middle)", -1e6, 1e6)
      .Needs(focal);
  return files;
}

constexpr char kDescription[] =
    "refine, prior and grow in one process, where cores are few: the same messages and bytes, but\n"
    "images are received and decoded once. Joins SPROUT_LEFT, SPROUT_RIGHT, SPROUT_TOF and\n"
    "SPROUT_RIG; publishes SPROUT_SEEDS, SPROUT_LEFT_SEEDS, SPROUT_PRIOR, SPROUT_DISPARITY and "
    "what\n"
    "else the configuration asks for, and the statuses of all three; with temporal { in_pipeline:\n"
    "true } also what sprout-temporal does. `sprout-pipeline files --help`: depth of image files,\n"
    "without any bus.";

int Main(int argc, char** argv) {
  Service service("pipeline", kDescription);
  service.OfferReplay();
  FilesOptions files;
  const Flags& files_command = AddFilesCommand(service.flags(), files);
  return service.Run(argc, argv, [&](const ServiceContext& context) {
    if (files_command.IsGiven()) return RunFiles(files, context.config, context.stop);
    StepMonitors steps(Digest(ConfigText(context.config)), context.config.temporal().in_pipeline());
    PipelineAdapter adapter(context.config, steps);
    if (context.replay) {
      for (StageMonitor& step : steps.all()) step.SetReplay();
      return RunReplay(context, *context.replay, adapter);
    }
    RunLive(context, adapter, steps.all());
    return 0;
  });
}

}  // namespace
}  // namespace sprout

int main(int argc, char** argv) { return sprout::Main(argc, argv); }
