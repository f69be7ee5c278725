#include "services/tools/calibrate/program.h"

#include <fmt/core.h>
#include <glog/logging.h>

#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/config/required.h"
#include "common/core/number_text.h"
#include "common/picture/eight_bits.h"
#include "common/rig/rig_file.h"
#include "services/tools/calibrate/board.h"
#include "services/tools/calibrate/board_finder.h"
#include "services/tools/calibrate/calibrator.h"
#include "services/tools/calibrate/coverage.h"
#include "services/tools/calibrate/frame_log.h"
#include "services/tools/calibrate/image_folder.h"
#include "services/tools/calibrate/import/import.h"
#include "services/tools/calibrate/refine.h"
#include "services/tools/calibrate/report.h"
#include "services/tools/calibrate/result_file.h"
#include "services/tools/calibrate/watch.h"

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
  sprout-calibrate import left.yaml right.yaml --out rig.textproto    a calibration of ROS, OpenCV, Kalibr

`sprout-calibrate COMMAND --help` explains a command. Exit codes: 0; 1 the calibration is not good
(any more), or there is none, or check cannot tell; 2 a flag or a file that cannot be used.
)";

struct BoardOptions {
  std::string squares = "9x6";
  double square_mm = 60;
  std::string kind = "charuco";
  std::string dictionary = BoardSize().dictionary;
  std::optional<double> marker_mm;
  double tag_spacing = BoardSize().gap_per_tag;
};

struct Options {
  BoardOptions board;
  fs::path out;
  std::vector<fs::path> inputs;
  fs::path rig;
  fs::path report;
  std::string prefix;
  int bits = 0;  // of images in folders, see EightBits
  RefineOptions check;
  RefineOptions refine;
  ImportOptions import;
  WatchOptions watch{.out = {}, .prefix = {}, .lcm_url = kDefaultLcmUrl};
};

void AddBits(Flags& flags, int& bits) {
  flags
      .Add("--bits N", bits,
           "Bits that pixels of 16 bits in a folder use: 8 to 16; 0: as the format or the first "
           "pair says")
      .WithinWhole(0, kMaxBits);
}

void AddBoardFlags(Flags& flags, BoardOptions& board) {
  flags.Add("--squares CxR", board.squares, "Columns and rows of the board").ShowDefault();
  flags.Add("--square-mm", board.square_mm, "Side of a square as measured on the print, mm")
      .Within(1, 10000)
      .ShowDefault();
}

// Flags for boards that other programs print.
void AddKindFlags(Flags& flags, BoardOptions& board) {
  flags
      .Add("--board KIND", board.kind,
           "What is printed: charuco, chessboard, or aprilgrid (Kalibr's; --squares counts its "
           "tags, --square-mm is a tag's side)")
      .OneOf({"charuco", "chessboard", "aprilgrid"})
      .ShowDefault();
  flags
      .Add("--dictionary NAME", board.dictionary,
           "OpenCV's dictionary of a ChArUco board's markers")
      .ShowDefault();
  flags.Add("--marker-mm", board.marker_mm,
            "Side of a ChArUco board's markers, mm; else three quarters of a square");
  flags
      .Add("--tag-spacing", board.tag_spacing,
           "Gap between an AprilGrid's tags, of a tag's side (Kalibr's tagSpacing)")
      .ShowDefault();
}

Board BoardOf(const BoardOptions& options) {
  BoardSize size{.square_m = options.square_mm / 1000,
                 .dictionary = options.dictionary,
                 .gap_per_tag = options.tag_spacing};
  if (options.kind == "chessboard") size.kind = BoardKind::kChessboard;
  if (options.kind == "aprilgrid") size.kind = BoardKind::kAprilGrid;
  if (options.marker_mm) size.marker_per_square = *options.marker_mm / options.square_mm;
  const auto squares = ParseSize(options.squares);
  if (!squares) {
    throw ConfigError("--squares " + options.squares + ": allowed is COLUMNSxROWS, such as 9x6");
  }
  std::tie(size.columns, size.rows) = *squares;
  return Board(size);
}

int RunBoard(const Options& options) {
  const Board board = BoardOf(options.board);
  const std::string page = BoardPage(board, options.out);
  RequireWritableFile("--out", options.out);
  WriteWhole(options.out, page);
  const Eigen::Vector2d extent_mm = 1000 * board.extent_m();
  const Eigen::Vector2d page_mm = BoardPageSizeMm(board);
  std::cout << fmt::format(
      "{}: a board of {:g} x {:g} mm on a page of {:g} x {:g} mm; print at 100 % and measure the "
      "line below it\n",
      options.out.string(), extent_mm.x(), extent_mm.y(), page_mm.x(), page_mm.y());
  return 0;
}

