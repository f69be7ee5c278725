#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <memory>
#include <tuple>

#include "common/core/printable.h"
#include "common/logfile/log_reader.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/event_stream.h"
#include "services/tools/log/message_diff.h"
#include "services/tools/log/print_line.h"
#include "services/tools/log/read_progress.h"

namespace sprout::log {
namespace {

struct DiffOptions {
  std::filesystem::path a;
  std::filesystem::path b;
  std::vector<std::string> channels;
  std::string prefix;
  bool common = false;
  bool all = false;
  std::filesystem::path images;
};

constexpr int kShownDifferences = 10;

// What the comparison of one channel gave.
struct ChannelDiff {
  int64_t compared = 0;
  int64_t equal = 0;
  int64_t encoded_differently = 0;  // of the equal ones
  int64_t different = 0;
  std::array<int64_t, 2> only{};  // in A, in B
  DisparityDiff disparity;        // sums over the frames that differ
  int64_t maps = 0;               // of those
};

std::string FrameText(const EventKey& key) {
  std::string text = key.channel;
  if (!key.rig_id.empty()) return text + ", calibration " + key.rig_id;
  if (key.utime == 0) return text + fmt::format(", message {}", key.seq);
  text += fmt::format(", frame {} (utime {})", key.seq, key.utime);
  return key.version > 0 ? text + fmt::format(", version {}", key.version) : text;
}

// The place of a frame among all, whatever its channel.
std::tuple<int64_t, int64_t, std::string> OrderOf(const EventKey& key) {
  return {key.utime, key.seq, key.channel};
}

// Reads both logs in step. An event without a counterpart so far is kept as some 200 bytes, not as
// a message, so memory depends on how far the logs are apart and not on their size.
class LogDiff {
 public:
  explicit LogDiff(const DiffOptions& options)
      : options_(options),
        filter_(options.channels, options.prefix),
        streams_{EventStream(options.a, filter_), EventStream(options.b, filter_)},
        fetchers_{EventFetcher(options.a), EventFetcher(options.b)},
        names_(options.images),
        progress_("comparing", streams_[0].reader().size() + streams_[1].reader().size()) {}

  // Prints the differences as they come.
  void Run();

  // The table and the remarks on it.
  std::string Report() const;
  bool IsEqual() const;
  bool IsSharedEqual() const;
  bool HasAnything() const;
  bool HasShared() const;
  // A channel that was asked for and is in neither log, without prefix; else empty.
  std::string Absent() const;
  void Warn();

 private:
  struct Difference {
    EventKey key;
    std::string text;
  };

  void Take(size_t side);
  void AddUnmatched(size_t side);
  void Print(const std::string& line);
  void CompareWith(size_t side, const EventDigest& other);
  void AddDifference(const EventKey& key, const std::string& text);
  void AddSums(ChannelDiff& channel, const DisparityDiff& diff) const;

