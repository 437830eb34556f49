#include "station/desk/exercise_list.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "station/desk/pages.h"
#include "tests/station/desk/english.h"
#include "tests/station/render/virtual_display.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

constexpr int64_t kDay_ms = int64_t{24} * 60 * 60 * 1000, kToday = 1000 * kDay_ms;

Catalogue::Exercise Exercise(const std::string& title, int tooth, bool graded) {
  Catalogue::Exercise out;
  out.title = title;
  out.facts = Catalogue::Facts{tooth, "occlusal_centre", false, false, graded};
  return out;
}

TEST(ExerciseListTest, EachExerciseIsInOneGroup) {
  Catalogue::Exercise e = Exercise("Class I", 46, true);
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kGraded);
  e.facts->graded = false;
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kPractice);
  e.exam = true;
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kGraded);
  e.due_unix_ms = kToday + 8 * kDay_ms;
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kGraded) << "more than a week away";
  for (const int64_t days : {7, 1, -1}) {
    e.due_unix_ms = kToday + days * kDay_ms;
    EXPECT_EQ(GroupOf(e, kToday), ListGroup::kDue) << days;
  }
  e.refusal = Status(Code::kForbidden, "it was due", "due");
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kGraded) << "nothing is to be done about it";
  e.attempt_limit = 2;
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kDone);
  e.attempts_left = 1;
  e.refusal = {};
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kDue);
  e = {};
  EXPECT_EQ(GroupOf(e, kToday), ListGroup::kGraded) << "of which nothing is known";
}

TEST(ExerciseListTest, SearchFindsPartsOfWordsInAnyOrder) {
  const std::array<std::string, 2> texts = {"Kronenpr\u00e4paration", "Tooth 46, occlusal"};
  for (const char* typed : {"", "kron", "46", "46 KRONE", "occl PR\u00c4P", " 46 "}) {
    EXPECT_TRUE(Matches(typed, texts)) << typed;
  }
  for (const char* typed : {"47", "46 veneer", "krone46", "parationtooth"}) {
    EXPECT_FALSE(Matches(typed, texts)) << typed;
  }
}

TEST(ExerciseListTest, ListsAGroupThatMatchesDueFirst) {
  std::vector<Catalogue::Exercise> all = {Exercise("Class I", 46, true),
                                          Exercise("Class II", 36, false),
                                          Exercise("Crown", 46, true), Exercise("Crown", 26, true)};
  all[0].due_unix_ms = kToday + 3 * kDay_ms;
  all[2].due_unix_ms = kToday + kDay_ms;
  const auto listed = [&](ListGroup group, const char* typed) {
    return Listed(kEnglish, all, group, typed, kToday);
  };
  EXPECT_EQ(listed(ListGroup::kDue, ""), (std::vector<size_t>{2, 0}));
  EXPECT_EQ(listed(ListGroup::kDue, "46 class"), (std::vector<size_t>{0}));
  EXPECT_EQ(listed(ListGroup::kGraded, "crown"), (std::vector<size_t>{3}));
  EXPECT_EQ(listed(ListGroup::kPractice, ""), (std::vector<size_t>{1}));
  EXPECT_TRUE(listed(ListGroup::kDone, "").empty());
}

// The window's pages without an attempt, at the sizes and in the languages that crowd them most.
struct Look {
  int width_px, height_px;
  language::Language language;
};

