#pragma once

#include <optional>
#include <string_view>

#include "common/scoring/measured.h"

// Standard uncertainties (JCGM 100:2008, type B) of what is measured on the tooth: schemas/score.md, "Uncertainty".
// Deterministic: + - * / sqrt. Thread safety: functions, any thread.
namespace enamel::scoring {

// A limit is borderline within so many of them.
inline constexpr double kBorderlineWithin = 2;

// Standard deviation of what is even between 0 and 1: 1 / sqrt(12).
inline constexpr double kEven = 0.28867513459481287;

// Of where a surface lies: rectangular within a quarter of a voxel, and within `registration_m` of where it should lie.
double SurfaceUncertainty_m(double voxel_m, double registration_m);

// A prepared tooth was laid on the scene's within this; its own residual is not stored. The largest RMS that an import
// accepts (import::kMaxRms_mm).
inline constexpr double kRegistration_m = 0.07e-3;

// In the metric's unit. None where the recording alone has it, which the grid does not touch, or where there is no
// formula. `value`: the metric's.
std::optional<double> UncertaintyOf(std::string_view metric, std::string_view unit, double value,
                                    const Measured& measured);

}  // namespace enamel::scoring