  const DiffOptions& options_;
  ChannelFilter filter_;
  std::array<EventStream, 2> streams_;
  std::array<EventFetcher, 2> fetchers_;
  std::array<std::map<EventKey, EventDigest>, 2> waiting_;
  std::map<std::string, ChannelDiff> channels_;
  std::optional<Difference> first_;
  int64_t differences_ = 0;
  FrameFileNames names_;  // of --images
  ReadProgress progress_;
};

void LogDiff::Run() {
  std::array<bool, 2> there = {streams_[0].Next(), streams_[1].Next()};
  while (there[0] || there[1]) {
    const bool first_is_earlier = streams_[0].utime() <= streams_[1].utime();
    const size_t side = !there[1] || (there[0] && first_is_earlier) ? 0 : 1;
    Take(side);
    there[side] = streams_[side].Next();
    progress_.Update(streams_[0].reader().position() + streams_[1].reader().position());
  }
  for (const size_t side : {size_t{0}, size_t{1}}) AddUnmatched(side);
}

void LogDiff::AddUnmatched(size_t side) {
  for (const auto& [key, digest] : waiting_[side]) ++channels_[key.channel].only[side];
  if (options_.common) return;
  std::string told;
  for (const auto& [key, digest] : waiting_[side]) {
    const ChannelDiff& channel = channels_[key.channel];
    // A channel that the other log does not have at all takes one line.
    const bool whole = channel.compared == 0 && channel.only[1 - side] == 0;
    if (whole && key.channel == told) continue;
    told = key.channel;
    const std::string text = side == 0 ? "only in A" : "only in B";
    AddDifference(
        key, whole ? text + fmt::format(", as all {} of this channel", channel.only[side]) : text);
  }
}

void LogDiff::Take(size_t side) {
  const EventStream& stream = streams_[side];
  auto& counterparts = waiting_[1 - side];
  const auto counterpart = counterparts.find(stream.key());
  if (counterpart == counterparts.end()) {
    waiting_[side].emplace(stream.key(), stream.digest());
    return;
  }
  CompareWith(side, counterpart->second);
  counterparts.erase(counterpart);
}

void LogDiff::CompareWith(size_t side, const EventDigest& other) {
  const EventKey& key = streams_[side].key();
  const EventDigest& digest = streams_[side].digest();
  ChannelDiff& channel = channels_[key.channel];
  ++channel.compared;
  if (digest.SameBytes(other)) {
    ++channel.equal;
    if (options_.all) Print(FrameText(key) + ": equal");
    return;
  }
  const std::array<int64_t, 2> offsets =
      side == 0 ? std::array{digest.offset, other.offset} : std::array{other.offset, digest.offset};
  const MessageDiff diff =
      Compare(fetchers_[0].Fetch(offsets[0]).data, fetchers_[1].Fetch(offsets[1]).data);
  if (diff.equal) {
    ++channel.equal;
    ++channel.encoded_differently;
    if (options_.all) Print(FrameText(key) + ": equal, but encoded differently");
    return;
  }
  ++channel.different;
  if (diff.disparity) {
    ++channel.maps;
    AddSums(channel, *diff.disparity);
  }
  AddDifference(key, diff.text);
  if (options_.images.empty() || (!options_.all && differences_ > kShownDifferences)) return;
  WriteDifferencePictures(fetchers_[0].Fetch(offsets[0]).data, fetchers_[1].Fetch(offsets[1]).data,
                          key.channel, names_);
}

void LogDiff::AddSums(ChannelDiff& channel, const DisparityDiff& diff) const {
  DisparityDiff& sum = channel.disparity;
  sum.pixels += diff.pixels;
  sum.differing += diff.differing;
  sum.changed += diff.changed;
  sum.newly_valid += diff.newly_valid;
  sum.newly_invalid += diff.newly_invalid;
  sum.sum_px += diff.sum_px;
  sum.max_px = std::max(sum.max_px, diff.max_px);
}

void LogDiff::AddDifference(const EventKey& key, const std::string& text) {
  ++differences_;
  if (options_.all || differences_ <= kShownDifferences) {
    Print(FrameText(key) + ": " + text);
  } else if (differences_ == kShownDifferences + 1) {
    Print("... (--all shows every frame)");
  }
  if (!first_ || OrderOf(key) < OrderOf(first_->key)) first_ = Difference{key, text};
}

void LogDiff::Print(const std::string& line) {
  progress_.Clear();
  PrintLine(line);
}

std::string LogDiff::Report() const {
  size_t width = 7;
  for (const auto& [name, channel] : channels_) width = std::max(width, name.size());
  std::string text = fmt::format("{:<{}} {:>9} {:>9} {:>10} {:>10} {:>10}\n", "channel", width,
                                 "compared", "equal", "different", "only in A", "only in B");
  std::string remarks;
  for (const auto& [name, channel] : channels_) {
    text += fmt::format("{:<{}} {:>9} {:>9} {:>10} {:>10} {:>10}\n", name, width, channel.compared,
                        channel.equal, channel.different, channel.only[0], channel.only[1]);
    if (channel.encoded_differently > 0) {
      remarks += fmt::format("{}: {} of the equal ones are encoded differently\n", name,
                             channel.encoded_differently);
    }
    if (channel.maps == 0) continue;
    const DisparityDiff& sum = channel.disparity;
    remarks += fmt::format(
        "{}: in the {} maps that differ, {:.3f} % of the pixels do: {} changed (mean {:.3f} px, "
        "max {:.3f} px), {} newly valid, {} newly invalid\n",
        name, channel.maps,
        100 * static_cast<double>(sum.differing) / static_cast<double>(sum.pixels), sum.changed,
        sum.mean_px(), sum.max_px, sum.newly_valid, sum.newly_invalid);
  }
  for (const size_t side : {size_t{0}, size_t{1}}) {
    if (streams_[side].repeated() == 0) continue;
    remarks += fmt::format("in {}, repeated messages with the same bytes, counted once: {}\n",
                           side == 0 ? "A" : "B", streams_[side].repeated());
  }
  remarks += ConfigDiffText(streams_[0].processes(), streams_[1].processes());
  if (names_.files() > 0) {
    remarks += fmt::format("{}: {} pictures{}\n", Printable(options_.images.string()),
                           names_.files(), names_.OthersText());
  }
  text += remarks.empty() ? "" : "\n" + remarks;
  if (IsEqual()) return text + (options_.common ? "equal in what both have\n" : "equal\n");
  // A recording and the replay of one of its stages have different channels, and equal shared ones.
  const bool shared_is_equal = HasShared() && IsSharedEqual();
  return text + "first difference: " + Printable(FrameText(first_->key) + ": " + first_->text) +
         "\n" + "different" +
         (shared_is_equal ? ", but equal in what both have (--common)\n" : "\n");
}

bool LogDiff::IsSharedEqual() const {
  return std::all_of(channels_.begin(), channels_.end(),
                     [](const auto& entry) { return entry.second.different == 0; });
}

bool LogDiff::HasShared() const {
  return std::any_of(channels_.begin(), channels_.end(),
                     [](const auto& entry) { return entry.second.compared > 0; });
}

bool LogDiff::IsEqual() const { return options_.common ? IsSharedEqual() : !first_; }

bool LogDiff::HasAnything() const {
  return options_.common ? HasShared() : streams_[0].events() + streams_[1].events() > 0;
}

std::string LogDiff::Absent() const {
  const auto absent = std::ranges::find_if(options_.channels, [&](const std::string& name) {
    return !channels_.contains(options_.prefix + name);
  });
  return absent == options_.channels.end() ? "" : *absent;
}

void LogDiff::Warn() {
  progress_.Clear();
  WarnOfDamage(options_.a, streams_[0].reader().damage());
  WarnOfDamage(options_.b, streams_[1].reader().damage());
}

int RunDiff(const DiffOptions& options) {
  LogDiff diff(options);
  diff.Run();
  if (!diff.HasAnything()) {
    throw LogError(options.a, std::string("nothing to compare: ") +
                                  (options.common ? "no event on these channels is in both logs"
                                                  : "neither log has an event on these channels"));
  }
  if (const std::string absent = diff.Absent(); !absent.empty()) {
    throw LogError(options.a, "--channels " + absent + ": neither log has an event on it");
  }
  diff.Warn();
  std::cout << diff.Report();
  return diff.IsEqual() ? 0 : 1;
}

}  // namespace

void AddDiff(Flags& program) {
  const auto options = std::make_shared<DiffOptions>();
  Flags& flags = program.AddCommand(
      "diff",
      "Compares two logs frame by frame: messages are matched by channel and header\n"
      "(utime, seq). Exit code 0 equal, 1 different, 2 unusable",
      [options] { return RunDiff(*options); });
  flags.SetFooter(R"(
Messages with the same bytes are equal; so are messages that decode to the same values, such as a
map sent raw and compressed, with a remark. Calibrations are matched by rig_id. A message repeated
with the same bytes counts once. Statuses, which depend on clock and machine, SPROUT_PROCESS and
LCM's own channels are compared only when named by --channels; configurations that differ are shown, but are no difference of the answers.)");
  flags.Add("A", options->a, "Log, such as a recorded one").Required();
  flags.Add("B", options->b, "Log, such as a replayed one").Required();
  AddChannels(flags, options->channels);
  AddPrefix(flags, options->prefix);
  flags.Add(
      "--common", options->common,
      "Messages in only one log are no difference: a live run skips frames that a replay does not");
  flags.Add("--all", options->all, "A line for every frame, also for equal ones");
  flags.Add("--images DIR", options->images,
            "Write pictures of A, B and their difference, of the maps and images that differ; "
            "without --all of the first 10");
}

}  // namespace sprout::log
