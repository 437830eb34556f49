#pragma once

#include <functional>
#include <vector>

#include "common/math/vec.h"
#include "station/lab/tissue/cut_fit.h"

// Recordings of cuts with known parameters, made independently of the code that fits them.
namespace enamel::station::lab {

struct TrueCut {
  dmat3 b{1};  // N s/mm
  double coulomb_n = 0, threshold_n = 0;
  double compliance_mm_per_n = 0;
  // Above 0: tissue that is cut by load in b's place, coulomb + root sqrt(v), N (s/mm)^(1/2); and a bur along z that turns
  // with this friction, so that the sensor reads a force across the motion, too.
  double root = 0, friction = 0;
};

struct Sensor {
  double rate_hz = 1000;
  double count_mm = 0.009;  // positions are the middles of cells; 0: not rounded
  double position_noise_mm = 0;
  double force_noise_n = 0.03;
  double dropped = 0.01;  // part of the rows
  double spikes = 0;      // part of the rows that hold nonsense
};

// A force hand: the tissue responds to `force_n(t)`.
std::vector<CutSample> CutByForce(const TrueCut& truth, const Sensor& sensor, double seconds,
                                  uint64_t seed, const std::function<dvec3(double)>& force_n);
// A hand that prescribes the far end of the tip's spring; the front follows. Requires a compliance
// above 0.
std::vector<CutSample> CutByMotion(const TrueCut& truth, const Sensor& sensor, double seconds,
                                   uint64_t seed, const std::function<dvec3(double)>& position_mm);

}  // namespace enamel::station::lab
