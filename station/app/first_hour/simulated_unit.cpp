#include "station/app/first_hour/simulated_unit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/core/params.h"
#include "common/scene/cell.h"
#include "station/devices/limited.h"
#include "station/devices/operators.h"

namespace enamel::station::first_hour {

struct Play {
  enum class Hands : uint8_t { kOff, kHold, kLoose, kLie } hands = Hands::kOff;
  std::vector<dvec3> places;  // to hold it at, one after the other
  double lying_n = 0;         // weight of what lies or hangs there
  bool pedal = false, plugged = true;
};

namespace {

constexpr double kHeld_n_per_m = 400, kLoose_n_per_m = 30, kBooks_n_per_m = 3000;
constexpr double kWays_m_per_s = 0.15;
constexpr double kArm_n = 0.2, kHung_g = 100;

// Of the person's hands, and of the books that the handle lies on.
class Hands final : public SimulatedOperator {
 public:
  explicit Hands(std::shared_ptr<Play> play) : play_(std::move(play)) {}
  std::string Name() const override { return "the first hour's person"; }
  dvec3 Start_m() const override { return dvec3(0); }
  double Progress() const noexcept override { return 0; }
  HandDrive Act(const dvec3& hand_m, const dvec3&, double tick_s) noexcept override {
    const bool same = play_->hands == did_;
    did_ = play_->hands;
    if (!same) at_ = hand_m;
    HandDrive out;
    out.pedal = play_->pedal;
    switch (play_->hands) {
      case Play::Hands::kOff:
        break;
      case Play::Hands::kHold:
        Hold(tick_s, out);
        break;
      case Play::Hands::kLoose:
        out.equilibrium_m = at_;
        out.stiffness_n_per_m = kLoose_n_per_m;
        out.damping_n_s_per_m = 2;
        out.max_force_n = 2;
        break;
      case Play::Hands::kLie:
        Lie(hand_m, out);
        break;
    }
    return out;
  }

 private:
  void Hold(double tick_s, HandDrive& out) noexcept {
    if (!play_->places.empty()) {
      const dvec3 way = play_->places.front() - at_;
      at_ += Limited(way, kWays_m_per_s * tick_s);
      if (Dot(way, way) < 1e-8 && play_->places.size() > 1)
        play_->places.erase(play_->places.begin());
    }
    out.equilibrium_m = at_;
    out.stiffness_n_per_m = kHeld_n_per_m;
    out.damping_n_s_per_m = 8;
    out.max_force_n = 30;
  }
  // The weight pulls; on the books it lies.
  void Lie(const dvec3& hand_m, HandDrive& out) noexcept {
    const double in_m = at_.z - hand_m.z;
    const double up_n = in_m > 0 ? kBooks_n_per_m * in_m : 0;
    out.damping_n_s_per_m = in_m > 0 ? 20 : 0;
    out.stiffness_n_per_m = 1;
    out.equilibrium_m = hand_m + dvec3(0, 0, up_n - play_->lying_n);
    out.max_force_n = 100;
  }

  const std::shared_ptr<Play> play_;
  Play::Hands did_ = Play::Hands::kOff;
  dvec3 at_{0};
};

// With a cable.
class Plugged final : public Device {
 public:
  Plugged(const PlantParams& plant, std::shared_ptr<Play> play)
      : play_(play), inner_(plant, std::make_unique<Hands>(play)) {}
  std::string Name() const override { return inner_.Name(); }
  enamel::Hand hand() const override { return inner_.hand(); }
  DeviceSample ReadSample() noexcept override {
    if (play_->plugged) {
      sample_ = inner_.ReadSample();
      ++counters_.samples;
      return sample_;
    }
    counters_.detached += sample_.attached;
    sample_.attached = sample_.fresh = false;
    return sample_;
  }
  void SendForce(const dvec3& force_n) noexcept override {
    counters_.writes += play_->plugged;
    inner_.SendForce(play_->plugged ? force_n : dvec3(0));
  }
  DeviceCounters counters() const noexcept override { return counters_; }

