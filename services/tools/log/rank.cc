#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/config/config_error.h"
#include "common/core/joined.h"
#include "common/logfile/log_error.h"
#include "common/measure/frame_quality.h"
#include "common/picture/frame_pictures.h"
#include "services/tools/log/commands.h"
#include "services/tools/log/log_frames.h"
#include "services/tools/log/print_line.h"

namespace sprout::log {
namespace {

// The folder is for the pictures of the worst frames.
struct RankOptions : PicturesOptions {
  std::string by = "score";
  int top = 0;  // 0: kShown in the table and as pictures, all in files
  bool csv = false;
  bool json = false;
};

// What the table shows without --top; files have all frames.
constexpr int kShown = 20;

// Several frames may have one number: capture began anew.
using Key = std::pair<int64_t, int64_t>;  // utime, seq

struct Row {
  Key key;
  FrameQuality quality;
};

const QualityColumn& ColumnToRankBy(const std::string& name) {
  if (const QualityColumn* const column = FindQualityColumn(name)) return *column;
  throw ConfigError("--by " + name +
                    ": allowed: " + Joined(", ", QualityColumns(), &QualityColumn::name));
}

class Ranking {
 public:
  explicit Ranking(const RankOptions& options)
      : options_(options), by_(ColumnToRankBy(options.by)) {}

  void Read();
  std::string Table() const;
  std::string Csv() const;
  std::string Json() const;
  void WritePictures() const;

 private:
  void Sort();
  size_t CountShown(int otherwise) const;

