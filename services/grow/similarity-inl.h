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

// Exponent of eq. (4), exp(−Σ(wL − wR)² / (σ_s²·Σ(wL² + wR²))), times the scale's unit.
// Eq. (1) has the same form: 1 − MNCC = (var(wL) + var(wR) − 2·cov(wL, wR)) / (var(wL) + var(wR)).
// @param difference  Σ(wL − wR)², or the numerator. @param energy  Σ(wL² + wR²), or the
// denominator; > 0. @param scale  unit / σ_s², or the unit.
template <class Number>
HWY_INLINE Number PhotoCost(Number difference, Number energy, Number scale) {
  return difference * (scale / energy);
}

// Exponent of eq. (5), exp(−(d − D_p)² / (2·σ_p²)), times the scale's unit. That of eq. (6) is the
// sum of both.
// @param distance  d − D_p. @param scale  unit / (2·σ_p²).
template <class Number>
HWY_INLINE Number PriorCost(Number distance, Number scale) {
  return distance * distance * scale;
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
