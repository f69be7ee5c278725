#include "services/pipeline/files/flags.h"

#include <optional>

#include "services/pipeline/files/write_results.h"

namespace sprout {
namespace {

constexpr char kDescription[] =
    "Depth of image files, without any bus: a pair, or folders or patterns of many";

constexpr char kFooter[] = R"(
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

}  // namespace

Flags& AddFilesCommand(Flags& flags, FilesOptions& options) {
  Flags& files = flags.AddCommand("files", kDescription);
  files.InheritExcept({"--lcm-url", "--channel-prefix", "--replay", "--record", "--frames"});
  files.SetFooter(kFooter);
  files.Add("LEFT", options.left, "Left image, folder, 'pattern' or video").Required();
  files.Add("RIGHT", options.right, "Right image, folder, 'pattern' or video").Required();
  files.Add("--tof TOF", options.tof, "ToF image, folder or 'pattern'");
  files.Add(
      "--tof-unit UNIT", options.pixels.tof_unit,
      "Unit of the ToF image: mm, cm, m, or metres a count, such as 1/256 or 1/5000 (default: "
      "integers mm, floating point m)");
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
           "ToF "
           "image shows what the left one shows")
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

}  // namespace sprout
