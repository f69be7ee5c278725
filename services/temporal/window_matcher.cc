// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
// Plain loops: the compiler makes vectors of them.
#include "services/temporal/window_matcher.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/temporal/window_matcher.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::temporal {
namespace HWY_NAMESPACE {

constexpr int kSide = 16;  // of the window, px
constexpr int kCount = kSide * kSide;
constexpr int kGreyBits = 3;  // parts of a grey level that windows keep: 256 products of two
                              // differences of at most 2¹¹ fit 32 bits
constexpr int kMaxSteps = 10;
// A step shorter than this ends the search, parts of a pixel. What is left has the sign of the
// motion, so a coarser end would make every motion too short.
constexpr int kShortStep = kPositionParts / 64;
// Smaller eigenvalue of the structure tensor, a pixel of the window, of a texture of one grey level
// a pixel, in the units below (differences over 2 px, parts of a grey level).
constexpr double kMinTexture = (2 << kGreyBits) * (2 << kGreyBits) / 2.0;

// Grey values of kRows × kColumns places, one pixel apart from each other. Their right and lower
// neighbours are in the image, too.
template <int kRows, int kColumns>
HWY_INLINE void Sample(const View<uint8_t>& image, Place first, int16_t* window) {
  const int right = first.u & (kPositionParts - 1);
  const int below = first.v & (kPositionParts - 1);
  const int32_t weights[4] = {(kPositionParts - right) * (kPositionParts - below),
                              right * (kPositionParts - below), (kPositionParts - right) * below,
                              right * below};
  constexpr int kShift = 2 * kPositionBits - kGreyBits;
  const uint8_t* row =
      image.pixels + (first.v >> kPositionBits) * image.stride + (first.u >> kPositionBits);
  for (int y = 0; y < kRows; ++y, row += image.stride, window += kColumns) {
    const uint8_t* const next = row + image.stride;
    for (int x = 0; x < kColumns; ++x) {
      const int32_t sum = weights[0] * row[x] + weights[1] * row[x + 1] + weights[2] * next[x] +
                          weights[3] * next[x + 1];
      window[x] = static_cast<int16_t>((sum + (1 << (kShift - 1))) >> kShift);
    }
  }
}

// Whether a window of `side` px from `first` on, and the neighbours of its pixels, are inside.
HWY_INLINE bool IsInside(const View<uint8_t>& image, Place first, int side) {
  const int u = first.u >> kPositionBits;
  const int v = first.v >> kPositionBits;
  return u >= 0 && v >= 0 && u + side < image.width && v + side < image.height;
}

// The first pixel of a window of `side` px around a place.
HWY_INLINE Place FirstOf(Place place, int side) {
  const int half = (side - 1) * kPositionParts / 2;
  return {place.u - half, place.v - half};
}

// Sums of the grey values of a window, and of their products with the slopes of the window looked
// for.
struct GreySums {
  int32_t grey = 0, squares = 0, with_u = 0, with_v = 0;

  double Contrast() const { return squares - grey * (double(grey) / kCount); }
  // Covariances with the slopes, times the number of pixels.
  double AlongU(double mean_slope) const { return with_u - grey * mean_slope; }
  double AlongV(double mean_slope) const { return with_v - grey * mean_slope; }
};

HWY_INLINE GreySums SumsOf(const int16_t* window, const int16_t* slope_u, const int16_t* slope_v) {
  GreySums sums;
  for (int i = 0; i < kCount; ++i) {
    const int32_t grey = window[i];
    sums.grey += grey;
    sums.squares += grey * grey;
    sums.with_u += grey * slope_u[i];
    sums.with_v += grey * slope_v[i];
  }
  return sums;
}

bool MatchOnTarget(const View<uint8_t>& before, Place place, const View<uint8_t>& after,
                   Place& found) {
  constexpr int kWide = kSide + 2;  // with the neighbours that differences need
  const Place first = FirstOf(place, kWide);
  if (!IsInside(before, first, kWide)) return false;
  alignas(64) int16_t wide[kWide * kWide];
  Sample<kWide, kWide>(before, first, wide);
  alignas(64) int16_t grey[kSide * kSide], slope_u[kSide * kSide], slope_v[kSide * kSide];
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int16_t* const at = wide + (y + 1) * kWide + x + 1;
      grey[y * kSide + x] = at[0];
      slope_u[y * kSide + x] = static_cast<int16_t>(at[1] - at[-1]);
      slope_v[y * kSide + x] = static_cast<int16_t>(at[kWide] - at[-kWide]);
    }
  }
  int32_t su = 0, sv = 0, suu = 0, suv = 0, svv = 0;
  for (int i = 0; i < kCount; ++i) {
    const int32_t a = slope_u[i];
    const int32_t b = slope_v[i];
    su += a;
    sv += b;
    suu += a * a;
    suv += a * b;
    svv += b * b;
  }
  const GreySums own = SumsOf(grey, slope_u, slope_v);
  const double mean_u = double(su) / kCount;
  const double mean_v = double(sv) / kCount;
  const double uu = suu - su * mean_u;
  const double uv = suv - su * mean_v;
  const double vv = svv - sv * mean_v;
  const double half_difference = (uu - vv) / 2;
  const double smaller = (uu + vv) / 2 - std::sqrt(half_difference * half_difference + uv * uv);
  if (!(smaller >= kMinTexture * kCount)) return false;
  const double determinant = uu * vv - uv * uv;

  for (int step = 0; step < kMaxSteps; ++step) {
    const Place now = FirstOf(found, kSide);
    if (!IsInside(after, now, kSide)) return false;
    alignas(64) int16_t there[kCount];
    Sample<kSide, kSide>(after, now, there);
    const GreySums other = SumsOf(there, slope_u, slope_v);
    if (!(other.Contrast() > 0)) return false;
    const double gain = std::sqrt(own.Contrast() / other.Contrast());
    const double du = own.AlongU(mean_u) - gain * other.AlongU(mean_u);
    const double dv = own.AlongV(mean_v) - gain * other.AlongV(mean_v);
    // Slopes are differences over 2 px.
    const double u = 2 * kPositionParts * (vv * du - uv * dv) / determinant;
    const double v = 2 * kPositionParts * (uu * dv - uv * du) / determinant;
    // A step longer than the window ends the search: it has lost its object.
    if (!(std::abs(u) < kSide * kPositionParts && std::abs(v) < kSide * kPositionParts)) {
      return false;
    }
    found.u += static_cast<int32_t>(std::lround(u));
    found.v += static_cast<int32_t>(std::lround(v));
    if (std::abs(u) < kShortStep && std::abs(v) < kShortStep) break;
  }
  return IsInside(after, FirstOf(found, kSide), kSide);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::temporal
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::temporal {

HWY_EXPORT(MatchOnTarget);

bool MatchWindow(const View<uint8_t>& before, Place place, const View<uint8_t>& after,
                 Place& found) {
  return HWY_DYNAMIC_DISPATCH(MatchOnTarget)(before, place, after, found);
}

}  // namespace sprout::temporal
#endif  // HWY_ONCE
