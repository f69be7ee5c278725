#include "services/tools/evaluate/tables.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

namespace sprout::evaluate {
namespace {

using Row = std::vector<std::string>;

constexpr const char* kPaperScenes[] = {"Lampshade1", "Monopoly", "Plastic"};

struct PublishedRow {
  const char* method;
  double percent[std::size(kPaperScenes)];
};

// Gandhi, Čech, Horaud: "High-Resolution Depth Maps Based on TOF-Stereo Fusion", ICRA 2012, III-A:
// the evaluation on Middlebury 2006, full size.
constexpr PublishedRow kPaperRows[] = {
    {"mncc-harris", {61.5, 51.2, 25.2}},   {"mncc-tof", {64.3, 53.4, 28.2}},
    {"expssd-harris", {44.9, 29.4, 13.5}}, {"expssd-tof", {49.5, 32.1, 20.6}},
    {"epc", {88.8, 85.2, 88.7}},           {"epc-filled", {96.4, 95.3, 98.2}},
    {"prior", {92.9, 92.1, 96.0}},
};

// What the paper reports for a method of this name on a scene of this name: per cent of
// non-occluded pixels with an error <= 1 px, the ToF camera simulated by every 10th pixel of the
// truth.
std::optional<double> PaperPercent(const std::string& scene, const std::string& method) {
  for (const PublishedRow& row : kPaperRows) {
    for (size_t i = 0; i < std::size(kPaperScenes); ++i) {
      if (method == row.method && scene == kPaperScenes[i]) return row.percent[i];
    }
  }
  return std::nullopt;
}

std::string Fixed(double number, int digits) { return fmt::format("{:.{}f}", number, digits); }

// Milliseconds; "-" for a stage that a method does not have.
std::string Milliseconds(double ms) { return ms == 0 ? "-" : Fixed(ms, 1); }

// Whether ToF points are near some of the pixels, but not all.
bool HasAway(const SceneResult& scene) {
  const MethodResult& any = scene.methods.front();
  return any.away.scored > 0 && any.away.scored < any.all.scored;
}

// A column of a scene's table.
struct TableColumn {
  const char* head;
  bool is_wide;  // only in the wide table
  bool is_away;  // only where ToF points are near some of the pixels, but not all
  std::string (*cell)(const MethodResult& method);
};

constexpr TableColumn kTableColumns[] = {
    {"<= 1 px %", false, false,
     [](const auto& m) { return Fixed(m.nonoccluded.correct_le1_percent(), 2); }},
    {"< 1 px %", false, false,
     [](const auto& m) { return Fixed(m.nonoccluded.correct_lt1_percent(), 2); }},
    {"bad 0.5 %", true, false,
     [](const auto& m) { return Fixed(m.nonoccluded.bad05_percent(), 2); }},
    {"bad 2 %", false, false, [](const auto& m) { return Fixed(m.nonoccluded.bad2_percent(), 2); }},
    {"bad 4 %", true, false, [](const auto& m) { return Fixed(m.nonoccluded.bad4_percent(), 2); }},
    {"D1 %", true, false, [](const auto& m) { return Fixed(m.nonoccluded.d1_percent(), 2); }},
    {"density %", false, false,
     [](const auto& m) { return Fixed(m.nonoccluded.density_percent(), 2); }},
    {"invalid %", true, false,
     [](const auto& m) { return Fixed(m.nonoccluded.invalid_percent(), 2); }},
    {"mean px", false, false, [](const auto& m) { return Fixed(m.nonoccluded.mean_abs_px(), 3); }},
    {"rms px", true, false, [](const auto& m) { return Fixed(m.nonoccluded.rms_px(), 3); }},
    {"all <= 1 %", false, false,
     [](const auto& m) { return Fixed(m.all.correct_le1_percent(), 2); }},
    {"all D1 %", true, false, [](const auto& m) { return Fixed(m.all.d1_percent(), 2); }},
    {"away <= 1 %", false, true,
     [](const auto& m) { return Fixed(m.away.correct_le1_percent(), 2); }},
    {"away D1 %", true, true, [](const auto& m) { return Fixed(m.away.d1_percent(), 2); }},
    {"refine ms", true, false, [](const auto& m) { return Milliseconds(m.ms.refine_ms); }},
    {"prior ms", true, false, [](const auto& m) { return Milliseconds(m.ms.prior_ms); }},
    {"grow ms", true, false, [](const auto& m) { return Milliseconds(m.ms.grow_ms); }},
    {"fill ms", true, false, [](const auto& m) { return Milliseconds(m.ms.fill_ms); }},
    {"total ms", false, false, [](const auto& m) { return Milliseconds(m.ms.total_ms); }}};

std::vector<Row> MetricsRows(const SceneResult& scene, bool is_wide) {
  const bool has_away = HasAway(scene);
  std::vector<Row> rows{{"method"}};
  for (const MethodResult& method : scene.methods) rows.push_back({method.name});
  for (const TableColumn& column : kTableColumns) {
    if ((column.is_wide && !is_wide) || (column.is_away && !has_away)) continue;
    rows[0].emplace_back(column.head);
    for (size_t i = 0; i < scene.methods.size(); ++i) {
      rows[i + 1].push_back(column.cell(scene.methods[i]));
    }
  }
  return rows;
}

std::string PercentText(double percent) {
  return std::isnan(percent) ? "unknown" : Fixed(percent, 2) + " %";
}

std::string RefinementLine(const RefinementQuality& quality) {
  const SeedSet& seeds = quality.refined;
  const int32_t kept = CountTofSeeds(seeds.seeds);
  if (seeds.raw == 0) {
    return fmt::format("refinement: no ToF points; {} seeds from stereo, wrong {}\n",
                       seeds.seeds.size(), PercentText(quality.wrong_after_percent()));
  }
  return fmt::format(
      "refinement: {} ToF points, dropped {} outside, {} dark, {} loose, {} background, {} hidden, "
      "{} contradicted; {} kept, {} from stereo; wrong {} before, {} after; good ones lost {}\n",
      seeds.raw, seeds.outside, seeds.dark, seeds.loose, seeds.background, seeds.hidden,
      seeds.contradicted, kept, std::ssize(seeds.seeds) - kept,
      PercentText(quality.wrong_before_percent()), PercentText(quality.wrong_after_percent()),
      PercentText(quality.good_lost_percent()));
}

std::string ConfidenceLine(const MethodResult& method) {
  const Sparsification& curve = *method.confidence;
  std::string line = fmt::format("confidence of {}: bad 1 ", method.name);
  for (const int kept_percent : {100, 95, 90, 80, 50}) {
    line += fmt::format(
        "{:.2f} % of {}, ", curve.BestPercent(kept_percent),
        kept_percent == 100 ? "all pixels" : fmt::format("the best {} %", kept_percent));
  }
  return line + fmt::format("best 70 % / all {:.2f}, area {:.3f} (oracle {:.3f})\n",
                            curve.BestPercent(70) / curve.BestPercent(100), curve.area_percent,
                            curve.oracle_area_percent);
}

std::string CalibrationLine(const MethodResult& method) {
  const Calibration& calibration = *method.calibration;
  return fmt::format(
      "calibration of {}: error > 1 px claimed {:.2f} %, true {:.2f} %, calibration error {:.2f} "
      "points; within sigma {:.1f} %, within 2 sigma {:.1f} %\n",
      method.name, calibration.claimed_percent, calibration.bad1_percent, calibration.error_points,
      calibration.within_1_sigma_percent, calibration.within_2_sigma_percent);
}

// Measured, the paper's, difference.
Row PaperCells(const SceneResult& scene, const MethodResult& method) {
  const double measured = method.nonoccluded.correct_le1_percent();
  const double paper = PaperPercent(scene.name, method.name).value();
  return {Fixed(measured, 1), Fixed(paper, 1), fmt::format("{:+.1f}", measured - paper)};
}

bool IsInPaper(const SceneResult& scene, const MethodResult& method) {
  return PaperPercent(scene.name, method.name).has_value();
}

bool HasPaperMethod(const SceneResult& scene) {
  return std::ranges::any_of(scene.methods,
                             [&](const MethodResult& method) { return IsInPaper(scene, method); });
}

using Json = nlohmann::ordered_json;

Json AccuracyJson(const Accuracy& score) {
  return {{"correct_le1", score.correct_le1_percent()},
          {"correct_lt1", score.correct_lt1_percent()},
          {"bad2", score.bad2_percent()},
          {"bad4", score.bad4_percent()},
          {"density", score.density_percent()},
          {"mean_abs_px", score.mean_abs_px()},
          {"rms_px", score.rms_px()},
          {"bad05", score.bad05_percent()},
          {"d1", score.d1_percent()}};
}

Json ConfidenceJson(const Sparsification& confidence) {
  Json kept_percent = Json::array();
  for (int i = 1; i <= Sparsification::kSteps; ++i) {
    kept_percent.push_back(i * 100 / Sparsification::kSteps);
  }
  return {{"kept", kept_percent},
          {"bad1", confidence.bad1_percent},
          {"area", confidence.area_percent},
          {"oracle_area", confidence.oracle_area_percent}};
}

Json CalibrationJson(const Calibration& calibration) {
  Json claimed = Json::array();
  Json bad1 = Json::array();
  for (const Calibration::Bin& bin : calibration.bins) {
    claimed.push_back(bin.claimed_percent);
    bad1.push_back(bin.bad1_percent);
  }
  return {{"claimed", calibration.claimed_percent},
          {"bad1", calibration.bad1_percent},
          {"error", calibration.error_points},
          {"within_1_sigma", calibration.within_1_sigma_percent},
          {"within_2_sigma", calibration.within_2_sigma_percent},
          {"reliability", {{"claimed", claimed}, {"bad1", bad1}}}};
}

Json TimesJson(const StageTimes& ms) {
  return {{"refine", ms.refine_ms},
          {"prior", ms.prior_ms},
          {"grow", ms.grow_ms},
          {"fill", ms.fill_ms},
          {"total", ms.total_ms}};
}

Json RefinementJson(const RefinementQuality& quality) {
  const SeedSet& seeds = quality.refined;
  const int32_t kept = CountTofSeeds(seeds.seeds);
  return {{"raw", seeds.raw},
          {"outside", seeds.outside},
          {"dark", seeds.dark},
          {"loose", seeds.loose},
          {"background", seeds.background},
          {"hidden", seeds.hidden},
          {"contradicted", seeds.contradicted},
          {"kept", kept},
          {"stereo", std::ssize(seeds.seeds) - kept},
          {"wrong_before", quality.wrong_before_percent()},
          {"wrong_after", quality.wrong_after_percent()},
          {"good_lost", quality.good_lost_percent()}};
}

Json SceneJson(const SceneResult& scene) {
  Json methods = Json::array();
  for (const MethodResult& method : scene.methods) {
    Json json = {{"name", method.name},
                 {"nonocc", AccuracyJson(method.nonoccluded)},
                 {"all", AccuracyJson(method.all)},
                 {"away", AccuracyJson(method.away)},
                 {"ms", TimesJson(method.ms)}};
    if (method.confidence) json["confidence"] = ConfidenceJson(*method.confidence);
    if (method.calibration) json["calibration"] = CalibrationJson(*method.calibration);
    methods.push_back(std::move(json));
  }
  return {{"name", scene.name},
          {"width", scene.size.width},
          {"height", scene.size.height},
          {"methods", methods},
          {"refinement", RefinementJson(scene.refinement)}};
}

std::string CsvNumber(double number) { return std::isnan(number) ? "" : fmt::format("{}", number); }

// A comma or a quote in a name must not shift the columns.
std::string CsvText(const std::string& text) {
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? "\"\"" : std::string(1, letter);
  return quoted + "\"";
}

std::string CsvLine(const RunResult& run, const SceneResult& scene, const MethodResult& method,
                    const std::string& pixels, const Accuracy& score) {
  std::string line =
      fmt::format("{},{},{},{},{},{},{}", CsvText(run.preset), CsvText(run.tof),
                  CsvText(scene.name), scene.size.width, scene.size.height, method.name, pixels);
  for (const double number :
       {score.correct_le1_percent(), score.correct_lt1_percent(), score.bad05_percent(),
        score.bad2_percent(), score.bad4_percent(), score.d1_percent(), score.density_percent(),
        score.invalid_percent(), score.mean_abs_px(), score.rms_px(), method.ms.refine_ms,
        method.ms.prior_ms, method.ms.grow_ms, method.ms.fill_ms, method.ms.total_ms}) {
    line += "," + CsvNumber(number);
  }
  return line + "\n";
}

}  // namespace

std::string MarkdownTable(const std::vector<Row>& rows) {
  std::vector<size_t> widths(rows.front().size(), 3);
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) {
      text += i == 0 ? fmt::format("| {:<{}} |", row[i], widths[i])
                     : fmt::format(" {:>{}} |", row[i], widths[i]);
    }
    text += "\n";
    if (&row != &rows.front()) continue;
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string dashes(widths[i], '-');
      text += i == 0 ? "|-" + dashes + "-|" : "-" + dashes + ":|";
    }
    text += "\n";
  }
  return text;
}

