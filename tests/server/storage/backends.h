#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/storage/simulated_disk.h"
#include "tests/server/storage/store_world.h"

// The conformance suite (conformance, ingest, personal_data, retention tests) runs once for each of
// these. A new backend adds itself to Backends() in backends.cpp and has to pass all of it.
namespace enamel::server::testing {

// One store's place, empty at first and gone with this. Open gives the same data again.
class Place {
 public:
  virtual ~Place() = default;
  virtual Result<std::unique_ptr<Store>> Try() = 0;
  std::unique_ptr<Store> Open() {
    auto store = Try();
    EXPECT_TRUE(store.ok()) << store.status().message();
    return store.ok() ? std::move(store).value() : nullptr;
  }
  // To the rows themselves, past the store.
  virtual std::unique_ptr<sql::Db> Connect() const = 0;
  virtual const std::vector<sql::Migration>& migrations() const = 0;
  // Compares the stored rows with their audit trail: no action of a store may look like an edit.
  virtual void ExpectTrailAgrees() const = 0;
};

struct Backend {
  const char* name;
  std::function<std::unique_ptr<Place>()> make;
};
const std::vector<Backend>& Backends();

// `store_` is open on an empty place; Reopen closes it and opens it again. What every test leaves
// is compared with its audit trail.
class StoreSuite : public ::testing::TestWithParam<Backend> {
 protected:
  void Reopen() {
    store_.reset();
    store_ = place_->Open();
  }
  void TearDown() override { place_->ExpectTrailAgrees(); }

  std::unique_ptr<Place> place_ = GetParam().make();
  std::unique_ptr<Store> store_ = place_->Open();
};

inline std::string BackendName(const ::testing::TestParamInfo<Backend>& info) {
  return info.param.name;
}

}  // namespace enamel::server::testing
