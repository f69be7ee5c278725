#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>

#include "common/config/config.h"

namespace sprout::grow {

/// The content of confidence_model.textproto, which the build puts into the library.
extern const char* const kConfidenceModelText;

/// 16·log₂(x), straight between powers of two (Mitchell, "Computer multiplication and division
/// using binary logarithms", 1962) and rounded down: the exponent of a float and 4 binary digits.
/// @param x  1 to 2²⁴, which a float holds exactly.
constexpr int LevelOf(int x) {
  return (std::bit_cast<int32_t>(static_cast<float>(x)) >> 19) - (127 << 4);
}

/// Level of a range above 1 px, which is more than a surface's slope: a depth edge.
inline constexpr int kEdgeLevel = 81;

/// The model as the kernel needs it: for each value of a feature what it adds to the log-odds of an
/// error > 1 px (upper half of a number, in 2⁻⁸) and to log₂ of the standard deviation in counts
/// (lower half, in 2⁻⁸). Sums are a pixel's log-odds and log₂ σ.
struct ConfidenceTables {
  using Table = std::array<uint32_t, 256>;
  Table step, bend, margin, gaps, blank, edge, tof_seed, seed, prior, rough;
  uint32_t start = 0;  ///< a₀ and b₀ of (C2) and (C3), which every sum begins with

  // Least log-odds, in units of 2⁻⁴; no pixel is surer than log-odds of −16.
  static constexpr int kMinOdds = -16;
  std::array<uint8_t, 512> confidence;  ///< of log-odds from kMinOdds on
  std::array<uint8_t, 256> sigma;       ///< of log₂ from 0 on

  uint8_t ConfidenceOf(uint32_t sum) const {
    return confidence[std::min<size_t>(sum >> 20, confidence.size() - 1)];
  }
  uint8_t SigmaOf(uint32_t sum) const {
    return sigma[std::min<size_t>((sum & 0xffff) >> 4, sigma.size() - 1)];
  }
};

/// The tables of a model.
/// @param name  of the text's origin, for messages.
/// @throws ConfigError, one line, for text that is no model: a feature is missing or there twice, a
///         curve has another number of values than 17, falls, or is so high that sums overflow.
ConfidenceTables ParseConfidenceModel(const std::string& text, const std::string& name);

/// Those of confidence_model.textproto, which is part of the library.
const ConfidenceTables& DefaultConfidenceTables();

}  // namespace sprout::grow
