#include <gtest/gtest.h>
#include <stdlib.h>

#include <boost/json.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <thread>

#include "station/desk/pages.h"
#include "station/desk/warm_up.h"
#include "station/desk/workflow.h"
#include "station/session/practice_list.h"
#include "tests/station/desk/english.h"
#include "tests/station/desk/played_board.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/render/virtual_display.h"
#include "tests/station/session/kept_attempt.h"
#include "tests/station/uplink/fake_server.h"

namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;
using testing_support::HidBus;
using Clock = Workflow::Clock;

// Attempts in the window, on tickets kept for later; pages are drawn as for a person.
class DeskAttemptTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    HidBus::Get().Reset();
    std::string name = (fs::temp_directory_path() / "enamel_attempt_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    server_.emplace(folder_);
    const trace::KeyPair keys = trace::NewKeyPair();
    ticket_key_ = keys.secret_key;
    Credentials credentials = server_->NewStation();
    credentials.ticket_key = keys.public_key;
    ASSERT_TRUE(SaveCredentials(folder_ / "data", credentials).ok());
    workplace_ = std::move(*Workplace::Open({.data = folder_ / "data"}));
    screen_.emplace(render::ScreenOptions{.width_px = 1920, .height_px = 1080, .visible = false});
  }
  void TearDown() override {
    pages_.reset();
    flow_.reset();
    ui_.reset();
    screen_.reset();
    board_.reset();
    workplace_.reset();
    HidBus::Get().Reset();
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  void Frame() {
    (void)screen_->Begin();
    flow_->Tick(Clock::now(), true);
    DeskAttempt* attempt = flow_->place() == Place::kRunning ? flow_->attempt() : nullptr;
    if (attempt != nullptr) {
      attempt->Point(*screen_, 0.01, true);
      attempt->view().Draw(screen_->width(), screen_->height(), render::kQualities[0]);
      screen_->Show(attempt->view().result());
    }
    (void)pages_->Draw();
    screen_->End();
  }
  // A limit that is not reached when all is well.
  template <typename Until>
  [[nodiscard]] bool Reached(Until&& until) {
    const auto patience = Clock::now() + std::chrono::seconds(100);
    while (!until() && Clock::now() < patience) Frame();
    return until();
  }
  // With the exercise chosen, and a device for it.
  void Choose(const std::string& profile) {
    id_ = KeepAttempt(folder_ / "data", workplace_->spool(), workplace_->credentials(), ticket_key_,
                      server_->person, profile, kKeptPin);
    ui_.emplace(*screen_);
    flow_.emplace(*workplace_, WorkflowOptions{});
    pages_.emplace(*ui_, *flow_, "Chair 7");
    flow_->ToReserved();
    ASSERT_EQ(flow_->reserved().size(), 1u);
    flow_->AskPin(0);
    flow_->OpenReserved(kKeptPin);
    ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kExercise && !flow_->busy(); }))
        << flow_->problem();
    ASSERT_LT(flow_->offer_index(), flow_->offers().size()) << flow_->problem();
    ASSERT_EQ(flow_->offers()[flow_->offer_index()].profile, profile);
  }
  // Up to the first tick.
  void Begin(const std::string& profile) {
    ASSERT_NO_FATAL_FAILURE(Choose(profile));
    Start();
  }
  void Start() {
    flow_->Start(false);
    ASSERT_TRUE(Reached([&] {
      // On an overloaded machine the arm is not heard within its second: tries again.
      const bool again = flow_->place() == Place::kExercise && !flow_->busy();
      if (again && !flow_->problem().empty()) flow_->Start(false);
      return flow_->place() == Place::kRunning;
    })) << flow_->problem();
  }
  const Snapshot& Newest() { return flow_->attempt()->run()->snapshot(); }
  // Writes a picture for people to look at.
  void Picture(const std::string& name) {
    const char* folder = ::getenv("ENAMEL_PICTURES");
    if (folder == nullptr) return;
    EXPECT_TRUE(screen_->WriteScreenshot((fs::path(folder) / (name + ".png")).string()).ok());
  }

  render::VirtualDisplay display_;
  fs::path folder_;
  std::optional<FakeServer> server_;
  trace::SecretKey ticket_key_{};
  std::unique_ptr<Workplace> workplace_;
  std::optional<render::Screen> screen_;
  std::optional<Ui> ui_;
  std::optional<PlayedBoard> board_;
  std::optional<Workflow> flow_;
  std::optional<Pages> pages_;
  Uuid id_;
};

