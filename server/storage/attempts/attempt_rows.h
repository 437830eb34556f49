#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/recordings/recording_rows.h"
#include "server/training/types.h"

namespace enamel::server {

struct AttemptFilter {
  std::optional<Uuid> person{};
  std::optional<Uuid> cohort{};     // attempts of its students
  std::optional<Uuid> taught_by{};  // those that this person teaches (Teaches)
  // Without those that this person has yet to mark blind: a list says whose they are.
  std::optional<Uuid> not_to_be_marked_by{};
  std::optional<Uuid> exercise{};
  std::optional<Uuid> assignment{};
  std::optional<AttemptState> state{};
  uint32_t flags = 0;        // with all of these bits of AttemptFlag
  bool open_appeal = false;  // only those with an appeal that nobody has answered
  std::string name{};        // each of its words is part of the person's login or name
  enum class Order : uint8_t { kNewest, kName, kLowestScore };  // without a score: last
  Order order = Order::kNewest;
  std::optional<Uuid> before{};  // page: what comes after this attempt
  // A row has about 1 kB. Lists that a browser asks for are in pages of at most 200 (paging.h).
  static constexpr uint32_t kMaxAtOnce = 20'000;
  uint32_t limit = 50;
};

// Reads attempts. Their recordings: RecordingRows; their scores: ResultRows.
class AttemptRows {
 public:
  explicit AttemptRows(Transactions& rows) : rows_(rows) {}

  Result<AttemptRow> AttemptById(const Uuid& id);
  // True if the person is a member of the attempt's cohort. An assignment to one cohort decides alone: the student may be
  // in several, and instructors of another cohort have no say in that work. Practice, and work for everybody, belongs to
  // every cohort of its student.
  Result<bool> Teaches(const Uuid& person, const Uuid& attempt);
  Result<std::vector<AttemptRow>> Attempts(const AttemptFilter& filter);

 private:
  Transactions& rows_;
};

// Inside a transaction, for other rows.
Result<AttemptRow> FindAttempt(Db& db, const Uuid& id);

}  // namespace enamel::server
