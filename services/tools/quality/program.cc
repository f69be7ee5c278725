#include "services/tools/quality/program.h"

#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/app/version.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_error.h"
#include "common/core/number_text.h"
#include "common/logfile/log_error.h"
#include "common/picture/write_image.h"
#include "services/tools/quality/report.h"
#include "services/tools/quality/sources.h"
#include "services/tools/quality/verdict.h"

namespace sprout::quality {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] =
    "How good depth is on a flat target: point the rig at a wall or a board that stands still.\n"
    "Measures a running graph (without INPUT), a log, or a folder of disparity maps.";

constexpr char kFooter[] = R"(
Examples
  sprout-quality                                            the running graph, until Ctrl-C
  sprout-quality run.lcm --distance-m 1.204 --report q.html a recording, with a page to look at
  sprout-quality --once --limits limits.textproto           a production line: exit code 0 or 1
  sprout-quality maps --calib calib.txt                     PFM files, in px

limits.textproto: limit { figure: "fill_rate_percent" at_least: 98 }
                  limit { figure: "plane_rms_percent" at_most: 0.5 }

Exit codes: 0; 1 a limit is not kept, or nothing could be measured; 2 a flag, a file or a region
that cannot be used.
)";

struct Options {
  fs::path input;
  std::string region;
  std::string edge;
  TargetSettings settings;
  double distance_m = 0;
  std::string frames;
  fs::path calibration;
  fs::path limits;
  fs::path json;
  fs::path report;
  fs::path images;
  LiveOptions live{.lcm_url = kDefaultLcmUrl, .prefix = {}};
};

void AddMeasureFlags(Flags& flags, Options& options) {
  flags
      .Add("INPUT", options.input,
           "Log of a graph (SPROUT_DISPARITY, SPROUT_RIG), or folder of disparity maps "
           "(*disparity.pfm, else *.pfm; px); without it: the running graph")
      .ExistingPath();
  flags.Add("--region LEFT,TOP,WIDTH,HEIGHT", options.region,
            "Part of the left image that shows the target alone, px (default: its middle "
            "half each way)");
  flags.Add("--edge LEFT,TOP,WIDTH,HEIGHT", options.edge,
            "Part of the left image that one depth edge crosses, such as the border of a "
            "board before a wall, px: how wide the edge is");
  flags
      .Add("--distance-m", options.distance_m,
           "True distance of the target from the left camera, square to the target, m")
      .Within(0.001, 10000);
  flags
      .Add("--count", options.settings.count,
           "Maps that are measured: the first ones, of a running graph the newest")
      .WithinWhole(1, 1000)
      .ShowDefault();
  flags.Add("--frames A:B", options.frames, "Of a log: frames by number, both included");
  flags.Add("--calib FILE", options.calibration,
            "Of a folder: calibration in Middlebury's format: cam0, cam1 (px), baseline (mm) "
            "(default: its calib.txt)");
}

void AddOutputFlags(Flags& flags, Options& options) {
  flags.Add("--limits FILE", options.limits,
            "What figures have to keep; exit code 1 when one does not");
  flags.Add("--json FILE", options.json, "Write the figures as JSON");
  flags.Add("--report FILE", options.report, "Write an HTML page: figures, plane, residuals");
  flags.Add("--images DIR", options.images,
            "Write region.png, residuals.png and noise.png; of a running graph once a second");
  flags.Add("--once", options.live.once,
            "Of a running graph: ends when --count maps are measured, or when none came for 30 "
            "s");
  flags
      .Add("--lcm-url URL", options.live.lcm_url,
           "Where the messages travel: udpm://GROUP:PORT?ttl=0 or tcpq://HOST:PORT")
      .Environment("LCM_DEFAULT_URL")
      .ShowDefault();
  flags.Add("--channel-prefix TEXT", options.live.prefix, "Before the channels of the graph");
}

cv::Rect RectOf(const std::string& flag, const std::string& text) {
  std::vector<int> numbers;
  size_t begin = 0;
  while (begin <= text.size()) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const auto number =
        ParseNumber<int>(Trimmed(std::string_view(text).substr(begin, end - begin)));
    if (!number) break;
    numbers.push_back(*number);
    begin = end + 1;
  }
  if (begin <= text.size() || numbers.size() != 4) {
    throw ConfigError(flag + " " + text + ": allowed is LEFT,TOP,WIDTH,HEIGHT in whole px");
  }
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

