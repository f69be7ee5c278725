#include <iostream>
#include <optional>

#include "common/app/service.h"
#include "common/config/config_error.h"
#include "services/capture/capture_loop.h"
#include "services/capture/genicam/genicam_source.h"

namespace sprout::capture {
namespace {

// Flags that stand for configuration values; unset ones leave the configuration alone.
struct ConfigFlags {
  std::optional<std::string> source;
  std::optional<double> rate_hz;
  std::optional<int> gt_scale;

  void Apply(SproutConfig& config) const {
    if (source) config.mutable_capture()->set_source(*source);
    if (rate_hz) config.mutable_capture()->set_rate_hz(*rate_hz);
    if (gt_scale) SetGtScale(*config.mutable_capture());
  }

 private:
  void SetGtScale(CaptureConfig& capture) const {
    if (!capture.source().starts_with("middlebury:")) {
      throw ConfigError("--gt-scale: of no use for capture.source = " + capture.source() +
                        "; allowed: with middlebury:DIR");
    }
    capture.set_gt_scale(*gt_scale);
  }
};

void AddFlags(Flags& flags, ConfigFlags& config, CaptureOptions& options) {
  flags.Add(
      "--source SOURCE", config.source,
      "middlebury:DIR (a scene folder) or synthetic:WxH (a moving scene), with ?tof=grid or "
      "?tof=sr4000 for the simulated ToF camera, ?tof=zones:8x8 for a multi-zone sensor; log:FILE, "
      "a recorded log, with ?prefix=TEXT if its channels have one, ?rig=RIG to rectify raw images; "
      "cameras: genicam:RIG (GigE Vision, USB3 Vision), opencv:LEFT,RIGHT?rig=RIG (videos, image "
      "lists, devices), opencv:BOTH?rig=RIG and v4l2:DEVICE?rig=RIG (both views side by side); ROS "
      "2: ros2:left=TOPIC&right=TOPIC, live, and mcap:FILE?left=TOPIC&right=TOPIC, with &points= "
      "or &depth= of a range sensor");
  flags.Add("--rate HZ", config.rate_hz,
            "Frames a second; 0 = as fast as possible. Without it a log keeps its recorded "
            "pace, or with --lockstep that of the answers");
  flags.Add("--gt-scale", config.gt_scale,
            "Disparity units of one pixel in a 2005/2006 ground truth; 0 = from the height");
  flags.Add("--frames N", options.frames, "Stop after N frames").WithinWhole(int64_t{1}, INT64_MAX);
  flags.Add("--loop", options.loop, "Start again when the source ends");
  flags.AddAction(
      "--list", [] { std::cout << ListCameras(); },
      "List the GigE Vision and USB3 Vision cameras that answer, and end");
  flags.Add("--raw", options.raw,
            "Send the cameras' unrectified images, on RAW_SPROUT_LEFT and so on, for "
            "calibration or to rectify them later (log:FILE?rig=RIG)");
  flags
      .Add("--lockstep N", options.lockstep,
           "Have at most N frames without a SPROUT_DISPARITY answer; a frame not answered "
           "in time is sent again")
      .WithinWhole(1, 1000);
  flags.Add("--lockstep-timeout", options.lockstep_timeout_s, "How long to wait for that answer, s")
      .Within(0.1, 3600.0)
      .ShowDefault();
  flags
      .Add("--wait-for STAGES", options.wait_for,
           "Send nothing before these stages report, e.g. refine,prior,grow")
      .SplitAtCommas();
  flags.Add("--wait-timeout", options.wait_timeout_s, "How long to wait for those stages, s")
      .Within(0.1, 3600.0)
      .ShowDefault();
}

int Main(int argc, char** argv) {
  Service service("capture",
                  "Takes frames from a source and sends them to the graph: publishes SPROUT_LEFT,\n"
                  "SPROUT_RIGHT, SPROUT_TOF and SPROUT_RIG.");
  ConfigFlags config_flags;
  CaptureOptions options;
  AddFlags(service.flags(), config_flags, options);
  return service.Run(
      argc, argv,
      [&](const ServiceContext& context) {
        options.rate_is_asked_for = config_flags.rate_hz.has_value();
        return RunCapture(context, options);
      },
      [&](SproutConfig& config) { config_flags.Apply(config); });
}

}  // namespace
}  // namespace sprout::capture

int main(int argc, char** argv) { return sprout::capture::Main(argc, argv); }
