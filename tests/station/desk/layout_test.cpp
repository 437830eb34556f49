#include "station/desk/layout.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "station/desk/exercise_words.h"
#include "station/desk/operator_panel.h"
#include "station/desk/pages.h"
#include "station/desk/problem_words.h"
#include "station/desk/stop_sign.h"
#include "station/render/panel.h"
#include "station/session/practice_list.h"
#include "tests/station/desk/played_board.h"
#include "tests/station/render/virtual_display.h"
#include "tests/station/session/kept_attempt.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

// No page cuts words or buttons off or draws words over each other: at the sizes that stations have, in
// every language, with every kind of device, with the longest texts that it shows. Nothing is
// rasterized.
namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;
using testing_support::HidBus;
using Clock = Workflow::Clock;
using language::Language;

constexpr int kFrames = 4;  // until a page's sizes have settled

const std::vector<scene::BurSpec> kBurs = {
    {{}, cutting::BurShape::kCylinder, 500, 4'000},
    {{}, cutting::BurShape::kInvertedCone, 600, 1'200, 400, 0, 0, "806 314 010 544 012"},
    {{}, cutting::BurShape::kWheel, 1'500, 1'000}};

struct Size {
  int width_px, height_px;
  double inches;  // of the screen
  double pixel_mm() const { return 25.4 * inches / std::hypot(width_px, height_px); }
};

class LayoutTest : public testing::TestWithParam<Size> {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    screen_.emplace(render::ScreenOptions{.width_px = GetParam().width_px,
                                          .height_px = GetParam().height_px,
                                          .pixel_mm = GetParam().pixel_mm(),
                                          .visible = false,
                                          .paced = false});
    // With these letters the window can say every language.
    if (render::FindChineseFont()) screen_->Speak(Language::kChinese);
    ui_.emplace(*screen_);
  }

  std::vector<Language> languages() const {
    std::vector<Language> out = {Language::kEnglish, Language::kGerman};
    if (render::FindChineseFont()) out.push_back(Language::kChinese);
    return out;
  }
  // True if this size shows this language to somebody left-handed.
  static bool IsLeftIn(Language language) {
    return (static_cast<int>(language) + GetParam().width_px / 2) % 2 != 0;
  }
  template <typename Page>
  void Expect(const std::string& what, Page&& page, int frames = kFrames) {
    for (int i = 0; i < frames; ++i) {
      (void)screen_->Begin();
      page();
      ImGui::Render();
    }
    for (const std::string& fault : LayoutFaults(ui_->choices())) {
      ADD_FAILURE() << what << ": " << fault;
    }
  }
  // The panel of a running attempt, with the most that it can say.
  render::PanelContent FullPanel(const Words& words, bool by_pointer) const;

  void ExpectPanel();
  void ExpectCards();
  void ExpectBar();

  render::VirtualDisplay display_;
  std::optional<render::Screen> screen_;
  std::optional<Ui> ui_;
};

// A person's way through the window, with a server on loopback.
// Minutes of pictures: the smallest, the upright and the largest window for every commit.
bool IsOfEveryCommit(const Size& size) {
  return size.width_px == 900 || size.width_px == 1080 || size.width_px == 3840;
}

class PagesLayoutTest : public LayoutTest {
 protected:
  void SetUp() override {
    if (std::getenv("ENAMEL_FULL") == nullptr && !IsOfEveryCommit(GetParam()))
      GTEST_SKIP() << "one of five more sizes: ./check --full";
    LayoutTest::SetUp();
    if (IsSkipped()) return;
    server_.emplace(folder_);
    const trace::KeyPair keys = trace::NewKeyPair();
    Credentials credentials = server_->NewStation();
    credentials.ticket_key = keys.public_key;
    ASSERT_TRUE(SaveCredentials(data(), credentials).ok());
    workplace_ = std::move(*Workplace::Open({.data = data()}));
    for (const char* profile : {"pointer", "pointer", kForce, kForce}) {
      KeepAttempt(data(), workplace_->spool(), credentials, keys.secret_key, server_->person,
                  profile, kKeptPin);
    }
    HidBus::Get().Reset();
    board_.emplace(folder_ / "board", kForce);
    flow_.emplace(*workplace_, kOptions);
    pages_.emplace(*ui_, *flow_, "Simulation clinic, chair 17");
  }
  void TearDown() override {
    pages_.reset();
    flow_.reset();
    workplace_.reset();
    board_.reset();
    HidBus::Get().Reset();
  }

  fs::path data() const { return folder_ / "data"; }
  template <typename Until>
  void Await(Until&& until) {
    const auto patience = Clock::now() + std::chrono::seconds(100);
    while (!until() && Clock::now() < patience) {
      (void)screen_->Begin();
      flow_->Tick(Clock::now(), true);
      (void)pages_->Draw();
      ImGui::Render();
      // A loop without it would only take the processor from what it waits for.
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ASSERT_TRUE(until()) << flow_->problem();
  }
  // On a busy computer the board's poses come late, and the page refuses the board as too slow. A person
  // would try again.
  template <typename Try, typename Until>
  void AwaitTrying(const Try& again, const Until& until) {
    Await([&] {
      if (!until() && !flow_->busy() && flow_->place() == Place::kExercise) again();
      return until();
    });
  }
  void Settle() {
    Await([&] { return !flow_->busy(); });
  }
  // In every language. Over a picture each hand meets each size and each language; with ENAMEL_FULL=1
  // all three together.
  void ExpectPage(const std::string& what) {
    for (Language language : languages()) {
      flow_->Speak(language);
      std::vector<bool> hands = {flow_->cutting() && IsLeftIn(language)};
      if (flow_->cutting() && std::getenv("ENAMEL_FULL") != nullptr) hands = {false, true};
      for (const bool left : hands) {
        flow_->HoldInLeft(left);
        Expect(what + ", " + std::string(NameOf(language)) + (left ? ", left-handed" : ""), [&] {
          if (flow_->cutting()) DrawBelow(language, left);
          (void)pages_->Draw();
        });
      }
    }
  }
  // Draws what the window draws below the page.
  void DrawBelow(Language language, bool left) {
    const Words words(language);
    render::PanelContent content = FullPanel(words, flow_->attempt()->by_pointer());
    if (flow_->dialog() != Dialog::kNone) content.hint.clear();
    const render::Canvas canvas = render::DrawPanel(content, words, screen_->fonts(),
                                                    {screen_->width(), screen_->height(), left});
    if (flow_->dialog() == Dialog::kNone) {
      DrawBurChoice(kBurs, content.state, words, screen_->fonts(), ui_->AbovePage(canvas));
    }
    ui_->Over(canvas);
  }
  // The kept attempt for this kind of device, opened with it.
  void OpenKept(const char* profile) {
    flow_->ToReserved();
    const auto kept = std::ranges::find_if(flow_->reserved(), [&](const auto& r) {
      return r.ticket.profile == profile && !r.cut_off;
    });
    ASSERT_NE(kept, flow_->reserved().end()) << profile;
    flow_->AskPin(static_cast<size_t>(kept - flow_->reserved().begin()));
    flow_->OpenReserved(kKeptPin);
    Await([&] { return flow_->place() == Place::kExercise && !flow_->busy(); });
  }
  void ExpectForceDevice(bool simulated);
  void ExpectOperatorPanel(const std::string& name);
  void RunChosen() {
    flow_->Start(false);
    Await([&] { return flow_->place() == Place::kRunning; });
    // What has no tick cannot be handed in.
    Await([&] { return flow_->attempt()->run()->snapshot().counters.ticks > 10; });
  }
  void ExpectPractice();
  void ExpectPracticeWithoutServer();
  void ExpectDialog(Dialog dialog, const std::string& what) {
    flow_->Open(dialog);
    ExpectPage(what);
    flow_->CloseDialog();
  }
  Uuid Recorded(bool ended) {
    trace::Header header = HeaderOf(server_->person);
    EXPECT_TRUE(workplace_->spool().BeginAttempt(header, "class-2", "phantom_desktop").ok());
    trace::Seal seal;
    seal.attempt = header.ticket.attempt;
    if (ended) EXPECT_TRUE(workplace_->spool().PutSeal(seal).ok());
    return header.ticket.attempt;
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  static constexpr char kForce[] = "phantom_desktop";
  static inline const WorkflowOptions kOptions{.simulated = true};
  std::optional<FakeServer> server_;
  std::optional<PlayedBoard> board_;
  std::unique_ptr<Workplace> workplace_;
  std::optional<Workflow> flow_;
  std::optional<Pages> pages_;
};

const std::vector<scene::Exercise>& AllExercises() {
  static std::vector<scene::Exercise> all;
  if (!all.empty()) return all;
  for (const std::string& name : scene::BuiltinSceneNames()) {
    auto built = scene::BuildBuiltinScene(name, 500'000);
    ENAMEL_CHECK(built.ok());
    for (scene::Exercise& exercise : scene::BuiltinExercises(built->scene, {})) {
      all.push_back(std::move(exercise));
    }
  }
  return all;
}

// Everything lost, and three errors that fail.
std::string WorstScore() {
  const scene::Exercise exercise = AllExercises().front();
  scoring::ScoreResult score;
  for (scoring::Group group : scoring::GroupsOf(exercise.rubric)) {
    scoring::CriterionResult c;
    c.name = scoring::NameOf(group);
    c.group = group;
    c.lost = 88.8;
    c.most = 25;
    c.state = scoring::State::kRedo;
    score.criteria.push_back(c);
  }
  for (const auto& criterion : exercise.rubric.criteria) {
    scoring::CriterionResult c;
    c.name = criterion.metric;
    c.title = criterion.title;
    c.lost = c.most = criterion.points;
    c.reason = "All of it";
    score.criteria.push_back(c);
  }
  score.beyond = 123.4;
  // Those with the longest names of what and where, each with a stroke.
  for (scoring::MistakeKind kind :
       {scoring::MistakeKind::kUnderReduced, scoring::MistakeKind::kUnderExtended,
        scoring::MistakeKind::kCorner, scoring::MistakeKind::kNeighbour}) {
    scoring::Mistake m;
    m.kind = kind;
    m.place = "cusp_distolingual";
    m.size = 12.34;
    m.points = 88.8;
    scoring::Deduction d;
    d.mistake = static_cast<uint32_t>(score.mistakes.size());
    d.volume_m3 = 1e-9;
    d.strokes = {{123, 72'000, 3'972.4, 2, d.volume_m3}};
    score.mistakes.push_back(m);
    score.deductions.push_back(d);
  }
  score.critical_fail = true;
  for (const char* error : {"neighbour_damaged", "pulp_exposed", "gross_overextension"}) {
    scoring::CriticalResult c;
    c.error = error;
    c.above = true;
    c.value = 12.5;
    c.limit = 0.05;
    c.unit = "mm3";
    score.critical.push_back(c);
  }
  return scoring::ToJson(score);
}

// One test for each size, which needs fonts of its own.
TEST_P(PagesLayoutTest, ShowsAllWords) {
  ExpectPanel();
  ExpectCards();
  ExpectBar();
  server_->SetPageUrl("https://enamel.dental-school.example.edu/enamel");
  for (Language language : languages()) {
    flow_->SignOut(language::Words(language).Say("signed_out.lost"));  // looks for what was kept
    flow_->Speak(language);
    server_->must_change_password = true;
    flow_->SignIn("ada", "once");
    Settle();
    ASSERT_EQ(flow_->place(), Place::kFirstPassword);
    flow_->ChoosePassword("short", "short");
    ASSERT_FALSE(flow_->problem().empty());
    ExpectPage("first password");
    flow_->Back();
    server_->must_change_password = false;
    server_->refuse_sign_ins = Status(Code::kUnauthenticated, "login or password is wrong");
    flow_->SignIn("ada", "wrong");
    Settle();
    ExpectPage("sign-in, wrong password");
    server_->refuse_sign_ins.reset();
  }
  ExpectDialog(Dialog::kClose, "close");

  flow_->ToReserved();
  ExpectPage("reserved");
  flow_->AskPin(0);
  flow_->OpenReserved("804218");
  Settle();
  ASSERT_FALSE(flow_->problem().empty());
  ExpectPage("pin");
  flow_->CloseDialog();
  ExpectForceDevice(false);
  ExpectForceDevice(true);
  OpenKept("pointer");
  ExpectPage("exercise kept");
  flow_->TryDevice();
  Await([&] { return flow_->place() == Place::kWarmUp && flow_->attempt()->rehearsal(); });
  ExpectPage("warm-up");
  flow_->EndWarmUp();
  flow_->Start(false);
  Await([&] { return flow_->place() == Place::kReady && !flow_->busy(); });
  ExpectPage("ready");
  Await([&] { return flow_->place() == Place::kRunning; });
  // What has no tick cannot be handed in.
  Await([&] { return flow_->attempt()->run()->snapshot().counters.ticks > 10; });
  ExpectPage("running");
  ExpectDialog(Dialog::kPaused, "paused");
  ExpectDialog(Dialog::kFinish, "finish");
  ExpectDialog(Dialog::kGiveUp, "give up");
  server_->silent = true;
  flow_->EndAttempt();
  ExpectPage("hand-in");
  server_->silent = false;
  Await([&] { return flow_->place() == Place::kSignIn; });

  server_->must_change_password = false;
  Recorded(false);
  const Uuid handed_in = Recorded(true);
  server_->seen.insert(handed_in);
  const std::vector<scene::Exercise> exercises = AllExercises();
  server_->assignments.assign(exercises.size(), Uuid::New());
  server_->describe = [&](size_t i, wire::ExerciseRef& ref) {
    ref.set_name(exercises[i].name);
    ref.set_title(exercises[i].title);
    ref.set_due_unix_ms(4'000'000'000'000);
    ref.set_attempt_limit(3);
    ref.set_attempts_left(2);
    ref.set_exam(i % 2 == 0);
    ref.set_best_score(99);
  };
  flow_->SignIn("ada", "secret");
  Await([&] { return flow_->place() == Place::kExercises && !flow_->busy(); });
  ExpectPage("exercises");
  flow_->OpenCutOff(0);
  ExpectPage("cut off");
  flow_->CloseDialog();
  flow_->ChooseExercise(0);
  ExpectPage("exercise");
  Settle();
  ExpectPage("exercise that cannot be had");
  ExpectDialog(Dialog::kReserve, "reserve");
  ExpectDialog(Dialog::kSignOff, "sign-off");
  ExpectDialog(Dialog::kReference, "reference");
  flow_->Back();
  Settle();
  flow_->OpenHandedIn(0);
  Await([&] { return flow_->progress().has_value() && !flow_->busy(); });
  ExpectPage("result on its way");
  flow_->ToExercises();
  Settle();
  server_->result_json = WorstScore();
  flow_->OpenHandedIn(0);
  Await([&] { return flow_->score().has_value(); });
  ExpectPage("result");
  ExpectPractice();
  ExpectPracticeWithoutServer();

  pages_.reset();
  flow_.reset();
  workplace_.reset();
  for (const char* end : {"-wal", "-shm"}) fs::remove((data() / "spool.sqlite").string() + end);
  std::ofstream(data() / "spool.sqlite") << std::string(4096, 'Z');
  Opening opening({.data = data()});
  ASSERT_EQ(opening.workplace(), nullptr);
  for (Language language : languages()) {
    const Words words(language);
    Expect("trouble, " + std::string(NameOf(language)),
           [&] { (void)DrawOpeningProblem(*ui_, words, opening); });
  }
}

// An attempt with a device whose force is felt, or with a hand that is played.
void PagesLayoutTest::ExpectForceDevice(bool simulated) {
  const std::string name = simulated ? "simulated: " : "board: ";
  OpenKept(kForce);
  if (simulated) {
    const auto hand = std::ranges::find_if(
        flow_->offers(), [](const DeviceOffer& o) { return !o.operator_name.empty(); });
    ASSERT_NE(hand, flow_->offers().end());
    flow_->ChooseOffer(static_cast<size_t>(hand - flow_->offers().begin()));
  }
  ExpectPage(name + "exercise");
  if (!simulated) {
    AwaitTrying([&] { flow_->TryDevice(); },
                [&] { return flow_->place() == Place::kWarmUp && flow_->attempt()->rehearsal(); });
    ExpectPage(name + "warm-up");
    flow_->AlignHand();
    ExpectPage(name + "match hand and picture");
    flow_->EndWarmUp();
  }
  AwaitTrying([&] { flow_->Start(false); },
              [&] { return flow_->place() == Place::kReady && !flow_->busy(); });
  ExpectPage(name + "ready");
  Await([&] { return flow_->place() == Place::kRunning; });
  Await([&] { return flow_->attempt()->run()->snapshot().counters.ticks > 10; });
  ExpectPage(name + "running");
  ExpectOperatorPanel(name);
  ExpectDialog(Dialog::kPaused, name + "paused");
  flow_->EndAttempt();
  Await([&] { return flow_->place() == Place::kSignIn; });
}

void PagesLayoutTest::ExpectOperatorPanel(const std::string& name) {
  StationWatch station(*workplace_);
  const PictureTimes times;
  Expect(name + "operator's panel", [&] {
    (void)pages_->Draw();
    DrawOperatorPanel(*flow_, station, *screen_, times, render::kQualities[0], 1.0 / 60);
  });
}

// A cut that was interrupted is ended by somebody who may continue it for practice.
void PagesLayoutTest::ExpectPractice() {
  flow_->SignOut();
  OpenKept("pointer");
  RunChosen();
  Await([&] { return flow_->chunks() > 0; });
  flow_->LeaveForNow();
  Await([&] { return flow_->place() == Place::kSignIn; });
  EXPECT_EQ(flow_->notice(), flow_->words().Say("signed_out.left"));
  ExpectPage("sign-in, left");
  server_->role = "instructor";
  flow_->SignIn("ada", "secret");
  Await([&] { return flow_->place() == Place::kExercises && !flow_->busy(); });
  const auto kept =
      std::ranges::find_if(flow_->cut_off(), [](const auto& a) { return a.chunks > 0; });
  ASSERT_NE(kept, flow_->cut_off().end());
  flow_->OpenCutOff(static_cast<size_t>(kept - flow_->cut_off().begin()));
  flow_->GoOnWithCutOff();
  Await([&] { return flow_->place() == Place::kExercise && !flow_->busy(); });
  ExpectPage("exercise that continues");
  RunChosen();
  flow_->EndAttempt();
  Await([&] { return flow_->may_go_on() && !flow_->busy(); });
  ExpectPage("result that continues");
  flow_->GoOnForPractice();
  ExpectPage("practice");
  ExpectDialog(Dialog::kPracticePaused, "practice paused");
  flow_->EndPractice();
}

// With all the ways that the first page can offer.
void PagesLayoutTest::ExpectPracticeWithoutServer() {
  Catalogue list;
  for (bool graded : {false, true}) {
    const KeptDocuments kept = KeepDocuments(data(), "pointer", graded);
    Catalogue::Exercise& listed = list.exercises.emplace_back();
    listed.name = graded ? "graded" : "practice";
    listed.exercise = kept.exercise_hash;
    listed.facts = Catalogue::Facts();
    listed.facts->graded = false;
  }
  KeepPracticeList(data(), list, 0);
  Recorded(false);
  pages_.reset();
  flow_.emplace(*workplace_, WorkflowOptions{.profile = "inverse3"});
  pages_.emplace(*ui_, *flow_, "Simulation clinic, chair 17");
  flow_->SignOut(flow_->words().Say("practice.idle"));
  ASSERT_TRUE(flow_->may_practise());
  ExpectPage("sign-in with practice");
  flow_->ToPractice();
  Settle();
  ASSERT_EQ(flow_->exercises().size(), 1U)
      << "the graded one is not offered, whatever the list says";
  ExpectPage("practice list");
  flow_->ChooseExercise(0);
  Settle();
  EXPECT_FALSE(flow_->problem().empty()) << "a profile that is not here";
  ExpectPage("practice that this device cannot do");
  ExpectDialog(Dialog::kPracticePaused, "practice paused");
  ExpectDialog(Dialog::kFallback, "fallback");
  flow_->Back();
  flow_->Back();
}

render::PanelContent LayoutTest::FullPanel(const Words& words, bool by_pointer) const {
  render::PanelContent content;
  content.has_state = true;
  content.state.time_s = 3607;
  content.time_limit_s = 5400;
  for (cutting::Tissue tissue :
       {cutting::Tissue::kEnamel, cutting::Tissue::kDentin, cutting::Tissue::kPulp,
        cutting::Tissue::kCaries, cutting::Tissue::kNeighbour}) {
    content.state.removed_mm3[static_cast<size_t>(tissue)] = 12.34;
  }
  content.zones = render::ZoneShares{100, 100, 12.34, 12.34};
  content.reach.leeway = render::Reach::Leeway{-1.23, 0.5, "reach.mesial_wall"};
  content.reach.pulp_mm = 0.12;
  content.state.bur_waits = true;
  content.heading = words.Say("builtin_title.class_ii_cavity_mesial_box");
  content.several_burs = true;
  content.hint = (by_pointer ? words.Say("hint.pointer", {{"keys", std::string("W A S D")}})
                             : words.Say("hint.camera")) +
                 "   " + words.Say("hint.outline") + "   " + words.Say("hint.depth") + "   " +
                 words.Say("hint.bur") + "   " + words.Say("hint.mirror_held");
  return content;
}

void LayoutTest::ExpectPanel() {
  for (Language language : languages()) {
    const Words words(language);
    render::PanelContent content = FullPanel(words, true);
    const std::string name(NameOf(language));
    const bool left = IsLeftIn(language);
    Stop stop = Stop::kNone;
    auto panel = [&] {
      const render::Canvas canvas = render::DrawPanel(content, words, screen_->fonts(),
                                                      {screen_->width(), screen_->height(), left});
      if (stop == Stop::kNone) {
        DrawBurChoice(kBurs, content.state, words, screen_->fonts(), canvas);
      }
      DrawStop(stop, words.Say("stop.kept"), screen_->fonts(), canvas);
    };
    for (uint32_t warning = 0; warning < render::kWarningCount; ++warning) {
      content.state.warnings = 1U << warning;
      content.bur_away = {{-0.6F, 0.8F}};
      Expect("warning " + std::to_string(warning) + ", " + name, panel);
    }
    content.state.warnings = render::kWarnDisk | render::kWarnOffline | render::kWarnTime;
    for (Fault fault : {Fault::kStalled, Fault::kLateOnce, Fault::kLateOften, Fault::kTooSlow,
                        Fault::kUnplugged, Fault::kSwitchedOff}) {
      stop = StopOf(fault, false, false);
      content.bur_away.reset();
      for (bool lacks_realtime : {false, true}) {
        const std::string said = FaultSentence(words, fault, Status::Ok(), lacks_realtime);
        if (said == content.fault) continue;
        content.fault = said;
        // Also in the frame in which it is said.
        Expect("first " + std::string(FaultKey(fault)) + ", " + name, panel, 1);
        Expect(std::string(FaultKey(fault)) + ", " + name, panel);
      }
    }
    content.fault.clear();
  }
}

void LayoutTest::ExpectCards() {
  std::vector<Catalogue::Exercise> all;
  for (const scene::Exercise& exercise : AllExercises()) {
    Catalogue::Exercise& ref = all.emplace_back();
    ref.title = exercise.title;
    ref.due_unix_ms = 4'000'000'000'000;
    ref.attempt_limit = 12;
    ref.exam = true;
    ref.best_score = 100;
    ref.facts = Catalogue::Facts();
    ref.facts->tooth = 46;
    ref.facts->landmark = exercise.target.landmark;
    ref.facts->caries = ref.facts->neighbours = ref.facts->graded = true;
  }
  for (Language language : languages()) {
    const Words words(language);
    std::vector<Card> cards;
    for (const auto& exercise : all) cards.push_back(CardOf(words, exercise, 0));
    for (size_t from = 0; from < cards.size(); from += 4) {
      const auto some = std::span(cards).subspan(from, std::min<size_t>(4, cards.size() - from));
      Expect("cards, " + std::string(NameOf(language)), [&] {
        ui_->Begin("exercises", kWidePage);
        ui_->BeginList("exercises");
        (void)ui_->Cards(some);
        ui_->EndList();
        ui_->End();
        ui_->EndFrame();
      });
    }
  }
}

// While the end of a recording is not stored.
void LayoutTest::ExpectBar() {
  for (Language language : languages()) {
    const Words words(language);
    Expect("bar, " + std::string(NameOf(language)), [&] {
      ui_->Begin("hand-in", kHandInPage);
      ui_->Title(words.Say("hand_in.title"));
      ui_->Bar(words.Say("hand_in.share_without_end", {{"percent", std::string("99")}}), 0.5);
      DrawStopSign(Stop::kDisk, ui_->Square(kSign_px));
      ui_->Problem(words.Say("hand_in.cannot_store"));
      ui_->Gap(12);
      for (const char* choice : {"hand_in.give_up_end", "hand_in.leave", "hand_in.again"}) {
        (void)ui_->Button(words.Say(choice));
      }
      ui_->End();
      ui_->EndFrame();
    });
  }
}

// What it finds, so that the test above can fail.
TEST_P(LayoutTest, FindsWordsThatCannotBeRead) {
  const auto w = static_cast<float>(screen_->width()), h = static_cast<float>(screen_->height());
  auto faults = [&](auto&& draw) {
    for (int i = 0; i < kFrames; ++i) {
      (void)screen_->Begin();
      ImGui::SetNextWindowPos({0, 0});
      ImGui::SetNextWindowSize({w, h});
      ImGui::Begin("page", nullptr, ImGuiWindowFlags_NoDecoration);
      draw(*ImGui::GetWindowDrawList());
      ImGui::End();
      ImGui::Render();
    }
    return LayoutFaults();
  };
  constexpr ImU32 kWhite = 0xffffffff;
  auto at = [&](float x, float y) {
    return [=](ImDrawList& list) { list.AddText({x * w, y * h}, kWhite, "Back"); };
  };
  EXPECT_TRUE(faults(at(0.5F, 0.5F)).empty());
  EXPECT_EQ(faults(at(0.99F, 0.5F)).size(), 1U) << "beyond the window";
  const auto twice = faults([&](ImDrawList& list) {
    list.AddText({0.5F * w, 0.5F * h}, kWhite, "Back");
    list.AddText({0.5F * w + 2, 0.5F * h + 2}, kWhite, "Next");
  });
  ASSERT_FALSE(twice.empty());
  EXPECT_NE(twice[0].find("over each other: 'Back"), std::string::npos) << twice[0];
  const auto boxed = faults([&](ImDrawList& list) {
    list.PushClipRect({0.5F * w, 0}, {0.5F * w + 0.5F * ImGui::CalcTextSize("F").x, h}, true);
    list.AddText({0.5F * w, 0.5F * h}, kWhite, "Find devices");
    list.PopClipRect();
  });
  ASSERT_EQ(boxed.size(), 1U);
  EXPECT_NE(boxed[0].find("cut off: 'F"), std::string::npos) << boxed[0];
  const auto tall = faults([&](ImDrawList&) { ImGui::Dummy({10, 2 * h}); });
  ASSERT_EQ(tall.size(), 1U);
  EXPECT_EQ(tall[0], "longer than its place: page");
}

// Boxes: their words may be whole.
TEST_P(LayoutTest, FindsButtonsThatAreNotSeenWhole) {
  const auto faults = [&](auto&& draw) {
    for (int i = 0; i < kFrames; ++i) {
      (void)screen_->Begin();
      draw();
      ui_->EndFrame();
      ImGui::Render();
    }
    std::vector<std::string> found;
    for (std::string& fault : LayoutFaults(ui_->choices())) {
      if (fault.find('[') != fault.npos) found.push_back(std::move(fault));
    }
    return found;
  };
  const auto page = [&](float at_y, auto&& inside) {
    return [&, at_y] {
      ui_->Begin("page", {0.1F, at_y, 0.8F, 0.3F, true});
      inside();
      ui_->End();
    };
  };
  const auto finish = [&] { (void)ui_->Button("Finish"); };
  EXPECT_TRUE(faults(page(0.5F, finish)).empty());
  const auto half_out = faults(page(0.94F, finish));
  ASSERT_EQ(half_out.size(), 1U);
  EXPECT_NE(half_out[0].find("not whole: [Finish]"), std::string::npos) << half_out[0];

  // A list of devices, which may scroll; but not the one in use.
  size_t chosen = 0;
  const auto devices = [&] {
    ui_->Begin("exercise", kWidePage);
    ui_->BeginList("devices");
    for (size_t i = 0; i < 20; ++i) {
      (void)ui_->Row("Device " + std::to_string(i), "", "", i == chosen);
    }
    ui_->EndList();
    (void)ui_->Button("Start");
    ui_->End();
  };
  EXPECT_TRUE(faults(devices).empty());
  chosen = 15;
  const auto below = faults(devices);
  ASSERT_EQ(below.size(), 1U);
  EXPECT_NE(below[0].find("chosen and not seen: [Device 15]"), std::string::npos) << below[0];
}

// A window on a desktop, as small as a chair's may be; 4:3, 5:4, 3:2, upright; and what most have.
constexpr Size kSizes[] = {{900, 600, 11.79}, {1024, 768, 15},  {1280, 1024, 19}, {1366, 768, 15.6},
                           {1080, 1920, 24},  {1920, 1080, 24}, {2160, 1440, 15}, {3840, 2160, 27}};
std::string SizeName(const testing::TestParamInfo<Size>& size) {
  return std::to_string(size.param.width_px) + "x" + std::to_string(size.param.height_px);
}
INSTANTIATE_TEST_SUITE_P(Smallest, LayoutTest, testing::Values(kSizes[0]), SizeName);
INSTANTIATE_TEST_SUITE_P(Sizes, PagesLayoutTest, testing::ValuesIn(kSizes), SizeName);

}  // namespace
}  // namespace enamel::station::desk
