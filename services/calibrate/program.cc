#include "services/calibrate/program.h"

#include <fmt/core.h>
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/app/progress.h"
#include "common/app/version.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/config/config.h"
#include "common/core/number_text.h"
#include "common/logfile/log_error.h"
#include "common/rig/rig_file.h"
#include "services/calibrate/board.h"
#include "services/calibrate/board_page.h"
#include "services/calibrate/calibrator.h"
#include "services/calibrate/check.h"
#include "services/calibrate/frame_log.h"
#include "services/calibrate/image_folder.h"
#include "services/calibrate/refine.h"
#include "services/calibrate/report.h"
#include "services/calibrate/result_file.h"
#include "services/calibrate/view_collector.h"
#include "services/calibrate/watch.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] =
    "Calibrates a rig: lenses and poses of both cameras and the ToF camera, and the bias of the "
    "ranges.";

constexpr char kFooter[] = R"(
Examples
  sprout-calibrate board --out board.pdf                   print it at 100 %, glue it to a flat board
  sprout-capture --source ... --raw   and   sprout-calibrate watch --out views   while you show it
  sprout-calibrate estimate views --rig rig.textproto --out rig.textproto --report report.html
  sprout-calibrate check run.lcm                           weeks later: does it still hold
  sprout-calibrate refine run.lcm --rig rig.textproto --out new.textproto    if not: without a board

`sprout-calibrate COMMAND --help` explains a command. Exit codes: 0; 1 the calibration is not good
(any more), or there is none; 2 a flag or a file that cannot be used.
)";

struct BoardOptions {
  std::string squares = "9x6";
  double square_mm = 60;
};

struct Options {
  BoardOptions board;
  fs::path out;
  std::vector<fs::path> inputs;
  fs::path rig;
  fs::path report;
  std::string prefix;
  CheckOptions check;
  RefineOptions refine;
  WatchOptions watch{.out = {}, .prefix = {}, .lcm_url = kDefaultLcmUrl};
  std::function<int()> chosen;
};

void AddBoardFlags(CLI::App& flags, BoardOptions& board) {
  flags.add_option("--squares", board.squares, "Columns and rows of the board")
      ->type_name("CxR")
      ->capture_default_str();
  flags.add_option("--square-mm", board.square_mm, "Side of a square as measured on the print, mm")
      ->check(NumberIn(1, 10000))
      ->capture_default_str();
}

Board BoardOf(const BoardOptions& options) {
  BoardSize size{.square_m = options.square_mm / 1000};
  const std::string_view text = options.squares;
  const size_t cross = std::min(text.find('x'), text.size());
  const auto columns = ParseNumber<int>(text.substr(0, cross));
  const auto rows = ParseNumber<int>(text.substr(std::min(cross + 1, text.size())));
  if (columns && rows) {
    size.columns = *columns;
    size.rows = *rows;
    return Board(size);
  }
  throw ConfigError("--squares " + options.squares + ": allowed is COLUMNSxROWS, such as 9x6");
}

int RunBoard(const Options& options) {
  const Board board = BoardOf(options.board);
  WriteWhole(options.out, BoardPage(board, options.out));
  const Eigen::Vector2d extent_mm = 1000 * board.extent_m();
  std::cout << fmt::format("{}: {:g} x {:g} mm; print at 100 % and measure the line below it\n",
                           options.out.string(), extent_mm.x(), extent_mm.y());
  return 0;
}

// Shows the board's views, file by file.
ViewCollector Collect(const Board& board, const Options& options) {
  ViewCollector collector(board);
  Progress progress(/*quiet=*/false);
  const auto show = [&](const fs::path& input) {
    progress.Show(fmt::format("{}: {}", input.string(),
                              CountsText(collector.counts(), collector.views().size())));
  };
  for (const fs::path& input : options.inputs) {
    if (fs::is_directory(input)) {
      ReadImageFolder(input, [&](const RigImages& images) {
        collector.Add(images, std::nullopt);
        show(input);
      });
    } else {
      const std::string complaint = ReadFrameLog(
          input, options.prefix + std::string(kRawPrefix), {Part::kLeft, Part::kRight, Part::kTof},
          [&](const Frame& frame) {
            collector.Add({.left = frame.left, .right = frame.right, .tof = *frame.tof},
                          frame.id.utime);
            show(input);
          });
      progress.Clear();
      if (!complaint.empty()) std::cerr << "sprout-calibrate: " << complaint << "\n";
    }
    collector.EndRecording();
  }
  return collector;
}