TEST_F(DeskAttemptTest, HowItsLoopWentIsKeptAsThatOfOneFromTheCommandLineIs) {
  ASSERT_NO_FATAL_FAILURE(Begin("pointer"));
  EXPECT_FALSE(LastDeviceOf(folder_ / "data")) << "a mouse has no motors";
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= 300; }));
  flow_->EndAttempt();
  ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kSignIn; })) << flow_->problem();
  EXPECT_NE(flow_->notice().find("Handed in"), std::string::npos) << flow_->notice();
  EXPECT_TRUE(server_->sealed());
  auto stored = workplace_->spool().Get(id_);
  ASSERT_TRUE(stored.ok());
  auto kept = workplace_->spool().loop_facts().Of(id_);
  ASSERT_TRUE(kept.ok());
  ASSERT_EQ(kept->size(), 1u);
  const auto facts = boost::json::parse((*kept)[0].json);
  EXPECT_EQ(facts.at("version"), 1);
  EXPECT_EQ(facts.at("ticks"), stored->ticks);
  EXPECT_GE(facts.at("lateness").at("count").to_number<uint64_t>(), stored->ticks);
  EXPECT_FALSE(facts.at("lateness").at("ns").as_object().empty());
  EXPECT_TRUE(facts.at("faults").is_array());
  EXPECT_EQ(facts.at("device").at("name"), "mouse and keyboard");
}

TEST_F(DeskAttemptTest, TheNextBurIsTakenShownAndRecorded) {
  ASSERT_NO_FATAL_FAILURE(Begin("pointer"));
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= 100; }));
  EXPECT_EQ(Newest().bur, 0);
  flow_->attempt()->NextBur();
  ASSERT_TRUE(Reached([&] { return flow_->attempt()->view().state().bur == 1; }));
  EXPECT_FALSE(Newest().bur_waits);
  const uint64_t seen = Newest().counters.ticks;
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= seen + 300; }));
  Picture("bur-change");
  flow_->attempt()->NextBur();
  ASSERT_TRUE(Reached([&] { return Newest().bur == 0; })) << "after the last the first again";
  flow_->EndAttempt();
  ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kSignIn; })) << flow_->problem();
  auto file = workplace_->spool().Export(id_);
  ASSERT_TRUE(file.ok()) << file.status().message();
  std::vector<size_t> burs;
  for (const Bytes& bytes : file->chunks) {
    const auto chunk = trace::DecodeChunk(bytes);
    ASSERT_TRUE(chunk.ok());
    for (const trace::Tick& tick : chunk->ticks) {
      const size_t bur = core::BurIn(tick.input.flags);
      if (burs.empty() || burs.back() != bur) burs.push_back(bur);
    }
  }
  EXPECT_EQ(burs, (std::vector<size_t>{0, 1, 0}));
}

TEST_F(DeskAttemptTest, ADeviceIsTriedOnABlockOfWhichNothingIsRecorded) {
  board_.emplace(folder_ / "board", "phantom_desktop");
  ASSERT_NO_FATAL_FAILURE(Choose("phantom_desktop"));
  flow_->TryDevice();
  ASSERT_TRUE(Reached([&] {
    // On an overloaded machine the arm is not heard within its second: tries again.
    if (flow_->place() == Place::kExercise && !flow_->busy()) flow_->TryDevice();
    return flow_->attempt() != nullptr && flow_->attempt()->rehearsal() != nullptr;
  })) << flow_->problem();
  EXPECT_EQ(flow_->place(), Place::kWarmUp);
  UnrecordedRun& run = *flow_->attempt()->rehearsal();
  ASSERT_TRUE(Reached([&] { return run.found().ticks >= 200; }));
  EXPECT_EQ(run.found().turning_s, 0);
  // A fault of a busy machine ends with the next press.
  ASSERT_TRUE(Reached([&] {
    board_->buttons = board_->buttons ^ 1;
    for (int i = 0; i < 3; ++i) Frame();
    return run.found().turning_s > 0.1;
  }));
  EXPECT_NE(ui_->words().find("Cut into the block"), std::string::npos) << ui_->words();
  Picture("warm-up");
  board_->buttons = 0;
  flow_->Interrupt();
  EXPECT_EQ(flow_->place(), Place::kExercise);
  EXPECT_NE(flow_->notice().find("Device tried for"), std::string::npos) << flow_->notice();
  EXPECT_TRUE(workplace_->spool().List()->empty());
  ASSERT_NO_FATAL_FAILURE(Start()) << "and the attempt begins as before";
  flow_->EndAttempt();
  ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kSignIn; })) << flow_->problem();
}

