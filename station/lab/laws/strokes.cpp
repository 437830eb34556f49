#include "station/lab/laws/strokes.h"

#include <algorithm>
#include <cmath>

#include "common/core/core.h"
#include "common/fidelity/feel.h"
#include "station/lab/laws/stroke_way.h"
#include "station/lab/laws/withdrawal.h"

namespace enamel::station::lab {
namespace {

using cutting::Pose;

constexpr double kB_n_s_per_m = 6500;
constexpr double kLongest_s = 12;
// Below a four-hundredth of B nothing is ahead: 0.03 N at 2 mm/s.
constexpr double kNothing_n_s_per_m = kB_n_s_per_m / 400;

// The ideal: a bur at the tip.
class IdealBur {
 public:
  IdealBur(const cutting::Volume& block, const dvec3& tip_m)
      : volume_(block),
        cutter_((volume_.Reserve(), volume_), StrokeBur()),
        reader_(StrokeBur(), block.spec().voxel_m(), Damping()),
        tip_(tip_m) {}

  struct Felt {
    dvec3 force_n{0};            // R
    double ahead_n_s_per_m = 0;  // damping along `direction`
  };
  Felt MoveTo(const dvec3& tip_m, const dvec3& direction, double tick_s) {
    const dvec3 way = tip_m - tip_;
    const double length = glm::length(way), step = 0.5 * volume_.spec().voxel_m();
    const int moves = std::max(1, static_cast<int>(std::ceil(length / step)));
    Felt felt;
    const dvec3 from = tip_;
    for (int i = 1; i <= moves; ++i) {
      reader_.Sample(volume_, {tip_, {}});
      if (length > 0)
        felt.force_n += reader_.Read(volume_, way).damping_n_s_per_m * way * (1 / (tick_s * moves));
      const dvec3 press = reader_.Read(volume_, direction).damping_n_s_per_m * direction;
      felt.ahead_n_s_per_m = std::max(felt.ahead_n_s_per_m, Dot(press, direction));
      tip_ = from + way * (static_cast<double>(i) / moves);
      cutter_.Cut({tip_, {}}, removed_);
    }
    return felt;
  }

 private:
  static cutting::TissueDamping Damping() {
    cutting::TissueDamping d;
    d.lateral.fill(kB_n_s_per_m);
    d.axial.fill(kB_n_s_per_m);
    return d;
  }

  cutting::Volume volume_;
  cutting::Cutter cutter_;
  cutting::EngagementReader reader_;
  cutting::RemovedUnits removed_{};
  dvec3 tip_;
};

core::CoreParams ParamsOf(const DeviceModel& m, haptics::LawKind law) {
  auto nm = [](double v) { return static_cast<int32_t>(std::lround(v * 1e9)); };
  core::CoreParams p;
  p.rate_hz = static_cast<uint32_t>(std::lround(m.rate_hz));
  p.law = law;
  p.kc_mn_per_mm = static_cast<int32_t>(std::lround(m.kc_n_per_m));
  p.resolution_nm.fill(nm(m.resolution_m));
  p.peak_force_mn = static_cast<int32_t>(std::lround(m.peak_force_n * 1e3));
  p.soft_start_ticks = 0;
  p.bur_shape = StrokeBur().shape;
  p.bur_radius_nm = nm(StrokeBur().radius_m);
  p.bur_length_nm = nm(StrokeBur().length_m);
  p.damping_mn_s_per_mm[static_cast<size_t>(cutting::Tissue::kEnamel)] =
      static_cast<int32_t>(kB_n_s_per_m);
  p.bus_delay_ticks = static_cast<uint32_t>(m.delay_ticks);
  return p;
}

// A tick before evaluation.
struct Raw {
  double t_s = 0, ahead_n_s_per_m = 0;
  dvec3 r{0}, in_hand{0}, ideal{0}, oracle{0}, tip{0}, bur{0}, direction{0};
};

class StrokeRun {
 public:
  StrokeRun(const DeviceModel& m, StrokeCase c, haptics::LawKind law, const cutting::Volume& block)
      : model_(m),
        case_(c),
        law_(law),
        way_(WayOf(c, m)),
        hand_(way_),
        plant_(Spec(m), hand_, way_.start),
        core_(ParamsOf(m, law), block),
        ideal_(block, way_.start) {}

