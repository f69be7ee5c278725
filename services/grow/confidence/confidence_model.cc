#include "services/grow/confidence/confidence_model.h"

#include <cmath>
#include <functional>
#include <set>

#include "common/core/prior_map.h"
#include "services/grow/confidence/confidence_model.pb.h"

namespace sprout::grow {
namespace {

using Curve = ConfidenceModel::Curve;
using Values = google::protobuf::RepeatedField<int32_t>;

constexpr int kKnotStep = 16;
constexpr int kKnots = 256 / kKnotStep + 1;
// Twelve curves and the start stay below 2¹⁶.
constexpr int kMaxValue = 4700;

// Maps the values of a feature to its level, at which the knots of its curve stand.
std::function<int(int)> LevelsOf(Curve::Feature feature) {
  switch (feature) {
    case Curve::EDGE:
    case Curve::TOF_SEED:
    case Curve::SEED:  // nearness to the logarithm of the distance
      return [](int nearness) { return LevelOf(256 - nearness); };
    case Curve::PRIOR:
      return [](int counts) { return LevelOf(std::max(counts, 1)); };
    default:
      return [](int level) { return level; };
  }
}

ConfidenceTables::Table& TableOf(Curve::Feature feature, ConfidenceTables& tables) {
  switch (feature) {
    case Curve::STEP:
      return tables.step;
    case Curve::BEND:
      return tables.bend;
    case Curve::MARGIN:
      return tables.margin;
    case Curve::GAPS:
      return tables.gaps;
    case Curve::EDGE:
      return tables.edge;
    case Curve::TOF_SEED:
      return tables.tof_seed;
    case Curve::SEED:
      return tables.seed;
    case Curve::BLANK:
      return tables.blank;
    case Curve::ROUGH:
      return tables.rough;
    case Curve::PRIOR:
      break;
  }
  return tables.prior;
}

// Doubt falls with the distance to an edge, and rises with all other levels.
bool IsFalling(Curve::Feature feature) { return feature == Curve::EDGE; }

void Check(const Curve& curve, const Values& values, const std::string& what) {
  if (values.size() != kKnots) {
    throw ConfigError(what + ": " + std::to_string(values.size()) +
                      " values; allowed: " + std::to_string(kKnots));
  }
  for (int i = 0; i < kKnots; ++i) {
    if (values[i] < 0 || values[i] > kMaxValue) {
      throw ConfigError(what + ": " + std::to_string(values[i]) + "; allowed: 0 to " +
                        std::to_string(kMaxValue));
    }
    if (i == 0) continue;
    if (IsFalling(curve.feature()) ? values[i] > values[i - 1] : values[i] < values[i - 1]) {
      throw ConfigError(what + ": " + std::to_string(values[i]) + " after " +
                        std::to_string(values[i - 1]) + "; allowed: values that " +
                        (IsFalling(curve.feature()) ? "never rise" : "never fall"));
    }
  }
}

// The value of a curve at a level, linear between the knots.
uint32_t At(const Values& values, int level) {
  const int knot = level / kKnotStep;
  const int rest = level % kKnotStep;
  return static_cast<uint32_t>(
      (values[knot] * (kKnotStep - rest) + values[knot + 1] * rest + kKnotStep / 2) / kKnotStep);
}

void FillOutputs(ConfidenceTables& tables) {
  for (size_t i = 0; i < tables.confidence.size(); ++i) {
    // No result but that of odds 0, which is exact, is within 10⁻³ of a half, nor is one below.
    const double odds = ConfidenceTables::kMinOdds + static_cast<double>(i) / 16;
    tables.confidence[i] = static_cast<uint8_t>(std::lround(255 / (1 + std::exp(odds))));
  }
  for (size_t i = 0; i < tables.sigma.size(); ++i) {
    const double counts = std::exp2(static_cast<double>(i) / 16);
    tables.sigma[i] = SigmaToCounts(counts / kSigmaCountsPerPx);
  }
}

}  // namespace

ConfidenceTables ParseConfidenceModel(const std::string& text, const std::string& name) {
  ConfidenceModel model;
  ParseText(text, name, model);
  RequireInRange(model, name);
  ConfidenceTables tables{};
  tables.start = static_cast<uint32_t>(model.doubt() - ConfidenceTables::kMinOdds * 256) << 16 |
                 static_cast<uint32_t>(model.spread());
  std::set<int> known;
  for (const Curve& curve : model.curve()) {
    const std::string what = name + ": " + Curve::Feature_Name(curve.feature());
    if (!known.insert(curve.feature()).second) throw ConfigError(what + ": twice; allowed: once");
    Check(curve, curve.doubt(), what + ".doubt");
    Check(curve, curve.spread(), what + ".spread");
    const auto level_of = LevelsOf(curve.feature());
    ConfidenceTables::Table& table = TableOf(curve.feature(), tables);
    for (size_t i = 0; i < table.size(); ++i) {
      const int level = level_of(static_cast<int>(i));
      table[i] = At(curve.doubt(), level) << 16 | At(curve.spread(), level);
    }
  }
  if (static_cast<int>(known.size()) != Curve::Feature_ARRAYSIZE) {
    throw ConfigError(name + ": curves of " + std::to_string(known.size()) +
                      " features; allowed: of all " + std::to_string(Curve::Feature_ARRAYSIZE));
  }
  FillOutputs(tables);
  return tables;
}

const ConfidenceTables& DefaultConfidenceTables() {
  static const ConfidenceTables tables =
      ParseConfidenceModel(kConfidenceModelText, "confidence_model.textproto");
  return tables;
}

}  // namespace sprout::grow
