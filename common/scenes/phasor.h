#ifndef SPROUT_COMMON_SCENES_PHASOR_H_
#define SPROUT_COMMON_SCENES_PHASOR_H_

namespace sprout::scenes {

/// Amplitude and phase of modulated light, as a complex number.
struct Phasor {
  double real = 0;
  double imaginary = 0;
};

/// The phasor of amplitude 1 with that phase, turns (1 = 2π): cosine and sine, to 1e-11. Made of
/// sums and products, so that simulated frames have the same bytes on every machine.
Phasor UnitPhasor(double turns);

/// Amplitudes multiplied, phases added.
inline Phasor Product(const Phasor& a, const Phasor& b) {
  return {a.real * b.real - a.imaginary * b.imaginary, a.real * b.imaginary + a.imaginary * b.real};
}

/// Its phase, turns, −1/2 to 1/2, to 1e-11; 0 for no signal. The inverse of UnitPhasor().
double TurnsOf(const Phasor& phasor);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_PHASOR_H_