// The block to try a mouse on.
Result<PreparedAttempt> BlockForAMouse() {
  PreparedAttempt base;
  base.exercise = scene::ClassOneExercise(scene::BuildBuiltinScene("block", 500'000)->scene, {});
  for (const auto& profile : scene::BuiltinProfiles()) {
    if (profile.name == "pointer") base.profile = profile;
  }
  return WarmUpFor(base);
}

TEST(WarmUpTest, TheBlockIsForPractice) {
  const auto block = BlockForAMouse();
  ASSERT_TRUE(block.ok()) << block.status().message();
  EXPECT_FALSE(block->exercise.graded);
  EXPECT_TRUE(block->terms.outline);
}

TEST_F(DeskAttemptTest, EitherHandTiltsTheBurByKeysOfItsOwn) {
  std::map<char, QuantisedOrientation> tilted;
  for (char key : {'W', 'A', 'S', 'D', 'I', 'J', 'K', 'L'}) {
    auto block = BlockForAMouse();
    ASSERT_TRUE(block.ok());
    auto attempt = DeskAttempt::Create(std::move(*block), {}, nullptr, false);
    ASSERT_TRUE(attempt.ok()) << attempt.status().message();
    screen_->Inject(render::InputEvent::Key(key, true));
    (void)screen_->Begin();
    for (int i = 0; i < 5; ++i) (*attempt)->Point(*screen_, 0.1, false);
    screen_->End();
    for (int tick = 0; tick < 500; ++tick) {
      tilted[key] = (*attempt)->device().ReadSample().orientation;
    }
    screen_->Inject(render::InputEvent::Key(key, false));
    (void)screen_->Begin();
    screen_->End();
    EXPECT_NE(tilted[key], kIdentityOrientation) << key;
  }
  EXPECT_EQ(tilted['I'], tilted['W']);
  EXPECT_EQ(tilted['J'], tilted['A']);
  EXPECT_EQ(tilted['K'], tilted['S']);
  EXPECT_EQ(tilted['L'], tilted['D']);
  EXPECT_NE(tilted['W'], tilted['S']);
  EXPECT_NE(tilted['A'], tilted['D']);
}

// They were shown as of an uncut tooth until the next cut.
TEST_F(DeskAttemptTest, AResumedCutIsMeasuredBeforeItsFirstPicture) {
  auto prepared = BlockForAMouse();
  ASSERT_TRUE(prepared.ok());
  prepared->core = std::make_unique<core::Core>(prepared->header.params, prepared->volume);
  // Half a second in the air, then down to a millimetre under the top, and a millimetre to the side.
  constexpr int64_t kTop_um = 5000;
  const core::CoreParams& params = prepared->header.params;
  const auto counts = [&](int axis, int64_t at_nm) {
    const auto i = static_cast<size_t>(axis);
    return static_cast<int32_t>((at_nm - params.device_origin_nm[i]) / params.resolution_nm[i]);
  };
  core::TickInput input;
  input.flags = core::kBurOn;
  input.bur_speed_krpm = kTurbineSpeed_krpm;
  double removed_mm3 = 0;
  for (int tick = 0; tick < 3500; ++tick) {
    input.counts = {counts(0, 1000 * std::clamp(tick - 2500, 0, 1000)), counts(1, 0),
                    counts(2, 1000 * (kTop_um + 1000 - std::clamp(tick - 500, 0, 2000)))};
    const auto out = prepared->core->Step(input);
    for (const int64_t units : out.removed) {
      removed_mm3 += 1e9 * cutting::RemovedUnitsToM3(units, prepared->voxel_m());
    }
  }
  prepared->header.hand = PointerDevice(1e-6, 1e-3).hand();
  const scene::CavityTarget target = prepared->exercise.target;
  DeviceOffer mouse;
  auto attempt = DeskAttempt::Create(std::move(*prepared), mouse, nullptr, false);
  ASSERT_TRUE(attempt.ok()) << attempt.status().message();
  ASSERT_TRUE((*attempt)->view().WaitIdle(std::chrono::seconds(60)));
  const auto zones = (*attempt)->zones();
  ASSERT_TRUE(zones);
  // The slot is within the box to be cut.
  const double box_mm3 = 4e-9 * target.half_size_um[0] * target.half_size_um[1] * target.depth_um;
  EXPECT_GT(removed_mm3, 1);
  EXPECT_NEAR(zones->target_percent / 100 * box_mm3, removed_mm3, 0.05 * removed_mm3);
  EXPECT_EQ(zones->beyond_mm3, 0);
}

TEST(WarmUpTextTest, ADeviceThatIsAskewIsTurnedTheOtherWay) {
  const auto text = [](double turned_deg) {
    const double angle = -turned_deg * std::numbers::pi / 180;
    HandAlignment alignment;
    EXPECT_EQ(AlignmentText(kEnglish, alignment), "");
    alignment.Begin(dvec3(0));
    EXPECT_EQ(AlignmentText(kEnglish, alignment),
              "Lift the handpiece and move it 5 cm straight to your right.");
    EXPECT_TRUE(alignment.Look(0.05 * dvec3(std::cos(angle), std::sin(angle), 0)));
    return AlignmentText(kEnglish, alignment);
  };
  EXPECT_EQ(text(95), "Your right is now right in the picture.");
  EXPECT_NE(text(110).find("by 20° clockwise"), std::string::npos) << text(110);
  EXPECT_NE(text(70).find("by 20° counter-clockwise"), std::string::npos) << text(70);
}

TEST(WarmUpTextTest, ATriedDeviceIsReportedInALine) {
  const auto text = [](uint64_t late, uint64_t faults, double turning_s) {
    return WarmUpText(kEnglish, {10'000, late, faults, turning_s, 2.14});
  };
  EXPECT_EQ(text(0, 0, 10), "Device tried for 10 s: the computer kept up, largest force 2.1 N.");
  EXPECT_EQ(text(1, 0, 2.5),
            "Device tried for 2.5 s: the computer was late once, largest force 2.1 N.");
  EXPECT_EQ(text(7, 2, 10),
            "Device tried for 10 s: the computer was late 7 times, largest force 2.1 N. The force "
            "was switched off 2 "
            "times. Tell the person who looks after this station.");
  EXPECT_EQ(text(0, 0, 0), "The bur did not turn. Check the pedal, then try again.");
}

TEST_F(DeskAttemptTest, AStrokeIsMadeAgainFromTheRecordingWhereItWas) {
  ASSERT_NO_FATAL_FAILURE(Begin("pointer"));
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= 1200; }));
  flow_->EndAttempt();
  ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kSignIn; })) << flow_->problem();
  const auto seal = workplace_->spool().Get(id_)->seal;
  ASSERT_TRUE(seal);

  EXPECT_EQ(workplace_->LookBackAt(id_).status().code(), Code::kUnauthenticated);
  const Uuid person = std::exchange(server_->person, Uuid::New());
  ASSERT_TRUE(workplace_->SignIn("somebody", "secret").ok());
  EXPECT_EQ(workplace_->LookBackAt(id_).status().code(), Code::kForbidden);
  workplace_->SignOut();
  server_->person = person;
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  auto back = workplace_->LookBackAt(id_);
  ASSERT_TRUE(back.ok()) << back.status().message();

  auto end = (*back)->Take(UINT64_MAX, UINT64_MAX);
  ASSERT_TRUE(end.ok()) << end.status().message();
  EXPECT_TRUE(end->ticks.empty());
  EXPECT_EQ(end->core->ticks(), seal->ticks);
  EXPECT_EQ(end->core->state_hash(), seal->state_hash);

  const auto surfaces = SurfacesOf(**back, {});
  ASSERT_TRUE(surfaces.ok());
  ResultPictures pictures(*surfaces);
  pictures.Add(TargetSurface((*back)->prepared()), std::nullopt);
  EXPECT_TRUE(pictures.before && pictures.after && pictures.target);
  EXPECT_FALSE(pictures.deviation) << "the server gave none";
  EXPECT_FALSE(SurfacesOf(**back, [](double) { return false; }).ok()) << "nobody looks any more";

  auto stretch = (*back)->Take(700, 1100);
  ASSERT_TRUE(stretch.ok()) << stretch.status().message();
  EXPECT_EQ(stretch->core->ticks(), 700u);
  ASSERT_EQ(stretch->ticks.size(), 400u);
  EXPECT_GE(stretch->passed_ticks, 700u);
  const core::Core* core = stretch->core.get();
  scoring::Deduction place;
  place.position_m = dvec3(1e-3, 0, 0);
  LossView view((*back)->prepared(), std::move(*stretch), place);
  // Without a tooth nothing is cut from it.
  const auto patience = Clock::now() + std::chrono::seconds(100);
  while (!view.over() && Clock::now() < patience) {
    view.Advance(0.05);
    view.view().Draw(640, 480, render::kQualities[0]);
  }
  EXPECT_TRUE(view.over());
  EXPECT_EQ(core->ticks(), 1100u);
  ASSERT_TRUE(view.view().has_state());
  EXPECT_EQ(view.view().state().tick, 1100u);
  const LossView::Ring ring = view.RingIn(640, 480);
  EXPECT_NEAR(ring.middle_px.x, 320 + 0.16 * 480, 1) << "the panel is on the left";
  EXPECT_NEAR(ring.middle_px.y, 240, 1);
  EXPECT_GT(ring.radius_px, 40);
}

