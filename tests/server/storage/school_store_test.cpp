
#include "server/storage/audit/audit_rows.h"
#include "server/storage/people/school_list.h"
#include "tests/server/storage/backends.h"
#include "tests/server/storage/store_world.h"

// The schools of an installation, the same for every backend.
namespace enamel::server {
namespace {

using namespace testing;

class SchoolStoreTest : public StoreSuite {
 protected:
  static SchoolRow Row(const std::string& name, const std::vector<std::string>& hosts) {
    SchoolRow row;
    row.name = name;
    row.id = Uuid::New();
    row.hosts = hosts;
    return row;
  }
  std::vector<std::string> Names() {
    std::vector<std::string> out;
    const auto rows = store_->schools.Schools();
    for (const SchoolRow& row : *rows) out.push_back(row.name);
    return out;
  }
  size_t AuditRows(const std::string& action) {
    AuditFilter filter;
    filter.action = action;
    filter.limit = 10;
    return store_->audit.FindAudit(filter)->size();
  }
};
INSTANTIATE_TEST_SUITE_P(Backends, SchoolStoreTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(SchoolStoreTest, ASchoolIsAddedChangedSuspendedAndRemoved) {
  EXPECT_TRUE(store_->schools.Schools()->empty());
  SchoolRow south = Row("south", {"south.example.edu", "s.example.edu"});
  ASSERT_TRUE(store_->schools.AddSchool(south, kSystem).ok());
  ASSERT_TRUE(store_->schools.AddSchool(Row("north", {"north.example.edu"}), kSystem).ok());
  EXPECT_EQ(Names(), (std::vector<std::string>{"north", "south"}));
  const SchoolRow kept = store_->schools.Schools()->at(1);
  EXPECT_EQ(kept.id, south.id);
  EXPECT_EQ(kept.hosts, south.hosts);
  EXPECT_EQ(kept.state, SchoolState::kServed);
  EXPECT_GT(kept.created_ms, 0);

  EXPECT_EQ(store_->schools.RemoveSchool("south", kSystem).code(), Code::kConflict)
      << "it is served";
  south.hosts = {"south.example.edu"};
  south.state = SchoolState::kSuspended;
  ASSERT_TRUE(store_->schools.ChangeSchool(south, kSystem).ok());
  EXPECT_EQ(store_->schools.Schools()->at(1).state, SchoolState::kSuspended);
  EXPECT_TRUE(store_->schools.AddSchool(Row("s", {"s.example.edu"}), kSystem).ok())
      << "the host name has become free";
  EXPECT_EQ(store_->schools.RemoveSchool("south", kSystem).code(), Code::kConflict)
      << "its data is there";
  south.state = SchoolState::kBeingDeleted;
  ASSERT_TRUE(store_->schools.ChangeSchool(south, kSystem).ok());
  south.state = SchoolState::kServed;
  EXPECT_EQ(store_->schools.ChangeSchool(south, kSystem).code(), Code::kConflict)
      << "it may be half gone";
  ASSERT_TRUE(store_->schools.RemoveSchool("south", kSystem).ok());
  EXPECT_EQ(Names(), (std::vector<std::string>{"north", "s"}));
  EXPECT_EQ(store_->schools.RemoveSchool("south", kSystem).code(), Code::kNotFound);
  EXPECT_EQ(store_->schools.ChangeSchool(south, kSystem).code(), Code::kNotFound);
  EXPECT_EQ(AuditRows("school.add"), 3u);
  EXPECT_EQ(AuditRows("school.change"), 2u);
  EXPECT_EQ(AuditRows("school.remove"), 1u);
}

TEST_P(SchoolStoreTest, NamesAndHostNamesAreOneSchoolsAndWellFormed) {
  ASSERT_TRUE(store_->schools.AddSchool(Row("north", {"north.example.edu"}), kSystem).ok());
  EXPECT_EQ(store_->schools.AddSchool(Row("north", {"other.example.edu"}), kSystem).code(),
            Code::kConflict);
  const Status taken =
      store_->schools.AddSchool(Row("east", {"east.edu", "north.example.edu"}), kSystem);
  EXPECT_EQ(taken.code(), Code::kConflict);
  EXPECT_EQ(taken.field(), "hosts");
  for (const char* name : {"", "North", "1st", "-a", "a/b", "..", "a b", "a\"b", "ä"}) {
    EXPECT_EQ(store_->schools.AddSchool(Row(name, {"x.edu"}), kSystem).code(), Code::kInvalidInput)
        << name;
  }
  EXPECT_EQ(store_->schools.AddSchool(Row(std::string(33, 'a'), {"x.edu"}), kSystem).code(),
            Code::kInvalidInput);
  for (const char* host : {"", "X.edu", "x.edu:80", "x y", "x_y", "[::1]", ".", "..", "-", "a..b",
                           "x.edu.", "-a.edu", "a-.edu"}) {
    EXPECT_EQ(store_->schools.AddSchool(Row("a", {host}), kSystem).code(), Code::kInvalidInput)
        << host;
  }
  EXPECT_EQ(store_->schools.AddSchool(Row("a", {}), kSystem).code(), Code::kInvalidInput);
  EXPECT_EQ(Names(), std::vector<std::string>{"north"});
  EXPECT_TRUE(store_->schools.AddSchool(Row(std::string(32, 'a'), {"x.edu"}), kSystem).ok());
}

TEST_P(SchoolStoreTest, OneThatIsBeingMadeIsServedOrDeleted) {
  SchoolRow row = Row("north", {"north.example.edu"});
  row.state = SchoolState::kBeingMade;
  ASSERT_TRUE(store_->schools.AddSchool(row, kSystem).ok());
  EXPECT_EQ(store_->schools.Schools()->at(0).state, SchoolState::kBeingMade);
  row.state = SchoolState::kSuspended;
  EXPECT_EQ(store_->schools.ChangeSchool(row, kSystem).code(), Code::kConflict);
  row.state = SchoolState::kServed;
  ASSERT_TRUE(store_->schools.ChangeSchool(row, kSystem).ok());
  row.state = SchoolState::kBeingDeleted;
  EXPECT_EQ(store_->schools.ChangeSchool(row, kSystem).code(), Code::kConflict)
      << "suspended first";
}

TEST_P(SchoolStoreTest, AnEnrolmentCodeIsKnownWhereItWasGivenOut) {
  const Sha256 code = HashSha256(AsBytes("a code"));
  EXPECT_FALSE(*store_->stations.IsEnrolCode(code));
  ASSERT_TRUE(store_->stations.AddEnrolCode(code, enamel::UnixMs() + 60'000, kSystem).ok());
  EXPECT_TRUE(*store_->stations.IsEnrolCode(code));
}

}  // namespace
}  // namespace enamel::server