class PagesTest : public testing::TestWithParam<Look> {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    screen_.emplace(render::ScreenOptions{
        .width_px = GetParam().width_px, .height_px = GetParam().height_px, .visible = false});
    server_.emplace(folder_.path());
    ASSERT_TRUE(SaveCredentials(folder_.path() / "data", server_->NewStation()).ok());
    workplace_ = std::move(*Workplace::Open({.data = folder_.path() / "data"}));
    WorkflowOptions options;
    options.language = GetParam().language;
    flow_.emplace(*workplace_, options);
    ui_.emplace(*screen_);
    pages_.emplace(*ui_, *flow_, "Chair 7");
  }
  // Draws until the window has taken its input and waits for nothing, and two frames more.
  void Play() {
    for (int more = 3; more > 0;) {
      if (!screen_->injecting() && !flow_->busy()) --more;
      (void)screen_->Begin();
      flow_->Tick(Workflow::Clock::now(), true);
      (void)pages_->Draw();
      screen_->End();
    }
  }
  void Type(const std::string& text) {
    for (const char c : text) screen_->Inject(render::InputEvent::Character(c));
    Play();
  }
  void Press(int key) {
    screen_->Inject({render::InputEvent::Key(key, true), render::InputEvent::Key(key, false)});
    Play();
  }
  void SignIn() {
    flow_->SignIn("ada", "secret");
    Play();
  }
  std::string Say(const char* key) { return flow_->words().Say(key); }
  // Whether this choice is in the window, whole.
  bool IsSeen(const std::string& label) {
    for (const Choice& choice : ui_->choices()) {
      if (choice.label != label || !choice.visible) continue;
      return choice.at.x0 >= 0 && choice.at.y0 >= 0 && choice.at.x1 <= screen_->width() &&
             choice.at.y1 <= screen_->height();
    }
    return false;
  }
  // Writes a picture for people to look at.
  void Picture(const std::string& name) {
    const char* folder = ::getenv("ENAMEL_PICTURES");
    if (folder == nullptr) return;
    const std::string file = name + "-" + std::to_string(GetParam().width_px) + "-" +
                             std::string(language::CodeOf(GetParam().language)) + ".png";
    EXPECT_TRUE(screen_->WriteScreenshot((std::filesystem::path(folder) / file).string()).ok());
  }

  render::VirtualDisplay display_;
  std::optional<render::Screen> screen_;
  test::TempFolder folder_;
  std::optional<FakeServer> server_;
  std::unique_ptr<Workplace> workplace_;
  std::optional<Ui> ui_;
  std::optional<Workflow> flow_;
  std::optional<Pages> pages_;
};

TEST_P(PagesTest, FirstPasswordIsTypedTwiceAndItsButtonsAreSeen) {
  server_->must_change_password = true;
  SignIn();
  EXPECT_EQ(ui_->page(), "first-password");
  Type("kettle orbit plum fence");
  Press(render::kKeyEnter);
  Type("kettle orbit");
  Press(render::kKeyEnter);
  EXPECT_EQ(flow_->problem(), Say("first_password.different"));
  EXPECT_TRUE(IsSeen(Say("first_password.set")));
  EXPECT_TRUE(IsSeen(Say("exercise.back")));
  Picture("first-password");
  // And the fields are empty again.
  Type("kettle orbit plum fence");
  Press(render::kKeyEnter);
  Type("kettle orbit plum fence");
  Press(render::kKeyEnter);
  EXPECT_EQ(ui_->page(), "exercises") << flow_->problem();
}

TEST_P(PagesTest, LongListIsSearchedByTypingAndEscShowsAllAgain) {
  server_->assignments.resize(kLongList + 11);
  for (Uuid& assignment : server_->assignments) assignment = Uuid::New();
  SignIn();
  EXPECT_NE(ui_->words().find(Say("list.graded")), std::string::npos);
  EXPECT_TRUE(IsSeen("Exercise 1"));
  EXPECT_TRUE(IsSeen(Say("exercises.sign_out")));
  Picture("long-list");
  Type("20");
  EXPECT_TRUE(IsSeen("Exercise 20"));
  EXPECT_EQ(ui_->words().find("Exercise 1 "), std::string::npos) << ui_->words();
  Picture("searched-list");
  Press(render::kKeyEscape);
  EXPECT_EQ(ui_->page(), "exercises");
  EXPECT_TRUE(IsSeen("Exercise 1"));
  Press(render::kKeyEscape);
  EXPECT_EQ(ui_->page(), "sign-in");
}

INSTANTIATE_TEST_SUITE_P(Looks, PagesTest,
                         testing::Values(Look{900, 600, language::Language::kEnglish},
                                         Look{900, 600, language::Language::kGerman},
                                         Look{1920, 1080, language::Language::kEnglish},
                                         Look{1920, 1080, language::Language::kGerman}));

}  // namespace
}  // namespace enamel::station::desk