 private:
  const std::shared_ptr<Play> play_;
  SimulatedDevice inner_;
  DeviceSample sample_;
  DeviceCounters counters_;
};

}  // namespace

SimulatedPerson::SimulatedPerson(Person& shown, Person* answers)
    : shown_(shown), answers_(answers), play_(std::make_shared<Play>()) {}
SimulatedPerson::~SimulatedPerson() = default;

MeasuredDevice SimulatedPerson::Unit(const scene::DeviceProfile& profile, double tick_s) {
  core::CoreParams params;
  params.rate_hz = static_cast<uint32_t>(std::lround(1 / tick_s));
  params.resolution_nm.fill(scene::CountNm(profile));
  params.peak_force_mn = static_cast<int32_t>(profile.peak_force_mn.value);
  PlantParams plant = PlantOf(profile, params);
  plant.hand_mass_kg = 0;  // what calibrates it has to find the unit alone
  plant.delay_ticks = static_cast<int>(
      std::min<int64_t>(profile.bus_delay_ticks.value, SimulatedDevice::kMaxDelay));
  MeasuredDevice out;
  out.count_m.fill(plant.count_m);
  out.device = std::make_unique<Plugged>(plant, play_);
  out.profile = profile;
  out.address = std::string(kSimulated) + profile.name;
  radius_m_ = static_cast<double>(profile.workspace_radius_um.value) * 1e-6;
  return out;
}

void SimulatedPerson::Ask(const std::string& id, const std::string& text) {
  (answers_ != nullptr ? *answers_ : shown_).Ask(id, text);
  using Hands = Play::Hands;
  since_s_ = -1;
  takes_s_ = 1.5;
  answer_.clear();
  presses_ = id == "buttons.end";
  pulls_ = id == "unplug.pull";
  Play& play = *play_;
  const auto hold = [&](const dvec3& place) {
    play.hands = Hands::kHold;
    play.places = {place};
  };
  const auto lie = [&](double weight_n) {
    play.hands = Hands::kLie;
    play.lying_n = weight_n;
    answer_ = "yes";
  };
  if (id == "homing.middle" || id.ends_with(".from")) return hold(dvec3(0));
  if (id == "directions.right.to") return hold(dvec3(0.05, 0, 0));
  if (id == "directions.away.to") return hold(dvec3(0, 0.05, 0));
  if (id == "directions.up.to") return hold(dvec3(0, 0, 0.05));
  if (id == "weight.grams") answer_ = std::to_string(std::lround(kHung_g));
  if (id == "weight.empty.yes") return lie(kArm_n);
  if (id == "weight.loaded.yes") return lie(kArm_n + kHung_g * 1e-3 * 9.80665);
  if (id == "unplug.plugged") play.plugged = true;
  if (id == "end.free") answer_ = "yes";
  if (id == "homing.did") answer_ = "nothing: it is simulated";
  if (id == "workspace.end") {
    hold(dvec3(0));
    for (int i = 0; i < 6; ++i) {
      dvec3 end(0);
      end[i / 2] = (i % 2 == 0 ? 0.98 : -0.98) * radius_m_;
      play.places.push_back(end);
    }
    takes_s_ = 13 * radius_m_ / kWays_m_per_s + 1;
  }
  if (id.starts_with("force.")) {
    play.hands = Hands::kLoose;
    answer_ = "yes";
  }
  if (id == "delay.yes" || id == "noise.still") play.hands = Hands::kOff;
  if (id == "delay.yes") answer_ = "yes";
}

Heard SimulatedPerson::Listen(double now_s) {
  if (since_s_ < 0) since_s_ = now_s;
  const double since = now_s - since_s_;
  play_->pedal = presses_ && since > 0.3 && since < 0.6;
  if (since < takes_s_) return {};
  Heard heard =
      answers_ != nullptr ? answers_->Listen(now_s) : Heard{Heard::Kind::kAnswer, answer_};
  if (heard.kind != Heard::Kind::kAnswer) return heard;
  if (answers_ == nullptr) shown_.Tell(answer_);
  if (pulls_) play_->plugged = false;
  return heard;
}

}  // namespace enamel::station::first_hour
