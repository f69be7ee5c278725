// The subcommands that copy a log: but for some events (cut, repair), or in fewer bytes and back
// (compress, expand).
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <set>

#include "common/config/config.h"
#include "common/config/frame_range.h"
#include "common/logfile/log_reader.h"
#include "common/logfile/log_writer.h"
#include "common/messages/compressor.h"
#include "common/messages/message_type.h"
#include "services/tools/log/channel_summary.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/event_stream.h"
#include "services/tools/log/print_line.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

struct CopyOptions {
  std::filesystem::path in;
  std::filesystem::path out;
  bool force = false;
};

struct CutOptions : CopyOptions {
  std::string frames;
  int64_t warm_up = 0;
  std::vector<std::string> channels;
  std::string prefix;
};

struct CompressOptions : CopyOptions {
  std::optional<int> jpeg_quality;
};

std::optional<FrameId> IdOf(const LogEvent& event) {
  if (!TypeOf(event.data)) return std::nullopt;
  auto id = DecodeFrameId(event.data);
  return id ? std::optional(std::move(*id)) : std::nullopt;
}

// An event that was read before and may be written later.
struct KeptEvent {
  int64_t utime = 0;
  std::string channel;
  std::vector<uint8_t> data;

  LogEvent event() const { return {.utime = utime, .channel = channel, .data = data}; }
};

void Copy(const LogEvent& event, LogWriter& out) {
  out.Write(event.utime, event.channel, event.data);
}

// Sees to it that the calibration of every frame that is kept is kept, too. It is sent once a
// second, so it may stand before the first frame that is kept or behind the last one.
class RigKeeper {
 public:
  explicit RigKeeper(LogWriter& out) : out_(out) {}

  void OnRig(const LogEvent& event, const FrameId& id, bool in_range) {
    if (in_range || (needed_.contains(id.rig_id) && !written_.contains(id.rig_id))) {
      Copy(event, out_);
      written_.insert(id.rig_id);
    } else if (!written_.contains(id.rig_id)) {
      waiting_[id.rig_id] = {
          event.utime, std::string(event.channel), {event.data.begin(), event.data.end()}};
    }
  }

  // Copies a calibration that waits, before the first frame that needs it is written.
  void OnFrame(const FrameId& id) {
    needed_.insert(id.rig_id);
    const auto rig = waiting_.find(id.rig_id);
    if (rig == waiting_.end() || !written_.insert(id.rig_id).second) return;
    Copy(rig->second.event(), out_);
    waiting_.erase(rig);
  }

 private:
  LogWriter& out_;
  std::map<std::string, KeptEvent> waiting_;  // newest of each rig_id that was not written yet
  std::set<std::string> needed_;
  std::set<std::string> written_;
};

// Sees to it that frames that are cut out keep what the processes say of themselves, each text
// once: what was said before the first frame stands before it.
class ProcessKeeper {
 public:
  explicit ProcessKeeper(LogWriter& out) : out_(out) {}

  void OnProcess(const LogEvent& event) {
    if (!known_.emplace(event.data.begin(), event.data.end()).second) return;
    if (frame_seen_) return Copy(event, out_);
    waiting_.push_back(
        {event.utime, std::string(event.channel), {event.data.begin(), event.data.end()}});
  }

  // Copies what processes said of themselves, before the first frame is written.
  void OnFrame() {
    frame_seen_ = true;
    for (const KeptEvent& process : waiting_) Copy(process.event(), out_);
    waiting_.clear();
  }

 private:
  LogWriter& out_;
  bool frame_seen_ = false;
  std::vector<KeptEvent> waiting_;
  std::set<std::vector<uint8_t>> known_;
};

// Tells whoever cuts frames out of a log with fused maps that these depend on earlier frames.
class MemoryHint {
 public:
  MemoryHint(const CutOptions& options, int64_t first) : options_(options), first_(first) {}

  void Add(std::string_view channel, const FrameId& id) {
    if (channel != ChannelOf(Part::kFused)) return;
    before_ |= id.seq < first_;
  }

  void Warn() const {
    if (!before_ || options_.warm_up > 0) return;
    PrintWarning(fmt::format(
        "{}: SPROUT_FUSED depends on earlier frames: a replay of {} begins anew at frame {}; "
        "--warm-up {} keeps what matters",
        options_.in.string(), options_.out.string(), first_, TemporalConfig().warm_up_frames()));
  }

 private:
  const CutOptions& options_;
  int64_t first_;
  bool before_ = false;  // there are fused maps before the first frame that is kept
};

