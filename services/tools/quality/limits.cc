#include "services/tools/quality/limits.h"

#include <fmt/core.h>

#include <cmath>
#include <set>

#include "common/config/config.h"
#include "common/measure/target_limits.pb.h"

namespace sprout::quality {
namespace {

std::string FigureNames() {
  std::string names;
  for (const TargetFigure& figure : TargetFigures()) {
    names += (names.empty() ? "" : ", ") + std::string(figure.name);
  }
  return names;
}

Limit LimitOf(const TargetLimit& message, const std::string& where) {
  Limit limit{.figure = FindTargetFigure(message.figure()), .at_least = {}, .at_most = {}};
  if (limit.figure == nullptr) {
    throw ConfigError(fmt::format("{}: no figure is called '{}'; allowed: {}", where,
                                  message.figure(), FigureNames()));
  }
  if (message.has_at_least()) limit.at_least = message.at_least();
  if (message.has_at_most()) limit.at_most = message.at_most();
  const bool finite =
      std::isfinite(limit.at_least.value_or(0)) && std::isfinite(limit.at_most.value_or(0));
  const bool some = limit.at_least || limit.at_most;
  const bool ordered = !limit.at_least || !limit.at_most || *limit.at_least <= *limit.at_most;
  if (some && finite && ordered) return limit;
  throw ConfigError(
      fmt::format("{}: {}: allowed is at_least, at_most or both, finite numbers in "
                  "this order",
                  where, limit.figure->name));
}

}  // namespace

bool Limit::IsKept(const TargetQuality& quality) const {
  const std::optional<double>& value = quality.*figure->value;
  return value && (!at_least || *value >= *at_least) && (!at_most || *value <= *at_most);
}

std::string Limit::Text() const {
  if (at_least && at_most) return fmt::format("{:g} to {:g}", *at_least, *at_most);
  return at_least ? fmt::format(">= {:g}", *at_least) : fmt::format("<= {:g}", *at_most);
}

std::vector<Limit> LoadLimits(const std::filesystem::path& path) {
  const std::string where = "--limits " + path.string();
  TargetLimits messages;
  ParseTextFile(path, "limits", "a file of limit { figure: \"...\" at_most: ... }", messages);
  std::vector<Limit> limits;
  std::set<const TargetFigure*> seen;
  for (const TargetLimit& message : messages.limit()) {
    limits.push_back(LimitOf(message, where));
    if (seen.insert(limits.back().figure).second) continue;
    throw ConfigError(
        fmt::format("{}: two limits of {}; allowed: one", where, limits.back().figure->name));
  }
  if (limits.empty()) throw ConfigError(where + ": no limit in it; allowed: at least one");
  return limits;
}

}  // namespace sprout::quality
