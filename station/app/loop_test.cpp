#include "station/app/loop_test.h"

#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <thread>
#include <vector>

#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/plan.h"
#include "station/devices/pointer_device.h"
#include "station/loop/realtime.h"
#include "station/loop/tick_loop.h"
#include "station/session/loop_facts.h"

namespace enamel::station {
namespace {

// Short alternating turns, so that the computer's other work affects both alike.
constexpr int kTurn_s = 5;
constexpr int kBatch = 1000, kBatches = 200;
// 0.4 s at the highest rate: a drain that is late loses nothing.
constexpr size_t kRingTicks = 8000;
constexpr int64_t kSecond_ns = 1'000'000'000;

int64_t Now_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond_ns + t.tv_nsec;
}

struct Bench {
  core::CoreParams params;
  cutting::Volume volume;
};

Result<Bench> MakeBench(int rate_hz) {
  // A small scene: the bur stays in free air, where the loop's own cost is the largest share of a
  // tick.
  ENAMEL_ASSIGN_OR_RETURN(auto built, scene::BuildBuiltinScene("block", 100'000));
  scene::Exercise exercise = scene::ClassOneExercise(built.scene, {});
  exercise.rate_hz = std::min(rate_hz, 8000);
  for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    if (p.name != "pointer") continue;
    ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(built.scene, exercise, p));
    // Above an exercise's limits: this measures the loop, not a law.
    params.rate_hz = static_cast<uint32_t>(rate_hz);
    return Bench{params, std::move(built.volume)};
  }
  return Status(Code::kInternal, "no pointer profile");
}

// A hand that circles in the air, at a window's rate of publishing.
void Circle(PointerDevice& device, int step) {
  PointerPose pose;
  double turn = 0.05 * step;
  pose.offset_m = dvec3(std::cos(turn), std::sin(turn), 0) * 2e-3;
  pose.buttons = kPedal;
  device.Publish(pose);
}

struct Cost {
  double loop_ns = 0, core_ns = 0;        // means per tick
  double own_p05_ns = 0, own_p95_ns = 0;  // of the batches' differences
  double own_ns() const { return loop_ns - core_ns; }
};

Cost MeasureCost(const Bench& bench) {
  PointerDevice device(bench.params.resolution_nm[0] * 1e-9, 1.0 / bench.params.rate_hz);
  core::Core in_loop(bench.params, bench.volume), alone(bench.params, bench.volume);
  SampleRing ring(kBatch);
  TickLoop loop(device, in_loop, ring, {bench.params.rate_hz, false, true});
  std::vector<core::TickInput> inputs(kBatch);
  std::vector<double> own;
  Cost out;
  for (int batch = 0; batch < kBatches; ++batch) {
    Circle(device, batch);
    int64_t begin = Now_ns();
    // Tick instead of Run: without its sleep, the difference to the core alone is the loop's own
    // work.
    for (int i = 0; i < kBatch; ++i) loop.Tick();
    int64_t middle = Now_ns();
    Sample sample;
    for (auto& input : inputs) {
      ENAMEL_CHECK(ring.Pop(sample));
      input = sample.tick.input;
    }
    int64_t again = Now_ns();
    for (const auto& input : inputs) alone.Step(input);
    int64_t end = Now_ns();
    double tick = static_cast<double>(middle - begin) / kBatch;
    double step = static_cast<double>(end - again) / kBatch;
    out.loop_ns += tick / kBatches;
    out.core_ns += step / kBatches;
    own.push_back(tick - step);
  }
  // Both did the same, so the difference is not in the core.
  ENAMEL_CHECK(alone.state_hash() == in_loop.state_hash());
  std::sort(own.begin(), own.end());
  out.own_p05_ns = own[own.size() / 20];
  out.own_p95_ns = own[own.size() - 1 - own.size() / 20];
  return out;
}

// Lateness in readable steps, us; the last is unlimited.
constexpr std::array<double, 9> kSteps_us{20, 50, 100, 200, 500, 1000, 2000, 5000, 1e12};
using Steps = std::array<uint64_t, kSteps_us.size()>;

struct Turn {
  double p50_us = 0, p99_us = 0, max_us = 0;
  uint64_t ticks = 0, late = 0;  // late: by a whole period or more
  Steps steps{};
  boost::json::object histogram;
};

// A bucket that straddles an edge counts below it: its width is a 32nd of its value.
Turn TurnOf(const DurationHistogram& h, int rate_hz) {
  Turn out{h.Quantile_ns(0.5) * 1e-3,
           h.Quantile_ns(0.99) * 1e-3,
           static_cast<double>(h.max_ns()) * 1e-3,
           h.count(),
           0,
           {},
           DurationFacts(h)};
  const uint64_t period_ns = static_cast<uint64_t>(kSecond_ns / rate_hz);
  for (size_t i = 0; i < DurationHistogram::kBuckets; ++i) {
    const uint64_t floor_ns = DurationHistogram::Floor_ns(i), count = h.InBucket(i);
    if (floor_ns >= period_ns) out.late += count;
    size_t step = 0;
    while (static_cast<double>(floor_ns) >= kSteps_us[step] * 1e3) ++step;
    out.steps[step] += count;
  }
  return out;
}

double LateShare(const Turn& t) {
  return t.ticks == 0 ? 0 : static_cast<double>(t.late) / static_cast<double>(t.ticks);
}

// Empties the ring every 2 ms, like the recorder, even when nothing comes.
class Drain {
 public:
  explicit Drain(SampleRing& ring) : ring_(ring), thread_([this] { Run(); }) {}
  ~Drain() {
    stop_ = true;
    thread_.join();
  }

