#include "station/app/first_hour/rig.h"

#include <algorithm>
#include <cmath>

#include "station/devices/limited.h"

namespace enamel::station::first_hour {
namespace {

constexpr double kNoPose_s = 0.02;
// A loop that was kept from running for so long begins its ticks anew, and makes none up.
constexpr int64_t kLate_ns = 50'000'000;

}  // namespace

Rig::Rig(double tick_s, bool by_clock, const std::atomic<int>& stop)
    : tick_s_(tick_s), by_clock_(by_clock), stop_(stop), began_ns_(Now_ns()), due_ns_(began_ns_) {}

Rig::~Rig() { Close(); }

void Rig::Hold(MeasuredDevice unit) {
  Close();
  unit_ = std::move(unit);
  sample_ = {};
  tip_m_ = dvec3(0);
  stale_ticks_ = 0;
  known_ = 0;
}

void Rig::Close() {
  EndPush();
  if (unit_) unit_->device->SendForce(dvec3(0));
  unit_.reset();
}

double Rig::now_s() const {
  return by_clock_ ? static_cast<double>(Now_ns() - began_ns_) * 1e-9
                   : static_cast<double>(ticks_) * tick_s_;
}

void Rig::BeginPush(const PushLimits& limits) {
  push_ = limits;
  push_from_m_ = tip_m_;
  cut_.clear();
}

void Rig::EndPush() {
  push_.reset();
  sent_n_ = dvec3(0);
}

double Rig::speed_m_per_s() const {
  if (known_ < kSpeedOver) return 0;
  const dvec3 way = tip_m_ - before_m_[static_cast<size_t>(ticks_) % kSpeedOver];
  return std::sqrt(Dot(way, way)) / (static_cast<double>(kSpeedOver) * tick_s_);
}

const char* Rig::WhyCut() const {
  if (is_stopped()) return "the program was asked to stop";
  if (!sample_.attached) return "the unit was unplugged";
  if (!sample_.driven) return "the unit switched its motors off";
  if (silent_s() > kNoPose_s) return "the unit sent no pose for 20 ms";
  if (speed_m_per_s() > push_->fastest_m_per_s) return "the handle moved too fast";
  const dvec3 way = tip_m_ - push_from_m_;
  if (Dot(way, way) > push_->farthest_m * push_->farthest_m) return "the handle moved too far";
  return nullptr;
}

void Rig::Read() {
  if (by_clock_) {
    due_ns_ += std::llround(tick_s_ * 1e9);
    if (Now_ns() - due_ns_ > kLate_ns) due_ns_ = Now_ns();
    SleepUntil(due_ns_);
  }
  if (unit_) {
    const dvec3 before = tip_m_;
    sample_ = unit_->device->ReadSample();
    stale_ticks_ = sample_.fresh ? 0 : stale_ticks_ + 1;
    if (sample_.fresh) {
      for (int i = 0; i < 3; ++i) {
        const auto a = static_cast<size_t>(i);
        tip_m_[i] = sample_.counts[a] * unit_->count_m[a];
      }
    }
    before_m_[static_cast<size_t>(ticks_) % kSpeedOver] = before;
    known_ = std::min(known_ + 1, kSpeedOver);
  }
  ++ticks_;
  if (push_) {
    if (const char* why = WhyCut()) {
      cut_ = why;
      push_.reset();
    }
  }
}

void Rig::Send(const dvec3& force_n) {
  sent_n_ = push_ ? Limited(force_n, push_->most_n) : dvec3(0);
  if (unit_) unit_->device->SendForce(sent_n_);
}

}  // namespace enamel::station::first_hour
