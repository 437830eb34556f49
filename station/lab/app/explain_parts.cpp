#include <malloc.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>

#include "common/cutting/cutter.h"
#include "common/scene/pruning.h"
#include "station/devices/operators.h"
#include "station/lab/app/explain_steps.h"
#include "station/mouth/mouth.h"

namespace enamel::station::lab {
namespace {

using scene::Part;
using scene::PartId;

class Appraiser {
 public:
  explicit Appraiser(const Explained& subject)
      : s_(subject), way_(MakeCutWay(s_.params, s_.exercise.target, kTicks)) {
    ShowProgress("the tick as planned");
    base_ = MeasureSteps(s_.params, s_.built.volume, way_, kReplays);
    // Twice: what the same thing differs by from itself is printed, so that nobody mistakes noise for a cost.
    for (int i = 0; i < 2; ++i) Timed(s_.params, s_.built.volume);
  }

  Appraisal Measure(std::vector<Part> parts) {
    Appraisal out;
    for (Part& part : parts) {
      Worth worth = Of(part);
      out.rows.emplace_back(std::move(part), std::move(worth));
    }
    ShowProgress("with and without, in turns");
    const std::vector<Interval> more = MoreThanFirst_us(cases_);
    out.base = base_;
    out.volume_mb = base_.volume_mb;
    out.noise_ns = Ns(more[1], 1);
    for (const Asked& a : asked_) {
      Worth& worth = out.rows[a.row].second;
      worth.ns_per_tick = Ns(more[a.timed], a.sign);
      // A dozen parts are asked at once: an interval without 0 alone would name one in three runs.
      worth.within_noise = !worth.ns_per_tick->apart() || Overlap(*worth.ns_per_tick, out.noise_ns);
    }
    return out;
  }

 private:
  // A row whose cost is how much longer a timed case takes than the plan, or with the sign -1 how much less.
  struct Asked {
    size_t row, timed;
    int sign;
  };

  static Interval Ns(const Interval& us, int sign) {
    if (sign < 0) return {-1e3 * us.value, -1e3 * us.high, -1e3 * us.low};
    return {1e3 * us.value, 1e3 * us.low, 1e3 * us.high};
  }

  // Will be timed in turns with the others; its hash after a run now.
  uint64_t Timed(const core::CoreParams& params, cutting::Volume volume) {
    auto kept = std::make_shared<cutting::Volume>(std::move(volume));
    cases_.push_back({[this, params, kept] {
      const StepCost c = MeasureSteps(params, *kept, way_, kRunsOfRound);
      return Spread{c.mean_us, c.p99_us};
    }});
    return MeasureSteps(params, *kept, way_, 1).state_hash;
  }
  // The row that is being appraised costs what the last timed case takes longer or less.
  void Ask(int sign) { asked_.push_back({row_, cases_.size() - 1, sign}); }

  Worth Of(const Part& part) {
    ShowProgress(std::string(part.name));
    row_ = part_++;
    switch (part.id) {
      case PartId::kLabels:
        return part.kept ? LabelsKept() : LabelsLeftOut();
      case PartId::kUniform:
        return Instead(scene::Unpruned(s_.built.volume), "all of air and inside stored");
      case PartId::kNeighbour:
        return Neighbour(part.kept);
      case PartId::kTurning:
        return Turning();
      case PartId::kTorque:
        return part.kept ? Torque() : Worth{{}, {}, "nothing computes it"};
      case PartId::kTouchCues:
        return TouchCues(part.kept);
      case PartId::kOtherBurs:
        return OtherBurs(part.kept);
      case PartId::kSurface: {
        SurfaceCost c;
        const Interval ns = Apart([&] {
          c = MeasureSurface(s_.params, s_.built.volume, way_);
          return c.us_per_tick * 1e3;
        });
        return {ns, c.mb, "triangles of the touched bricks, on another thread"};
      }
      case PartId::kMouth:
        return Mouth({s_.exercise.isolation, false}, std::nullopt);
      case PartId::kRubberDam:
        return Mouth({scene::Isolation::kRubberDam, false},
                     mouth::MouthOptions{.antagonist = false});
      case PartId::kAntagonist:
        return Mouth({s_.exercise.isolation, true},
                     mouth::MouthOptions{s_.exercise.isolation, false});
      case PartId::kMirror:
        return {{}, {}, "off the tick's thread; 'bench frames' prints pictures with it"};
      case PartId::kBusWrite:
        return BusWrite();
      // Never left out, so there is nothing to compare with.
      case PartId::kForceBounds:
      case PartId::kStateHash:
        return {{}, {}, "inside the tick's figure"};
    }
    return {};
  }

