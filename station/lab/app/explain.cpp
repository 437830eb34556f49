#include "station/lab/app/explain.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/base/file.h"
#include "common/cutting/cutter.h"
#include "common/import/scene_folder.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/parts.h"
#include "common/scene/plan.h"
#include "common/scene/pruning.h"
#include "station/devices/operators.h"
#include "station/lab/cutting/scene_cost.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;
using scene::Part;
using scene::PartId;

// Enough for a p99 of six ticks; parts are measured a dozen times while somebody waits.
constexpr size_t kTicks = 600;
constexpr int kReplays = 5;

// One line on a terminal that the next one replaces; lines elsewhere.
void Progress(const std::string& what) {
  if (program::LogIsJson()) return;
  bool terminal = ::isatty(STDERR_FILENO) != 0;
  std::fprintf(stderr, terminal ? "\r\033[Kmeasuring: %s" : "measuring: %s\n", what.c_str());
}
void EndProgress() {
  if (::isatty(STDERR_FILENO) != 0 && !program::LogIsJson()) std::fprintf(stderr, "\r\033[K");
}

// The subject of the explanation.
struct Subject {
  scene::BuiltScene built;
  scene::Exercise exercise;
  scene::DeviceProfile profile;
  core::CoreParams params;
};

Result<scene::BuiltScene> Load(const ExplainCommand& options, int32_t voxel_nm) {
  return import::LoadScene(options.scene, voxel_nm,
                           static_cast<size_t>(options.memory_mb) * 1'000'000);
}

Result<scene::Exercise> Choose(const scene::Scene& scene, const std::string& name) {
  auto all = scene::BuiltinExercises(scene, HashSha256(AsBytes(scene::ToJson(scene))));
  std::string known;
  for (const scene::Exercise& e : all) {
    if (name.empty() || e.name == name || e.name == name + "-" + scene.name) return e;
    known += (known.empty() ? "" : ", ") + e.name;
  }
  return Status(Code::kNotFound,
                "scene '" + scene.name + "' has no exercise '" + name +
                    "': " + (known.empty() ? "it has none" : "it has " + known),
                "exercise");
}

Result<Subject> Prepare(const ExplainCommand& options) {
  Subject s;
  ENAMEL_ASSIGN_OR_RETURN(auto built, Load(options, options.voxel_um * 1000));
  s.built = std::move(built);
  // As a ticket would: a scene that a station refuses is not worth measuring.
  ENAMEL_RETURN_IF_ERROR(scene::CheckVolume(s.built.scene, s.built.volume));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, Choose(s.built.scene, options.exercise));
  s.exercise = std::move(exercise);
  ENAMEL_ASSIGN_OR_RETURN(auto profile, scene::FindProfile(options.profile));
  s.profile = profile;
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(s.built.scene, s.exercise, s.profile));
  s.params = params;
  return s;
}

// Cost of a part: where it is kept, its cost; where it is left out, the cost it would have.
struct Worth {
  std::optional<double> ns_per_tick, mb;
  std::string note;
};

class Appraiser {
 public:
  explicit Appraiser(const Subject& subject)
      : s_(subject), way_(MakeCutWay(s_.params, s_.exercise.target, kTicks)) {
    Progress("the tick as planned");
    // Twice: the difference between two runs of the same measurement is printed, so that nobody
    // mistakes noise for a cost.
    base_ = Steps(s_.built.volume);
    again_ = Steps(s_.built.volume);
  }

  const StepCost& base() const { return base_; }
  // Difference between two measurements of the same thing.
  double noise_ns() const { return std::abs(base_.mean_us - again_.mean_us) * 1e3; }
  double volume_mb() const { return Mb(s_.built.volume); }

  Worth Of(const Part& part) {
    Progress(std::string(part.name));
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

  const Subject& s_;
  CutWay way_;
  StepCost base_, again_;
};

void PrintPart(const Part& part, const Worth& worth) {
  char ns[24] = "-", mb[24] = "-";
  if (worth.ns_per_tick) std::snprintf(ns, sizeof ns, "%+.0f", *worth.ns_per_tick);
  if (worth.mb) std::snprintf(mb, sizeof mb, "%+.2f", *worth.mb);
  std::printf("%-15s %-9s %9s %9s  %s; %s\n", std::string(part.name).c_str(),
              part.kept ? "kept" : "left out", ns, mb, part.why.c_str(), worth.note.c_str());
}

json::object PartJson(const Part& part, const Worth& worth) {
  json::object out{{"part", part.name}, {"kept", part.kept}, {"why", part.why}};
  out["ns_per_tick"] = worth.ns_per_tick ? json::value(*worth.ns_per_tick) : json::value(nullptr);
  out["mb"] = worth.mb ? json::value(*worth.mb) : json::value(nullptr);
  out["measured"] = worth.note;
  return out;
}

// --- a tick's budget ---

struct VoxelPoint {
  int32_t voxel_nm;
  StepCost cost;
  double mb;
};
struct LawPoint {
  const haptics::LawEntry* law;
  int32_t rate_hz;
  double force_error_n;
  double more_us;  // a tick's mean against the exercise's own law
  bool passive;    // anchored laws are, by the coupling's proof; only they are picked
};

class Budget {
 public:
  Budget(const ExplainCommand& options, const Subject& subject, const StepCost& base)
      : options_(options), s_(subject), base_(base), budget_us_(*options.budget_us) {}

