#include "services/tools/evaluate/result_files.h"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace sprout::evaluate {
namespace {

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
      "density,"
      "invalid,mean_abs_px,rms_px,refine_ms,prior_ms,grow_ms,fill_ms,total_ms\n";
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