  static bool Overlap(const Interval& a, const Interval& b) {
    return a.low <= b.high && b.low <= a.high;
  }
  // Measured by itself, without a plan beside it.
  static Interval Apart(const std::function<double()>& ns) {
    std::vector<double> rounds;
    for (int i = 0; i < kRounds; ++i) rounds.push_back(ns());
    return IntervalOf(std::move(rounds));
  }
  static double HeapMb() {
    struct mallinfo2 m = ::mallinfo2();
    return 1e-6 * static_cast<double>(m.uordblks + m.hblkhd);
  }
  static double Mb(const cutting::Volume& v) { return static_cast<double>(v.MemoryBytes()) * 1e-6; }
  // The same with `other` for the volume; its hash must be equal.
  Worth Instead(cutting::Volume other, const char* what) {
    Worth w{{}, Mb(other) - base_.volume_mb, what};
    // Leaving out must not change a hash. This measurement also checks it.
    if (Timed(s_.params, other) != base_.state_hash)
      w.note += "; THE HASH DIFFERS: do not trust this plan";
    Ask(1);
    return w;
  }

  // Labels on every stored brick, compared with the existing ones.
  Worth LabelsLeftOut() {
    double labelled = 0;
    for (int b = 0; b < s_.built.volume.spec().brick_count(); ++b) {
      labelled += s_.built.volume.IsStored(b) && !s_.built.volume.HasLabels(b);
    }
    cutting::Volume all(s_.built.volume.spec());
    for (int b = 0; b < s_.built.volume.spec().brick_count(); ++b) LabelBrick(b, all);
    Worth w = Instead(std::move(all), "labels on every stored brick");
    w.note += " (" + std::to_string(static_cast<int>(labelled)) + ")";
    return w;
  }

  void LabelBrick(int b, cutting::Volume& out) const {
    const cutting::Volume& v = s_.built.volume;
    if (!v.IsStored(b)) return out.SetUniform(b, v.UniformTissue(b));
    std::array<uint8_t, cutting::kBrickVoxels> labels;
    labels.fill(static_cast<uint8_t>(v.UniformTissue(b)));
    if (v.HasLabels(b)) labels = v.Labels(b).tissue;
    out.SetBrick(b, v.Phi(b).phi, labels, static_cast<cutting::Tissue>(labels[0]));
  }

  // One tissue everywhere: the cut then takes another path, so only the memory is comparable.
  Worth LabelsKept() const {
    const cutting::Volume& v = s_.built.volume;
    size_t bricks = 0;
    for (int b = 0; b < v.spec().brick_count(); ++b) bricks += v.HasLabels(b);
    return {{},
            static_cast<double>(bricks * sizeof(cutting::BrickLabels)) * 1e-6,
            std::to_string(bricks) + " bricks hold two tissues; without labels B would be wrong"};
  }

  Worth Neighbour(bool kept) {
    if (!kept) return {{}, 0.0, "there is none"};
    cutting::Volume without = scene::Without(s_.built.volume, cutting::Tissue::kNeighbour);
    const double mb = base_.volume_mb - Mb(without);
    Timed(s_.params, without);
    Ask(-1);  // this one leaves out a part that the plan keeps
    return {{}, mb, "against the tooth alone"};
  }

  // Against the same plan with other parameters of the core.
  Worth Against(const core::CoreParams& without, const char* what) {
    Timed(without, s_.built.volume);
    Ask(-1);
    return {{}, 0.0, what};
  }

