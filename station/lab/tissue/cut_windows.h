#pragma once

#include <cstddef>
#include <vector>

#include "station/lab/tissue/cut_fit.h"

// A recording of a cut, and the windows for speed, force and the force's rate (method: cut_fit.h).
// Units: s, mm, N. Pure functions, any thread.
namespace enamel::station::lab::cut {

constexpr size_t kMinSamples = 8;        // in a window
constexpr double kContact_n = 0.02;      // less is air
constexpr double kForceSmooth_s = 0.01;  // half width of the force used by the gate

// Means under one bump: speed, force and the force's rate.
struct Means {
  dvec3 v{0}, f{0}, fdot{0};
  double noise = 0;  // variance of v per axis for white noise of variance 1 in position
  bool ok = false, gap = false;
};

struct Window {
  Means whole, early, late;
  dvec3 axis{0}, variance{0};  // of whole.v, per axis
  size_t first = 0, last = 0;  // samples
  double middle_s = 0;
  // By Classify.
  dvec3 v{0}, u{0};  // of the front
  bool used = false, steady = false;
  double weight = 1;
};

struct Recording {
  std::vector<CutSample> s;
  std::vector<dvec3> smooth;     // F for the gate
  std::vector<double> smooth_n;  // its size
  std::vector<double> width_s;   // of each sample's trapezium
  double dt = 0, window_s = 0;
  dvec3 noise_mm2{0}, count_mm{0};
  double force_noise_n = 0;
  bool magnitude = false;
};

// The recording with all its measures: widths, counts, noise, window_s. `s`: without spikes, at
// least kMinSamples. The caller runs SmoothForce, and may turn the force first.
Recording RecordingOf(std::vector<CutSample> s, double dt_s, bool magnitude);

// Drops single samples far from the median of five around them; returns the number.
size_t DropSpikes(std::vector<CutSample>* s);

// Overlapping windows of `width` seconds, run by run.
std::vector<Window> WindowsOf(const Recording& r, double width);

// Fills in the force for the threshold's gate.
void SmoothForce(Recording* r);

// The front's speed from the tip's. A magnitude's rate is taken along the motion.
dvec3 Front(const Recording& r, const Means& m, double c);

// The force along the front's motion.
double Along(const Recording& r, const Window& w);

// Sorts the windows into used and left out, for a tip of compliance `c`, and counts both in `fit`.
// With `threshold` (above 0: seen) the force must stay above it.
void Classify(const Recording& r, double c, double threshold, std::vector<Window>* windows,
              CutFit* fit);

}  // namespace enamel::station::lab::cut