// Why there is no calibration, and what may be wrong with the images.
std::runtime_error NoCalibration(const std::string& why, const ViewCounts& counts, size_t views,
                                 const BoardOptions& board) {
  std::string text = fmt::format("{} ({})", why, CountsText(counts, views));
  if (counts.foreign > 0) {
    text += fmt::format(
        "; {} images show markers that do not lie as on a board of {}: is that "
        "what was printed (--squares)?",
        counts.foreign, board.squares);
  }
  if (counts.moving > counts.images / 2) {
    text += "; hold the board still for a second at each place";
  }
  return std::runtime_error(text);
}

int RunEstimate(const Options& options) {
  const Board board = BoardOf(options.board);
  RigDescription rig;
  if (!options.rig.empty()) rig = LoadRigFile(options.rig);
  const ViewCollector collector = Collect(board, options);
  const ViewCounts& counts = collector.counts();
  const size_t views = collector.views().size();
  if (views == 0) throw NoCalibration("no image can be used", counts, views, options.board);
  const Result<Calibration> calibration = Calibrate(board, collector.sizes(), collector.views());
  if (!calibration) throw NoCalibration(calibration.error().text, counts, views, options.board);

  const std::string counts_text = CountsText(counts, views);
  *rig.mutable_calibration() = ToCalibration(calibration->rig);
  rig.clear_board_calibration();
  if (!options.report.empty()) {
    WriteWhole(options.report, ReportHtml(*calibration, collector.best_images(), counts_text));
  }
  std::cout << counts_text << "\n" << SummaryText(*calibration);
  SaveResult(rig, calibration->quality.is_good(), options.out);
  return calibration->quality.is_good() ? 0 : 1;
}

void AddBoard(CLI::App& program, Options& options) {
  CLI::App& flags =
      *program.add_subcommand("board", "Writes a ChArUco board at true scale, to be printed");
  AddBoardFlags(flags, options.board);
  flags.add_option("--out", options.out, "Page to print: .pdf or .svg")
      ->required()
      ->type_name("FILE");
  flags.callback([&] { options.chosen = [&] { return RunBoard(options); }; });
}

void AddEstimate(CLI::App& program, Options& options) {
  CLI::App& flags =
      *program.add_subcommand("estimate", "Estimates a rig's calibration from images of the board");
  flags
      .add_option("LOG", options.inputs,
                  "Logs of unrectified images (RAW_SPROUT_LEFT, RAW_SPROUT_RIGHT, RAW_SPROUT_TOF), "
                  "or folders of left_NAME.png, right_NAME.png, tof_amplitude_NAME, tof_depth_NAME")
      ->required()
      ->check(CLI::ExistingPath);
  AddBoardFlags(flags, options.board);
  flags.add_option("--rig", options.rig, "Rig file whose devices are kept")->type_name("FILE");
  flags
      .add_option("--out", options.out, "Rig file to write; a bad calibration is written beside it")
      ->required()
      ->type_name("FILE");
  flags.add_option("--report", options.report, "HTML page to write")->type_name("FILE");
  flags.add_option("--channel-prefix", options.prefix, "Before the channels in the log")
      ->type_name("TEXT");
  flags.callback([&] { options.chosen = [&] { return RunEstimate(options); }; });
}