  Worth Turning() {
    core::CoreParams rigid = s_.params;
    rigid.rotational_kc_un_m_per_rad = rigid.peak_torque_un_m = rigid.rotation_cell_urad = 0;
    return Against(rigid, "against a bur that never turns");
  }

  Worth TouchCues(bool kept) {
    if (!kept) return {{}, {}, "nothing computes them"};
    core::CoreParams silent = s_.params;
    silent.contact_cue_mn = silent.chatter_cue_mn = silent.cue_energy_nj = silent.cue_power_nw = 0;
    return Against(silent, "against a tick without them");
  }

  // Compared with a device of three axes, whose bur turns as softly as its coupling permits.
  Worth Torque() {
    core::CoreParams without = s_.params;
    without.peak_torque_un_m = without.rotation_cell_urad = 0;
    return Against(without, "against the same bur without torque");
  }

  // From the heap: a process grows by whole pages, and keeps freed memory.
  double CoreMb(const core::CoreParams& params) const {
    const double before_mb = HeapMb();
    const core::Core core(params, s_.built.volume);
    return HeapMb() - before_mb;
  }

  // The first bur cuts, beside others or alone.
  Worth OtherBurs(bool kept) {
    core::CoreParams alone = s_.params, with = s_.params;
    alone.other_burs.clear();
    if (!kept) {
      with.other_burs.resize(1);
      with.other_burs[0].radius_nm = s_.params.bur_radius_nm;
      with.other_burs[0].rotational_kc_un_m_per_rad = s_.params.rotational_kc_un_m_per_rad;
    }
    Timed(kept ? alone : with, s_.built.volume);
    Ask(kept ? -1 : 1);
    return {{},
            CoreMb(with) - CoreMb(alone),
            kept ? "against the first bur alone" : "with a sphere to change to"};
  }

  struct Made {
    render::Scenery scenery;
    double ms = 0;
  };
  Made MakeMouth(const mouth::MouthOptions& options) const {
    const auto from = std::chrono::steady_clock::now();
    Made out{mouth::MakeMouth(s_.built.scene, s_.built.volume, {}, options)};
    out.ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
    return out;
  }

  // More than `without`; none: than nothing.
  Worth Mouth(const mouth::MouthOptions& with,
              const std::optional<mouth::MouthOptions>& without) const {
    const Made more = MakeMouth(with), less = without ? MakeMouth(*without) : Made{};
    if (more.scenery.empty()) return {{}, {}, "there is none"};
    char note[120];
    std::snprintf(note, sizeof note,
                  "%+lld triangles on the graphics card, made in %+.0f ms off the tick's thread",
                  static_cast<long long>(more.scenery.triangle_count()) -
                      static_cast<long long>(less.scenery.triangle_count()),
                  more.ms - less.ms);
    return {{},
            1e-6 * (static_cast<double>(more.scenery.bytes()) -
                    static_cast<double>(less.scenery.bytes())),
            note};
  }

  Worth BusWrite() const {
    const OperatorPreset& preset = OperatorPresets().front();
    auto device = MakeSimulatedDevice(preset, s_.built.scene, s_.exercise, s_.profile, s_.params,
                                      s_.built.volume);
    if (!device.ok()) return {{}, {}, "no operator can do this exercise: not measured"};
    constexpr int kCalls = 10'000;
    const Interval ns = Apart([&] {
      auto from = std::chrono::steady_clock::now();
      // Differing forces, because a device may skip repeated values at no cost.
      for (int i = 0; i < kCalls; ++i) (*device)->SendForce(dvec3(0, 0, 1e-3 * (i & 7)));
      const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - from;
      return took.count() / kCalls;
    });
    return {ns, 0.0, "the simulated device's; a bus takes longer"};
  }

  const Explained& s_;
  CutWay way_;
  StepCost base_;
  std::vector<TimedCase> cases_;  // the plan twice, then what is compared with it
  std::vector<Asked> asked_;
  size_t row_ = 0, part_ = 0;
};

}  // namespace

Appraisal Appraise(const Explained& subject, std::vector<Part> parts) {
  Appraisal out = Appraiser(subject).Measure(std::move(parts));
  EndProgress();
  return out;
}

}  // namespace enamel::station::lab
