#pragma once

#include <optional>
#include <vector>

#include "common/core/core.h"
#include "common/scoring/movement/smoothness.h"
#include "common/scoring/movement/strokes.h"
#include "common/trace/trace.h"

// What the hand did, from a recording; schemas/score.md, "Process", has the formula of every
// figure. Deterministic. Thread safety: one owner. Real-time: not safe (allocates).
namespace enamel::scoring {

// A stretch of the recording reduced to what the alignment needs.
struct PathSample {
  double time_s;   // since the start, gaps included
  dvec3 anchor_m;  // scene frame, at the stretch's first tick
  dvec3 force_n;   // pressed (core::PressedForce_mn), mean over the stretch
  double way_m;    // of the anchor until then, without the jumps after gaps and faults
};

// Accumulates process metrics during the replay pass (trace::Replay's observe). Pose and force are
// taken at the resolution of the witness (0.1 um, 1 mN), so that a recording read back without
// re-running the core gives the same figures. The force is what the hand pressed with
// (core::PressedForce_mn): a touch cue is not the student's.
class ProcessRecorder {
 public:
  // Requires: ValidateParams(params).ok().
  explicit ProcessRecorder(const core::CoreParams& params);

  void Add(const trace::Tick& tick, const core::TickOutput& output);
  // The same from the recording alone, for a reference whose replay was verified before: everything
  // but what needs the removal (cutting_s, force_sent_mean_cutting_n stay 0, and what is said
  // below).
  void AddRecorded(const trace::Tick& tick);

  // After the last Add:
  uint64_t ticks() const { return ticks_; }
  uint64_t gap_ticks() const { return gap_ticks_; }
  double duration_s() const;  // gaps included
  // Time less than 50 ms after something was removed: a cut is renewed when it would leave a mark,
  // after some way or some ticks, so that most ticks of a stroke remove nothing themselves, the
  // more of them the faster the loop.
  double cutting_s() const;
  double anchor_path_m() const { return path_m_; }  // without the jumps after gaps and faults
  double force_sent_p95_n() const;                  // over ticks with any force; 1 mN steps
  double force_sent_max_n() const { return max_force_n_; }
  double force_sent_mean_cutting_n() const;  // mean over cutting ticks; 0 when nothing was cut
  uint64_t bounded_ticks() const { return bounded_ticks_; }  // peak bound engaged
  uint64_t late_ticks() const { return late_ticks_; }
  // Times the device or the station took the force away: gaps without force, and faults.
  uint64_t outages() const { return outages_; }
  bool shook() const { return shook_; }  // the core saw hand and device swing
  // At most 50 Hz.
  const std::vector<PathSample>& samples() const { return samples_; }
  double impulse_n_s() const { return impulse_n_s_; }
  // Work of the hand on the tool, less the work it got back: - the sum of F (p_next - p), F pressed
  // and held over the tick, p as the device read it. Not over gaps and faults.
  double work_j() const { return work_j_; }
  // |F - F before| / 10 ms of the means of 10 ms, over those with any force; 0.1 N/s steps.
  double force_rate_p95_n_per_s() const;
  // Ticks with any force: of these the bounds' share is what a force figure suffers from.
  uint64_t force_ticks() const { return force_ticks_; }

  // From a replay only; a recording alone has none.
  const StrokeRecorder& strokes() const { return strokes_; }
  double idle_s() const;  // outside contacts, without gaps
  // Angle of the bur's axis, as the device holds it, against +z of the scene, read 50 times a
  // second while cutting_s counts; steps of 0.1 degrees. Nothing where nothing was cut.
  std::optional<double> angulation_mean_deg() const;
  std::optional<double> angulation_p95_deg() const;
  // By when half of what was removed of a tissue was: s since the start, gaps included; steps of
  // 0.1 s. Nothing where none was.
  std::optional<double> half_removed_s(cutting::Tissue tissue) const;
  // Medians over the strokes of at least a second, of the anchor's speed at 50 Hz (smoothness.h).
  struct Smoothness {
    std::optional<double> log_dimensionless_jerk, spectral_arc_length;
  };
  Smoothness MeasureSmoothness() const;  // takes a while
  // Of the device's readings, in contact (smoothness.h).
  std::optional<double> tremor_m() const { return tremor_.Rms_m(); }

 private:
  void AddWitness(const core::TickInput& input, const core::TickWitness& witness, bool cutting);
  void AddForceRate(const dvec3& force, bool broken);
  void AddAngle(const QuantisedOrientation& orientation);

  uint32_t rate_hz_;
  dvec3 origin_m_, resolution_m_;
  uint32_t decimation_;  // ticks per kept sample
  uint64_t cutting_window_,
      cutting_left_ = 0;  // ticks that count as cutting after one that removed
  uint64_t cutting_time_ticks_ = 0;
  uint64_t ticks_ = 0, cutting_ticks_ = 0, bounded_ticks_ = 0, late_ticks_ = 0, gap_ticks_ = 0;
  uint64_t outages_ = 0;
  bool is_faulted_ = false, shook_ = false;
  uint64_t force_ticks_ = 0;
  double path_m_ = 0, max_force_n_ = 0, cutting_force_sum_n_ = 0;
  dvec3 last_anchor_{0};
  std::vector<uint32_t> force_histogram_;  // 1 mN bins
  std::vector<PathSample> samples_;
  // Anchors of the samples as the replay computes them: the jerk of a slow, skilled hand is less
  // than what the witness's rounding adds.
  std::vector<dvec3> computed_m_;

  double impulse_n_s_ = 0, work_j_ = 0;
  dvec3 last_tip_m_{0}, last_force_n_{0};
  uint32_t block_ticks_, in_block_ = 0;  // of 10 ms
  bool block_before_ = false;
  dvec3 block_sum_n_{0}, last_block_n_{0};
  std::vector<uint32_t> rate_histogram_;  // 0.1 N/s bins
  uint64_t rates_ = 0;

  StrokeRecorder strokes_;
  TremorMeter tremor_;
  std::vector<uint32_t> angle_histogram_;  // 0.1 degree bins
  uint64_t angles_ = 0;
  double angle_sum_deg_ = 0;
  uint32_t tenth_ticks_;
  std::vector<cutting::RemovedUnits> removed_;  // in each tenth of a second
};

}  // namespace enamel::scoring
