#include <malloc.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/cutting/cutter.h"
#include "common/scene/pruning.h"
#include "station/devices/operators.h"
#include "station/lab/app/explain_steps.h"

namespace enamel::station::lab {
namespace {

using scene::Part;
using scene::PartId;

class Appraiser {
 public:
  explicit Appraiser(const Explained& subject)
      : s_(subject), way_(MakeCutWay(s_.params, s_.exercise.target, kTicks)) {
    ShowProgress("the tick as planned");
    // Twice: the difference between two runs of the same measurement is printed, so that nobody
    // mistakes noise for a cost.
    base_ = Steps(s_.built.volume);
    again_ = Steps(s_.built.volume);
  }

  Appraisal Measured() const {
    return {base_, std::abs(base_.mean_us - again_.mean_us) * 1e3, volume_mb()};
  }

  Worth Of(const Part& part) {
    ShowProgress(std::string(part.name));
    switch (part.id) {
      case PartId::kLabels:
        return part.kept ? LabelsKept() : LabelsLeftOut();
      case PartId::kUniform:
        return Instead(scene::Unpruned(s_.built.volume), "all of air and inside stored");
      case PartId::kNeighbour:
        return Neighbour(part.kept);
      case PartId::kBeyondReach:
        return BeyondReach();
      case PartId::kTurning:
        return Turning();
      case PartId::kTorque:
        return part.kept ? Torque() : Worth{{}, {}, "nothing computes it"};
      case PartId::kTouchCues:
        return TouchCues(part.kept);
      case PartId::kOtherBurs:
        return OtherBurs();
      case PartId::kSurface: {
        SurfaceCost c = MeasureSurface(s_.params, s_.built.volume, way_);
        return {c.us_per_tick * 1e3, c.mb, "triangles of the touched bricks, on another thread"};
      }
      case PartId::kBusWrite:
        return BusWrite();
      // Never left out, so there is nothing to compare with.
      case PartId::kForceBounds:
      case PartId::kStateHash:
        return {{}, {}, "inside the tick's figure"};
    }
    return {};
  }

 private:
  static double HeapMb() {
    struct mallinfo2 m = ::mallinfo2();
    return 1e-6 * static_cast<double>(m.uordblks + m.hblkhd);
  }
  static double Mb(const cutting::Volume& v) { return static_cast<double>(v.MemoryBytes()) * 1e-6; }
  double volume_mb() const { return Mb(s_.built.volume); }
  StepCost Steps(const cutting::Volume& v) const {
    return MeasureSteps(s_.params, v, way_, kReplays);
  }
  double MoreThanBase_ns(const StepCost& other) const {
    return (other.mean_us - base_.mean_us) * 1e3;
  }

  // The same with `other` for the volume; its hash must be equal.
  Worth Instead(const cutting::Volume& other, const char* what) const {
    StepCost c = Steps(other);
    Worth w{MoreThanBase_ns(c), Mb(other) - volume_mb(), what};
    // Leaving out must not change a hash. This measurement also checks it.
    if (c.state_hash != base_.state_hash) w.note += "; THE HASH DIFFERS: do not trust this plan";
    return w;
  }

