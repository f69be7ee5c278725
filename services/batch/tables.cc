#include "services/batch/tables.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <utility>

#include "common/core/disparity_diff.h"
#include "common/logfile/log_error.h"
#include "common/quality/frame_quality.h"
#include "common/quality/score.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

const PartSet kMeasured{Part::kLeft,       Part::kRight, Part::kSeeds,          Part::kDisparity,
                        Part::kConfidence, Part::kFused, Part::kFusedConfidence};

constexpr int kMisfitOneIn = 8;  // bands of rows; all would take 10 ms a frame

using Cell = std::optional<double>;

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

Cell ParseCell(const std::filesystem::path& path, const std::string& text) {
  if (text.empty()) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw LogError(path, "'" + text + "' is no finite number");
  }
  return value;
}

std::vector<Cell> RowStart(const FrameId& id) {
  return {static_cast<double>(id.seq), static_cast<double>(id.utime)};
}

// The frames that any of the two has, those of A in their order first.
std::vector<FrameId> AllFrames(const FrameLookup& a, const FrameLookup* b, Part map) {
  std::vector<FrameId> frames = a.FramesWith(map);
  if (b == nullptr) return frames;
  std::set<std::pair<int64_t, int64_t>> seen;
  for (const FrameId& id : frames) seen.emplace(id.utime, id.seq);
  for (const FrameId& id : b->FramesWith(map)) {
    if (!seen.contains({id.utime, id.seq})) frames.push_back(id);
  }
  return frames;
}

std::optional<DisparityImage> MapOf(FrameLookup& frames, const FrameId& id, Part map) {
  const Frame frame = frames.Get(id, {map});
  return map == Part::kFused ? frame.fused : frame.disparity;
}

std::vector<std::string> WithFrame(const std::vector<std::string>& columns) {
  std::vector<std::string> all = {"seq", "utime"};
  all.insert(all.end(), columns.begin(), columns.end());
  return all;
}

// As ComparisonColumns() begins.
std::vector<Cell> CellsOf(const DisparityDiff& diff) {
  const auto share = [&](int64_t count) {
    return static_cast<double>(count) / static_cast<double>(diff.pixels);
  };
  const int64_t in_one = diff.newly_valid + diff.newly_invalid;
  return {share(diff.differing), share(diff.moved + in_one), diff.mean_px(),
          diff.max_px,           share(diff.newly_valid),    share(diff.newly_invalid)};
}

// Share of the pixels with a true disparity where the map is off by more than 1 px or has none.
Cell BadShare(const DisparityImage& map, const cv::Mat1f& truth_px) {
  const Result<Accuracy> accuracy = Score(map, truth_px, cv::Mat1b(truth_px.size(), uchar{255}));
  if (!accuracy || accuracy->scored == 0) return std::nullopt;
  return 1 - accuracy->correct_le1_percent() / 100;
}

}  // namespace

std::vector<std::string> MeasureColumns() {
  std::vector<std::string> columns;
  for (const QualityColumn& column : QualityColumns()) columns.emplace_back(column.name);
  return columns;
}

std::vector<std::string> ComparisonColumns() {
  return {"changed",  "moved",    "mean_change_px", "max_change_px",
          "appeared", "vanished", "a_bad1",         "b_bad1"};
}

std::optional<size_t> Table::Find(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<size_t>(found - columns.begin());
}

std::string TableHead(const Table& table) {
  std::string line;
  for (const std::string& column : table.columns) line += (line.empty() ? "" : ",") + column;
  return line + "\n";
}

std::string TableRow(const std::vector<Cell>& row) {
  std::string line;
  for (size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += ',';
    if (!row[i]) continue;
    // Whole numbers without an exponent: utime and seq are exact up to 2^53.
    line += *row[i] == std::floor(*row[i]) && std::abs(*row[i]) < 1e15 * 8
                ? fmt::format("{:.0f}", *row[i])
                : fmt::format("{:.6g}", *row[i]);
  }
  return line + "\n";
}

void WriteTable(const std::filesystem::path& path, const Table& table) {
  OutputFile file(path);
  file.Write(TableHead(table));
  for (const auto& row : table.rows) file.Write(TableRow(row));
  CommitFile(path, file);
}

Table ReadTable(const std::filesystem::path& path, const std::vector<std::string>& columns) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) throw LogError(path, "cannot be read");
  Table table{.columns = Split(line), .rows = {}};
  if (table.columns != WithFrame(columns)) throw LogError(path, "has other columns");
  while (std::getline(file, line)) {
    std::vector<Cell>& row = table.rows.emplace_back();
    for (const std::string& cell : Split(line)) row.push_back(ParseCell(path, cell));
    if (row.size() != table.columns.size()) throw LogError(path, "a row has missing cells");
    if (!row[0] || !row[1]) throw LogError(path, "a row has no seq or utime");
  }
  return table;
}

bool IsMeasured(const PartSet& parts, Part answer) {
  return std::any_of(kAllParts.begin(), kAllParts.end(), [&](Part part) {
    return parts.Has(part) && (part == answer || kMeasured.Has(part));
  });
}

Table MeasureFrames(FrameLookup& frames, Part answer) {
  Table table{.columns = WithFrame(MeasureColumns()), .rows = {}};
  for (const FrameId& id : frames.FramesWith(answer)) {
    Frame frame = frames.Get(id, kMeasured);
    if (answer == Part::kFused) {
      frame.disparity = std::move(frame.fused);
      frame.confidence = frame.fused_confidence;
    }
    const FrameQuality quality = QualityOf(frame, kMisfitOneIn);
    std::vector<Cell>& row = table.rows.emplace_back(RowStart(id));
    for (const QualityColumn& column : QualityColumns()) row.push_back(column.value(quality));
  }
  return table;
}

Table ListFrames(const FrameLookup& frames, Part answer) {
  Table table{.columns = WithFrame(MeasureColumns()), .rows = {}};
  for (const FrameId& id : frames.FramesWith(answer)) {
    table.rows.emplace_back(RowStart(id)).resize(table.columns.size());
  }
  return table;
}

Table CompareFrames(FrameLookup& a, FrameLookup* b, Part map, const std::filesystem::path& truth) {
  Table table{.columns = WithFrame(ComparisonColumns()), .rows = {}};
  for (const FrameId& id : AllFrames(a, b, map)) {
    const std::optional<DisparityImage> map_a = MapOf(a, id, map);
    std::optional<DisparityImage> map_b;
    if (b != nullptr) map_b = MapOf(*b, id, map);
    std::vector<Cell>& row = table.rows.emplace_back(RowStart(id));
    row.resize(table.columns.size());
    if (map_a && map_b && !map_a->empty() && map_a->size() == map_b->size()) {
      const std::vector<Cell> cells = CellsOf(Compare(*map_a, *map_b));
      std::copy(cells.begin(), cells.end(), row.begin() + 2);
    }
    if (truth.empty()) continue;
    const auto file = truth / fmt::format("{:06}_disparity.pfm", id.seq);
    const cv::Mat truth_px = cv::imread(file, cv::IMREAD_UNCHANGED);
    if (truth_px.type() != CV_32FC1) continue;
    if (map_a) row[8] = BadShare(*map_a, truth_px);
    if (map_b) row[9] = BadShare(*map_b, truth_px);
  }
  return table;
}

}  // namespace sprout::batch