using Bytes = std::vector<uint8_t>;

LogError AtEvent(const std::filesystem::path& log, const LogEvent& event, const std::string& what) {
  return LogError(log, fmt::format("event at byte {}, {}: {}", event.offset, event.channel, what));
}

// Copies a log, of each event what `change` gives in its place. Numbers and times stay.
// @param change  gives nothing for an event that stays as it is.
template <typename Change>
void ChangeEvents(const std::filesystem::path& in, const std::filesystem::path& out, bool force,
                  const Change& change) {
  const auto begun = std::chrono::steady_clock::now();
  LogReader reader(in);
  LogWriter writer(out, force, OutputFile::OverInput::kAllowed);
  ReadProgress progress("reading " + in.string(), reader.size());
  int64_t changed = 0;
  int64_t bytes = 0;
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) {
    const std::optional<Bytes> instead = change(event);
    const std::span<const uint8_t> data = instead ? std::span(*instead) : event.data;
    writer.Write(event.utime, event.channel, data, event.number);
    changed += instead.has_value();
    bytes += std::ssize(data);
  }
  progress.Clear();
  if (!reader.damage().empty()) {
    throw LogError(in, SkippedText(reader.damage().front()) +
                           "; allowed is an undamaged log, such as sprout-log repair writes");
  }
  writer.Close();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begun;
  const double mb = static_cast<double>(reader.size()) / 1e6;
  PrintLine(fmt::format("{}: {} of {} events changed, {:.1f} MB of {:.1f} MB, {:.0f} MB/s",
                        out.string(), changed, writer.events(), static_cast<double>(bytes) / 1e6,
                        mb, mb / seconds.count()));
}

int RunCut(const CutOptions& options) {
  const bool by_frame = !options.frames.empty();
  FrameRange range = by_frame ? ParseFrameRange("--frames", options.frames) : FrameRange{};
  range.first = std::max<int64_t>(0, range.first - options.warm_up);
  MemoryHint memory(options, range.first);
  const ChannelFilter filter(options.channels, options.prefix);
  LogReader reader(options.in);
  LogWriter out(options.out, options.force, OutputFile::OverInput::kAllowed);
  RigKeeper rigs(out);
  ProcessKeeper processes(out);
  ReadProgress progress("reading " + options.in.string(), reader.size());
  int64_t events = 0;
  int64_t kept = 0;  // without calibrations that are added for the frames
  std::set<std::string, std::less<>> absent = filter.names();
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) {
    ++events;
    if (!event.channel.starts_with(options.prefix)) continue;
    if (const auto name = absent.find(event.channel); name != absent.end()) absent.erase(name);
    const auto id = IdOf(event);
    const bool in_range = id ? range.Has(id->seq) : false;
    if (id) memory.Add(event.channel.substr(options.prefix.size()), *id);
    if (TypeOf(event.data) == MessageType::kRig && id) {
      rigs.OnRig(event, *id, in_range || !by_frame);
      if (filter.names().contains(event.channel) && (in_range || !by_frame)) ++kept;
      continue;
    }
    if (!filter.Has(event.channel)) continue;
    if (by_frame && TypeOf(event.data) == MessageType::kProcess) {
      processes.OnProcess(event);
      continue;
    }
    if (by_frame && !in_range) continue;
    if (by_frame) processes.OnFrame();
    if (id) rigs.OnFrame(*id);
    Copy(event, out);
    ++kept;
  }
  progress.Clear();
  WarnOfDamage(options.in, reader.damage());
  memory.Warn();
  if (kept == 0) throw LogError(options.in, "no event in these frames and channels");
  for (const std::string& name : absent) {
    PrintWarning(options.in.string() + ": no event on " + name);
  }
  out.Close();
  PrintLine(fmt::format("{}: {} of {} events", options.out.string(), out.events(), events));
  return 0;
}

