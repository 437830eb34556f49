#include "tests/server/storage/backends.h"

namespace enamel::server::testing {
namespace {

class SqlitePlace final : public Place {
 public:
  std::unique_ptr<Store> Open() override { return OpenStore(folder_.path()); }

 private:
  TempFolder folder_;
};

// The same, all files through the seams that the power-cut test uses.
class SqliteOnSimulatedDisk final : public Place {
 public:
  std::unique_ptr<Store> Open() override {
    SqliteOptions options;
    options.folder = folder_.path();
    options.vfs = disk_.vfs();
    options.disk = &disk_;
    auto store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }

 private:
  TempFolder folder_;
  SimulatedDisk disk_{folder_.path()};
};

// Every change made twice: what it says and leaves is of the second time alone.
class SqliteTwice final : public Place {
 public:
  std::unique_ptr<Store> Open() override {
    SqliteOptions options;
    options.folder = folder_.path();
    options.change_twice = true;
    auto store = OpenSqliteStore(options);
    EXPECT_TRUE(store.ok()) << store.status().message();
    return std::move(store).value();
  }

 private:
  TempFolder folder_;
};

}  // namespace

const std::vector<Backend>& Backends() {
  static const std::vector<Backend> kBackends = {
      {"Sqlite", [] { return std::make_unique<SqlitePlace>(); }},
      {"SqliteOnSimulatedDisk", [] { return std::make_unique<SqliteOnSimulatedDisk>(); }},
      {"SqliteTwice", [] { return std::make_unique<SqliteTwice>(); }},
  };
  return kBackends;
}

}  // namespace enamel::server::testing