  StrokeTrack Run() {
    input_.flags = core::kBurOn;
    StepCore();
    while (!Over()) Tick();
    StrokeTrack out;
    out.which = case_;
    out.law = law_;
    Draw(&out);
    Judge(&out);
    return out;
  }

 private:
  static PlantSpec Spec(const DeviceModel& m) {
    PlantSpec s = SpecOf(m, haptics::kDefaultLaw, kB_n_s_per_m, 0).plant;
    s.mode_hz = 0;  // rigid
    return s;
  }
  bool Over() const {
    if (plant_.time_s() > kLongest_s) return true;
    if (Dot(way_.push, way_.push) == 0) return plant_.time_s() >= hand_.end_s();
    return Dot(plant_.tip_m() - way_.start, way_.along) > way_.push_end_m;
  }
  void StepCore() {
    for (int i = 0; i < 3; ++i) {
      input_.counts[static_cast<size_t>(i)] =
          static_cast<int32_t>(std::lround(plant_.tip_m()[i] / model_.resolution_m));
    }
    out_ = core_.Step(input_);
  }
  // The hand moves under the last tick's force; then the loop reads and answers.
  void Tick() {
    hand_.Feels(plant_.tip_m(), -out_.force_sent_n, plant_.time_s());
    const dvec3 was = plant_.tip_m();
    const double tick_s = model_.tick_s();
    plant_.Step(out_.force_sent_n);
    Raw raw;
    raw.in_hand = plant_.in_hand_n();
    StepCore();
    raw.t_s = plant_.time_s();
    raw.tip = plant_.tip_m();
    raw.bur = out_.anchor.tip_m;
    raw.r = -out_.force_sent_n;
    raw.direction = hand_.DirectionAt(plant_.time_s() - 0.5 * tick_s);
    IdealBur::Felt felt = ideal_.MoveTo(raw.tip, raw.direction, tick_s);
    raw.ideal = felt.force_n;
    raw.ahead_n_s_per_m = felt.ahead_n_s_per_m;
    // The oracle knows B v and has no memory; like any coupling's, its force rises by at most Kc
    // times the tip's distance.
    const double most = std::min(
        glm::length(oracle_) + model_.kc_n_per_m * glm::length(raw.tip - was), model_.peak_force_n);
    const double wanted = glm::length(raw.ideal);
    oracle_ = raw.oracle = wanted > most ? raw.ideal * (most / wanted) : raw.ideal;
    raw_.push_back(raw);
  }

  size_t FirstRecorded() const {
    size_t i = 0;
    while (i + 1 < raw_.size() && raw_[i].t_s < hand_.record_from_s()) ++i;
    return i;
  }
  void Draw(StrokeTrack* out) const {
    const size_t from = FirstRecorded();
    for (size_t i = from; i < raw_.size(); ++i) {
      const Raw& k = raw_[i];
      auto Along = [&](const dvec3& p) { return Dot(p - raw_[from].tip, way_.along); };
      out->points.push_back({k.t_s - raw_[from].t_s, Dot(k.r, k.direction), glm::length(k.r),
                             Dot(k.ideal, k.direction), Dot(k.oracle, k.direction), Along(k.tip),
                             Along(k.bur)});
    }
  }

