#include "common/scenes/solid_texture.h"

#include <algorithm>
#include <cmath>

namespace sprout::scenes {
namespace {

// Odd 64-bit numbers without a pattern: fractions of the roots of 2, 3 and 5.
constexpr uint64_t kStepX = 0x6a09e667f3bcc909;
constexpr uint64_t kStepY = 0xbb67ae8584caa73b;
constexpr uint64_t kStepZ = 0x3c6ef372fe94f82b;

// Smallest feature that is drawn, in pixels: below, bilinear views of it no longer agree.
constexpr double kFinestCellPx = 1.5;
constexpr int kOctaves = 3;
constexpr double kContrast = 1.8;  // value noise crowds around 0.5

double SmoothStep(double t) { return t * t * (3 - 2 * t); }

double Mix(double a, double b, double t) { return a + t * (b - a); }

// Value of a lattice point, 0 to 1. Half of Scramble(): it runs 24 times a ray, and no eye sees
// the difference.
double UnitValue(uint64_t lattice) {
  lattice = (lattice ^ (lattice >> 32)) * kStepX;
  return static_cast<double>(static_cast<int64_t>(lattice >> 40)) * 0x1p-24;
}

// A coordinate as a cell and the position in it, 0 to 1.
struct CellPosition {
  explicit CellPosition(double coordinate) {
    auto whole = static_cast<int64_t>(coordinate);
    if (static_cast<double>(whole) > coordinate) --whole;  // std::floor is a call on old CPUs
    cell = static_cast<uint64_t>(whole);
    weight = SmoothStep(coordinate - static_cast<double>(whole));
  }
  uint64_t cell;
  double weight;
};

// Random values at the whole numbers, interpolated in between.
double ValueNoise(const Vec3& point, uint64_t key) {
  const CellPosition x(point.x);
  const CellPosition y(point.y);
  const CellPosition z(point.z);
  const auto row = [&x](uint64_t corner) {
    return Mix(UnitValue(corner), UnitValue(corner + kStepX), x.weight);
  };
  const auto layer = [&](uint64_t corner) {
    return Mix(row(corner), row(corner + kStepY), y.weight);
  };
  const uint64_t corner = key + x.cell * kStepX + y.cell * kStepY + z.cell * kStepZ;
  return Mix(layer(corner), layer(corner + kStepZ), z.weight);
}

}  // namespace

uint64_t Scramble(uint64_t value) {
  value ^= value >> 32;
  value *= kStepX;
  value ^= value >> 29;
  value *= kStepY;
  return value ^ (value >> 32);
}

double SolidNoise(const Vec3& point, double pixel_m, uint64_t key) {
  // Cells are powers of two in metres, so that they stay in place when the distance changes.
  // finest = mantissa · 2^exponent with mantissa in [0.5, 1): 2^exponent is the next larger power.
  int exponent = 0;
  const double mantissa = std::frexp(kFinestCellPx * pixel_m, &exponent);  // exact, as ldexp
  const double fade = SmoothStep(1 / mantissa - 1);
  const double weights[kOctaves] = {fade, 1, 1 - fade};

  double sum = 0;
  double cells_per_m = std::ldexp(1.0, -exponent);
  for (int octave = 0; octave < kOctaves; ++octave) {
    const uint64_t octave_key = Scramble(key + static_cast<uint64_t>(exponent + octave));
    sum += weights[octave] * (ValueNoise(cells_per_m * point, octave_key) - 0.5);
    cells_per_m /= 2;
  }
  return std::clamp(0.5 + kContrast * sum / 2, 0.0, 1.0);
}

}  // namespace sprout::scenes
