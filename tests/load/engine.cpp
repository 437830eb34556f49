#include "tests/load/engine.h"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "common/base/check.h"

namespace enamel::load {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr uint64_t kHostileTag = uint64_t{1} << 32;
constexpr double kHostileEvery_s = 0.05;

}  // namespace

double NowS() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Engine::Engine(const LinkTarget& target) : target_(target), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
  ENAMEL_CHECK(epoll_ >= 0);
}

Engine::~Engine() {
  stations_.clear();
  hostile_.clear();
  ::close(epoll_);
}

Station& Engine::Add(StationPlan plan) {
  stations_.push_back(
      std::make_unique<Station>(target_, epoll_, stations_.size(), std::move(plan), figures_));
  return *stations_.back();
}

void Engine::AddHostile(HostileKind kind) {
  hostile_.push_back(
      std::make_unique<Hostile>(target_, epoll_, kHostileTag + hostile_.size(), kind));
}

std::string Engine::Problem() const {
  for (const auto& station : stations_) {
    if (!station->problem().empty()) return station->problem();
  }
  return "";
}

void Engine::Touch(size_t index, double now) {
  Station& station = *stations_[index];
  uint64_t ticks = station.ticks();
  double wake = station.Advance(now);
  progress_.ticks += station.ticks() - ticks;
  if (wake != wake_s_[index]) {
    wake_s_[index] = wake;
    if (wake < kNever) wakes_.push({wake, index});
  }
  bool reached = station.Reached() || !station.problem().empty();
  if (reached == reached_[index]) return;
  reached_[index] = reached;
  reached_count_ += reached ? 1 : -1;
  progress_.reached = reached_count_;
}

// Lets the next stations begin while fewer than the limit are starting.
void Engine::Admit(const Phase& phase, double now) {
  while (admitted_ < stations_.size() && admitted_ < reached_count_ + phase.at_once) {
    stations_[admitted_]->SetGoal(phase.goal);
    Touch(admitted_++, now);
  }
}

void Engine::PullCables(double rate, double now) {
  if (rate <= 0 || now < next_cut_s_) return;
  if (next_cut_s_ > 0) {
    size_t index = random_() % stations_.size();
    stations_[index]->Cut();
    Touch(index, now);
  }
  next_cut_s_ = now + std::exponential_distribution<>(rate)(random_);
}

void Engine::WaitForEvents(double now, double until_s) {
  double wait_s = std::clamp(until_s - now, 0.0, kHostileEvery_s);
  epoll_event events[256];
  int n = ::epoll_wait(epoll_, events, 256, static_cast<int>(std::ceil(wait_s * 1e3)));
  now = NowS();
  for (int i = 0; i < n; ++i) {
    uint64_t tag = events[i].data.u64;
    if (tag >= kHostileTag) {
      hostile_[tag - kHostileTag]->Advance(now);
    } else if (tag < admitted_) {
      Touch(tag, now);
    }
  }
}

bool Engine::Run(const Phase& phase) {
  wake_s_.assign(stations_.size(), -1);
  wakes_ = {};
  // All begin as absent; Touch finds those that are present.
  reached_.assign(stations_.size(), false);
  reached_count_ = admitted_ = 0;
  progress_.reached = 0;
  next_cut_s_ = 0;
  double hostile_s = 0;
  for (double now = NowS(); now < phase.until_s; now = NowS()) {
    Admit(phase, now);
    if (!phase.stay && reached_count_ == stations_.size()) return Problem().empty();
    while (!wakes_.empty() && wakes_.top().at_s <= now) {
      Wake wake = wakes_.top();
      wakes_.pop();
      if (wake_s_[wake.station] == wake.at_s) Touch(wake.station, now);
    }
    if (now - hostile_s > kHostileEvery_s) {
      hostile_s = now;
      for (auto& hostile : hostile_) hostile->Advance(now);
    }
    PullCables(phase.cuts_per_s, now);
    double next = wakes_.empty() ? phase.until_s : std::min(phase.until_s, wakes_.top().at_s);
    WaitForEvents(NowS(), next);
  }
  return reached_count_ == stations_.size() && Problem().empty();
}

}  // namespace enamel::load
