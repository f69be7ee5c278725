#include "services/tools/batch/measures.h"

#include <algorithm>
#include <set>

#include "common/core/disparity_diff.h"
#include "common/frames/log_frames.h"
#include "common/measure/frame_quality.h"

namespace sprout::batch {
namespace {

constexpr int kMisfitOneIn = 8;  // one band of rows in 8; all would take 10 ms a frame

// The cells of kFrameColumns. In a comparison the position of the left image is not known.
std::vector<Cell> RowStart(const FrameId& id, std::optional<int64_t> left_at = {}) {
  return {static_cast<double>(id.seq), static_cast<double>(id.utime),
          left_at ? Cell(static_cast<double>(*left_at)) : std::nullopt};
}

// The frames that any of the two has, those of A in their order first.
std::vector<FrameId> AllFrames(const FrameLookup& a, const FrameLookup& b, Part map) {
  std::vector<FrameId> frames = a.FramesWith(map);
  std::set<std::pair<int64_t, int64_t>> seen;
  for (const FrameId& id : frames) seen.emplace(id.utime, id.seq);
  for (const FrameId& id : b.FramesWith(map)) {
    if (!seen.contains({id.utime, id.seq})) frames.push_back(id);
  }
  return frames;
}

std::optional<DisparityImage> MapOf(FrameLookup& frames, const FrameId& id, Part map) {
  const Frame frame = frames.Get(id, {map});
  return map == Part::kFused ? frame.fused : frame.disparity;
}

// The cells for ComparisonColumns().
std::vector<Cell> CellsOf(const DisparityDiff& diff) {
  const auto share = [&](int64_t count) {
    return static_cast<double>(count) / static_cast<double>(diff.pixels);
  };
  const int64_t in_one = diff.newly_valid + diff.newly_invalid;
  return {share(diff.differing), share(diff.moved + in_one), diff.mean_px(),
          diff.max_px,           share(diff.newly_valid),    share(diff.newly_invalid)};
}

}  // namespace

void FrameLookup::Add(const std::filesystem::path& log, const PartSet& parts) {
  const FrameChoice choice{.prefix = prefix_, .parts = parts, .look_back = FrameChoice::kWholeLog};
  FrameIndex& index = logs_.emplace_back(log, choice).index;
  LogReader reader(log);
  for (LogEvent event; reader.Next(event);) index.Add(event);
}

std::vector<FrameId> FrameLookup::FramesWith(Part part) const {
  std::vector<FrameId> frames;
  std::set<FrameId> seen;
  for (const Log& log : logs_) {
    for (const IndexedFrame& frame : log.index.frames()) {
      if (frame.Has(part) && seen.insert(frame.id).second) frames.push_back(frame.id);
    }
  }
  return frames;
}

std::optional<int64_t> FrameLookup::PlaceOf(const FrameId& id, Part part) const {
  for (const Log& log : logs_) {
    const IndexedFrame* const places = log.index.Find(id);
    if (places != nullptr && places->Has(part)) return places->offset(part);
  }
  return std::nullopt;
}

Frame FrameLookup::Get(const FrameId& id, const PartSet& parts) {
  Frame frame;
  frame.id = id;
  for (Log& log : logs_) {
    const IndexedFrame* const places = log.index.Find(id);
    if (places == nullptr) continue;
    for (auto& [part, value] : FetchParts(log.fetcher, *places, parts)) {
      SetPart(frame, part, std::move(value));
    }
  }
  return frame;
}

std::vector<std::string> MeasureColumns() {
  std::vector<std::string> columns;
  for (const QualityColumn& column : QualityColumns()) columns.emplace_back(column.name);
  return columns;
}

std::vector<std::string> ComparisonColumns() {
  return {"changed", "moved", "mean_change_px", "max_change_px", "appeared", "vanished"};
}

const PartSet& MeasuredParts() {
  static const PartSet kParts{Part::kLeft,           Part::kRight,      Part::kSeeds,
                              Part::kDisparity,      Part::kConfidence, Part::kFused,
                              Part::kFusedConfidence};
  return kParts;
}

Table MeasureFrames(FrameLookup& frames, Part answer) {
  Table table = Table::Of(MeasureColumns());
  for (const FrameId& id : frames.FramesWith(answer)) {
    std::vector<Cell>& row = table.rows.emplace_back(RowStart(id, frames.PlaceOf(id, Part::kLeft)));
    Frame frame = frames.Get(id, MeasuredParts());
    if (answer == Part::kFused) {
      frame.disparity = std::move(frame.fused);
      frame.confidence = frame.fused_confidence;
    }
    const FrameQuality quality = QualityOf(frame, kMisfitOneIn);
    for (const QualityColumn& column : QualityColumns()) row.push_back(column.value(quality));
  }
  return table;
}

Table CompareFrames(FrameLookup& a, FrameLookup& b, Part map) {
  Table table = Table::Of(ComparisonColumns());
  for (const FrameId& id : AllFrames(a, b, map)) {
    const std::optional<DisparityImage> map_a = MapOf(a, id, map);
    const std::optional<DisparityImage> map_b = MapOf(b, id, map);
    std::vector<Cell>& row = table.rows.emplace_back(RowStart(id));
    row.resize(table.columns.size());
    if (map_a && map_b && !map_a->empty() && map_a->size() == map_b->size()) {
      std::ranges::copy(CellsOf(Compare(*map_a, *map_b)), row.begin() + kFrameCells);
    }
  }
  return table;
}

}  // namespace sprout::batch
