#pragma once

#include <functional>

#include "common/base/result.h"
#include "common/sql/db.h"

namespace enamel::server::sqlite {

// How a part of the store that has rows of its own reaches them. Each runs its argument, and `write` may
// run it again: in a transaction that is kept when both are done, and on a connection that reads.
struct Transactions {
  using Run = std::function<Status(const std::function<Status(sql::Db&)>&)>;
  Run read, write;
};

}  // namespace enamel::server::sqlite