TEST_F(DeskAttemptTest, AfterItsEndTheCutGoesOnForPracticeAndNothingOfItIsRecorded) {
  ASSERT_NO_FATAL_FAILURE(Begin("pointer"));
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= 300; }));
  EXPECT_FALSE(flow_->may_go_on()) << "it runs still";
  DeskAttempt& attempt = *flow_->attempt();
  attempt.run()->End();
  ASSERT_TRUE(attempt.run()->Join().ok());
  const auto recorded = workplace_->spool().Get(id_);
  const uint64_t ticks = recorded->ticks;
  for (int again = 0; again < 2; ++again) {
    attempt.Rehearse(-1);
    while (attempt.newest().counters.ticks < ticks + 300) {
      ASSERT_TRUE(attempt.rehearsal()->ticking());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    attempt.view().Draw(320, 240, render::kQualities[0]);
    EXPECT_EQ(attempt.view().state().warnings & (render::kWarnGap | render::kWarnResumed),
              uint32_t{render::kWarnResumed})
        << "no recording has stalled";
    const uint64_t from = attempt.newest().counters.ticks;
    // More than the ring holds: it must not stop for want of a recorder.
    while (attempt.newest().counters.ticks < std::max(from, ticks) + 4300) {
      ASSERT_TRUE(attempt.rehearsal()->ticking());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    attempt.rehearsal()->End();
  }
  EXPECT_EQ(workplace_->spool().Get(id_)->ticks, ticks);
  EXPECT_EQ(workplace_->spool().Get(id_)->bytes, recorded->bytes);
  EXPECT_EQ(workplace_->spool().List()->size(), 1u);
}

TEST_F(DeskAttemptTest, PracticeWithoutTheServerIsCutLikeAnyOtherAndNothingOfItIsKept) {
  const KeptDocuments kept = KeepDocuments(folder_ / "data", "pointer", false);
  Catalogue list;
  list.exercises.resize(1);
  list.exercises[0].name = kept.exercise.name;
  list.exercises[0].exercise = kept.exercise_hash;
  list.exercises[0].facts = Catalogue::Facts();
  list.exercises[0].facts->graded = false;
  list.profiles = {{"pointer", "", kept.profile_hash}};
  KeepPracticeList(folder_ / "data", list, 0);
  const uint16_t port = server_->endpoint().port;
  workplace_.reset();
  server_.reset();
  workplace_ = std::move(*Workplace::Open({.data = folder_ / "data"}));
  ui_.emplace(*screen_);
  flow_.emplace(*workplace_, WorkflowOptions{});
  pages_.emplace(*ui_, *flow_, "Chair 7");
  flow_->ToPractice();
  ASSERT_TRUE(Reached([&] { return flow_->exercises().size() == 1; })) << flow_->problem();
  Picture("practice-list");
  flow_->ChooseExercise(0);
  ASSERT_TRUE(Reached([&] { return flow_->preview() != nullptr && !flow_->busy(); }));
  Picture("practice-exercise");
  flow_->Start(false);
  ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kPractice; })) << flow_->problem();
  EXPECT_EQ(flow_->attempt()->run(), nullptr);
  ASSERT_TRUE(Reached([&] { return flow_->attempt()->newest().counters.ticks >= 300; }));
  EXPECT_NE(ui_->words().find("nothing is recorded"), std::string::npos) << ui_->words();
  server_.emplace(folder_, port);
  ASSERT_TRUE(Reached([&] {
    workplace_->uploader().Retry();
    return server_->connections() > 0;
  }));
  EXPECT_EQ(flow_->place(), Place::kPractice);
  flow_->Back();
  EXPECT_EQ(flow_->dialog(), Dialog::kPracticePaused);
  flow_->EndPractice();
  EXPECT_EQ(flow_->place(), Place::kExercise);
  ASSERT_TRUE(Reached([&] { return flow_->preview() != nullptr && !flow_->busy(); }))
      << "and can be begun again: " << flow_->problem();
  EXPECT_TRUE(workplace_->spool().List()->empty());
}