// What is asked for, and everything that can be wrong with the flags.
class Run {
 public:
  explicit Run(const Options& options) : options_(options), measurement_(SettingsOf(options)) {
    if (!options.limits.empty()) limits_ = LoadLimits(options.limits);
    NoteFolder();
    if (!options.json.empty()) RequireWritableFile("--json", options.json);
    if (!options.report.empty()) RequireWritableFile("--report", options.report);
    if (!options.images.empty()) {
      RequireWritableFolder("--images", options.images,
                            {"region.png", "residuals.png", "noise.png"});
    }
    if (!IsChannelPrefix(options.live.prefix)) {
      throw ConfigError("--channel-prefix " + options.live.prefix +
                        ": allowed: " + AllowedChannelPrefix());
    }
  }

  int Measure() {
    const std::string complaint = Read();
    if (!complaint.empty()) std::cerr << "sprout-quality: " << complaint << "\n";
    const std::string left_out = measurement_.LeftOutText();
    if (!left_out.empty()) std::cerr << "sprout-quality: " << left_out << "\n";
    const TargetQuality quality = measurement_.meter().Quality();
    if (!options_.images.empty()) WriteImages(quality);
    const std::string input = InputText();
    if (!options_.json.empty()) WriteWhole(options_.json, JsonText(measurement_, limits_, input));
    if (!options_.report.empty()) {
      WriteWhole(options_.report, ReportHtml(measurement_, limits_, input));
    }
    std::cout << TableText(measurement_, limits_) << MissingText(quality, measurement_.settings());
    return quality.distance_m && IsGood(quality, limits_) ? 0 : 1;
  }

 private:
  static TargetSettings SettingsOf(const Options& options) {
    TargetSettings settings = options.settings;
    if (!options.region.empty()) settings.region = RectOf("--region", options.region);
    if (!options.edge.empty()) settings.edge = RectOf("--edge", options.edge);
    if (options.distance_m > 0) settings.distance_m = options.distance_m;
    return settings;
  }

  // What is measured, so that no flag asks to replace it.
  void NoteFolder() const {
    if (!fs::is_directory(options_.input)) return;
    NoteFolderFiles(options_.input, options_.calibration);
  }

  std::string Read() {
    if (options_.input.empty()) {
      MeasureGraph(options_.live, measurement_, [this] { Refresh(); });
      return "";
    }
    if (fs::is_directory(options_.input)) {
      MeasureFolder(options_.input, options_.calibration, measurement_);
      return "";
    }
    return MeasureLog(options_.input, options_.live.prefix, options_.frames, measurement_);
  }

  std::string InputText() const {
    return options_.input.empty() ? "the running graph" : options_.input.string();
  }

  void Refresh() {
    if (!options_.images.empty()) WriteImages(measurement_.meter().Quality());
    if (isatty(STDOUT_FILENO) == 0) return;
    constexpr std::string_view kHome = "\x1b[H\x1b[J";  // cursor to the corner, rest empty
    std::cout << kHome << TableText(measurement_, limits_) << std::flush;
  }

  void WriteImages(const TargetQuality& quality) const {
    const TargetMaps maps = measurement_.meter().Maps();
    const auto write = [&](const char* name, const cv::Mat3b& picture) {
      if (const Result<void> written = WritePng(options_.images / name, picture); !written) {
        throw std::runtime_error(written.error().text);
      }
    };
    write("region.png", RegionPicture(measurement_));
    write("residuals.png", ResidualPicture(maps, quality));
    write("noise.png", NoisePicture(maps, quality));
  }

  const Options& options_;
  Measurement measurement_;
  std::vector<Limit> limits_;
};

int RunChosen(const Options& options) {
  try {
    return Run(options).Measure();
  } catch (const LogError& e) {
    throw ConfigError(e.what());  // exit code 2
  }
}

}  // namespace

int QualityMain(int argc, const char* const* argv) {
  Flags flags("sprout-quality", kDescription);
  Options options;
  AddMeasureFlags(flags, options);
  AddOutputFlags(flags, options);
  flags.AddVersion(Version());
  flags.SetFooter(kFooter);
  return RunProgram(flags, argc, argv, [&] { return RunChosen(options); });
}

}  // namespace sprout::quality
