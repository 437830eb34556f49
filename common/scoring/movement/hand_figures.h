#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "common/scoring/movement/process.h"

// Figures of the hand behind a recording, beside a motion (schemas/motion.md). They help a person
// decide which attempts to look at. They cost no points and prove nothing: a program can be written
// that trembles and rests like a person. Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

struct HandFigures {
  static constexpr int32_t kNoTremor = -1;
  int32_t tremor_nm = kNoTremor;  // 8 to 12 Hz, in contact (TremorMeter); else: no whole second
  int32_t still_ppm = 0;          // share of the time slower than kStill_m_s, gaps left out
  int32_t late_ppm = 0;           // share of the ticks that the loop was late for
  int32_t gap_ppm = 0;            // share of the ticks that are missing

  bool operator==(const HandFigures&) const = default;
};

inline constexpr double kStill_m_s = 1e-3;
HandFigures FiguresOf(const ProcessRecorder& process);

// A hand that trembles less is worth a look. How many seconds of people's motion lie below it by
// mistake: `enamel-lab hand-signs`.
inline constexpr double kMinTremor_um = 8;
bool IsTooCalm(const HandFigures& figures);

// What is compared between the attempts of an assignment. `near_share`: distance to the nearest
// earlier motion over the motion's own size; none: there was none.
struct HandRecord {
  HandFigures hand;
  std::optional<double> near_share;
};

// Place of records[which] among all, 1 the most unusual; equal ones share the better place. An
// attempt is as unusual as its most unusual figure: the distance from the median in robust standard
// deviations (1.4826 times the median distance from the median, at least the floor of
// schemas/motion.md). Of nearness only nearer counts. Nothing for fewer than kMinRanked records.
// Requires: which < records.size().
inline constexpr size_t kMinRanked = 5;
std::optional<size_t> UnusualRank(std::span<const HandRecord> records, size_t which);

}  // namespace enamel::scoring
