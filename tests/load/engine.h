#pragma once

#include <functional>
#include <memory>
#include <queue>
#include <vector>

#include "tests/load/stations/hostile.h"
#include "tests/load/stations/station.h"

namespace enamel::load {

// Seconds of the steady clock, used by all schedules.
double NowS();

// Some stations on one thread and one epoll. Thread safety: one thread at a time; `stop` and
// progress() may be used from others.
class Engine {
 public:
  // Values that other threads may read while it runs.
  struct Progress {
    std::atomic<uint64_t> reached{0}, connected{0}, ticks{0};
  };

  explicit Engine(const LinkTarget& target);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  Station& Add(StationPlan plan);
  // A hostile connection, run alongside the stations.
  void AddHostile(HostileKind kind);

  struct Phase {
    Goal goal = Goal::kTicket;
    size_t at_once = SIZE_MAX;  // stations that may be on their way to the goal together
    double until_s = 0;         // ends then at the latest
    bool stay = false;          // ends then and not when all have got there
    double cuts_per_s = 0;      // cables pulled, at random
  };
  // Runs the stations toward a goal. True when all reached it.
  bool Run(const Phase& phase);

  std::vector<std::unique_ptr<Station>>& stations() { return stations_; }
  StreamFigures& figures() { return figures_; }
  const Progress& progress() const { return progress_; }
  const std::vector<std::unique_ptr<Hostile>>& hostile() const { return hostile_; }
  // The first station's problem, if any has one.
  std::string Problem() const;

 private:
  struct Wake {
    double at_s;
    size_t station;
    bool operator>(const Wake& other) const { return at_s > other.at_s; }
  };
  void Touch(size_t index, double now);
  void Admit(const Phase& phase, double now);
  void WaitForEvents(double now, double until_s);
  void PullCables(double rate, double now);
  size_t Reached() const;

  const LinkTarget& target_;
  int epoll_;
  StreamFigures figures_;
  Progress progress_;
  std::vector<std::unique_ptr<Station>> stations_;
  std::vector<std::unique_ptr<Hostile>> hostile_;
  std::vector<double> wake_s_;  // the valid entry of the queue, per station
  std::vector<bool> reached_;
  size_t reached_count_ = 0, admitted_ = 0;
  std::priority_queue<Wake, std::vector<Wake>, std::greater<>> wakes_;
  double next_cut_s_ = 0;
  std::mt19937 random_{7};
};

}  // namespace enamel::load
