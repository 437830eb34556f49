#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

#include "common/base/result.h"
#include "common/sql/db.h"
#include "server/storage/engine/readers.h"
#include "server/storage/engine/writer.h"

namespace enamel::server {

// How rows are reached: one connection that writes and a pool of connections that read. All rows of
// a store stand on one of these. Thread safety: any thread; calls block.
class Transactions {
 public:
  using OpenDb = std::function<Result<std::unique_ptr<sql::Db>>()>;
  struct Connections {
    std::unique_ptr<sql::Db> writer;
    OpenDb open_reader;
    // Another that writes; none where no other server has its rows in this database.
    OpenDb open_writer{};
    // The highest timeline of a database of several servers (PgDbOptions::newest).
    std::shared_ptr<std::atomic<int64_t>> newest{};
  };
  // At most `readers` connections read. `twice`: as Writer's.
  Transactions(Connections connections, int readers, bool twice = false)
      : open_writer_(std::move(connections.open_writer)),
        newest_(std::move(connections.newest)),
        writer_(std::move(connections.writer), twice),
        readers_(std::move(connections.open_reader), readers) {}

  // `read` is called as Result<T>(Db&) or Status(Db&) on a connection of the pool.
  template <typename F>
  auto Read(const F& read) -> std::invoke_result_t<F, sql::Db&> {
    ENAMEL_ASSIGN_OR_RETURN(auto db, readers_.Take());
    Readers::Lease lease(readers_, std::move(db));
    auto result = read(lease.db());
    if (lease.db().damaged()) reader_found_damage_ = true;
    return result;
  }

  // Commits the changes of `work` if it returns Ok; they are then durable. `work` may be rolled
  // back and run again (writer.h), so it must reset anything it sets outside the database when it
  // starts.
  Status Write(const Writer::Work& work) { return writer_.Run(work); }
  Status Write(const std::function<Status(sql::Db&)>& work) {
    return writer_.Run([&](sql::Db& db, bool&) { return work(db); });
  }
  // For every chunk and every job: `work` first locks (Dialect::row_lock) the attempt or job that
  // it decides on. Servers that work on others do not conflict.
  Status WriteRow(const Writer::Work& work) { return writer_.Run(work, sql::Isolation::kRowLocks); }
  Status WriteRow(const std::function<Status(sql::Db&)>& work) {
    return WriteRow(Writer::Work([&](sql::Db& db, bool&) { return work(db); }));
  }
  // One statement of that kind. With a server, those that wait are sent together.
  Status WriteRow(sql::Change& change) { return writer_.Run(change); }

  Writer& writer() { return writer_; }
  const Writer& writer() const { return writer_; }
  // The engine has found the database damaged.
  bool damaged() const { return reader_found_damage_ || writer_.damaged(); }
  // Whether other servers may have their rows in the same database, and a connection of its own to
  // it for whoever must not wait for the writer. Requires of the second: the first.
  bool shared() const { return open_writer_ != nullptr; }
  Result<std::unique_ptr<sql::Db>> OpenWriter() const { return open_writer_(); }
  // Null: the engine has no timelines.
  const std::shared_ptr<std::atomic<int64_t>>& newest() const { return newest_; }

 private:
  const OpenDb open_writer_;
  const std::shared_ptr<std::atomic<int64_t>> newest_;
  Writer writer_;
  Readers readers_;
  std::atomic<bool> reader_found_damage_{false};
};

}  // namespace enamel::server