  // The last tick with tissue ahead.
  size_t LastAhead() const {
    size_t last = 0;
    for (size_t i = 0; i < raw_.size(); ++i) {
      if (raw_[i].ahead_n_s_per_m >= kNothing_n_s_per_m) last = i;
    }
    return last;
  }
  void Judge(StrokeTrack* out) const {
    auto Add = [&](const char* name, const char* unit, double value,
                   std::optional<double> bound = std::nullopt) {
      out->figures.push_back({name, unit, value, bound});
    };
    const double kc = model_.kc_n_per_m, cell_n = kc * model_.resolution_m;
    const size_t from = FirstRecorded();
    if (way_.leaves) {
      const size_t left = LastAhead();
      out->leaves_s = raw_[left].t_s - raw_[from].t_s;
      JudgeLeaving(left, cell_n, Add);
    }
    if (!way_.withdraws) JudgeCutting(cell_n, Add);
    double step = 0;
    for (size_t i = std::max<size_t>(1, from); i < raw_.size(); ++i) {
      const double moved = glm::length(raw_[i].tip - raw_[i - 1].tip);
      const double allowed = kc * (moved + std::sqrt(3.0) * model_.resolution_m);
      step = std::max(step, glm::length(raw_[i].r) - glm::length(raw_[i - 1].r) - allowed);
    }
    Add("step_beyond_n", "N", step, 0);
  }

  template <typename AddFigure>
  void JudgeLeaving(size_t left, double cell_n, const AddFigure& add) const {
    const double tick_s = model_.tick_s();
    double pull = 0, rise = 0, help_s = 0, push = 0, before = 0, way = 0;
    const double level = std::max(0.15, cell_n), stored = glm::length(raw_[left].r);
    size_t held_on = left;
    for (size_t i = left + 1; i < raw_.size(); ++i) {
      const double along = Dot(raw_[i].r, raw_[i].direction);
      pull = std::max(pull, along);
      push = std::max(push, -along);
      rise = std::max(rise, std::max(0.0, along) - before);
      before = std::max(0.0, along);
      // The remainder from an encoder's cell cannot be felt.
      if (along < -0.5 * cell_n) help_s += tick_s;
      if (glm::length(raw_[i].r) > level) held_on = i;
    }
    for (size_t i = left + 1; i <= held_on; ++i) way += glm::length(raw_[i].tip - raw_[i - 1].tip);
    const double let_go_s = raw_[held_on].t_s - raw_[left].t_s;
    // The force may not fall by more than Kc (v T + sqrt(3) delta) in a tick: that time, and 15 ms.
    const auto ticks = static_cast<double>(held_on - left);
    const double pace = ticks > 0 ? way / ticks : 0;
    const double least_s =
        stored / (model_.kc_n_per_m * (pace + std::sqrt(3.0) * model_.resolution_m)) * tick_s;
    if (way_.withdraws) {
      add("pull_n", "N", pull, std::max(0.15, cell_n));
      add("rise_n", "N", rise, std::max(0.1, cell_n));
    } else {
      add("pull_n", "N", pull);
    }
    add("push_n", "N", push);
    if (case_ == StrokeCase::kReverse) add("help_s", "s", help_s, HelpGoal());
    add("let_go_s", "s", let_go_s, fidelity::kDelay_s + least_s);
  }

  // Goals for people's motions on these devices; other devices have none.
  std::optional<double> HelpGoal() const {
    if (model_.name == "omega3") return 0.1;
    if (model_.name == "phantom_desktop") return 0.15;
    if (model_.name == "bhhd3") return 0.2;
    return std::nullopt;
  }

