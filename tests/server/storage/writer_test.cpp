#include "server/storage/engine/writer.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <optional>
#include <semaphore>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/storage/engine/query.h"
#include "tests/support/temp_folder.h"

// What becomes of works that are committed together.
namespace enamel::server {
namespace {

class WriterTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto db = OpenDatabase(folder_.path() / "enamel.db", DbMode::kCreate);
    ASSERT_TRUE(db.ok()) << db.status().message();
    ASSERT_TRUE((*db)->Exec("CREATE TABLE t (n INTEGER PRIMARY KEY)").ok());
    writer_.emplace(std::move(db).value());
  }

  static Status Insert(Db& db, int64_t n) {
    Query q(db, "INSERT INTO t VALUES (?2)");  // ?1 is every statement's tenant
    return q.Bind(n).Run();
  }
  std::vector<int64_t> Rows() {
    std::vector<int64_t> out;
    EXPECT_TRUE(writer_
                    ->RunAlone([&](Db& db) -> Status {
                      sql::Query q(db, "SELECT n FROM t ORDER BY n");
                      while (q.Next()) out.push_back(q.Int(0));
                      return q.status();
                    })
                    .ok());
    return out;
  }
  // All of them wait for the thread at the same moment, in this order.
  std::vector<Status> RunTogether(const std::vector<Writer::Work>& works,
                                  const std::vector<sql::Change*>& changes = {}) {
    std::binary_semaphore begun(0), go_on(0);
    std::jthread first([&] {
      EXPECT_TRUE(writer_
                      ->RunAlone([&](Db&) {
                        begun.release();
                        go_on.acquire();
                        return Status::Ok();
                      })
                      .ok());
    });
    begun.acquire();
    std::vector<Status> out(works.size() + changes.size());
    std::vector<std::jthread> callers;
    for (size_t i = 0; i < out.size(); ++i) {
      callers.emplace_back([&, i] {
        out[i] = i < works.size()
                     ? writer_->Run(works[i], changes.empty() ? sql::Isolation::kSerial
                                                              : sql::Isolation::kRowLocks)
                     : writer_->Run(*changes[i - works.size()]);
      });
      while (writer_->queued() <= i) std::this_thread::yield();
    }
    go_on.release();
    callers.clear();
    return out;
  }

  test::TempFolder folder_;
  std::optional<Writer> writer_;
};

TEST_F(WriterTest, WorksThatSucceedRunOnceAndShareACommit) {
  std::array<std::atomic<int>, 3> runs{};
  std::vector<Writer::Work> works;
  for (size_t i = 0; i < runs.size(); ++i) {
    works.emplace_back([&runs, i](Db& db, bool&) {
      ++runs[i];
      return Insert(db, static_cast<int64_t>(i));
    });
  }
  for (const Status& status : RunTogether(works)) EXPECT_TRUE(status.ok()) << status.message();
  for (const auto& count : runs) EXPECT_EQ(count, 1);
  EXPECT_EQ(Rows(), (std::vector<int64_t>{0, 1, 2}));
  EXPECT_EQ(writer_->counters().commits, 1u);
}

TEST_F(WriterTest, AWorkThatFailsIsTakenBackAloneAndOneThatKeepsItsRefusalIsNot) {
  const std::vector<Writer::Work> works{
      [](Db& db, bool&) { return Insert(db, 1); },
      [](Db& db, bool&) {
        EXPECT_TRUE(Insert(db, 2).ok());
        return Status(Code::kConflict, "changed its mind");
      },
      [](Db& db, bool& keep_anyway) {
        keep_anyway = true;
        EXPECT_TRUE(Insert(db, 3).ok());
        return Status(Code::kConflict, "refused, and noted");
      },
      [](Db& db, bool&) { return Insert(db, 1); },  // there already
      [](Db& db, bool&) { return Insert(db, 4); }};
  const auto out = RunTogether(works);
  EXPECT_TRUE(out[0].ok());
  EXPECT_EQ(out[1].message(), "changed its mind");
  EXPECT_EQ(out[2].message(), "refused, and noted");
  EXPECT_FALSE(out[3].ok());
  EXPECT_TRUE(out[4].ok());
  EXPECT_EQ(Rows(), (std::vector<int64_t>{1, 3, 4}));
}

