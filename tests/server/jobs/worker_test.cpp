#include "server/jobs/worker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>

#include "common/base/log_request.h"
#include "server/storage/engine/query.h"
#include "server/storage/store_engine.h"
#include "tests/server/jobs/job_school.h"

namespace enamel::server {
namespace {

using namespace std::chrono_literals;
using test::JobSchool;
using test::World;

// Far beyond what any machine needs; only a hang meets it.
constexpr auto kPatience = 60s;

// Collects what the worker reports.
class Reports {
 public:
  void Add(const JobRow& job, const Status& status) {
    {
      std::lock_guard lock(mutex_);
      seen_.emplace_back(job, status);
    }
    changed_.notify_all();
  }
  bool WaitFor(size_t count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return seen_.size() >= count; });
  }
  std::vector<std::pair<JobRow, Status>> seen() {
    std::lock_guard lock(mutex_);
    return seen_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::pair<JobRow, Status>> seen_;
};

class WorkerTest : public ::testing::Test {
 protected:
  WorkerOptions Options(std::chrono::milliseconds poll = 5ms) {
    WorkerOptions options;
    options.poll = poll;
    options.on_done = [this](const JobRow& job, const Status& status) {
      // What is logged of a job names its attempt.
      EXPECT_EQ(LogAttempt::Current(), job.attempt.IsZero() ? "" : job.attempt.Text()) << job.kind;
      reports_.Add(job, status);
    };
    return options;
  }
  // Scored against itself, as there is no reference.
  Uuid Queue() { return school_.Record({}, true); }
  // Queues one that was made at another station.
  Uuid QueueElsewhere() {
    if (elsewhere_.IsZero()) {
      const Sha256 code = HashSha256(AsBytes("code 2"));
      StationRow bench;
      bench.name = "bench 2";
      bench.public_key = Bytes(32, 2);
      EXPECT_TRUE(store_.stations.AddEnrolCode(code, 1000, Actor{{}, "test"}).ok());
      elsewhere_ = store_.stations.EnrolStation(code, bench, code, 10)->id;
      school_.Exec("UPDATE stations SET public_key = (SELECT public_key FROM stations WHERE id = " +
                   JobSchool::Sql(school_.station) + ")");
    }
    const Uuid attempt = Queue();
    school_.Set(attempt, "station = " + JobSchool::Sql(elsewhere_));
    return attempt;
  }
  // In which the queue's jobs end.
  std::vector<Uuid> OrderOf(size_t jobs, std::chrono::milliseconds turn) {
    WorkerOptions options = Options();
    options.turn = turn;
    Worker worker(store_, options);
    worker.Start();
    EXPECT_TRUE(reports_.WaitFor(jobs));
    worker.Stop();
    std::vector<Uuid> out;
    for (const auto& [job, status] : reports_.seen()) {
      EXPECT_TRUE(status.ok()) << status.message();
      out.push_back(job.attempt);
    }
    return out;
  }
  size_t Count(const std::string& state) { return store_.jobs.Jobs(state)->size(); }
  bool HasResult(const Uuid& attempt) { return store_.results.ResultOf(attempt).ok(); }
  std::vector<double> Numbers(const std::string& sql) {
    std::vector<double> out;
    const Status read = store_.engine->rows.Read([&](sql::Db& db) {
      sql::Query q(db, sql);
      while (q.Next()) out.push_back(q.Real(0));
      return q.status();
    });
    EXPECT_TRUE(read.ok()) << read.message();
    return out;
  }
  // Every progress that a run tells goes to told_progress; at three tenths of it, `also`.
  void OnProgress(const std::string& also = {}) {
    school_.Exec("CREATE TABLE told_progress (done REAL)");
    school_.Exec(
        "CREATE TRIGGER tells_progress AFTER UPDATE OF progress ON attempts WHEN NEW.state = 4 "
        "BEGIN INSERT INTO told_progress VALUES (NEW.progress); END");
    if (also.empty()) return;
    school_.Exec(
        "CREATE TRIGGER at_three_tenths AFTER UPDATE OF progress ON attempts WHEN NEW.state = 4 "
        "AND NEW.progress >= 0.3 BEGIN " +
        also + "; END");
  }
  std::vector<double> Told() { return Numbers("SELECT done FROM told_progress ORDER BY rowid"); }

  std::atomic<bool> broken_{false};
  std::atomic<int> refused_{0};
  JobSchool school_{World::Get(), [this] {
                      if (broken_) ++refused_;
                      return broken_.load();
                    }};
  Store& store_ = *school_.store;
  Reports reports_;
  Uuid elsewhere_{};
};

TEST_F(WorkerTest, RunsEveryJobAndShowsProgress) {
  OnProgress();
  const Uuid attempt = Queue();
  Queue();
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(Count("done"), 2u);
  EXPECT_EQ(school_.Row(attempt).state, AttemptState::kScored);
  EXPECT_GE(Told().size(), 4u);
  EXPECT_LE(Told().size(), 2u * 21);
}

TEST_F(WorkerTest, CancelledJobEndsUnscoredAndIsNotTriedAgain) {
  // As another server's CancelJob leaves it.
  OnProgress(
      "UPDATE jobs SET state = 'cancelled', lease = NULL WHERE attempt = NEW.id; "
      "UPDATE attempts SET state = 3 WHERE id = NEW.id");
  const Uuid attempt = Queue();
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kUnavailable);
  EXPECT_EQ(Count("cancelled"), 1u);
  EXPECT_EQ(school_.Row(attempt).state, AttemptState::kSealed);
  EXPECT_FALSE(HasResult(attempt));
  EXPECT_LT(Told().back(), 0.7) << "it stopped soon after";
}

