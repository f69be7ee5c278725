#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/core/checks.h"
#include "common/messages/convert.h"

namespace sprout {
namespace {

// Largest standard deviation of a disparity, px: as large as the largest disparity.
constexpr float kMaxSigmaPx = 1023;

bool HasWholeArrays(const seeds_t& message) {
  const auto count = static_cast<size_t>(std::max(message.count, 0));
  return message.u.size() == count && message.v.size() == count &&
         message.u_right.size() == count && message.sigma_px.size() == count &&
         message.origin.size() == count && message.tof_u.size() == count &&
         message.tof_v.size() == count;
}

// Calls visit(name, message's, set's) for each count of points seen or left out.
template <typename Message, typename Set, typename Visit>
void ForEachSeedCount(Message& message, Set& seeds, Visit visit) {
  visit("raw_count", message.raw_count, seeds.raw);
  visit("outside_count", message.outside_count, seeds.outside);
  visit("dark_count", message.dark_count, seeds.dark);
  visit("loose_count", message.loose_count, seeds.loose);
  visit("background_count", message.background_count, seeds.background);
  visit("hidden_count", message.hidden_count, seeds.hidden);
  visit("contradicted_count", message.contradicted_count, seeds.contradicted);
}

// False for NaN as well; anything beyond the largest image is no position.
bool IsPosition(float px) { return std::abs(px) <= kMaxSide; }

template <typename Value>
std::string NotAllowed(const char* field, Value value, const std::string& allowed) {
  return Checks().Require(false, field, value, allowed).error().value().text;
}

// What is wrong with a seed; empty = nothing. Makes no text of a good one: there are many.
std::string Complaint(const seeds_t& message, size_t i) {
  if (!IsPosition(message.u[i]) || !IsPosition(message.v[i]) || !IsPosition(message.u_right[i])) {
    return "position not finite or beyond ±" + std::to_string(kMaxSide) + " px";
  }
  const float sigma_px = message.sigma_px[i];
  if (!(sigma_px > 0 && sigma_px <= kMaxSigmaPx)) {
    return NotAllowed("sigma_px", sigma_px, "above 0, up to 1023");
  }
  const int origin = message.origin[i];
  const bool from_tof = origin == seeds_t::ORIGIN_TOF;
  if (!from_tof && origin != seeds_t::ORIGIN_STEREO) {
    return NotAllowed("origin", origin, "TOF (0) or STEREO (1)");
  }
  for (const auto& [field, pixel] :
       {std::pair{"tof_u", message.tof_u[i]}, {"tof_v", message.tof_v[i]}}) {
    if (pixel < -1 || pixel >= kMaxSide) {
      return NotAllowed(field, pixel, "-1 to " + std::to_string(kMaxSide - 1));
    }
    if (!from_tof && pixel != -1) return NotAllowed(field, pixel, "-1 for a stereo seed");
  }
  if ((message.tof_u[i] < 0) != (message.tof_v[i] < 0)) {
    return NotAllowed("tof_v", message.tof_v[i], "-1 where tof_u is, and nowhere else");
  }
  return {};
}

}  // namespace

seeds_t ToMessage(const FrameId& id, const SeedSet& seeds) {
  seeds_t message;
  message.header = ToMessage(id);
  message.count = static_cast<int32_t>(seeds.seeds.size());
  ForEachSeedCount(message, seeds, [](const char*, int32_t& field, int count) { field = count; });
  const auto fill = [&](auto& values, auto value_of) {
    values.reserve(seeds.seeds.size());
    for (const Seed& seed : seeds.seeds) values.push_back(value_of(seed));
  };
  fill(message.u, [](const Seed& seed) { return seed.u; });
  fill(message.v, [](const Seed& seed) { return seed.v; });
  fill(message.u_right, [](const Seed& seed) { return seed.u_right; });
  fill(message.sigma_px, [](const Seed& seed) { return seed.sigma_px; });
  fill(message.origin, [](const Seed& seed) { return static_cast<int8_t>(seed.origin); });
  fill(message.tof_u, [](const Seed& seed) { return seed.tof_u; });
  fill(message.tof_v, [](const Seed& seed) { return seed.tof_v; });
  return message;
}

Result<SeedSet> FromMessage(const seeds_t& message) {
  SeedSet seeds;
  Checks checks;
  checks.NotNegative("count", message.count)
      .Require(HasWholeArrays(message), "count", message.count,
               "the number of values in each array");
  ForEachSeedCount(message, seeds, [&](const char* name, int32_t field, int& count) {
    checks.NotNegative(name, field);
    count = field;
  });
  if (!checks.ok()) return checks.error();
  const auto count = static_cast<size_t>(message.count);
  seeds.seeds.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    if (const std::string complaint = Complaint(message, i); !complaint.empty()) {
      return Fail("seed " + std::to_string(i) + ": " + complaint);
    }
    seeds.seeds.push_back({.u = message.u[i],
                           .v = message.v[i],
                           .u_right = message.u_right[i],
                           .sigma_px = message.sigma_px[i],
                           .origin = static_cast<SeedOrigin>(message.origin[i]),
                           .tof_u = message.tof_u[i],
                           .tof_v = message.tof_v[i]});
  }
  return seeds;
}

}  // namespace sprout
