#include "station/devices/path_operator.h"

#include <algorithm>
#include <cmath>

#include "station/devices/limited.h"

namespace enamel::station {
namespace {

constexpr double kTremorHz = 10;
constexpr double kTremorDamping = 0.15;  // spread over about 8 to 12 Hz
constexpr double kOnLine_m = 40e-6;      // beside the line: near enough for full feed
constexpr double kOffLine_m = 200e-6;    // here he waits until the bur is back
constexpr double kMinLead_m = 50e-6;
constexpr double kReach = 5.0;    // of what he sees beside the line, added at once
constexpr double kPress = 2.5;    // how far he aims beyond the end, of what is left
constexpr double kStall_s = 1.5;  // no progress for this long: he moves on
constexpr double kRingStall_s = 0.35;
constexpr double kStallStep_m = 10e-6;
constexpr double kBin_m = 0.2e-3;  // length of a side that is judged and pressed as one
constexpr double kMaxStretch_m = 1.2e-3;
constexpr double kFirstYield = 0.08;  // share of the lean a pass takes, before he knows better
constexpr double kAim = 0.7;          // of what is left, to be taken in one pass
constexpr double kGoodEnough = 0.08;  // share of the bins that may be left
constexpr double kGentle = 0.2;       // of a light touch: more lean per pass, at most
constexpr double kNoGain_m = 5e-6;    // of all bins of a pass together: pressing on is no use
// Times what he sees is left, leaned beyond the line: hand and spring in series give way to most of it.
constexpr double kLean = 4;
constexpr double kHurry = 2;             // times the feed
constexpr double kLinger = 0.3;          // of the feed
constexpr double kMaxLinger_m = 150e-6;  // with more lean he would dig in
constexpr double kMaxSlope_m = 120e-6;   // of the lean, per bin

dvec3 Across(const dvec3& v, const dvec3& unit) noexcept { return v - unit * Dot(v, unit); }

}  // namespace

PathOperator::PathOperator(std::string name, std::vector<Move> plan, const HandParams& params,
                           dvec3 start_m)
    : name_(std::move(name)),
      plan_(std::move(plan)),
      params_(params),
      start_m_(start_m),
      // The sensor's noise begins at the seed itself.
      random_(~params.seed) {
  for (const Move& move : plan_) {
    if (const auto* ring = std::get_if<FinishRing>(&move)) {
      ENAMEL_CHECK(ring->corners.size() == ring->outward.size());
      ENAMEL_CHECK(ring->corners.size() <= kMaxSides);
    } else {
      ENAMEL_CHECK(!std::get<Stroke>(move).points.empty());
    }
  }
  at_ = equilibrium_ = start_m_;
  move_ = static_cast<size_t>(-1);
  NextMove();
}

double PathOperator::Progress() const noexcept {
  if (finished_ || plan_.empty()) return 1;
  return static_cast<double>(move_) / static_cast<double>(plan_.size());
}

PathOperator::Moment PathOperator::Seen(const Moment& now) noexcept {
  past_[past_head_] = now;
  past_count_ = std::min(past_count_ + 1, delay_ticks_ + 1);
  Moment out = past_[(past_head_ + kDelayRing - (past_count_ - 1)) % kDelayRing];
  past_head_ = (past_head_ + 1) % kDelayRing;
  return out;
}

HandDrive PathOperator::Act(const dvec3& hand_m, const dvec3& bur_m, double tick_s) noexcept {
  if (delay_ticks_ == 0) {
    delay_ticks_ =
        std::clamp(static_cast<size_t>(params_.eye_delay_s / tick_s), size_t{1}, kDelayRing - 1);
  }
  Moment past = Seen({hand_m, bur_m});
  const dvec3& seen = past.bur_m;
  dvec3 expected = seen + (hand_m - past.hand_m);
  HandDrive hand;
  hand.stiffness_n_per_m = params_.stiffness_n_per_m;
  hand.damping_n_s_per_m = params_.damping_n_s_per_m;
  hand.max_force_n = params_.max_force_n;
  hand.orientation = params_.orientation;
  hand.finished = finished_;
  hand.pedal = !finished_ && leg_.bur_on;
  dvec3 before = equilibrium_;
  if (!finished_) {
    double there = Dot(expected - leg_.from, leg_.along);
    dvec3 beside = Across(leg_.from - expected, leg_.along);
    beside = Across(beside, leg_.learnt_axis);
    // Off the line he first gets back to it.
    double on = std::clamp((kOffLine_m - std::sqrt(Dot(beside, beside))) / (kOffLine_m - kOnLine_m),
                           0.0, 1.0);
    if (Lingers(there)) on *= kLinger;
    carrot_ = std::min({carrot_ + on * leg_.feed * tick_s,
                        std::max(there, 0.0) + kMinLead_m + on * leg_.lead,
                        leg_.length + kPress * std::max(0.0, leg_.length - there)});
    lean_ = Limited(lean_ + beside * (params_.lean_rate_per_s * tick_s), params_.max_lean_m);
    equilibrium_ = leg_.from + leg_.along * carrot_ + lean_ + beside * kReach;
    const auto* ring = std::get_if<FinishRing>(&plan_[move_]);
    if (ring && leg_.learnt_axis != dvec3(0)) {
      equilibrium_ += leg_.learnt_axis * std::min(LearntLean(there), LeanInSight(*ring, seen));
    }
    if (ring && leg_.learnt_axis != dvec3(0)) WatchSide(*ring, seen);
    double left = leg_.length - Dot(seen - leg_.from, leg_.along);
    stalled_s_ = left < best_ - kStallStep_m ? 0 : stalled_s_ + tick_s;
    best_ = std::min(best_, stalled_s_ == 0 ? left : best_);
    bool arrived = leg_.length - there < leg_.tolerance && left < 3 * leg_.tolerance;
    if (arrived || stalled_s_ > (leg_.learnt_axis == dvec3(0) ? kStall_s : kRingStall_s)) NextLeg();
  }
  dvec3 tremor = Tremor(tick_s);
  hand.equilibrium_m = equilibrium_ + tremor;
  // Steps of the plan are left to the arm, not the damper.
  hand.velocity_m_per_s = Limited((equilibrium_ - before) / tick_s, leg_.feed);
  return hand;
}

void PathOperator::BeginLeg(const dvec3& to, const Stroke& like) noexcept {
  dvec3 way = to - at_;
  double length = std::sqrt(Dot(way, way));
  leg_ = Leg{};
  leg_.from = at_;
  leg_.along = length > 0 ? way / length : dvec3(0, 0, 1);
  leg_.length = length;
  leg_.feed = like.feed_m_per_s;
  double spring = 1 / (1 / params_.stiffness_n_per_m + 1 / params_.coupling_n_per_m);
  leg_.lead = like.push_n / spring + like.feed_m_per_s * params_.eye_delay_s;
  leg_.tolerance = like.tolerance_m;
  leg_.bur_on = like.bur_on;
  lean_ = Across(lean_, leg_.along);
  carrot_ = 0;
  best_ = length + 1;
  stalled_s_ = 0;
  at_ = to;
}

void PathOperator::NextLeg() noexcept {
  if (const auto* stroke = std::get_if<Stroke>(&plan_[move_])) {
    if (++point_ < stroke->points.size()) {
      BeginLeg(stroke->points[point_], *stroke);
      return;
    }
  } else if (NextRingSide(std::get<FinishRing>(plan_[move_]))) {
    return;
  }
  NextMove();
}

void PathOperator::NextMove() noexcept {
  if (++move_ >= plan_.size()) {
    finished_ = true;
    return;
  }
  if (const auto* stroke = std::get_if<Stroke>(&plan_[move_])) {
    point_ = 0;
    BeginLeg(stroke->points[0], *stroke);
    return;
  }
  const auto& ring = std::get<FinishRing>(plan_[move_]);
  sides_.fill(Side{});
  for (Side& side : sides_) {
    side.yield = kFirstYield;
    for (Bin& bin : side.bins) bin.lean = ring.gentle ? kGentle * params_.light_touch_m : 0;
  }
  pass_ = idle_passes_ = 0;
  Stroke like;
  like.feed_m_per_s = ring.feed_m_per_s;
  like.push_n = ring.push_n;
  like.tolerance_m = 0.3e-3;
  BeginLeg(ring.corners[0], like);
}

void PathOperator::BeginRingSide(const FinishRing& ring) noexcept {
  Stroke like;
  like.feed_m_per_s = ring.feed_m_per_s;
  like.push_n = ring.push_n;
  like.tolerance_m = ring.tolerance_m;
  side_ = backward() ? ring.corners.size() - 1 - step_ : step_;
  BeginLeg(ring.corners[(side_ + (backward() ? 0 : 1)) % ring.corners.size()], like);
  leg_.learnt_axis = ring.outward[side_];
  // He hurries past clean parts.
  if (pass_ > 0 && sides_[side_].undone == 0) leg_.feed *= kHurry;
  lean_ = Across(lean_, leg_.learnt_axis);
}

bool PathOperator::NextRingSide(const FinishRing& ring) noexcept {
  if (leg_.learnt_axis == dvec3(0)) {
    step_ = 0;  // at the first corner
  } else if (++step_ == ring.corners.size()) {
    step_ = 0;
    bool done = EndPass(ring);
    if (done || ++pass_ > ring.max_passes) return false;
  }
  BeginRingSide(ring);
  return true;
}

double PathOperator::FromCorner(double along_m) const noexcept {
  return backward() ? leg_.length - along_m : along_m;
}

size_t PathOperator::BinCount() const noexcept {
  return std::clamp(static_cast<size_t>(leg_.length / kBin_m), size_t{1}, kMaxBins);
}

double PathOperator::LearntLean(double along_m) const noexcept {
  const Side& side = sides_[side_];
  if (carrot_ >= leg_.length)
    return -params_.back_off_m;  // arriving: he no longer presses sideways
  size_t n = BinCount();
  double at = std::clamp(FromCorner(along_m) / leg_.length * static_cast<double>(n) - 0.5, 0.0,
                         static_cast<double>(n - 1));
  auto i = static_cast<size_t>(at);
  double part = at - static_cast<double>(i);
  return side.bins[i].lean * (1 - part) + side.bins[std::min(i + 1, n - 1)].lean * part;
}

// Limits the learned lean by what he sees is left, and lets go where the bur has reached the line.
double PathOperator::LeanInSight(const FinishRing& ring, const dvec3& seen) const noexcept {
  if (ring.gentle) return kMaxStretch_m;
  double left = Dot(ring.corners[side_] - seen, leg_.learnt_axis);
  return left > ring.accuracy_m ? params_.light_touch_m + kLean * left : -params_.back_off_m;
}

// He goes slowly out of a corner that is not clean yet.
bool PathOperator::Lingers(double along_m) const noexcept {
  if (leg_.learnt_axis == dvec3(0)) return false;
  const Bin& first = sides_[side_].bins[backward() ? BinCount() - 1 : 0];
  return first.seen && first.lean > 0 && first.lean < kMaxLinger_m &&
         along_m < leg_.length / static_cast<double>(BinCount());
}

void PathOperator::WatchSide(const FinishRing& ring, const dvec3& seen) noexcept {
  Side& side = sides_[side_];
  double along = FromCorner(Dot(seen - leg_.from, leg_.along));
  if (along < 0 || along > leg_.length) return;
  side.bin_count = BinCount();
  auto i = std::min(static_cast<size_t>(along / leg_.length * static_cast<double>(side.bin_count)),
                    side.bin_count - 1);
  side.bins[i].sum += Dot(seen - ring.corners[side_], ring.outward[side_]);
  ++side.bins[i].count;
}

// Compares what he saw with the target, bin by bin, and adjusts the lean of the next pass. True
// when everything is done.
bool PathOperator::EndPass(const FinishRing& ring) noexcept {
  double gained = 0;
  size_t bins = 0, left = 0;
  for (size_t i = 0; i < ring.corners.size(); ++i) {
    left += LearnSide(sides_[i], ring.accuracy_m, ring.gentle);
    gained += sides_[i].gained_m;
    bins += sides_[i].bin_count;
  }
  idle_passes_ = gained < kNoGain_m ? idle_passes_ + 1 : 0;
  return pass_ > 0 && (static_cast<double>(left) < kGoodEnough * static_cast<double>(bins) ||
                       idle_passes_ >= (ring.gentle ? 4 : 2));
}

// The arm cannot change its push abruptly from one bin to the next: limited to a slope.
void PathOperator::SmoothLeans(Side& side) noexcept {
  auto limit = [&](size_t b, size_t next) {
    if (!side.bins[next].seen) return;
    side.bins[b].lean = std::min(side.bins[b].lean, side.bins[next].lean + kMaxSlope_m);
  };
  for (size_t b = 1; b < side.bin_count; ++b) limit(b, b - 1);
  for (size_t b = side.bin_count; b-- > 1;) limit(b - 1, b);
}

size_t PathOperator::LearnSide(Side& side, double accuracy_m, bool gentle) noexcept {
  double gained = 0, pressed = 0;
  for (size_t b = 0; b < side.bin_count; ++b) {
    Bin& bin = side.bins[b];
    if (bin.count == 0) continue;
    double depth = bin.sum / bin.count;
    double stretch = bin.lean - bin.deepest - params_.light_touch_m;
    if (bin.seen && bin.deepest < -accuracy_m && stretch > 0) {
      gained += std::max(0.0, depth - bin.deepest);
      pressed += stretch;
    }
    bin.deepest = bin.seen ? std::max(bin.deepest, depth) : depth;
    bin.seen = true;
    bin.sum = 0;
    bin.count = 0;
  }
  if (pressed > 0) {
    side.yield = std::clamp(gained / pressed, std::max(0.04, 0.5 * side.yield),
                            std::min(1.5, 2 * side.yield));
  }
  side.gained_m = gained;
  size_t undone = 0;
  for (size_t b = 0; b < side.bin_count; ++b) {
    Bin& bin = side.bins[b];
    double left = -bin.deepest;
    if (!bin.seen) continue;
    if (left < accuracy_m) {
      bin.lean = -params_.back_off_m;
      continue;
    }
    ++undone;
    bin.lean =
        gentle ? bin.lean + std::min(kAim * left, kGentle * params_.light_touch_m)
               : std::min(params_.light_touch_m + kAim * left / side.yield, kMaxStretch_m) - left;
  }
  SmoothLeans(side);
  side.undone = undone;
  return undone;
}

dvec3 PathOperator::Tremor(double tick_s) noexcept {
  if (params_.tremor_m <= 0) return dvec3(0);
  constexpr double kOmega = 2 * 3.14159265358979323846 * kTremorHz;
  // A resonator kicked by noise; its variance is kick^2 / (4 damping omega^3 dt).
  double kick =
      params_.tremor_m * std::sqrt(4 * kTremorDamping * kOmega * kOmega * kOmega * tick_s);
  auto& [x, v] = tremor_state_;
  for (int i = 0; i < 3; ++i) {
    const double noise = random_.Signed() * std::sqrt(3.0);  // of variance 1
    v[i] += noise * kick - (kOmega * kOmega * x[i] + 2 * kTremorDamping * kOmega * v[i]) * tick_s;
  }
  x += v * tick_s;
  return x;
}

}  // namespace enamel::station
