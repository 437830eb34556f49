// How much faster two workers regrade a class than one: jobs as the server runs them, over a store
// in a temporary folder. Rounds alternate, so that a machine that slows down affects both.
//
// On a machine that does other work as well, a runnable thread waits for a core. The kernel counts
// that wait (schedstat), and it is subtracted. The rest is the workers' own time: computing, and
// waiting for one another, for locks and for the end of the round.
//
//   regrade_bench [ATTEMPTS, 144] [ROUNDS, 3]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

#include "server/jobs/score_job.h"
#include "server/jobs/worker.h"
#include "tests/server/jobs/job_school.h"

namespace {

using namespace enamel;
using namespace enamel::server;

double Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// For one thread since it began, s.
struct Spent {
  double computing = 0, waiting_for_a_core = 0;
};
Spent SpentByThisThread() {
  std::ifstream file("/proc/thread-self/schedstat");
  double computing_ns = 0, waiting_ns = 0;
  file >> computing_ns >> waiting_ns;
  return {1e-9 * computing_ns, 1e-9 * waiting_ns};
}

struct Round {
  double wall_s = 0, computing_s = 0;  // all workers together
  double own_s = 0;                    // the wall's time had every worker a core of its own
};

Round Grade(test::JobSchool& school, const std::vector<Uuid>& attempts, int workers) {
  std::mutex mutex;
  std::condition_variable ended;
  size_t done = 0;
  std::map<std::thread::id, Spent> spent;
  WorkerOptions options;
  options.threads = workers;
  options.on_done = [&](const JobRow&, const Status& status) {
    if (!status.ok()) std::abort();
    const std::lock_guard lock(mutex);
    spent[std::this_thread::get_id()] = SpentByThisThread();
    ++done;
    ended.notify_one();
  };
  for (const Uuid& attempt : attempts) {
    // The seal has queued its first run.
    if (school.Row(attempt).state != AttemptState::kScored) continue;
    if (!school.store->judging.Rescore(attempt, "rescore", Actor{{}, "bench"}).ok()) std::abort();
  }
  Worker worker(*school.store, options);
  const double from_s = Now_s();
  worker.Start();
  std::unique_lock lock(mutex);
  ended.wait(lock, [&] { return done == attempts.size(); });
  Round out;
  out.wall_s = Now_s() - from_s;
  double own_s = 0;
  for (const auto& [thread, s] : spent) {
    out.computing_s += s.computing;
    own_s += out.wall_s - s.waiting_for_a_core;
  }
  out.own_s = own_s / workers;
  lock.unlock();
  worker.Stop();
  for (const Uuid& attempt : attempts) {
    if (school.Row(attempt).state != AttemptState::kScored) std::abort();
  }
  return out;
}

int Number(int argc, char** argv, int index, int usual) {
  return argc > index ? std::max(1, std::atoi(argv[index])) : usual;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = Number(argc, argv, 1, 144), rounds = Number(argc, argv, 2, 3);
  const std::unique_ptr<test::JobSchool> school = test::JobSchool::WithReference();
  std::vector<Uuid> attempts;
  for (int i = 0; i < count; ++i) {
    attempts.push_back(school->Record({.mesial_extra_mm = 0.01 * (i % 40)}));
  }
  std::printf(
      "%d attempts of a class I cavity, 0.1 mm voxels, graded again\n\n%7s %8s %8s "
      "%12s\n",
      count, "workers", "wall s", "own s", "computing s");
  double own_s[3] = {0, 0, 0}, computing_s[3] = {0, 0, 0};
  for (int round = 0; round < rounds; ++round) {
    for (int workers : {1, 2}) {
      const Round r = Grade(*school, attempts, workers);
      std::printf("%7d %8.2f %8.2f %12.2f\n", workers, r.wall_s, r.own_s, r.computing_s);
      std::fflush(stdout);
      own_s[workers] += r.own_s;
      computing_s[workers] += r.computing_s;
    }
  }
  std::printf("\n2 workers against 1, waiting for a core taken off: %.2f x (goal 1.8)\n",
              own_s[1] / own_s[2]);
  std::printf("computing of both together against one's: %.2f x\n",
              computing_s[2] / computing_s[1]);
}