TEST_F(DeskAttemptTest, PuttingTheHandpieceDownPausesAndSaysHowToGoOn) {
  board_.emplace(folder_ / "board", "phantom_desktop");
  ASSERT_NO_FATAL_FAILURE(Begin("phantom_desktop"));
  EXPECT_EQ(LastDeviceOf(folder_ / "data"), (LastDevice{"Bench arm", "phantom_desktop"}));
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= 50; }));
  board_->buttons = 2;
  ASSERT_TRUE(Reached([&] { return flow_->dialog() == Dialog::kPaused; }));
  ASSERT_TRUE(Reached([&] { return ui_->words().find("holder") != std::string::npos; }))
      << ui_->words();
  for (int i = 0; i < 3; ++i) Frame();
  Picture("put-down");
  // Paused once each time it is put down, not continuously while it is in its holder.
  flow_->CloseDialog();
  const uint64_t ticks = Newest().counters.ticks;
  ASSERT_TRUE(Reached([&] { return Newest().counters.ticks >= ticks + 100; }));
  EXPECT_EQ(flow_->dialog(), Dialog::kNone);
  EXPECT_TRUE(Newest().put_down);
  // With the foot on the pedal: the window can be covered at any time.
  board_->buttons = 1;
  auto bur_on = [&] { return (Newest().input_flags & core::kBurOn) != 0; };
  ASSERT_TRUE(Reached([&] { return !Newest().put_down && bur_on(); }));
  flow_->Interrupt();
  EXPECT_EQ(flow_->dialog(), Dialog::kPaused);
  ASSERT_TRUE(Reached([&] { return !bur_on(); }));
  for (int i = 0; i < 3; ++i) Frame();
  EXPECT_EQ(ui_->words().find("holder"), std::string::npos) << ui_->words();
  flow_->EndAttempt();
  ASSERT_TRUE(Reached([&] { return flow_->place() == Place::kSignIn; })) << flow_->problem();
  auto kept = workplace_->spool().loop_facts().Of(id_);
  ASSERT_EQ(kept->size(), 1u);
  EXPECT_EQ(boost::json::parse((*kept)[0].json).at("put_downs"), 1);
}

}  // namespace
}  // namespace enamel::station::desk
