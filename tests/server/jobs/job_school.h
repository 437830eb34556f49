#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/scoring/score.h"
#include "server/storage/open_store.h"
#include "tests/server/jobs/recorded_attempt.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/support/temp_folder.h"

namespace enamel::test {

// A school in a temporary folder, with the exercise of a World, for tests that score and play back.
// Thread safety: as the store's, once a test has arranged it.
class JobSchool {
 public:
  // Without a reference. `fail_next`: StoreOptions.
  explicit JobSchool(const World& world = World::Get(), std::function<bool()> fail_next = {});
  // Of World::Get(), with a scored reference along the default path and an empty queue.
  static std::unique_ptr<JobSchool> WithReference();

  // Records an attempt, which is then sealed and waits for its score.
  Uuid Record(const PathOptions& path = {}, bool as_reference = false);
  // One that is scored, and others are compared with from now on.
  Uuid RecordReference(const PathOptions& path = {});

  server::AttemptRow Row(const Uuid& attempt);
  server::AttemptResult Result(const Uuid& attempt);
  scoring::ScoreResult Score(const Uuid& attempt);
  Bytes Blob(const Sha256& content);
  Recording RecordingOf(const Uuid& attempt);
  std::optional<server::NearAttempt> Near(const Uuid& attempt);

  // What the store itself would refuse, as a damaged disk or a hostile hand leaves it.
  void Spoil(const Uuid& attempt, const std::function<void(Recording&)>& change);
  void SetScore(const Uuid& attempt, const scoring::ScoreResult& score);
  // "column = value, …" of the attempt's row.
  void Set(const Uuid& attempt, const std::string& columns);
  void Exec(const std::string& sql);
  static std::string Sql(const Sha256& hash) { return "X'" + hash.Hex() + "'"; }
  static std::string Sql(const Uuid& id);

  TempFolder folder;
  server::testing::FailingDisk disk;
  std::unique_ptr<server::Store> store;
  Uuid person, station, exercise, reference;

 private:
  struct Kept;  // a school that is copied
  explicit JobSchool(const Kept& from);
  void Open(std::function<bool()> fail_next);

  const World& world_;
  int64_t now_ms_ = 1'000'000;
};

}  // namespace enamel::test
