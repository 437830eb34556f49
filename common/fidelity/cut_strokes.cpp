#include "common/fidelity/cut_strokes.h"

#include <algorithm>
#include <cmath>

#include "common/fidelity/way.h"
#include "common/scene/builtin/builtin.h"

namespace enamel::fidelity {
namespace {

constexpr size_t kBlock = 10;
constexpr double kBlock_s = kBlock * kWayStep_s;
// Slower, or with less force, nobody cuts: a bur that rests in its cut.
constexpr double kMinSpeed_m_per_s = 0.02e-3, kMinForce_n = 0.02;
constexpr size_t kMaxRest = 10, kShortest = 30, kLongest = 400;  // blocks
constexpr int kStrokes = 8;

dvec3 TipOf(const core::CoreParams& params, const core::TickInput& input) {
  dvec3 tip;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<size_t>(i);
    tip[i] = input.counts[k] * (params.resolution_nm[k] * 1e-9);
  }
  return tip;
}

}  // namespace

bool CutStrokes::Block::removes() const {
  return turns && Dot(resisted_n, moved_m) > 0 &&
         glm::length(moved_m) > kMinSpeed_m_per_s * kBlock_s &&
         glm::length(resisted_n) > kMinForce_n;
}

CutStrokes::CutStrokes(const core::CoreParams& params)
    : params_(params), every_(std::max<uint32_t>(1, params.rate_hz / 1000)) {}

void CutStrokes::Add(const core::TickInput& input, const core::TickWitness& witness) {
  dvec3 bur;
  for (int i = 0; i < 3; ++i) bur[i] = witness.anchor_100nm[static_cast<size_t>(i)] * 1e-7;
  // Over a gap nobody knows the way.
  if (ticks_ == 0 || input.gap_ticks > 0 || (witness.flags & core::kAnchorReset) != 0) {
    Close();
    filled_ = 0;
    bur_m_ = bur;
    sum_n_ = dvec3(0);
    turns_ = true;
    ticks_ = 0;
  }
  turns_ &= (input.flags & core::kBurOn) != 0;
  if (ticks_++ % every_ != 0) return;
  way_.push_back(TipOf(params_, input));
  for (int i = 0; i < 3; ++i)
    sum_n_[i] -= core::PressedForce_mn(witness)[static_cast<size_t>(i)] * 1e-3;
  if (++filled_ == kBlock) EndBlock(bur);
}

void CutStrokes::EndBlock(const dvec3& bur) {
  blocks_.push_back({bur - bur_m_, sum_n_ / static_cast<double>(kBlock), turns_});
  turns_ = true;
  bur_m_ = bur;
  sum_n_ = dvec3(0);
  filled_ = 0;
  if (blocks_.back().removes()) end_ = blocks_.size();
  // Without one that removes no stroke has begun.
  if (end_ == 0 || blocks_.size() - end_ > kMaxRest || end_ >= kLongest) Close();
}

void CutStrokes::Close() {
  if (end_ >= kShortest) strokes_.push_back(StrokeUnderWay());
  end_ = 0;
  blocks_.clear();
  way_.clear();
  if (strokes_.size() <= kMaxStrokes) return;
  std::vector<CutStroke> kept;
  for (size_t i = 0; i < strokes_.size(); ++i) {
    if (i % 2 == 0)
      kept.push_back(std::move(strokes_[i]));
    else
      kept.back().seconds += strokes_[i].seconds;
  }
  strokes_ = std::move(kept);
}

CutStroke CutStrokes::StrokeUnderWay() const {
  CutStroke out;
  double work_j = 0, way2 = 0, way_m = 0;
  for (size_t i = 0; i < end_; ++i) {
    const Block& b = blocks_[i];
    if (!b.removes()) continue;
    work_j += Dot(b.resisted_n, b.moved_m);
    way2 += Dot(b.moved_m, b.moved_m);
    way_m += glm::length(b.moved_m);
    out.seconds += kBlock_s;
  }
  out.b_n_s_per_m = work_j / way2 * kBlock_s;
  out.speed_m_per_s = way_m / out.seconds;
  out.way_m = Smoothed({way_.begin(), way_.begin() + static_cast<long>(end_ * kBlock)});
  const dvec3 from = out.way_m.front();
  for (dvec3& x : out.way_m) x -= from;
  return out;
}

std::vector<CutStroke> CutStrokes::Spread(int count) {
  Close();
  filled_ = 0;
  ticks_ = 0;
  double whole_s = 0;
  for (const CutStroke& s : strokes_) whole_s += s.seconds;
  std::vector<CutStroke> out;
  double passed_s = 0;
  for (const CutStroke& s : strokes_) {
    passed_s += s.seconds;
    while (static_cast<int>(out.size()) < count &&
           whole_s * (static_cast<double>(out.size()) + 0.5) / count < passed_s) {
      out.push_back(s);
      out.back().seconds = whole_s / count;
    }
  }
  return out;
}

FeltTrial TrialOf(const CutStroke& stroke, double grip_n_per_m, int delay_ticks,
                  const haptics::OwnFriction& told) {
  FeltTrial trial;
  trial.b_n_s_per_m = Sym3::Isotropic(stroke.b_n_s_per_m);
  trial.hand.stiffness_n_per_m = grip_n_per_m;
  trial.delay_ticks = delay_ticks;
  trial.friction = told;
  trial.ideal = false;
  return trial;
}

FeltDevice FeltDeviceOf(const scene::DeviceProfile& profile, const core::CoreParams& params) {
  FeltDevice d;
  d.mass_kg = static_cast<double>(profile.mass_g.value) * 1e-3;
  d.damping_n_s_per_m = static_cast<double>(profile.viscous_mn_s_per_m()) * 1e-3;
  d.friction_n = static_cast<double>(profile.friction_mn.value) * 1e-3;
  // The unit's own, where that was measured: the lower end.
  const haptics::OwnFriction told = core::OwnFrictionOf(params);
  const double measured = std::max({told.c_n.x, told.c_n.y, told.c_n.z});
  if (told.measured && measured > 0) d.friction_n = measured;
  d.resolution_m = static_cast<double>(profile.resolution_nm.value) * 1e-9;
  d.kc_n_per_m = params.kc_mn_per_mm;
  d.peak_force_n = params.peak_force_mn * 1e-3;
  d.tick_s = 1.0 / params.rate_hz;
  return d;
}

std::optional<double> FeltErrorOf(const scene::DeviceProfile& profile,
                                  const core::CoreParams& params, CutStrokes& strokes) {
  // A way has one position a millisecond.
  if (!scene::HasMotors(profile) || params.spring_on_board || params.rate_hz % 1000 != 0)
    return std::nullopt;
  const FeltDevice device = FeltDeviceOf(profile, params);
  double error2 = 0, tool2 = 0;
  for (const CutStroke& stroke : strokes.Spread(kStrokes)) {
    FeltTrial trial =
        TrialOf(stroke, kAttemptGrip_n_per_m, static_cast<int>(params.bus_delay_ticks),
                core::OwnFrictionOf(params));
    trial.law = params.law;
    const FeltFigures felt = Feel(device, trial, stroke.way_m);
    // So little force is a touch and no cut.
    if (!(felt.tool_rms_n > kMinForce_n)) continue;
    error2 += felt.felt_error_rms_n * felt.felt_error_rms_n;
    tool2 += felt.tool_rms_n * felt.tool_rms_n;
  }
  if (!(tool2 > 0) || !std::isfinite(error2 / tool2)) return std::nullopt;
  return std::sqrt(error2 / tool2);
}

}  // namespace enamel::fidelity
