#include "services/tools/evaluate/log_evaluation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/config/config_error.h"
#include "common/scenes/same_picture.h"
#include "services/tools/evaluate/scene.h"
#include "services/tools/evaluate/tables.h"
#include "services/tools/evaluate/truth_check.h"

namespace sprout::evaluate {
namespace {

constexpr const char* kFinalMap = "disparity";

// The figures of a frame with ground truth, as they are called in files.
std::vector<std::pair<const char*, double>> TruthFigures(const Accuracy& score) {
  return {{"scored", static_cast<double>(score.scored)},
          {"correct_le1", score.correct_le1_percent()},
          {"bad2", score.bad2_percent()},
          {"density", score.density_percent()},
          {"mean_abs_px", score.mean_abs_px()}};
}

void AddTo(Accuracy& sum, const Accuracy& one) {
  sum.scored += one.scored;
  sum.with_disparity += one.with_disparity;
  sum.within_half += one.within_half;
  sum.within_1 += one.within_1;
  sum.below_1 += one.below_1;
  sum.within_2 += one.within_2;
  sum.within_4 += one.within_4;
  sum.within_d1 += one.within_d1;
  sum.sum_abs_px += one.sum_abs_px;
  sum.sum_squares_px2 += one.sum_squares_px2;
}

}  // namespace

LogEvaluation::Row LogEvaluation::Evaluate(const Frame& frame) {
  Row row{.quality = QualityOf(frame), .maps = {}};
  if (truth_ == nullptr || !frame.disparity || frame.id.seq < 0) return row;
  const std::optional<int64_t> count = truth_->frame_count();
  const scenes::DatasetFrame captured = truth_->Get(count ? frame.id.seq % *count : frame.id.seq);
  const scenes::GroundTruth& truth = captured.truth;
  if (truth.left.empty()) return row;
  if (rows_.empty()) wrong_truth_ = WrongTruthText(captured, truth_->rig().pair);
  const cv::Mat1b seen = VisibilityOf(truth).nonoccluded;
  const auto score = [&](const char* name, const DisparityImage& map) {
    const Result<Accuracy> accuracy = Score(map, truth.left, seen);
    if (!accuracy) {
      throw ConfigError(fmt::format("--truth: frame {}, {}", frame.id.seq, accuracy.error().text));
    }
    row.maps[name] = *accuracy;
  };
  if (frame.prior) score("prior", frame.prior->disparity);
  if (frame.unfilled) score("unfilled", *frame.unfilled);
  score(kFinalMap, *frame.disparity);
  if (!frame.left.empty() && !scenes::IsSamePicture(frame.left, captured.left)) {
    throw ConfigError(fmt::format(
        "--truth: frame {} of the log is another picture than that of the source; allowed: the "
        "source that the log was captured from",
        frame.id.seq));
  }
  return row;
}

void LogEvaluation::Add(const Frame& frame) {
  Row row = Evaluate(frame);
  const auto [known, added] = rows_.try_emplace({frame.id.utime, frame.id.seq});
  if (added || CountKnown(row.quality) >= CountKnown(known->second.quality)) {
    known->second = std::move(row);
  }
}

int64_t LogEvaluation::answered() const {
  return std::ranges::count_if(
      rows_, [](const auto& entry) { return entry.second.quality.valid_share.has_value(); });
}

std::string LogEvaluation::Table() const {
  std::map<std::string, Accuracy> sums;
  int64_t with_truth = 0;
  for (const auto& [key, row] : rows_) {
    with_truth += row.maps.empty() ? 0 : 1;
    for (const auto& [name, accuracy] : row.maps) AddTo(sums[name], accuracy);
  }
  std::string text = fmt::format("{} frames, {} with a disparity map, {} with ground truth\n\n",
                                 rows_.size(), answered(), with_truth);
  if (with_truth > 0) {
    std::vector<std::vector<std::string>> maps = {
        {"map", "<= 1 px %", "< 1 px %", "bad 2 %", "density %", "mean px"}};
    for (const auto& [name, sum] : sums) {
      maps.push_back({name, fmt::format("{:.2f}", sum.correct_le1_percent()),
                      fmt::format("{:.2f}", sum.correct_lt1_percent()),
                      fmt::format("{:.2f}", sum.bad2_percent()),
                      fmt::format("{:.2f}", sum.density_percent()),
                      fmt::format("{:.3f}", sum.mean_abs_px())});
    }
    text += MarkdownTable(maps) + "\n";
  }
  std::vector<std::vector<std::string>> qualities = {{"quality", "mean", "worst", "in frame"}};
  for (const QualityColumn& column : QualityColumns()) {
    double sum = 0;
    int64_t count = 0;
    std::optional<double> worst;
    int64_t worst_seq = 0;
    for (const auto& [key, row] : rows_) {
      const auto value = column.value(row.quality);
      if (!value) continue;
      sum += *value;
      ++count;
      if (worst && (column.more_is_better ? *value >= *worst : *value <= *worst)) continue;
      worst = value;
      worst_seq = key.second;
    }
    if (!worst) continue;
    qualities.push_back({std::string(column.name),
                         fmt::format("{:.{}f}", sum / static_cast<double>(count), column.decimals),
                         fmt::format("{:.{}f}", *worst, column.decimals),
                         std::to_string(worst_seq)});
  }
  text += MarkdownTable(qualities);
  // The score (Q2) counts an unknown misfit as a perfect one.
  const auto without_images = std::ranges::count_if(rows_, [](const auto& entry) {
    return entry.second.quality.valid_share > 0.0 && !entry.second.quality.misfit;
  });
  if (without_images == 0) return text;
  return text + fmt::format(
                    "\n{} of {} frames have no images that fit the map, so no misfit: their "
                    "scores are higher, and comparable among themselves alone\n",
                    without_images, rows_.size());
}

std::string LogEvaluation::Csv() const {
  std::string text = "seq,utime" + QualityCsvHead();
  for (const auto& [name, unused] : TruthFigures({})) text += fmt::format(",{}", name);
  text += "\n";
  for (const auto& [key, row] : rows_) {
    text += fmt::format("{},{}{}", key.second, key.first, QualityCsvCells(row.quality));
    const auto map = row.maps.find(kFinalMap);
    for (const auto& [name, value] :
         TruthFigures(map == row.maps.end() ? Accuracy() : map->second)) {
      const bool known = map != row.maps.end() && !std::isnan(value);
      text += known ? fmt::format(",{}", value) : ",";
    }
    text += "\n";
  }
  return text;
}

std::string LogEvaluation::Json() const {
  using OrderedJson = nlohmann::ordered_json;
  OrderedJson frames = OrderedJson::array();
  for (const auto& [key, row] : rows_) {
    OrderedJson frame = {{"seq", key.second}, {"utime", key.first}};
    for (const QualityColumn& column : QualityColumns()) {
      const auto value = column.value(row.quality);
      frame[std::string(column.name)] = value ? OrderedJson(*value) : OrderedJson(nullptr);
    }
    OrderedJson maps = OrderedJson::object();
    for (const auto& [name, accuracy] : row.maps) {
      for (const auto& [figure, value] : TruthFigures(accuracy)) maps[name][figure] = value;
    }
    frame["maps"] = std::move(maps);
    frames.push_back(std::move(frame));
  }
  return OrderedJson{{"frames", std::move(frames)}}.dump(2) + "\n";
}

}  // namespace sprout::evaluate