std::string SceneTable(const SceneResult& scene, bool is_wide) {
  std::string text =
      fmt::format("{} ({} x {} px)\n\n", scene.name, scene.size.width, scene.size.height) +
      MarkdownTable(MetricsRows(scene, is_wide)) + "\n" + RefinementLine(scene.refinement);
  for (const MethodResult& method : scene.methods) {
    // The paper's variants have a confidence, too, but it is not of interest.
    if (!method.name.starts_with("sprout") || !method.confidence) continue;
    text += ConfidenceLine(method);
    // A map without a scored pixel has no calibration.
    if (method.calibration && !std::isnan(method.calibration->claimed_percent)) {
      text += CalibrationLine(method);
    }
  }
  return text;
}

std::string PaperTable(std::vector<SceneResult> scenes) {
  std::erase_if(scenes, [](const SceneResult& scene) { return !HasPaperMethod(scene); });
  if (scenes.empty()) return "";
  std::vector<Row> rows{{"method"}};
  for (const SceneResult& scene : scenes) {
    for (const std::string& head : {scene.name, std::string("paper"), std::string("diff")}) {
      rows.front().push_back(head);
    }
  }
  for (size_t i = 0; i < scenes.front().methods.size(); ++i) {  // the same ones in every scene
    const MethodResult& method = scenes.front().methods[i];
    if (!IsInPaper(scenes.front(), method)) continue;
    Row row{method.name};
    for (const SceneResult& scene : scenes) {
      std::ranges::copy(PaperCells(scene, scene.methods[i]), std::back_inserter(row));
    }
    rows.push_back(row);
  }
  return "Correct non-occluded pixels (error <= 1 px), %, beside the paper's figures\n\n" +
         MarkdownTable(rows);
}

std::string ToJson(const RunResult& run) {
  Json scenes = Json::array();
  for (const SceneResult& scene : run.scenes) scenes.push_back(SceneJson(scene));
  const Json json = {{"preset", run.preset}, {"tof", run.tof}, {"scenes", scenes}};
  // Paths may hold any bytes; JSON may not.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ToCsv(const RunResult& run) {
  std::string text =
      "preset,tof,scene,width,height,method,pixels,correct_le1,correct_lt1,bad05,bad2,bad4,d1,"
      "density,invalid,mean_abs_px,rms_px,refine_ms,prior_ms,grow_ms,fill_ms,total_ms\n";
  for (const SceneResult& scene : run.scenes) {
    for (const MethodResult& method : scene.methods) {
      text += CsvLine(run, scene, method, "nonocc", method.nonoccluded);
      text += CsvLine(run, scene, method, "all", method.all);
      text += CsvLine(run, scene, method, "away", method.away);
    }
  }
  return text;
}

}  // namespace sprout::evaluate
