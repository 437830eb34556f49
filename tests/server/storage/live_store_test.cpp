#include "tests/server/storage/backends.h"
#include "tests/server/storage/store_world.h"

// Remarks on their way to chairs, and which stations are connected, the same for every backend.
namespace enamel::server {
namespace {

using namespace testing;

class LiveStoreTest : public StoreSuite {
 protected:
  // A remark to the chair of `attempt`; gives what its station knows it by.
  uint64_t Say(World& world, const Uuid& attempt, const std::string& text, bool to_chair = true) {
    if (author_.person == Uuid())
      author_ = {AddPerson(world.store, "ada", Role::kInstructor), "test"};
    AnnotationRow row;
    row.attempt = attempt;
    row.tick = 7;
    row.text = text;
    row.to_chair = to_chair;
    auto kept = world.store.remarks.AddAnnotation(row, author_);
    EXPECT_TRUE(kept.ok()) << kept.status().message();
    return kept.ok() ? kept->remark_id : 0;
  }
  std::vector<ChairRemark> Remarks(UnixMs since_ms = 0) {
    auto all = store_->live.ChairRemarks(since_ms);
    EXPECT_TRUE(all.ok()) << all.status().message();
    return all.ok() ? *all : std::vector<ChairRemark>();
  }

  Actor author_;
};
INSTANTIATE_TEST_SUITE_P(Backends, LiveStoreTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(LiveStoreTest, WhatIsSaidAtAChairWaitsForItsStation) {
  World world(*store_);
  const Uuid attempt = world.OpenedAttempt(), other = world.OpenedAttempt();
  const uint64_t first = Say(world, attempt, "stop"), second = Say(world, attempt, "go on");
  EXPECT_GT(first, 0u);
  EXPECT_GT(second, first) << "also within the same millisecond";
  EXPECT_EQ(Say(world, attempt, "not at the chair", false), 0u);
  (void)Say(world, other, "elsewhere");
  std::vector<ChairRemark> all = Remarks();
  ASSERT_EQ(all.size(), 3u);
  std::erase_if(all, [&](const ChairRemark& remark) { return remark.attempt != attempt; });
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].id, first);
  EXPECT_EQ(all[0].text, "stop");
  EXPECT_EQ(all[0].from, "Name of ada");
  EXPECT_EQ(all[0].tick, 7u);
  EXPECT_EQ(all[0].state, RemarkState::kWaiting);
  EXPECT_EQ(all[1].id, second);
  EXPECT_TRUE(Remarks(all[1].sent_ms + 1000).empty());
}

TEST_P(LiveStoreTest, HowFarARemarkHasComeIsKeptAndNeverGoesBack) {
  World world(*store_);
  const Uuid attempt = world.OpenedAttempt();
  (void)Say(world, attempt, "one");
  (void)Say(world, attempt, "two");
  std::vector<ChairRemark> all = Remarks();
  all[0].state = RemarkState::kShown;
  all[0].shown_ms = 77;
  all[1].state = RemarkState::kSent;
  ASSERT_TRUE(store_->live.MoveRemarks(all).ok());
  ChairRemark late = all[0];
  late.state = RemarkState::kSent;
  late.shown_ms = 0;
  ASSERT_TRUE(store_->live.MoveRemarks({late}).ok());
  Reopen();
  const std::vector<ChairRemark> kept = Remarks();
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].state, RemarkState::kShown);
  EXPECT_EQ(kept[0].shown_ms, 77);
  EXPECT_EQ(kept[1].state, RemarkState::kSent);
}

TEST_P(LiveStoreTest, ARemarkGoesWithItsAttemptAndWhenItIsDeleted) {
  World world(*store_);
  const Uuid attempt = world.OpenedAttempt(), deleted_from = world.OpenedAttempt();
  const auto chunks = world.Append(attempt, 1);
  (void)Say(world, attempt, "stop");
  const uint64_t before = Say(world, deleted_from, "a mistake");
  auto mistake = store_->remarks.AnnotationsOf(deleted_from);
  ASSERT_TRUE(store_->remarks.DeleteAnnotation(mistake->at(0).id, 1, author_).ok());
  ChairRemark gone;
  gone.attempt = deleted_from;
  gone.id = before;
  gone.state = RemarkState::kShown;
  EXPECT_TRUE(store_->live.MoveRemarks({gone}).ok());
  (void)Say(world, deleted_from, "the next");
  EXPECT_EQ(Remarks().size(), 2u);
  ASSERT_TRUE(store_->seals.SealAttempt(World::SealOf(chunks), 200).ok());
  ASSERT_EQ(Remarks().size(), 1u) << "sealed: nobody is at the chair any more";
  EXPECT_EQ(store_->remarks.AnnotationsOf(attempt)->at(0).text, "stop");
}

TEST_P(LiveStoreTest, OwnStationsAreNotElsewhere) {
  const Uuid station = Uuid::New();
  EXPECT_EQ(store_->live.KeepLinks({{station, true}}, {}, /*anew=*/false).code(), Code::kNotFound)
      << "this server has not said that it runs";
  ASSERT_TRUE(store_->live.KeepLinks({{station, true}}, {}, /*anew=*/true).ok());
  ASSERT_TRUE(store_->live.KeepLinks({{station, false}}, {}, false).ok());
  ASSERT_TRUE(store_->live.KeepLinks({}, {station, Uuid::New()}, false).ok());
  EXPECT_TRUE(store_->live.LinksElsewhere()->empty());
}

}  // namespace
}  // namespace enamel::server
