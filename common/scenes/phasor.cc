#include "common/scenes/phasor.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace sprout::scenes {

Phasor UnitPhasor(double turns) {
  const double quarters = std::round(4 * turns);
  const double angle = 2 * std::numbers::pi * (turns - quarters / 4);  // −π/4 to π/4
  const double square = angle * angle;
  double sine = 0;  // Taylor's series by Horner's rule
  double cosine = 0;
  for (int k = 12; k > 0; k -= 2) {
    sine = (1 - sine) * square / (k * (k + 1));
    cosine = (1 - cosine) * square / (k * (k - 1));
  }
  sine = angle * (1 - sine);
  cosine = 1 - cosine;
  switch (static_cast<int64_t>(quarters) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

double TurnsOf(const Phasor& phasor) {
  const double amplitude =
      std::sqrt(phasor.real * phasor.real + phasor.imaginary * phasor.imaginary);
  if (!(amplitude > 0)) return 0;
  // Behind the imaginary axis: the angle to the negative real one.
  if (phasor.real < 0) {
    const double turned = TurnsOf({-phasor.real, -phasor.imaginary});
    return turned > 0 ? turned - 0.5 : turned + 0.5;
  }
  double tangent = phasor.imaginary / (amplitude + phasor.real);  // of half the angle, |x| <= 1
  double halves = 2;
  for (int i = 0; i < 2; ++i) {  // of an eighth: |x| <= 0.2
    tangent /= 1 + std::sqrt(1 + tangent * tangent);
    halves *= 2;
  }
  double angle = 0;  // arctangent by Horner's rule
  for (int k = 15; k > 1; k -= 2) angle = (1.0 / k - angle) * tangent * tangent;
  return halves * tangent * (1 - angle) / (2 * std::numbers::pi);
}

}  // namespace sprout::scenes