  // Labels on every stored brick, compared with the existing ones.
  Worth LabelsLeftOut() const {
    double labelled = 0;
    for (int b = 0; b < s_.built.volume.spec().brick_count(); ++b) {
      labelled += s_.built.volume.IsStored(b) && !s_.built.volume.HasLabels(b);
    }
    cutting::Volume all(s_.built.volume.spec());
    for (int b = 0; b < s_.built.volume.spec().brick_count(); ++b) LabelBrick(b, all);
    Worth w = Instead(all, "labels on every stored brick");
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

  Worth Neighbour(bool kept) const {
    if (!kept) return {0.0, 0.0, "there is none"};
    cutting::Volume without = scene::Without(s_.built.volume, cutting::Tissue::kNeighbour);
    StepCost c = Steps(without);
    // Negative: this one leaves out a part that the plan keeps.
    return {-MoreThanBase_ns(c), volume_mb() - Mb(without), "against the tooth alone"};
  }

  Worth BeyondReach() const {
    scene::Reach reach = scene::ReachOf(s_.built.scene, s_.exercise);
    cutting::Volume inside = scene::Pruned(s_.built.volume, reach);
    StepCost c = Steps(inside);
    Worth w{-MoreThanBase_ns(c), volume_mb() - Mb(inside), "the hash stays the same"};
    if (c.state_hash != base_.state_hash) w.note = "THE HASH DIFFERS: do not trust this plan";
    return w;
  }

  Worth Turning() const {
    core::CoreParams rigid = s_.params;
    rigid.rotational_kc_un_m_per_rad = rigid.peak_torque_un_m = rigid.rotation_cell_urad = 0;
    StepCost c = MeasureSteps(rigid, s_.built.volume, way_, kReplays);
    return {-MoreThanBase_ns(c), 0.0, "against a bur that never turns"};
  }

  Worth TouchCues(bool kept) const {
    if (!kept) return {{}, {}, "nothing computes them"};
    core::CoreParams silent = s_.params;
    silent.contact_cue_mn = silent.chatter_cue_mn = silent.cue_energy_nj = silent.cue_power_nw = 0;
    StepCost c = MeasureSteps(silent, s_.built.volume, way_, kReplays);
    return {-MoreThanBase_ns(c), 0.0, "against a tick without them"};
  }

  // Compared with a device of three axes, whose bur turns as softly as its coupling permits.
  Worth Torque() const {
    core::CoreParams without = s_.params;
    without.peak_torque_un_m = without.rotation_cell_urad = 0;
    StepCost c = MeasureSteps(without, s_.built.volume, way_, kReplays);
    return {-MoreThanBase_ns(c), 0.0, "against the same bur without torque"};
  }

  // A second bur's cutter on the same volume: time to make it, and growth of the heap.
  Worth OtherBurs() const {
    cutting::Volume volume = s_.built.volume;
    cutting::Bur other{cutting::BurShape::kSphere, s_.exercise.bur_radius_um * 1e-6};
    if (s_.exercise.bur_shape == cutting::BurShape::kSphere) {
      other.shape = cutting::BurShape::kCylinder;
      other.length_m = 4e-3;
    }
    // From the heap: a process grows by whole pages, and keeps freed memory.
    double before_mb = HeapMb();
    auto from = std::chrono::steady_clock::now();
    cutting::Cutter cutter(volume, other);
    std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - from;
    char note[96];
    std::snprintf(note, sizeof note, "a %s's cutter beside it, made in %.1f ms",
                  std::string(cutting::BurShapeName(other.shape)).c_str(), took.count());
    return {0.0, HeapMb() - before_mb, note};
  }

  Worth BusWrite() const {
    const OperatorPreset& preset = OperatorPresets().front();
    auto device = MakeSimulatedDevice(preset, s_.built.scene, s_.exercise, s_.profile, s_.params,
                                      s_.built.volume);
    if (!device.ok()) return {{}, {}, "no operator can do this exercise: not measured"};
    constexpr int kCalls = 100'000;
    auto from = std::chrono::steady_clock::now();
    // Differing forces, because a device may skip repeated values at no cost.
    for (int i = 0; i < kCalls; ++i) (*device)->SendForce(dvec3(0, 0, 1e-3 * (i & 7)));
    double ns =
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - from).count();
    return {ns / kCalls, 0.0, "the simulated device's; a bus takes longer"};
  }

  const Explained& s_;
  CutWay way_;
  StepCost base_, again_;
};

}  // namespace

Appraisal Appraise(const Explained& subject, std::vector<Part> parts) {
  Appraiser appraiser(subject);
  Appraisal out = appraiser.Measured();
  for (Part& part : parts) {
    Worth worth = appraiser.Of(part);
    out.rows.emplace_back(std::move(part), std::move(worth));
  }
  EndProgress();
  return out;
}

}  // namespace enamel::station::lab