 private:
  void Run() {
    Sample sample;
    while (!stop_) {
      while (ring_.Pop(sample)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  SampleRing& ring_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

Turn BareTurn(int rate_hz, const RealtimeRequest& realtime, RealtimeGrant& grant) {
  DurationHistogram late;
  std::thread([&] {
    grant = RequestRealtime(realtime);
    int64_t period = kSecond_ns / rate_hz, due = Now_ns(), end = due + kTurn_s * kSecond_ns;
    while (due < end) {
      due += period;
      timespec t{due / kSecond_ns, due % kSecond_ns};
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
      }
      int64_t late_ns = Now_ns() - due;
      late.Add(late_ns);
      // Leaves out whole periods that passed, as the loop does: catching up would count one delay
      // many times.
      if (late_ns > period) due += late_ns / period * period;
    }
  }).join();
  return TurnOf(late, rate_hz);
}

struct LoopTurn {
  Turn lateness;
  double tick_mean_us = 0, tick_max_us = 0;
  uint64_t late_ticks = 0, gap_ticks = 0;
};

LoopTurn WholeTurn(const Bench& bench, SampleRing& ring, const RealtimeRequest& realtime) {
  PointerDevice device(bench.params.resolution_nm[0] * 1e-9, 1.0 / bench.params.rate_hz);
  core::Core core(bench.params, bench.volume);
  auto loop = std::make_unique<TickLoop>(device, core, ring,
                                         TickLoopOptions{bench.params.rate_hz, false, true});
  std::thread ticks([&] {
    RequestRealtime(realtime);
    loop->Run();
  });
  for (int i = 0; i < kTurn_s * 60; ++i) {
    Circle(device, i);
    std::this_thread::sleep_for(std::chrono::microseconds(16'667));
  }
  loop->RequestStop();
  ticks.join();
  const LoopCounters& counters = loop->snapshot().counters;
  return {TurnOf(loop->lateness(), static_cast<int>(bench.params.rate_hz)),
          loop->durations().mean_ns() * 1e-3,
          static_cast<double>(loop->durations().max_ns()) * 1e-3, counters.late_ticks,
          counters.gap_ticks};
}

double Median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  size_t n = v.size();
  return n % 2 == 1 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
}

void PrintTurn(const char* kind, const Turn& t) {
  std::printf(
      "  %-5s %8llu ticks   p50 %7.1f   p99 %7.1f   max %8.1f us late   a period or more %.3f %%\n",
      kind, static_cast<unsigned long long>(t.ticks), t.p50_us, t.p99_us, t.max_us,
      100 * LateShare(t));
  std::fflush(stdout);
}

void PrintSteps(const char* kind, const Turn& all) {
  std::printf("  %-5s", kind);
  for (size_t i = 0; i < kSteps_us.size(); ++i) {
    double share =
        static_cast<double>(all.steps[i]) / static_cast<double>(std::max<uint64_t>(1, all.ticks));
    std::printf(" %9.4f", 100 * share);
  }
  std::printf("\n");
}

// Shares of all turns' ticks by lateness, in per cent.
void PrintHistogram(const Turn& bare, const Turn& loop) {
  std::printf("  share of ticks, %%, late by less than, us:\n       ");
  for (size_t i = 0; i + 1 < kSteps_us.size(); ++i) std::printf(" %9.0f", kSteps_us[i]);
  std::printf(" %9s\n", "more");
  PrintSteps("bare", bare);
  PrintSteps("loop", loop);
}

void AddTo(Turn& all, const Turn& turn) {
  all.ticks += turn.ticks;
  all.late += turn.late;
  for (size_t i = 0; i < all.steps.size(); ++i) all.steps[i] += turn.steps[i];
}

boost::json::object Json(const char* kind, const Turn& t) {
  return {{"kind", kind},
          {"p50_us", t.p50_us},
          {"p99_us", t.p99_us},
          {"max_us", t.max_us},
          {"ticks", t.ticks},
          {"late_ticks", t.late},
          {"late_share", LateShare(t)},
          {"lateness", t.histogram}};
}

}  // namespace

Status TestLoop(const LoopTestCommand& options) {
  if (options.rate_hz < 100 || options.rate_hz > 20'000 || options.seconds < 4 * kTurn_s) {
    return Status(Code::kInvalidInput,
                  "expected a rate of 100 to 20000 Hz and at least 20 s (two turns of 5 s each), "
                  "found " +
                      std::to_string(options.rate_hz) + " Hz and " +
                      std::to_string(options.seconds) + " s");
  }
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_ASSIGN_OR_RETURN(auto bench, MakeBench(options.rate_hz));

  std::printf("Own cost: %d batches of %d ticks in free air against the core alone, same inputs\n",
              kBatches, kBatch);
  Cost cost;
  std::thread([&] {
    RequestRealtime({options.cpu});
    cost = MeasureCost(bench);
  }).join();
  std::printf(
      "  loop %.0f ns, core %.0f ns: own cost %.0f ns a tick (90 %% of the batches %.0f to "
      "%.0f); 5000 allowed\n",
      cost.loop_ns, cost.core_ns, cost.own_ns(), cost.own_p05_ns, cost.own_p95_ns);

  const int turns = options.seconds / (2 * kTurn_s);
  std::printf("Lateness at %d Hz: a bare sleep and the loop take turns of %d s, %d of each\n",
              options.rate_hz, kTurn_s, turns);
  SampleRing ring(kRingTicks);
  Drain drain(ring);
  RealtimeGrant grant;
  RealtimeRequest realtime{options.cpu};
  std::vector<double> bare_p99, loop_p99, tick_mean;
  Turn all_bare, all_loop;
  boost::json::array all;
  for (int i = 0; i < turns; ++i) {
    Turn bare = BareTurn(options.rate_hz, realtime, grant);
    if (i == 0 && !grant.refused.empty()) std::printf("  note: %s\n", grant.refused.c_str());
    PrintTurn("bare", bare);
    LoopTurn loop = WholeTurn(bench, ring, realtime);
    PrintTurn("loop", loop.lateness);
    AddTo(all_bare, bare);
    AddTo(all_loop, loop.lateness);
    bare_p99.push_back(bare.p99_us);
    loop_p99.push_back(loop.lateness.p99_us);
    tick_mean.push_back(loop.tick_mean_us);
    all.push_back(Json("bare", bare));
    all.push_back(Json("loop", loop.lateness));
  }
  auto [low, high] = std::minmax_element(bare_p99.begin(), bare_p99.end());
  // Uses p99 instead of the largest: one hiccup of the system determines that, in either's turn.
  double spread = *high - *low, difference = Median(loop_p99) - Median(bare_p99);
  // 10 us: a hundredth of a tick at 1 kHz. If bare sleeps differ more among themselves, smaller
  // differences are not detectable.
  bool within = difference <= std::max(10.0, spread);
  std::printf(
      "  median p99: bare %.1f us, loop %.1f us, difference %+.1f us; bare against bare spreads "
      "over "
      "%.1f us: %s\n  a tick with everything in it takes %.2f us in the mean\n",
      Median(bare_p99), Median(loop_p99), difference, spread,
      within ? "within 10 us or the spread" : "NOT within 10 us or the spread", Median(tick_mean));
  PrintHistogram(all_bare, all_loop);
  std::printf("  late by a whole period or more: bare %.4f %%, loop %.4f %% of the ticks\n",
              100 * LateShare(all_bare), 100 * LateShare(all_loop));
  return program::WriteJsonFile(options.json, {{"rate_hz", options.rate_hz},
                                               {"own_ns", cost.own_ns()},
                                               {"loop_ns", cost.loop_ns},
                                               {"core_ns", cost.core_ns},
                                               {"bare_p99_us", Median(bare_p99)},
                                               {"loop_p99_us", Median(loop_p99)},
                                               {"difference_us", difference},
                                               {"bare_spread_us", spread},
                                               {"within", within},
                                               {"bare_late_share", LateShare(all_bare)},
                                               {"loop_late_share", LateShare(all_loop)},
                                               {"refused", grant.refused},
                                               {"turns", all}});
}

}  // namespace enamel::station