int RunRepair(const CopyOptions& options) {
  LogReader reader(options.in);
  LogWriter out(options.out, options.force, OutputFile::OverInput::kAllowed);
  ReadProgress progress("repairing " + options.in.string(), reader.size());
  int64_t undecodable = 0;
  std::vector<std::string> report;
  for (LogEvent event; reader.Next(event); progress.Update(reader.position())) {
    constexpr int kShown = 20;
    const std::string reason = WhyUndecodable(event);
    if (!reason.empty() && ++undecodable <= kShown) {
      report.push_back(fmt::format("kept, but undecodable: {}, event {} at byte {}: {}",
                                   event.channel, event.number, event.offset, reason));
    }
    Copy(event, out);
  }
  progress.Clear();
  out.Close();
  int64_t lost_bytes = 0;
  for (const LogDamage& damage : reader.damage()) {
    lost_bytes += damage.bytes;
    report.push_back("lost: " + DamageText(damage));
  }
  for (const std::string& line : report) PrintLine(line);
  PrintLine(fmt::format("{}: {} events; {} bytes of {} lost in {} place{}, {} undecodable kept",
                        options.out.string(), out.events(), lost_bytes, reader.size(),
                        reader.damage().size(), reader.damage().size() == 1 ? "" : "s",
                        undecodable));
  return 0;
}

int RunCompress(const CompressOptions& options) {
  MessageCompressor compressor(options.jpeg_quality);
  ChangeEvents(options.in, options.out, options.force, [&](const LogEvent& event) {
    std::optional<Bytes> smaller = compressor.Compress(event.channel, event.data);
    if (!smaller || !IsPacked(*smaller)) return smaller;
    // The original may be deleted afterwards, so what was packed is unpacked again and compared.
    const Result<Bytes> back = Unpack(*smaller);
    if (!back || !std::ranges::equal(*back, event.data)) {
      throw AtEvent(options.in, event, "does not come back as it was");
    }
    return smaller;
  });
  return 0;
}

int RunExpand(const CopyOptions& options) {
  ChangeEvents(options.in, options.out, options.force,
               [&](const LogEvent& event) -> std::optional<Bytes> {
                 if (!IsPacked(event.data)) return std::nullopt;
                 Result<Bytes> message = Unpack(event.data);
                 if (!message) throw AtEvent(options.in, event, message.error().text);
                 return *std::move(message);
               });
  return 0;
}

void AddPaths(Flags& flags, CopyOptions& options, const char* in = "Log") {
  flags.Add("IN", options.in, in).Required();
  flags.Add("OUT", options.out, "New log").Required();
}

}  // namespace

void AddCut(Flags& program) {
  const auto options = std::make_shared<CutOptions>();
  Flags& flags = program.AddCommand(
      "cut",
      "Writes some frames or channels of a log to a new one. Calibrations (RIG) of the frames "
      "are\nalways kept, and with --frames also SPROUT_PROCESS, once for each process; other "
      "messages\nwithout a frame are kept only without --frames",
      [options] { return RunCut(*options); });
  AddPaths(flags, *options);
  Flag frames = AddFrames(flags, options->frames);
  flags
      .Add("--warm-up N", options->warm_up,
           "Also keep so many frames before those of --frames: for a replay of "
           "sprout-temporal, which remembers earlier frames")
      .WithinWhole(int64_t{0}, int64_t{1'000'000})
      .ShowDefault()
      .Needs(frames);
  AddChannels(flags, options->channels);
  AddPrefix(flags, options->prefix);
  AddForce(flags, options->force);
}

void AddRepair(Flags& program) {
  const auto options = std::make_shared<CopyOptions>();
  Flags& flags = program.AddCommand(
      "repair",
      "Writes all good events of a damaged log to a new one that every LCM tool reads, and\nprints "
      "what was lost. Undecodable messages are kept: a later program may understand them",
      [options] { return RunRepair(*options); });
  AddPaths(flags, *options);
  AddForce(flags, options->force);
}

void AddCompress(Flags& program) {
  const auto options = std::make_shared<CompressOptions>();
  Flags& flags = program.AddCommand("compress",
                                    "Writes a log in fewer bytes: images lose nothing and take "
                                    "half, more or less. Every program\nof Sprout reads it as the "
                                    "original; `sprout-log expand` gives that back to the byte",
                                    [options] { return RunCompress(*options); });
  AddPaths(flags, *options);
  flags
      .Add("--jpeg QUALITY", options->jpeg_quality,
           "Left and right images as JPEG of this quality: a tenth of the bytes, but what is lost "
           "does not come back, and replays differ")
      .WithinWhole(1, 100);
  AddForce(flags, options->force);
}

void AddExpand(Flags& program) {
  const auto options = std::make_shared<CopyOptions>();
  Flags& flags = program.AddCommand(
      "expand", "Writes the log that was compressed, to the byte; for programs of others",
      [options] { return RunExpand(*options); });
  AddPaths(flags, *options, "Log, compressed or recorded with --compress");
  AddForce(flags, options->force);
}

}  // namespace sprout::log