// What the images without a board show instead, and what was looked for.
std::string LookedForText(const ViewCollector& collector, const Board& board) {
  const std::string seen = SeenBoards(collector.images_without_board());
  return fmt::format("found {}; looked for a {} (--board, --squares, --dictionary)",
                     seen.empty() ? "no board at all" : seen, BoardText(board.size()));
}

// Collects the board's views, file by file. Warns early if the first images do not show it: OpenCV
// takes up to a second for an image that lacks the chessboard.
ViewCollector Collect(const Board& board, const Options& options) {
  ViewCollector collector(board);
  Progress progress(/*quiet=*/false);
  const auto show = [&](const fs::path& input) {
    const int tried = collector.counts().images;
    const bool none_seen = tried == collector.counts().no_board;
    if (none_seen && std::cmp_equal(tried, ViewCollector::kMaxWithoutBoard + 1)) {
      progress.Clear();
      std::cerr << fmt::format("sprout-calibrate: the first {} images are without the board: {}\n",
                               tried, LookedForText(collector, board));
    }
    progress.Show(fmt::format("{}: {}", input.string(),
                              CountsText(collector.counts(), collector.views().size())));
  };
  for (const fs::path& input : options.inputs) {
    if (fs::is_directory(input)) {
      const auto notes = ReadImageFolder(input, options.bits, [&](const RigImages& images) {
        collector.Add(images, std::nullopt);
        show(input);
      });
      progress.Clear();
      for (const std::string& note : notes) std::cerr << "sprout-calibrate: " << note << "\n";
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
std::runtime_error NoCalibration(const std::string& why, const ViewCollector& collector,
                                 const BoardOptions& board) {
  const ViewCounts& counts = collector.counts();
  std::string text = fmt::format("{} ({})", why, CountsText(counts, collector.views().size()));
  if (2 * counts.no_board > counts.images) {
    text += "; " + LookedForText(collector, BoardOf(board));
  }
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
  Required(CheckBits(options.bits), "--bits ");
  const Board board = BoardOf(options.board);
  RequireResultFiles(options.inputs, options.rig, options.out, options.report);
  RigDescription rig;
  if (!options.rig.empty()) rig = LoadRigFile(options.rig);
  const ViewCollector collector = Collect(board, options);
  const ViewCounts& counts = collector.counts();
  const size_t views = collector.views().size();
  if (views == 0) throw NoCalibration("no image can be used", collector, options.board);
  const Result<Calibration> calibration = Calibrate(board, collector.sizes(), collector.views());
  if (!calibration) throw NoCalibration(calibration.error().text, collector, options.board);

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

void AddBoard(Flags& program, Options& options) {
  Flags& flags = program.AddCommand("board", "Writes a ChArUco board at true scale, to be printed",
                                    [&options] { return RunBoard(options); });
  AddBoardFlags(flags, options.board);
  flags.Add("--out FILE", options.out, "Page to print: .pdf or .svg").Required();
}

void AddEstimate(Flags& program, Options& options) {
  Flags& flags =
      program.AddCommand("estimate", "Estimates a rig's calibration from images of the board",
                         [&options] { return RunEstimate(options); });
  flags
      .Add("LOG", options.inputs,
           "Logs of unrectified images (RAW_SPROUT_LEFT, RAW_SPROUT_RIGHT, RAW_SPROUT_TOF), "
           "or folders of left_NAME.png, right_NAME.png, tof_amplitude_NAME, tof_depth_NAME")
      .Required()
      .ExistingPath();
  AddBoardFlags(flags, options.board);
  AddKindFlags(flags, options.board);
  flags.Add("--rig FILE", options.rig, "Rig file whose devices are kept");
  flags.Add("--out FILE", options.out, "Rig file to write; a bad calibration is written beside it")
      .Required();
  flags.Add("--report FILE", options.report, "HTML page to write");
  flags.Add("--channel-prefix TEXT", options.prefix, "Before the channels in the log");
  AddBits(flags, options.bits);
}

void AddWatch(Flags& program, Options& options) {
  Flags& flags =
      program.AddCommand("watch",
                         "Keeps the views of the board that add information, while it is "
                         "shown to the cameras\n(sprout-capture --raw); says what is still "
                         "missing. Ends when nothing is, or with Ctrl-C.\n"
                         "Exit code 0 nothing is missing, 1 something is",
                         [&options] { return RunWatch(BoardOf(options.board), options.watch); });
  AddBoardFlags(flags, options.board);
  AddKindFlags(flags, options.board);
  flags
      .Add("--out FOLDER", options.watch.out,
           "Folder for the views, for estimate; views already in it count")
      .Required();
  flags
      .Add("--lcm-url URL", options.watch.lcm_url,
           "The bus: udpm://GROUP:PORT?ttl=0 or tcpq://HOST:PORT")
      .Environment("LCM_DEFAULT_URL")
      .ShowDefault();
  flags.Add("--channel-prefix TEXT", options.watch.prefix, "Prefix of the graph's channels");
}

// What refine and check read.
void AddScenes(Flags& flags, RefineOptions& options) {
  flags
      .Add("LOG", options.inputs,
           "Logs of unrectified images (RAW_SPROUT_LEFT, RAW_SPROUT_RIGHT, RAW_SPROUT_TOF) or "
           "of a running graph,\nor folders as of estimate")
      .Required()
      .ExistingPath();
  flags.Add("--rig FILE", options.rig,
            "Rig file, with which the images were or will be rectified. Without it:\nthe "
            "calibration in the log of a running graph, as one of cameras without distortion");
  flags.Add("--channel-prefix TEXT", options.prefix, "Before the channels in the log");
  AddBits(flags, options.bits);
}

void AddCheck(Flags& program, Options& options) {
  Flags& flags = program.AddCommand(
      "check",
      "Checks with frames of any scene, without a board, whether the calibration still holds: as "
      "refine, but\nwrites nothing. Exit code 0 good, 1 calibrate again, or the scene shows too "
      "little to tell",
      [&options] {
        Required(CheckBits(options.check.bits), "--bits ");
        return RunCheck(options.check);
      });
  AddScenes(flags, options.check);
}

void AddRefine(Flags& program, Options& options) {
  Flags& flags = program.AddCommand(
      "refine",
      "Puts a calibration right from recordings of any scene, without a board: the rotations of "
      "the right camera\nand of the ToF camera, and the offset of its ranges. What the scene does "
      "not show stays, and is said.\nExit code 0 good, 1 not good, or the scene shows too little",
      [&options] {
        Required(CheckBits(options.refine.bits), "--bits ");
        return RunRefine(options.refine);
      });
  AddScenes(flags, options.refine);
  flags
      .Add("--out FILE", options.refine.out,
           "Rig file to write; a bad calibration is written beside it")
      .Required();
  flags.Add("--report FILE", options.refine.report, "HTML page to write");
  flags
      .Add("--also NAMES", options.refine.also,
           "What may change as well, for lenses whose distortion is known to some hundredths "
           "of a pixel:\nfocal (lengths), row (of the right principal point), place "
           "(direction of the baseline),\nyaw (where no ToF point shows it)")
      .SplitAtCommas()
      .OneOf({"focal", "row", "place", "yaw"});
}

void AddImport(Flags& program, Options& options) {
  Flags& flags = program.AddCommand(
      "import",
      "Makes a rig file of a pair's calibration by another program: OpenCV's stereoCalibrate (YAML "
      "or XML, in one file\nor intrinsics and extrinsics apart), ROS's camera_calibration "
      "(left.yaml right.yaml), Kalibr (camchain), EuRoC (two sensor.yaml)",
      [&options] { return RunImport(options.import); });
  flags
      .Add("FILE", options.import.files,
           "The calibration; of ROS and EuRoC that of the left camera first")
      .Required()
      .ExistingFile();
  flags.Add("--out FILE", options.import.out, "Rig file to write").Required();
  flags.Add("--rig FILE", options.import.rig, "Rig file whose devices are kept");
  flags.Add("--size WxH", options.import.size,
            "Size of the images, px, where the files do not say it (OpenCV's)");
  flags.Add("--unit UNIT", options.import.unit,
            "Unit of lengths in the files: mm, cm, m, or so many m, as of a square of the board "
            "(OpenCV's); else m");
  flags.Add("--fisheye", options.import.fisheye,
            "The lenses are of OpenCV's fisheye model, which its files do not name");
}

}  // namespace

int CalibrateMain(int argc, const char* const* argv) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // no remarks of Ceres: failures are reported here
  Flags flags("sprout-calibrate", kDescription);
  Options options;
  flags.RequireCommand();
  AddBoard(flags, options);
  AddWatch(flags, options);
  AddEstimate(flags, options);
  AddCheck(flags, options);
  AddRefine(flags, options);
  AddImport(flags, options);
  flags.SetFooter(kFooter);
  return RunProgram(flags, argc, argv,
                    [&] { return RefusingLogs([&] { return flags.RunCommand(); }); });
}

}  // namespace sprout::calibrate