  Status Decide(json::object& out) {
    out["budget_us"] = budget_us_;
    if (s_.exercise.graded) return DecideGraded(out);
    MeasureVoxels();
    MeasureLaws();
    EndProgress();
    Print(out);
    return Pick(out);
  }

 private:
  // A graded exercise fixes everything: the only question is whether this machine can run it.
  Status DecideGraded(json::object& out) {
    EndProgress();
    double period_us = 1e6 / s_.exercise.rate_hz;
    // By p99, not the mean: the hand feels a tick that is occasionally late.
    bool fits = base_.p99_us <= std::min(budget_us_, period_us);
    out["graded"] = true;
    out["fits"] = fits;
    char text[400];
    std::snprintf(text, sizeof text,
                  "exercise '%s' is graded: voxel %.0f um, law and rate (%d Hz) are fixed; "
                  "99 %% of its ticks take %.1f us here, the budget is %.1f us",
                  s_.exercise.name.c_str(), s_.built.scene.voxel_nm * 1e-3, s_.exercise.rate_hz,
                  base_.p99_us, std::min(budget_us_, period_us));
    if (!fits) {
      return Status(Code::kUnavailable,
                    std::string(text) +
                        ": this machine cannot carry it. Use a faster one, or practise on a "
                        "coarser scene",
                    "budget_us");
    }
    std::printf("%s: it fits.\n", text);
    return Status::Ok();
  }

  void MeasureVoxels() {
    std::vector<int32_t> sizes = {s_.built.scene.voxel_nm};
    // An imported scene has one size; a built-in one can be made in any.
    if (options_.scene.starts_with(import::kBuiltin)) sizes = {200'000, 100'000, 50'000, 25'000};
    for (int32_t nm : sizes) {
      Progress("voxels of " + std::to_string(nm / 1000) + " um");
      auto built = Load(options_, nm);
      if (!built.ok()) continue;  // more memory than allowed
      double mb = static_cast<double>(built->volume.MemoryBytes()) * 1e-6;
      CutWay way = MakeCutWay(s_.params, s_.exercise.target, kTicks);
      voxels_.push_back({nm, MeasureSteps(s_.params, built->volume, way, kReplays), mb});
      // Finer ones cost more, so the search ends here.
      if (voxels_.back().cost.p99_us > 4 * budget_us_) break;
    }
  }