void AddWatch(CLI::App& program, Options& options) {
  CLI::App& flags =
      *program.add_subcommand("watch",
                              "Keeps the views of the board that add information, while it is "
                              "shown to the cameras\n(sprout-capture --raw); says what is still "
                              "missing. Ends when nothing is, or with Ctrl-C.\n"
                              "Exit code 0 nothing is missing, 1 something is");
  AddBoardFlags(flags, options.board);
  flags
      .add_option("--out", options.watch.out,
                  "Folder for the views, for estimate; views already in it count")
      ->required()
      ->type_name("FOLDER");
  flags
      .add_option("--lcm-url", options.watch.lcm_url,
                  "The bus: udpm://GROUP:PORT?ttl=0 or tcpq://HOST:PORT")
      ->type_name("URL")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  flags.add_option("--channel-prefix", options.watch.prefix, "Prefix of the graph's channels")
      ->type_name("TEXT");
  flags.callback(
      [&] { options.chosen = [&] { return RunWatch(BoardOf(options.board), options.watch); }; });
}

void AddCheck(CLI::App& program, Options& options) {
  CLI::App& flags =
      *program.add_subcommand("check",
                              "Checks with frames without a board whether the calibration still "
                              "holds: whether rows agree,\nand whether ToF points are projected to "
                              "the right places. Exit code 0 good, 1 calibrate again");
  flags
      .add_option("LOG", options.check.log,
                  "Log of rectified frames, as a running graph sends them")
      ->required()
      ->check(CLI::ExistingFile);
  flags
      .add_option("--rig", options.check.rig,
                  "Rig file; the log has unrectified images, which are rectified with it")
      ->type_name("FILE");
  flags.add_option("--channel-prefix", options.check.prefix, "Before the channels in the log")
      ->type_name("TEXT");
  flags.callback([&] { options.chosen = [&] { return RunCheck(options.check); }; });
}

void AddRefine(CLI::App& program, Options& options) {
  CLI::App& flags = *program.add_subcommand(
      "refine",
      "Puts a calibration right from recordings of any scene, without a board: the rotations of "
      "the right camera\nand of the ToF camera, and the offset of its ranges. What the scene does "
      "not show stays, and is said.\nExit code 0 good, 1 not good, or the scene shows too little");
  flags
      .add_option(
          "LOG", options.refine.inputs,
          "Logs of unrectified images (RAW_SPROUT_LEFT, RAW_SPROUT_RIGHT, RAW_SPROUT_TOF) or "
          "of a running graph,\nor folders as of estimate")
      ->required()
      ->check(CLI::ExistingPath);
  flags
      .add_option("--rig", options.refine.rig,
                  "Rig file to refine, with which the images were or will be rectified. Without "
                  "it:\nthe calibration in the log of a running graph, as one of cameras without "
                  "distortion")
      ->type_name("FILE");
  flags
      .add_option("--out", options.refine.out,
                  "Rig file to write; a bad calibration is written beside it")
      ->required()
      ->type_name("FILE");
  flags.add_option("--report", options.refine.report, "HTML page to write")->type_name("FILE");
  flags
      .add_option(
          "--also", options.refine.also,
          "What may change as well, for lenses whose distortion is known to some hundredths "
          "of a pixel:\nfocal (lengths), row (of the right principal point), place "
          "(direction of the baseline),\nyaw (where no ToF point shows it)")
      ->delimiter(',')
      ->check(CLI::IsMember({"focal", "row", "place", "yaw"}))
      ->type_name("NAMES");
  flags.add_option("--channel-prefix", options.refine.prefix, "Before the channels in the log")
      ->type_name("TEXT");
  flags.callback([&] { options.chosen = [&] { return RunRefine(options.refine); }; });
}

int RunChosen(const Options& options) {
  try {
    return options.chosen();
  } catch (const LogError& e) {
    throw ConfigError(e.what());  // exit code 2
  }
}

}  // namespace

int CalibrateMain(int argc, const char* const* argv) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres' remarks; what they mean is said in our words
  CLI::App flags(kDescription, "sprout-calibrate");
  Options options;
  flags.require_subcommand(1);
  AddBoard(flags, options);
  AddWatch(flags, options);
  AddEstimate(flags, options);
  AddCheck(flags, options);
  AddRefine(flags, options);
  flags.set_version_flag("--version", "sprout-calibrate " + Version());
  flags.footer(kFooter);
  return RunProgram(flags, argc, argv, [&] { return RunChosen(options); });
}

}  // namespace sprout::calibrate
