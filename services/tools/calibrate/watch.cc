#include "services/tools/calibrate/watch.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <iostream>
#include <optional>
#include <stop_token>
#include <system_error>
#include <vector>

#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/app/progress.h"
#include "common/bus/channels.h"
#include "common/bus/mailbox.h"
#include "common/bus/receiver.h"
#include "common/config/config_error.h"
#include "common/core/printable.h"
#include "common/core/signal_watcher.h"
#include "common/frames/frame_joiner.h"
#include "services/tools/calibrate/coverage.h"
#include "services/tools/calibrate/image_folder.h"
#include "services/tools/calibrate/report.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr std::array kParts = {Part::kLeft, Part::kRight, Part::kTof};

// Locks the folder while the process lives: two processes would replace each other's views.
void Lock(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // Some network file systems have no locks.
  if (descriptor >= 0 && flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw ConfigError(
        "--out " + folder.string() +
        ": another sprout-calibrate watch writes there; allowed: a folder of its own");
  }
}

// Views of a board, what they cover, and the folder that they are in. For one thread.
class ViewFolder {
 public:
  ViewFolder(const Board& board, const fs::path& folder)
      : folder_(folder), collector_(board), coverage_(board) {
    RequireWritableFolder("--out", folder, {"left_0001.png"});  // checked before the board is shown
    Lock(folder);
    // The left image of a view is written last.
    const bool has_view = std::ranges::any_of(
        fs::directory_iterator(folder),
        [](const auto& entry) { return entry.path().filename().string().starts_with("left_"); });
    if (has_view) {
      constexpr int kFoundOut = 0;  // its own images have 8 bits
      ReadImageFolder(folder, kFoundOut,
                      [&](const RigImages& images) { Add(images, std::nullopt); });
      collector_.EndRecording();
    }
  }

  // Writes the view to the folder if it is a new one. @returns whether it is.
  bool AddAndWrite(const Frame& frame) {
    const RigImages images{.left = frame.left, .right = frame.right, .tof = *frame.tof};
    if (!Add(images, frame.id.utime)) return false;
    fs::path free;
    do {
      free = folder_ / fmt::format("left_{:04}.png", ++number_);
    } while (fs::exists(free));
    WriteImages(folder_, fmt::format("{:04}", number_), images);
    return true;
  }

  bool IsComplete() const { return coverage_.Missing().empty(); }

  std::string CountsLine() const {
    return CountsText(collector_.counts(), collector_.views().size());
  }

  std::string Text() const {
    std::string text = coverage_.Text();
    const std::vector<std::string> missing = coverage_.Missing();
    text += missing.empty() ? "nothing is missing\n" : "still missing:\n";
    for (const std::string& line : missing) text += "  * " + line + "\n";
    return text;
  }

  size_t views() const { return collector_.views().size(); }

 private:
  bool Add(const RigImages& images, std::optional<int64_t> utime) {
    const size_t before = collector_.views().size();
    collector_.Add(images, utime);
    if (collector_.views().size() == before) return false;
    coverage_.Add(collector_.views().back(), collector_.sizes());
    return true;
  }

  fs::path folder_;
  ViewCollector collector_;
  Coverage coverage_;
  int number_ = 0;
};

// Frames of the unrectified images on the bus; of those that come faster than they are taken the
// newest.
class RawFrames {
 public:
  explicit RawFrames(const WatchOptions& options)
      : receiver_(options.lcm_url, options.prefix + std::string(kRawPrefix), Channels(),
                  [this](std::string_view channel, std::span<const uint8_t> bytes) {
                    OnMessage(channel, bytes);
                  }) {}

  std::optional<Frame> Take(const std::stop_token& stop) { return mailbox_.Take(stop); }

 private:
  static std::vector<std::string_view> Channels() {
    std::vector<std::string_view> channels;
    for (const Part part : kParts) channels.push_back(ChannelOf(part));
    return channels;
  }

  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
    const std::optional<Part> part = PartOf(channel);
    if (!part) return;
    Result<std::vector<Frame>> frames = joiner_.AddMessage(*part, bytes);
    if (!frames) {
      // SilenceWatch warns that no frame is complete; the reason is printed once.
      if (!complained_) std::cerr << "sprout-calibrate: " << frames.error().text << std::endl;
      complained_ = true;
      return;
    }
    for (Frame& frame : *frames) mailbox_.Put(std::move(frame));
  }

  FrameJoiner joiner_{PartSet{Part::kLeft, Part::kRight, Part::kTof}};
  bool complained_ = false;
  Mailbox<Frame> mailbox_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

void Show(const ViewFolder& views) {
  constexpr std::string_view kHome = "\x1b[H\x1b[J";  // cursor to the corner, rest of screen empty
  std::cout << (isatty(STDOUT_FILENO) != 0 ? kHome : "\n") << "view " << views.views() << "\n"
            << views.Text() << std::flush;
}

// Takes views until nothing is missing or a stop is asked for.
void Watch(RawFrames& frames, ViewFolder& views, const std::stop_token& stop) {
  Progress progress(/*quiet=*/false);
  Show(views);
  progress.Show("waiting for images (sprout-capture --raw)");
  while (!views.IsComplete()) {
    const std::optional<Frame> frame = frames.Take(stop);
    if (!frame) break;
    if (views.AddAndWrite(*frame)) {
      progress.Clear();
      Show(views);
    }
    progress.Show(views.CountsLine());
  }
}

}  // namespace

std::string EstimateCommand(const Board& board, const fs::path& folder) {
  const BoardSize usual;
  const BoardSize& size = board.size();
  std::string command = "sprout-calibrate estimate " + ShellWord(folder.string());
  if (size.columns != usual.columns || size.rows != usual.rows) {
    command += fmt::format(" --squares {}x{}", size.columns, size.rows);
  }
  if (size.square_m != usual.square_m)
    command += fmt::format(" --square-mm {:g}", 1000 * size.square_m);
  if (size.kind == BoardKind::kChessboard) command += " --board chessboard";
  if (size.kind == BoardKind::kAprilGrid) command += " --board aprilgrid";
  if (size.dictionary != usual.dictionary) command += " --dictionary " + ShellWord(size.dictionary);
  if (size.marker_per_square != usual.marker_per_square) {
    command += fmt::format(" --marker-mm {:g}", 1000 * size.square_m * size.marker_per_square);
  }
  if (size.gap_per_tag != usual.gap_per_tag) {
    command += fmt::format(" --tag-spacing {:g}", size.gap_per_tag);
  }
  // A rig file that is there is given to estimate, which keeps its devices.
  std::error_code ignored;
  if (fs::is_regular_file("rig.textproto", ignored)) command += " --rig rig.textproto";
  return command + " --out rig.textproto --report report.html";
}

int RunWatch(const Board& board, const WatchOptions& options) {
  if (const auto error = LcmUrlError(options.lcm_url)) throw ConfigError("--lcm-url: " + *error);
  RequireChannelPrefix(options.prefix);
  const SignalWatcher signals;
  ViewFolder views(board, options.out);
  RawFrames frames(options);
  Watch(frames, views, signals.token());
  std::cout << fmt::format("{}: {}\n", options.out.string(), views.CountsLine());
  if (views.views() > 0) std::cout << "next: " << EstimateCommand(board, options.out) << "\n";
  return views.IsComplete() ? 0 : 1;
}

}  // namespace sprout::calibrate