  const RankOptions& options_;
  const QualityColumn& by_;
  int64_t without_images_ = 0;  // frames that have a map, but no images
  std::vector<Row> rows_;       // worst first, then those that are not ranked
  size_t ranked_ = 0;
};

void Ranking::Read() {
  std::map<Key, FrameQuality> qualities;
  const PartSet parts = {Part::kLeft, Part::kRight, Part::kSeeds, Part::kDisparity,
                         Part::kConfidence};
  const std::string complaint = ReadFrames(options_, parts, [&](const Frame& frame) {
    const FrameQuality quality = QualityOf(frame);
    const auto [known, added] = qualities.emplace(Key{frame.id.utime, frame.id.seq}, quality);
    // A part that was recorded twice makes a second frame of that number: the fuller one counts.
    if (!added && CountKnown(quality) >= CountKnown(known->second)) known->second = quality;
  });
  for (const auto& [key, quality] : qualities) {
    rows_.push_back({key, quality});
    without_images_ += quality.valid_share > 0.0 && !quality.misfit ? 1 : 0;
  }
  Sort();
  if (ranked_ == 0) {
    throw LogError(options_.file, fmt::format("no frame with a {}: allowed is a log with the "
                                              "answers of the stages, such as SPROUT_DISPARITY{}",
                                              by_.name, complaint.empty() ? "" : "; " + complaint));
  }
  if (!complaint.empty()) PrintWarning(complaint);
  if (without_images_ == 0) return;
  // The score (Q2) counts an unknown misfit as a perfect one.
  PrintWarning(fmt::format(
      "{} of {} frames have no images that fit the map, so no misfit: their scores are higher, and "
      "comparable among themselves alone; `sprout-log merge` adds the images of a recording",
      without_images_, ranked_));
}

void Ranking::Sort() {
  const auto unranked = std::stable_partition(rows_.begin(), rows_.end(), [&](const Row& row) {
    return by_.value(row.quality).has_value();
  });
  ranked_ = static_cast<size_t>(unranked - rows_.begin());
  std::stable_sort(rows_.begin(), unranked, [&](const Row& a, const Row& b) {
    const double value_a = *by_.value(a.quality);
    const double value_b = *by_.value(b.quality);
    return by_.more_is_better ? value_a < value_b : value_a > value_b;
  });
}

size_t Ranking::CountShown(int otherwise) const {
  const int top = options_.top > 0 ? options_.top : otherwise;
  return std::min(ranked_, static_cast<size_t>(top));
}

std::string Ranking::Table() const {
  const size_t shown = CountShown(kShown);
  int64_t first_utime = rows_.front().key.first;
  for (const Row& row : rows_) first_utime = std::min(first_utime, row.key.first);
  std::string text = fmt::format("{:>8} {:>9}", "frame", "s");
  for (const QualityColumn& column : QualityColumns()) text += fmt::format("  {:>8}", column.name);
  text += "\n";
  for (const Row& row : std::span(rows_).first(shown)) {
    text += fmt::format("{:>8} {:>9.3f}", row.key.second,
                        static_cast<double>(row.key.first - first_utime) / 1e6);
    for (const QualityColumn& column : QualityColumns()) {
      text += fmt::format("  {:>{}}", QualityText(column, row.quality),
                          std::max<size_t>(8, column.name.size()));
    }
    text += "\n";
  }
  if (shown < ranked_) {
    text += fmt::format("... of {} frames, the worst by {} first (--top N shows more)\n", ranked_,
                        by_.name);
  }
  if (ranked_ < rows_.size()) {
    text += fmt::format("not ranked, without a {}: {} frames\n", by_.name, rows_.size() - ranked_);
  }
  return text;
}

std::string Ranking::Csv() const {
  std::string text = "seq,utime" + QualityCsvHead() + "\n";
  const size_t shown = options_.top > 0 ? CountShown(kShown) : rows_.size();
  for (const Row& row : std::span(rows_).first(shown)) {
    text += fmt::format("{},{}{}\n", row.key.second, row.key.first, QualityCsvCells(row.quality));
  }
  return text;
}

std::string Ranking::Json() const {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  const size_t shown = options_.top > 0 ? CountShown(kShown) : rows_.size();
  for (const Row& row : std::span(rows_).first(shown)) {
    nlohmann::ordered_json frame = {{"seq", row.key.second}, {"utime", row.key.first}};
    for (const QualityColumn& column : QualityColumns()) {
      const auto value = column.value(row.quality);
      auto& field = frame[std::string(column.name)];
      if (value) field = *value;
      if (value && column.decimals == 0) field = static_cast<int64_t>(*value);
    }
    frames.push_back(std::move(frame));
  }
  const nlohmann::ordered_json json = {
      {"file", options_.file.string()}, {"by", by_.name}, {"frames", std::move(frames)}};
  // Paths may hold any bytes; JSON may not.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void Ranking::WritePictures() const {
  std::set<Key> worst;
  for (const Row& row : std::span(rows_).first(CountShown(kShown))) worst.insert(row.key);
  FrameFileNames names(options_.folder);
  ReadFrames(options_, AllParts(), [&](const Frame& frame) {
    if (worst.contains({frame.id.utime, frame.id.seq}))
      WriteFramePictures(frame, {}, names.For(frame.id));
  });
  PrintWarning(fmt::format("{}: {} pictures of the {} worst frames{}", options_.folder.string(),
                           names.files(), names.frames(), names.OthersText()));
}

int RunRank(const RankOptions& options) {
  Ranking ranking(options);
  ranking.Read();
  if (!options.folder.empty()) ranking.WritePictures();
  std::cout << (options.csv ? ranking.Csv() : options.json ? ranking.Json() : ranking.Table());
  return 0;
}

}  // namespace

void AddRank(Flags& program) {
  const auto options = std::make_shared<RankOptions>();
  Flags& flags = program.AddCommand(
      "rank",
      "Lists the frames of a log, the worst first, by figures that need no ground truth. The log "
      "must\nhave the images and the answers: `sprout-log merge` combines a recording and a replay",
      [options] { return RunRank(*options); });
  flags.Add("LOG", options->file, "Log").Required();
  flags
      .Add("--top N", options->top,
           "Only the N worst frames. Without it the table and --images have 20, --csv and "
           "--json all of the log")
      .WithinWhole(1, 1'000'000);
  flags.Add("--by COLUMN", options->by, "What to rank by, a column below").ShowDefault();
  Flag csv = flags.Add("--csv", options->csv, "For spreadsheets, all digits");
  flags.Add("--json", options->json, "For programs, all digits").Excludes(csv);
  flags.Add("--images DIR", options->folder, "Write the pictures of the worst frames");
  AddFrames(flags, options->frames);
  AddPrefix(flags, options->prefix);
  std::string columns = "Columns\n";
  for (const QualityColumn& column : QualityColumns()) {
    columns += fmt::format("  {:<14}{}\n", column.name, column.meaning);
  }
  flags.SetFooter(columns);
}

}  // namespace sprout::log
