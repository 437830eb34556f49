#include "server/jobs/worker.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>

#include "tests/server/jobs/recorded_attempt.h"

namespace enamel::server {
namespace {

using namespace std::chrono_literals;
using test::MemoryStore;
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

class WorkerTest : public testing::Test {
 protected:
  WorkerTest() { world_.AddTo(store_); }
  WorkerOptions Options(std::chrono::milliseconds poll = 5ms) {
    WorkerOptions options;
    options.poll = poll;
    options.on_done = [this](const JobRow& job, const Status& status) {
      reports_.Add(job, status);
    };
    return options;
  }

  const World& world_ = World::Get();
  MemoryStore store_;
  Reports reports_;
};

TEST_F(WorkerTest, RunsEveryJobAndShowsProgress) {
  Uuid reference = world_.RecordReference(store_), attempt = world_.Record(store_);
  store_.Queue(reference);
  store_.Queue(attempt);
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(store_.Jobs("done")->size(), 2u);
  EXPECT_EQ(store_.attempts[attempt].state, AttemptState::kScored);
  EXPECT_GE(store_.progress.size(), 4u);
  EXPECT_LE(store_.progress.size(), 2u * 21);
}

TEST_F(WorkerTest, CancelledJobEndsUnscoredAndIsNotTriedAgain) {
  Uuid reference = world_.RecordReference(store_);
  store_.cancel_at = 0.3;
  store_.Queue(reference);
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kUnavailable);
  EXPECT_EQ(store_.Jobs("cancelled")->size(), 1u);
  EXPECT_EQ(store_.attempts[reference].state, AttemptState::kSealed);
  EXPECT_EQ(store_.results.count(reference), 0u);
  EXPECT_LT(store_.progress.back(), 0.7) << "it stopped soon after";
}

TEST_F(WorkerTest, KeepsTheLeaseOfWhatItIsAt) {
  Uuid reference = world_.RecordReference(store_);
  store_.await_beat = true;
  store_.Queue(reference);
  WorkerOptions options = Options();
  options.heartbeat = 1ms;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_TRUE(reports_.seen()[0].second.ok()) << reports_.seen()[0].second.message();
  EXPECT_GT(store_.kept_leases, 0);
  EXPECT_EQ(store_.Jobs("done")->size(), 1u);
}

TEST_F(WorkerTest, ARunWhoseJobAnotherWorkerHasStopsAndChangesNothing) {
  Uuid reference = world_.RecordReference(store_);
  store_.await_beat = store_.take_over = true;
  store_.Queue(reference);
  WorkerOptions options = Options();
  options.heartbeat = 1ms;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kUnavailable);
  EXPECT_EQ(store_.Jobs("running")->size(), 1u) << "the other worker's";
  EXPECT_EQ(store_.results.count(reference), 0u);
}

TEST_F(WorkerTest, NotifyWakesAWorkerThatWouldSleepForAnHour) {
  Uuid reference = world_.RecordReference(store_);
  Worker worker(store_, Options(1h));
  worker.Start();
  store_.Queue(reference);
  worker.Notify();
  ASSERT_TRUE(reports_.WaitFor(1));
  EXPECT_EQ(store_.Jobs("done")->size(), 1u);
}

TEST_F(WorkerTest, AnAttemptsOwnProblemEndsItsJobAtOnce) {
  Uuid attempt = world_.Record(store_);  // no reference
  store_.Queue(attempt);
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(store_.Jobs("done")->size(), 1u);
  EXPECT_EQ(store_.jobs[0].tries, 1u);
  EXPECT_NE(store_.attempts[attempt].problem.find("no reference yet"), std::string::npos);
}

TEST_F(WorkerTest, TroubleWithTheDiskIsTriedAgain) {
  Uuid reference = world_.RecordReference(store_);
  store_.failing_puts = 1;
  store_.Queue(reference);
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kStorage);
  EXPECT_TRUE(reports_.seen()[1].second.ok());
  EXPECT_EQ(store_.jobs[0].tries, 2u);
}

TEST_F(WorkerTest, AnUnknownKindOfJobFailsAndIsNotRunForever) {
  store_.jobs.push_back({Uuid::New(), "polish", Uuid::New(), "queued", 0, ""});
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(3));
  worker.Stop();
  EXPECT_EQ(store_.Jobs("failed")->size(), 1u);
  EXPECT_NE(store_.jobs[0].error.find("polish"), std::string::npos);
}

TEST_F(WorkerTest, ABrokenQueueIsReportedOnceAndSurvived) {
  store_.SetQueueBroken(true);
  Worker worker(store_, Options(1ms));
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  EXPECT_EQ(reports_.seen()[0].second.code(), Code::kStorage);
  store_.Queue(world_.Record(store_));
  store_.SetQueueBroken(false);
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(reports_.seen().size(), 2u);
}

TEST_F(WorkerTest, StopReturnsAnInterruptedJobToTheQueue) {
  Uuid reference = world_.RecordReference(store_);
  store_.Queue(reference);
  // Stopping may win or lose the race against the job; both ends are whole.
  for (int i = 0; i < 2; ++i) {
    Worker worker(store_, Options());
    worker.Start();
    worker.Stop();
    worker.Stop();
  }
  auto queued = store_.Jobs("queued")->size(), done = store_.Jobs("done")->size();
  EXPECT_EQ(queued + done, 1u);
  EXPECT_EQ(store_.results.count(reference), done);
}

TEST_F(WorkerTest, SeveralThreadsShareTheQueue) {
  Uuid reference = world_.RecordReference(store_);
  for (int i = 0; i < 4; ++i) store_.Queue(reference);
  WorkerOptions options = Options();
  options.threads = 2;
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(4));
  worker.Stop();
  EXPECT_EQ(store_.Jobs("done")->size(), 4u);
}

TEST_F(WorkerTest, MakesTimelinesWhenNobodyWaitsForAScore) {
  Uuid reference = world_.RecordReference(store_);
  store_.timelines[reference].waits = true;
  store_.Queue(reference);
  WorkerOptions options = Options();
  options.timelines.emplace(store_);
  Worker worker(store_, options);
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(2));
  worker.Stop();
  EXPECT_EQ(reports_.seen()[0].first.kind, "score");
  EXPECT_EQ(reports_.seen()[1].first.kind, "timeline");
  EXPECT_EQ(reports_.seen()[1].first.attempt, reference);
  EXPECT_TRUE(reports_.seen()[1].second.ok()) << reports_.seen()[1].second.message();
  EXPECT_FALSE(store_.timelines[reference].content.IsZero());
}

TEST_F(WorkerTest, MakesNoTimelinesWhereItWasGivenNone) {
  Uuid reference = world_.RecordReference(store_);
  store_.timelines[reference].waits = true;
  store_.Queue(reference);
  Worker worker(store_, Options());
  worker.Start();
  ASSERT_TRUE(reports_.WaitFor(1));
  worker.Stop();
  EXPECT_EQ(store_.timelines_taken, 0);
}

}  // namespace
}  // namespace enamel::server