  template <typename AddFigure>
  void JudgeCutting(double cell_n, const AddFigure& add) const {
    // From the first contact to the last, or to the hand's rest.
    size_t first = raw_.size(), last = 0;
    double peak = 0;
    for (size_t i = 0; i < raw_.size(); ++i) {
      const double ideal = Dot(raw_[i].ideal, raw_[i].direction);
      if (raw_[i].ahead_n_s_per_m < kNothing_n_s_per_m || ideal <= 0) continue;
      first = std::min(first, i);
      last = i;
      peak = std::max(peak, ideal);
    }
    if (first >= last) return;
    double plateau = 0, error2 = 0, felt2 = 0, oracle2 = 0, beyond = 0, running = 0;
    const size_t quarter = std::max<size_t>(1, (last - first) / 4);
    for (size_t i = last + 1 - quarter; i <= last; ++i)
      plateau += Dot(raw_[i].ideal, raw_[i].direction) / static_cast<double>(quarter);
    for (size_t i = first; i <= last; ++i) {
      const Raw& k = raw_[i];
      running = std::max(running, Dot(k.ideal, k.direction));
      beyond = std::max(beyond, Dot(k.r, k.direction) - running);
      error2 += Dot(k.r - k.ideal, k.r - k.ideal);
      felt2 += Dot(k.in_hand - k.ideal, k.in_hand - k.ideal);
      oracle2 += Dot(k.oracle - k.ideal, k.oracle - k.ideal);
    }
    if (case_ == StrokeCase::kPress || case_ == StrokeCase::kStroke) {
      auto Reaches = [&](dvec3 Raw::*track, double share) {
        size_t i = first;
        while (i < last && Dot(raw_[i].*track, raw_[i].direction) < share * plateau) ++i;
        return raw_[i].t_s - raw_[first].t_s;
      };
      add("lag_s", "s", Reaches(&Raw::r, 0.5) - Reaches(&Raw::ideal, 0.5));
      const double rise_s = Reaches(&Raw::r, 0.9), least_s = Reaches(&Raw::oracle, 0.9);
      add("rise90_s", "s", rise_s, 1.15 * least_s + model_.tick_s());
    }
    if (case_ != StrokeCase::kSlipOut) {
      // Where B v is within the motors' continuous force.
      std::optional<double> bound;
      if (peak <= model_.continuous_force_n)
        bound = std::max({0.1 * peak, 0.05, 1.15 * cell_n / 2});
      add("overshoot_n", "N", beyond, bound);
      if (oracle2 > 0) add("error_over_oracle", "", std::sqrt(error2 / oracle2));
    }
    const auto ticks = static_cast<double>(last - first + 1);
    add("command_error_rms_n", "N", std::sqrt(error2 / ticks));
    add("felt_error_rms_n", "N", std::sqrt(felt2 / ticks));
    add("ideal_peak_n", "N", peak);
  }

  const DeviceModel model_;
  const StrokeCase case_;
  const haptics::LawKind law_;
  const StrokeWay way_;
  LegHand hand_;
  Plant plant_;
  core::Core core_;
  IdealBur ideal_;
  core::TickInput input_;
  core::TickOutput out_;
  dvec3 oracle_{0};
  std::vector<Raw> raw_;
};

}  // namespace

const char* StrokeName(StrokeCase c) {
  constexpr const char* kNames[] = {"press", "stroke", "reverse", "lift", "nick", "slip-out"};
  return kNames[static_cast<int>(c)];
}

bool StrokeTrack::held() const {
  return std::all_of(figures.begin(), figures.end(),
                     [](const StrokeFigure& f) { return f.held(); });
}

StrokeTrack RunStroke(const DeviceModel& model, StrokeCase c, haptics::LawKind law,
                      const cutting::Volume& block) {
  return StrokeRun(model, c, law, block).Run();
}

std::vector<size_t> PointsToDraw(const std::vector<StrokePoint>& points, size_t most) {
  std::vector<size_t> out;
  if (points.size() <= most) {
    for (size_t i = 0; i < points.size(); ++i) out.push_back(i);
    return out;
  }
  // Up to three of each group, and the first and the last.
  const size_t groups = (most - 2) / 3;
  out.push_back(0);
  for (size_t g = 0; g < groups; ++g) {
    const size_t from = g * points.size() / groups, to = (g + 1) * points.size() / groups;
    size_t low = from, high = from, strong = from;
    for (size_t i = from; i < to; ++i) {
      if (points[i].force_n < points[low].force_n) low = i;
      if (points[i].force_n > points[high].force_n) high = i;
      if (points[i].magnitude_n > points[strong].magnitude_n) strong = i;
    }
    for (size_t i : {low, high, strong}) out.push_back(i);
  }
  out.push_back(points.size() - 1);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace enamel::station::lab