  void MeasureLaws() {
    for (int32_t rate : {1'000, 2'000, 4'000}) {
      // The profile's rate is the device's own: nothing reads it faster.
      if (rate > s_.profile.rate_hz.value) continue;
      for (const haptics::LawEntry& law : haptics::ForceLaws()) {
        Progress(std::string(law.name) + " at " + std::to_string(rate) + " Hz");
        scene::Exercise e = s_.exercise;
        e.law = law.kind;
        e.rate_hz = rate;
        auto params = scene::CompilePlan(s_.built.scene, e, s_.profile);
        if (!params.ok()) continue;
        CutWay way = MakeCutWay(*params, e.target, kTicks);
        // Fewer replays than for a voxel: there are many laws and rates, and somebody waits.
        double mean = MeasureSteps(*params, s_.built.volume, way, 3).mean_us;
        laws_.push_back({&law, rate, ForceError_n(*params), mean - base_.mean_us,
                         law.make({law.kind, 1000, dvec3(1e-5)})->anchored()});
      }
    }
  }

  void Print(json::object& out) const {
    std::printf("\nvoxel um   tick mean us   p99 us      MB   removed mm3 (against the finest)\n");
    json::array voxels, laws;
    double finest = voxels_.empty() ? 0 : voxels_.back().cost.removed_mm3;
    for (const VoxelPoint& v : voxels_) {
      double error = finest > 0 ? 100 * (v.cost.removed_mm3 / finest - 1) : 0;
      std::printf("%8.0f %14.1f %8.1f %7.1f   %.4f (%+.2f %%)\n", v.voxel_nm * 1e-3, v.cost.mean_us,
                  v.cost.p99_us, v.mb, v.cost.removed_mm3, error);
      voxels.push_back(json::object{{"voxel_nm", v.voxel_nm},
                                    {"mean_us", v.cost.mean_us},
                                    {"p99_us", v.cost.p99_us},
                                    {"mb", v.mb},
                                    {"removed_mm3", v.cost.removed_mm3},
                                    {"removed_error_percent", error}});
    }
    std::printf(
        "\nlaw                  rate Hz   force error N   tick us against the exercise's   "
        "passive\n");
    for (const LawPoint& l : laws_) {
      std::printf("%-20s %7d %15.4f %+30.2f   %s\n", std::string(l.law->name).c_str(), l.rate_hz,
                  l.force_error_n, l.more_us, l.passive ? "yes" : "not proved");
      laws.push_back(json::object{{"law", l.law->name},
                                  {"rate_hz", l.rate_hz},
                                  {"force_error_n", l.force_error_n},
                                  {"more_us", l.more_us},
                                  {"passive", l.passive}});
    }
    out["voxels"] = std::move(voxels);
    out["laws"] = std::move(laws);
  }

  // The finest voxel first, then the smallest force error of a law that cannot release energy.
  Status Pick(json::object& out) const {
    for (auto v = voxels_.rbegin(); v != voxels_.rend(); ++v) {
      const LawPoint* best = nullptr;
      for (const LawPoint& l : laws_) {
        // Adds a law's cost to the voxel's: measuring each pair would take minutes.
        bool fits =
            v->cost.p99_us + std::max(l.more_us, 0.0) <= std::min(budget_us_, 1e6 / l.rate_hz);
        if (fits && l.passive && (best == nullptr || l.force_error_n < best->force_error_n))
          best = &l;
      }
      if (best == nullptr) continue;
      std::printf(
          "\nfor practice within %.1f us: voxels of %.0f um, law %s, %d Hz. The finest voxel whose "
          "slowest\nhundredth of ticks fits, then the law and rate with the smallest force "
          "error.\n",
          budget_us_, v->voxel_nm * 1e-3, std::string(best->law->name).c_str(), best->rate_hz);
      out["picked"] = json::object{
          {"voxel_nm", v->voxel_nm}, {"law", best->law->name}, {"rate_hz", best->rate_hz}};
      return Status::Ok();
    }
    out["picked"] = nullptr;
    double least = 1e12;
    for (const VoxelPoint& v : voxels_) least = std::min(least, v.cost.p99_us);
    return Status(Code::kUnavailable,
                  "no voxel size, law and rate fits a tick of " + std::to_string(budget_us_) +
                      " us on this machine: the least measured is " + std::to_string(least) + " us",
                  "budget_us");
  }

  const ExplainCommand& options_;
  const Subject& s_;
  const StepCost& base_;
  const double budget_us_;
  std::vector<VoxelPoint> voxels_;  // coarse to fine
  std::vector<LawPoint> laws_;
};

Status WriteJson(const std::filesystem::path& file, const json::object& object) {
  if (file.empty()) return Status::Ok();
  return WriteFileDurably(file, AsBytes(json::serialize(object) + "\n"));
}

}  // namespace

Status ExplainScene(const ExplainCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_ASSIGN_OR_RETURN(auto subject, Prepare(options));
  Appraiser appraiser(subject);
  std::vector<std::pair<Part, Worth>> rows;
  for (Part& part :
       scene::ListParts(subject.built.scene, subject.exercise,
                        {options.window, options.replay, subject.params.peak_torque_un_m > 0})) {
    Worth worth = appraiser.Of(part);
    rows.emplace_back(std::move(part), std::move(worth));
  }
  EndProgress();
  const StepCost& base = appraiser.base();
  std::printf("scene '%s', voxels of %.0f um; exercise '%s'; %s at %d Hz\n",
              subject.built.scene.name.c_str(), subject.built.scene.voxel_nm * 1e-3,
              subject.exercise.name.c_str(), subject.profile.name.c_str(),
              subject.exercise.rate_hz);
  std::printf(
      "as planned: tick %.2f us mean, %.2f us p99; volume %.1f MB. Per tick the least of %d runs\n"
      "over %zu ticks, bur engaged in %.0f %%; the same measured twice differs by %.0f ns.\n"
      "ns a tick and MB: the cost of a kept part, or of a left out part if it were kept.\n\n",
      base.mean_us, base.p99_us, appraiser.volume_mb(), kReplays, kTicks, 100 * base.engaged_share,
      appraiser.noise_ns());
  std::printf("part            plan        ns/tick        MB  why; how measured\n");
  json::array parts;
  for (const auto& [part, worth] : rows) {
    PrintPart(part, worth);
    parts.push_back(PartJson(part, worth));
  }
  json::object out{{"scene", subject.built.scene.name},
                   {"exercise", subject.exercise.name},
                   {"profile", subject.profile.name},
                   {"voxel_nm", subject.built.scene.voxel_nm},
                   {"mean_us", base.mean_us},
                   {"p99_us", base.p99_us},
                   {"noise_ns", appraiser.noise_ns()},
                   {"volume_mb", appraiser.volume_mb()},
                   {"engaged_share", base.engaged_share},
                   {"parts", std::move(parts)}};
  Status decided;
  if (options.budget_us) decided = Budget(options, subject, base).Decide(out);
  // Before the verdict: the figures matter most if nothing fits.
  ENAMEL_RETURN_IF_ERROR(WriteJson(options.json, out));
  return decided;
}

}  // namespace enamel::station::lab