// Statements alone go last in a batch, and as the works do where one of them fails.
TEST_F(WriterTest, StatementsAndWorksShareACommitAndFailAlone) {
  const auto insert = [](int64_t n) {
    return sql::Change{"INSERT INTO t VALUES (?1)", [n](sql::Query& q) { q.BindInt(n); }};
  };
  for (const bool one_fails : {false, true}) {
    const int64_t from = one_fails ? 10 : 0;
    sql::Change first = insert(from + 1), second = insert(one_fails ? 1 : 2);
    const auto before = writer_->counters();
    const auto out =
        RunTogether({[&](Db& db, bool&) { return Insert(db, from + 3); }}, {&first, &second});
    EXPECT_TRUE(out[0].ok());
    EXPECT_TRUE(out[1].ok());
    EXPECT_EQ(first.rows, 1);
    EXPECT_EQ(out[2].ok(), !one_fails);
    EXPECT_EQ(second.rows, one_fails ? 0 : 1);
    // Works that run apart are counted once, as their batch.
    EXPECT_EQ(writer_->counters().commits, before.commits + 1);
  }
  EXPECT_EQ(Rows(), (std::vector<int64_t>{1, 2, 3, 11, 13}));
  sql::Change alone = insert(11);
  EXPECT_FALSE(writer_->Run(alone).ok()) << "it is there already";
  EXPECT_EQ(alone.rows, 0);
}

TEST_F(WriterTest, AWorkThatFailsByItselfLeavesNothing) {
  int runs = 0;
  const Status status = writer_->Run([&](Db& db, bool&) {
    ++runs;
    EXPECT_TRUE(Insert(db, 1).ok());
    return Status(Code::kNotFound, "nothing there");
  });
  EXPECT_EQ(status.code(), Code::kNotFound);
  EXPECT_EQ(runs, 1);
  EXPECT_TRUE(Rows().empty());
  EXPECT_TRUE(writer_->Run([](Db& db, bool&) { return Insert(db, 2); }).ok());
  EXPECT_EQ(Rows(), (std::vector<int64_t>{2}));
}

TEST_F(WriterTest, AWorkThatWaitsTooLongIsRefusedAndLeavesNothing) {
  auto db = OpenDatabase(folder_.path() / "enamel.db", DbMode::kCreate);
  ASSERT_TRUE(db.ok());
  Writer writer(std::move(db).value(), false, std::chrono::milliseconds(5));
  std::binary_semaphore begun(0), go_on(0);
  const Writer::Work slow = [&](Db& at, bool&) {
    begun.release();
    go_on.acquire();
    return Insert(at, 1);
  };
  // On a busy machine the writer's thread may be late by more than those 5 ms: what it has not begun
  // is refused, and asked again.
  const auto until_begun = [](const auto& run) {
    Status status;
    do {
      status = run();
    } while (status.code() == Code::kUnavailable);
    EXPECT_TRUE(status.ok()) << status.message();
  };
  std::jthread first([&] { until_begun([&] { return writer.Run(slow); }); });
  begun.acquire();
  EXPECT_GT(writer.oldest_wait(), std::chrono::nanoseconds(0));
  const Status refused = writer.Run([&](Db& at, bool&) { return Insert(at, 2); });
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  go_on.release();
  first.join();
  EXPECT_EQ(Rows(), std::vector<int64_t>{1});
  EXPECT_EQ(writer.oldest_wait(), std::chrono::nanoseconds(0));
  // A work behind what runs alone is not refused, however long that takes.
  const std::function<Status(Db&)> alone = [&](Db&) {
    begun.release();
    go_on.acquire();
    return Status::Ok();
  };
  std::jthread second([&] { until_begun([&] { return writer.RunAlone(alone); }); });
  begun.acquire();
  std::atomic<bool> answered{false};
  std::jthread third([&] {
    (void)writer.Run([&](Db& at, bool&) { return Insert(at, 3); });
    answered = true;
  });
  while (writer.oldest_wait() < std::chrono::milliseconds(50)) std::this_thread::yield();
  EXPECT_FALSE(answered);
  go_on.release();
}

}  // namespace
}  // namespace enamel::server