TEST_F(WorkerTest, KeepsTheLeaseOfWhatItIsAt) {
  const Uuid attempt = Queue();
  const auto kept_until = [&] { return Numbers("SELECT lease_until_ms FROM jobs")[0]; };
  std::optional<double> at_first;
  std::atomic<bool> kept{false};
  // The run waits before storing its results.
  school_.disk.before_change = [&] {
    if (!at_first) at_first = kept_until();
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (!kept && std::chrono::steady_clock::now() < until) {
      kept = kept_until() > *at_first;
      std::this_thread::sleep_for(1ms);
    }
  };
  WorkerOptions options = Options();
  options.heartbeat = 1ms;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_TRUE(reports_.seen()[0].second.ok()) << reports_.seen()[0].second.message();
  EXPECT_TRUE(kept);
  EXPECT_EQ(Count("done"), 1u);
  EXPECT_TRUE(HasResult(attempt));
}

TEST_F(WorkerTest, ARunWhoseJobAnotherWorkerHasStopsAndChangesNothing) {
  OnProgress("UPDATE jobs SET lease = randomblob(16) WHERE attempt = NEW.id");
  const Uuid attempt = Queue();
  WorkerOptions options = Options();
  options.heartbeat = 1ms;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kUnavailable);
  EXPECT_EQ(Count("running"), 1u) << "the other worker's";
  EXPECT_FALSE(HasResult(attempt));
  EXPECT_LT(Told().back(), 0.7) << "it stopped soon after";
}

TEST_F(WorkerTest, NotifyWakesAWorkerThatWouldSleepForAnHour) {
  Worker worker(store_, Options(1h));
  worker.Start();
  Queue();
  worker.Notify();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(Count("done"), 1u);
}

TEST_F(WorkerTest, AnAttemptsOwnProblemEndsItsJobAtOnce) {
  const Uuid attempt = school_.Record();
  school_.Spoil(attempt, [](test::Recording& recording) { recording.header.resize(20); });
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  ASSERT_EQ(Count("done"), 1u);
  EXPECT_EQ(store_.jobs.Jobs("done")->front().tries, 1u);
  EXPECT_EQ(school_.Row(attempt).state, AttemptState::kFailed);
}

TEST_F(WorkerTest, TroubleWithTheDiskIsTriedAgain) {
  Queue();
  school_.disk.until_failure = 0;
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kStorage);
  EXPECT_TRUE(reports_.seen()[1].second.ok());
  EXPECT_EQ(store_.jobs.Jobs("done")->front().tries, 2u);
}

TEST_F(WorkerTest, AnUnknownKindOfJobFailsAndIsNotRunForever) {
  Queue();
  school_.Exec("UPDATE jobs SET kind = 'polish'");
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(3));
  worker.Stop();
  ASSERT_EQ(Count("failed"), 1u);
  EXPECT_NE(store_.jobs.Jobs("failed")->front().error.find("polish"), std::string::npos);
}

TEST_F(WorkerTest, ABrokenQueueIsReportedOnceAndSurvived) {
  Queue();
  broken_ = true;
  Worker worker(store_, Options(1ms));
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kStorage);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (refused_ < 5 && std::chrono::steady_clock::now() < until) std::this_thread::yield();
  broken_ = false;
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(reports_.seen().size(), 2u);
  EXPECT_EQ(Count("done"), 1u);
}

TEST_F(WorkerTest, StopReturnsAnInterruptedJobToTheQueue) {
  const Uuid attempt = Queue();
  // Stopping may win or lose the race against the job; both ends are whole.
  for (int i = 0; i < 2; ++i) {
    Worker worker(store_, Options());
    worker.Start();
    worker.Stop();
    worker.Stop();
  }
  EXPECT_EQ(Count("queued") + Count("done"), 1u);
  EXPECT_EQ(HasResult(attempt), Count("done") == 1);
}

TEST_F(WorkerTest, SeveralThreadsShareTheQueue) {
  for (int i = 0; i < 4; ++i) Queue();
  WorkerOptions options = Options();
  options.threads = 2;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(4));
  worker.Stop();
  EXPECT_EQ(Count("done"), 4u);
}

TEST_F(WorkerTest, StationsTakeTurns) {
  const Uuid first = Queue(), second = Queue(), third = Queue(), others = QueueElsewhere();
  EXPECT_EQ(OrderOf(4, 1h), (std::vector<Uuid>{first, others, second, third}));
}

// However long the nonsense of one chair takes to compute, another's score comes.
TEST_F(WorkerTest, ALongJobLetsThoseOfOtherStationsPass) {
  const Uuid slow = Queue(), next = Queue(), others = QueueElsewhere(), more = QueueElsewhere();
  EXPECT_EQ(OrderOf(4, 0ms), (std::vector<Uuid>{others, more, slow, next}));
  EXPECT_EQ(Count("done"), 4u);
  EXPECT_EQ(school_.Row(slow).state, AttemptState::kScored);
  EXPECT_EQ(school_.Row(others).state, AttemptState::kScored);
}

TEST_F(WorkerTest, MakesTimelinesWhenNobodyWaitsForAScore) {
  const Uuid attempt = Queue();
  WorkerOptions options = Options();
  options.timelines = true;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].first.kind, "score");
  EXPECT_EQ(reports_.seen()[1].first.kind, "timeline");
  EXPECT_EQ(reports_.seen()[1].first.attempt, attempt);
  EXPECT_TRUE(reports_.seen()[1].second.ok()) << reports_.seen()[1].second.message();
  EXPECT_FALSE(store_.timelines.TimelineOf(attempt)->content.IsZero());
}

TEST_F(WorkerTest, MakesNoTimelinesUnlessItIsToldTo) {
  Queue();
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(Numbers("SELECT tries FROM timelines"), std::vector<double>{0});
}

}  // namespace
}  // namespace enamel::server
