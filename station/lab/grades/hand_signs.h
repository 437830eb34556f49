#pragma once

#include <boost/json/fwd.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/math/vec.h"

// Whether a motion distinguishes a person from a program: figures of single seconds of motion, of
// recorded and of simulated people, and how well each figure separates the two. Thresholds of the
// server are measured here; none decides anything: a person may move like a program and a program
// like a person. Thread safety:
// functions, any thread. Blocks.
namespace enamel::station::lab {

// Figures of one second of motion. Requires: kSecond positions, 1 ms apart.
inline constexpr size_t kSecond = 1000;
struct HandSigns {
  double tremor_um = 0;       // 8 to 12 Hz (scoring::TremorMeter)
  double jerk = 0;            // log dimensionless jerk (scoring::LogDimensionlessJerk)
  double arc_length = 0;      // spectral (scoring::SpectralArcLength)
  double direction_bits = 0;  // Shannon entropy of the 10 ms steps' directions, in 26 of space
  double pause_percent = 0;   // share of 10 ms steps slower than a tenth of the fastest
};
// False for a second in which the hand moved less than 0.5 mm: it rests.
bool SignsOf(const dvec3* position_m, HandSigns& out);

// How well one figure separates programs, or copies, from people. `area`: under the receiver
// operating characteristic, the chance that a program's second has the higher figure than a
// person's; 0.5 separates nothing, 0 and 1 separate all. Its standard error: Hanley and McNeil,
// Radiology 143(1), 1982.
struct SignRoc {
  std::string sign;
  size_t people = 0, programs = 0;  // seconds of motion; of nearness pairs of motions
  double area = 0.5, standard_error = 0;
  // Share of the programs' seconds found when 5, 10 and 20 % of the people's are mistaken for a
  // program's, with the threshold on the side that finds more.
  double found_at_5 = 0, found_at_10 = 0, found_at_20 = 0;
  // Where the server calls lower figures worth a look (scoring::kMinTremor_um,
  // scoring::kNearOfSize): below which, and the share of people's taken for a program's by mistake
  // and of programs' found.
  std::optional<double> threshold{};
  double mistaken = 0, found = 0;
};
// Requires: both not empty.
SignRoc RocOf(std::string sign, std::vector<double> people, std::vector<double> programs,
              std::optional<double> threshold = {});

struct HandSignsOptions {
  std::string people;  // folder of CSV files as lab/laws/motions.h reads them
  std::vector<std::string> operators = {"dentist", "student-deep-mesial"};
  std::string exercise = "class-1-block";
  size_t seconds = 60;  // of each operator
};
// Each figure of a second of motion, and the nearness of two motions (scoring/motion.h, distance
// over size), by fifths of a recording: people who repeat a motion, against copies with noise,
// begun later, slower, and against the same simulated person with another tremor. Errors: kNotFound
// when the folder has no recordings, or an operator or exercise is unknown.
Result<std::vector<SignRoc>> MeasureHandSigns(
    const HandSignsOptions& options,
    const std::function<void(const std::string&, double)>& progress = {});

// schemas/lab_hand_signs.schema.json.
boost::json::object HandSignsJson(const std::vector<SignRoc>& rows);

}  // namespace enamel::station::lab
