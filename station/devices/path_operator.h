#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/fidelity/random.h"
#include "station/devices/cavity_plan.h"
#include "station/devices/operator.h"

namespace enamel::station {

// The properties of a person's hand and eye that matter here. SI units.
struct HandParams {
  double stiffness_n_per_m = 800;  // 0.5 to 1 N/mm
  double damping_n_s_per_m = 20;
  double max_force_n = 3.5;
  double coupling_n_per_m = 2500;  // of the device in hand, which he is used to
  double eye_delay_s = 0.150;      // from the picture to the hand
  double lean_rate_per_s = 1.5;    // slow correction of the distance he sees from the line
  double max_lean_m = 0.15e-3;
  double light_touch_m = 50e-6;  // lean that only just overcomes the device's friction
  double back_off_m = 25e-6;     // from where a wall is done
  double tremor_m = 8e-6;        // rms per axis of an 8 to 12 Hz tremor; 0: none
  uint64_t seed = 1;             // of the tremor
  Quat orientation;              // in which he holds the bur
};

// Follows a plan with a hand impedance. He sees the bur late and knows how his hand has moved
// since, so he expects it at seen + hand now - hand then. Along a stroke the hand's equilibrium is
// ahead of that, by at most the distance that gives the wanted push, and by less near the end: the
// bur comes to rest from behind. Across the stroke he corrects slowly what he sees. On finishing
// rings he remembers from pass to pass how much each side needs.
//
// Real-time: Act is safe (memory is fixed when built). Thread safety: none.
class PathOperator final : public SimulatedOperator {
 public:
  PathOperator(std::string name, std::vector<Move> plan, const HandParams& params, dvec3 start_m);

  std::string Name() const override { return name_; }
  dvec3 Start_m() const override { return start_m_; }
  ENAMEL_REALTIME HandDrive Act(const dvec3& hand_m, const dvec3& bur_m,
                                double tick_s) noexcept override;
  double Progress() const noexcept override;

 private:
  static constexpr size_t kDelayRing = 4096;  // eye_delay_s at the fastest loop, 20 kHz
  static constexpr size_t kMaxSides = 128;    // a round floor's
  static constexpr size_t kMaxBins = 32;

  // One straight piece of the way.
  struct Leg {
    dvec3 from{0}, along{0};
    double length = 0;
    double feed = 0, lead = 0, tolerance = 0;
    bool bur_on = false;
    dvec3 learnt_axis{0};  // across the leg: corrected from pass to pass, not while moving
  };
  // A piece of a finishing side.
  struct Bin {
    double lean = 0;     // how far beyond the line the hand aims here
    double deepest = 0;  // greatest mean depth of a pass so far, against the line, m
    bool seen = false;
    double sum = 0;  // of this pass
    int count = 0;
  };
  struct Side {
    std::array<Bin, kMaxBins> bins{};
    size_t bin_count = 0;
    size_t undone = 0;    // bins, after the last pass
    double gained_m = 0;  // by the last pass, summed over bins that were not done
    double yield = 0;     // how much of the lean a pass takes
  };
  // The operator's knowledge at one moment.
  struct Moment {
    dvec3 hand_m{0}, bur_m{0};
  };

  // Stores `now`; returns the moment that the delayed picture shows.
  Moment Seen(const Moment& now) noexcept;
  void BeginLeg(const dvec3& to, const Stroke& like) noexcept;
  void NextLeg() noexcept;
  void NextMove() noexcept;
  bool NextRingSide(const FinishRing& ring) noexcept;
  void BeginRingSide(const FinishRing& ring) noexcept;
  bool EndPass(const FinishRing& ring) noexcept;
  double LeanInSight(const FinishRing& ring, const dvec3& seen) const noexcept;
  bool Lingers(double along_m) const noexcept;
  static void SmoothLeans(Side& side) noexcept;
  // Number of bins not done yet.
  size_t LearnSide(Side& side, double accuracy_m, bool gentle) noexcept;
  // Passes alternate in direction, so that no corner is always approached from one side.
  bool backward() const noexcept { return pass_ % 2 != 0; }
  // Distance along a side from its first corner, in either direction of travel.
  double FromCorner(double along_m) const noexcept;
  size_t BinCount() const noexcept;
  double LearntLean(double along_m) const noexcept;
  void WatchSide(const FinishRing& ring, const dvec3& seen) noexcept;
  dvec3 Tremor(double tick_s) noexcept;

  const std::string name_;
  const std::vector<Move> plan_;
  const HandParams params_;
  const dvec3 start_m_;

  size_t move_ = 0, point_ = 0, side_ = 0, step_ = 0;
  int pass_ = 0, idle_passes_ = 0;
  std::array<Side, kMaxSides> sides_{};
  bool finished_ = false;

  Leg leg_;
  dvec3 at_{0};        // end of the last leg, on the plan
  double carrot_ = 0;  // how far along the leg the equilibrium is
  dvec3 lean_{0};
  dvec3 equilibrium_{0};
  double best_ = 0;  // nearest to the leg's end so far
  double stalled_s_ = 0;

  std::array<Moment, kDelayRing> past_{};
  size_t past_head_ = 0, past_count_ = 0, delay_ticks_ = 0;
  std::array<dvec3, 2> tremor_state_{};
  fidelity::Random random_;
};

}  // namespace enamel::station
