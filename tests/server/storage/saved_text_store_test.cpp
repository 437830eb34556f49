#include <gtest/gtest.h>

#include "server/storage/people/saved_text_rows.h"
#include "server/training/revision.h"
#include "tests/server/storage/backends.h"

// What every backend of Store must do with texts that are saved for remarks.
namespace enamel::server {
namespace {

using namespace testing;

class SavedTextTest : public StoreSuite {
 protected:
  SavedTextTest() {
    ada_ = {AddPerson(*store_, "ada", Role::kInstructor), "page"};
    ben_ = {AddPerson(*store_, "ben", Role::kInstructor), "page"};
  }
  Result<SavedText> Save(const Actor& by, const std::string& text, bool shared = false) {
    SavedText row;
    row.text = text;
    row.shared = shared;
    return store_->saved_texts.AddSavedText(row, by);
  }
  std::vector<std::string> SeenBy(const Actor& who) {
    std::vector<std::string> out;
    for (const SavedText& row : *store_->saved_texts.SavedTexts(who.person)) {
      out.push_back(row.text);
    }
    return out;
  }

  Actor ada_, ben_;
};

TEST_P(SavedTextTest, OwnAndSharedOnesAreListedNewestFirst) {
  ASSERT_TRUE(Save(ada_, "too deep").ok());
  const SavedText shared = *Save(ben_, "wall leans", true);
  ASSERT_TRUE(Save(ben_, "private").ok());
  Reopen();
  EXPECT_EQ(SeenBy(ada_), (std::vector<std::string>{"wall leans", "too deep"}));
  EXPECT_EQ(SeenBy(ben_), (std::vector<std::string>{"private", "wall leans"}));
  EXPECT_EQ(store_->saved_texts.SavedTexts(ada_.person)->front().owner_name, "Name of ben");
  SavedText kept = shared;
  kept.shared = false;
  ASSERT_TRUE(store_->saved_texts.ReplaceSavedText(kept, ben_).ok());
  EXPECT_EQ(SeenBy(ada_), std::vector<std::string>{"too deep"});
}

TEST_P(SavedTextTest, AreChangedByRevisionAndSavedOnce) {
  SavedText row = *Save(ada_, "too deep");
  EXPECT_EQ(Save(ada_, "too deep").status().field(), "text");
  EXPECT_TRUE(Save(ben_, "too deep").ok()) << "another's";
  row.text = "much too deep";
  row.shared = true;
  const SavedText changed = *store_->saved_texts.ReplaceSavedText(row, ada_);
  EXPECT_EQ(changed.text, row.text);
  EXPECT_TRUE(changed.shared);
  EXPECT_EQ(changed.owner, ada_.person);
  EXPECT_EQ(store_->saved_texts.ReplaceSavedText(row, ada_).status().field(), kStale);
  EXPECT_EQ(store_->saved_texts.DeleteSavedText(row.id, row.revision, ada_).field(), kStale);
  ASSERT_TRUE(store_->saved_texts.DeleteSavedText(row.id, changed.revision, ada_).ok());
  EXPECT_EQ(store_->saved_texts.SavedTextById(row.id).status().code(), Code::kNotFound);
  const AuditRow told = store_->audit.Audit(1)->front();
  EXPECT_EQ(told.action, "person.text_remove");
  EXPECT_EQ(told.object, ada_.person.Text());
}

TEST_P(SavedTextTest, NoMoreAreTakenThanSomebodyLooksThrough) {
  for (int64_t i = 0; i < SavedTextRows::kMaxOwn; ++i) {
    ASSERT_TRUE(Save(ada_, std::to_string(i)).ok());
  }
  const Status full = Save(ada_, "one more").status();
  EXPECT_EQ(full.code(), Code::kConflict);
  EXPECT_NE(full.message().find("Remove one"), std::string::npos) << full.message();
  SavedText changed = store_->saved_texts.SavedTexts(ada_.person)->front();
  changed.text = "in place of one";
  EXPECT_TRUE(store_->saved_texts.ReplaceSavedText(changed, ada_).ok());
}

TEST_P(SavedTextTest, NoMoreAreSharedThanEverybodyIsShown) {
  for (int64_t i = 0; i < SavedTextRows::kMaxShared; ++i) {
    if (i % SavedTextRows::kMaxOwn == 0) {
      ada_.person = AddPerson(*store_, "teacher" + std::to_string(i), Role::kInstructor);
    }
    ASSERT_TRUE(Save(ada_, std::to_string(i), true).ok());
  }
  EXPECT_EQ(Save(ben_, "for all", true).status().field(), "shared");
  const SavedText own = *Save(ben_, "for all");
  SavedText offered = own;
  offered.shared = true;
  EXPECT_EQ(store_->saved_texts.ReplaceSavedText(offered, ben_).status().field(), "shared");
}

INSTANTIATE_TEST_SUITE_P(Backends, SavedTextTest, ::testing::ValuesIn(Backends()), BackendName);

}  // namespace
}  // namespace enamel::server
