// Eqs. (1), (4) and (5) as costs, for single numbers and for vectors of them: Highway compiles this
// file once for each instruction set, so it has no usual include guard.
#if defined(SPROUT_SERVICES_GROW_SIMILARITY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_SIMILARITY_INL_H_
#undef SPROUT_SERVICES_GROW_SIMILARITY_INL_H_
#else
#define SPROUT_SERVICES_GROW_SIMILARITY_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

// −ln of eq. (4), exp(−Σ(wL − wR)² / (σ_s²·Σ(wL² + wR²))), times the scale's unit.
// Eq. (1) has the same form: 1 − MNCC = (var(wL) + var(wR) − 2·cov(wL, wR)) / (var(wL) + var(wR)).
// @param difference  Σ(wL − wR)², or the numerator. @param energy  Σ(wL² + wR²), or the
// denominator; > 0. @param scale  unit / σ_s², or the unit.
template <class Number>
HWY_INLINE Number PhotoCost(Number difference, Number energy, Number scale) {
  return difference * (scale / energy);
}

// −ln of eq. (5), exp(−(d − D_p)² / (2·σ_p²)), times the scale's unit. That of eq. (6) is the sum
// of both.
// @param distance  d − D_p. @param scale  unit / (2·σ_p²).
template <class Number>
HWY_INLINE Number PriorCost(Number distance, Number scale) {
  return distance * distance * scale;
}

// The coefficient k of the cubic in (S2): exact near the middle for a texture of w = π/2 a px, half
// the highest frequency that pixels can show, k = 1 − 2 sin(w/2) / w. Finer texture would need
// more, coarser texture less, but hardly shows it.
inline constexpr float kCubic = 0.1F;

HWY_INLINE float Clamped(float x, float least, float most) {
  return x < least ? least : x > most ? most : x;
}
template <class V>
HWY_INLINE V Clamped(V x, V least, V most) {
  return hwy::HWY_NAMESPACE::Min(hwy::HWY_NAMESPACE::Max(x, least), most);
}

// The numbers of a pixel that its sub-pixel step follows from, and constants as such numbers.
template <class Number>
struct StepInput {
  Number fall;  // e(d) − e(d + a), with e = Σ(wL − wR)² and a = ±1 the side where it is less
  Number texture;  // h > 0: Σ(wL − wL′)², wL′ being the left window one pixel to the side of −a
  Number energy;       // Σ(wL² + wR²)
  Number side;         // a, counts a pixel
  Number distance;     // d − D_p, counts
  Number photo_scale;  // unit / σ_s²
  Number prior_scale;  // that of PriorCost() for pixels instead of counts
};

// Counts from a whole disparity to the least cost (S2).
// @param number  makes one of a float.
template <class Number, class Make>
HWY_INLINE Number StepToMinimum(const StepInput<Number>& in, const Make& number) {
  const Number x = Clamped(in.fall / (in.texture + in.texture), number(-0.5F), number(0));
  const Number t = number(0.5F) + x * (number(1 - kCubic) + number(4 * kCubic) * x * x);
  const Number photo = in.texture * in.photo_scale;
  const Number prior = in.energy * in.prior_scale;
  return (photo * in.side * t - prior * in.distance) / (photo + prior);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
