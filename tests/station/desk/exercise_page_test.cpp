#include <gtest/gtest.h>
#include <imgui.h>

#include <optional>
#include <set>

#include "station/desk/layout.h"
#include "station/desk/pages.h"
#include "tests/station/desk/played_board.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/render/virtual_display.h"
#include "tests/station/session/kept_attempt.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;
using Clock = Workflow::Clock;
using render::InputEvent;
using testing_support::HidBus;
using testing_support::ScriptedHid;

// People at one window, with a server on loopback and an exercise in the cache.
class ExercisePageTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    HidBus::Get().Reset();
    server_.emplace(folder_);
    ASSERT_TRUE(SaveCredentials(folder_ / "data", server_->NewStation()).ok());
    const KeptDocuments kept = KeepDocuments(folder_ / "data", "pointer", false);
    const KeptDocuments arm = KeepDocuments(folder_ / "data", "phantom_desktop", false);
    server_->role = "instructor";
    server_->assignments = {Uuid::New()};
    server_->describe = [&, hash = kept.exercise_hash](size_t, wire::ExerciseRef& ref) {
      ref.set_name("class-1");
      ref.set_exercise(protocol::ToField(hash.view()));
    };
    server_->profiles = {{"pointer", kept.profile_hash}, {"phantom_desktop", arm.profile_hash}};
    workplace_ = std::move(*Workplace::Open({.data = folder_ / "data"}));
    screen_.emplace(render::ScreenOptions{
        .width_px = 1366, .height_px = 768, .visible = false, .paced = false});
  }
  void TearDown() override {
    Close();
    HidBus::Get().Reset();
  }

  void Open(WorkflowOptions options) {
    ui_.emplace(*screen_);
    flow_.emplace(*workplace_, std::move(options));
    pages_.emplace(*ui_, *flow_, "Chair 7");
  }
  void Close() {
    pages_.reset();
    flow_.reset();
    ui_.reset();
  }
  void Frame() {
    (void)screen_->Begin();
    flow_->Tick(Clock::now(), true);
    (void)pages_->Draw();
    ImGui::Render();
  }
  void Settle() {
    do Frame();
    while (flow_->busy());
    for (int i = 0; i < 4; ++i) Frame();
  }
  void Press(int key) {
    screen_->Inject({InputEvent::Key(key, true), InputEvent::Key(key, false)});
    Settle();
  }
  void Click(const Choice& choice) {
    screen_->Inject(InputEvent::Cursor(0.5 * (choice.at.x0 + choice.at.x1),
                                       0.5 * (choice.at.y0 + choice.at.y1)));
    screen_->Inject(InputEvent::Button(render::kMouseLeft, true));
    screen_->Inject(InputEvent::Button(render::kMouseLeft, false));
    Settle();
    // Where it is over nothing.
    screen_->Inject(InputEvent::Cursor(1, 1));
    Settle();
  }
  void ToExercise() {
    flow_->SignIn("ada", "secret");
    Settle();
    ASSERT_EQ(flow_->place(), Place::kExercises) << flow_->problem();
    flow_->ChooseExercise(0);
    Settle();
  }
  // A haptic board that may not be opened.
  void PlugBroken() {
    ScriptedHid d;
    d.path = folder_ / "board";
    d.vendor = 0x1209;
    d.product = 0x0001;
    d.usage_page = hid::kBoardUsagePage;
    d.usage = hid::kBoardUsage;
    d.name = L"Bench arm";
    HidBus::Get().Plug(d);
  }
  // Everything drawn on a page: words, boxes, marks, in their places and colours.
  std::string Drawn() {
    Frame();
    Sha256Stream stream;
    const ImDrawData& data = *ImGui::GetDrawData();
    for (int i = 0; i < data.CmdListsCount; ++i) {
      const ImDrawList* list = data.CmdLists[i];
      const auto* bytes = reinterpret_cast<const uint8_t*>(list->VtxBuffer.Data);
      stream.Update({bytes, static_cast<size_t>(list->VtxBuffer.size_in_bytes())});
    }
    return ui_->page() + " " + stream.Finish().Hex() + "\n" + ui_->words();
  }
  // The pages that a person sees up to an attempt, who then signs out.
  std::vector<std::string> Tour() {
    std::vector<std::string> out;
    Settle();
    Press(render::kKeyTab);  // the ring is drawn once somebody uses keys
    out.push_back(Drawn());
    flow_->SignIn("ada", "secret");
    Settle();
    out.push_back(Drawn());
    flow_->ChooseExercise(0);
    Settle();
    out.push_back(Drawn());
    flow_->Open(Dialog::kReference);
    Settle();
    out.push_back(Drawn());
    flow_->CloseDialog();
    flow_->SignOut();
    Settle();
    return out;
  }
  // Chooses once whatever this page offers, and writes into its fields; what leads elsewhere is gone
  // back from.
  void ChooseAll(const std::function<void()>& here, const std::set<std::string>& but) {
    std::set<std::string> done = but;
    for (;;) {
      here();
      const auto& all = ui_->choices();
      const auto next = std::ranges::find_if(
          all, [&](const Choice& c) { return c.visible && !done.contains(c.label); });
      if (next == all.end()) return;
      done.insert(next->label);
      Click(*next);
      screen_->Inject(InputEvent::Character('x'));
      Settle();
    }
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  render::VirtualDisplay display_;
  std::optional<FakeServer> server_;
  std::unique_ptr<Workplace> workplace_;
  std::optional<render::Screen> screen_;
  std::optional<Ui> ui_;
  std::optional<Workflow> flow_;
  std::optional<Pages> pages_;
};

TEST_F(ExercisePageTest, TheNextPersonFindsNothingThatSomebodyElseChose) {
  Open({.simulated = true});
  (void)Tour();  // from then on the station remembers what can be practised
  Close();
  Open({.simulated = true});
  const std::vector<std::string> fresh = Tour();
  EXPECT_EQ(Tour(), fresh) << "whoever chooses nothing leaves nothing";

  ToExercise();
  const std::string before = Drawn();
  const auto at_exercise = [&] {
    if (flow_->dialog() != Dialog::kNone) flow_->CloseDialog();
    if (flow_->place() == Place::kExercises) flow_->ChooseExercise(0);
    ASSERT_EQ(flow_->place(), Place::kExercise);
    Settle();
  };
  // An attempt has tests of its own, and takes long.
  ChooseAll(at_exercise, {"Start", "Try the device"});
  EXPECT_NE(Drawn(), before) << "something can be chosen";
  flow_->Open(Dialog::kReference);
  Settle();
  const auto at_dialog = [&] {
    if (flow_->dialog() != Dialog::kReference) flow_->Open(Dialog::kReference);
    Settle();
  };
  ChooseAll(at_dialog, {});
  flow_->CloseDialog();
  flow_->Speak(language::Language::kGerman);
  flow_->SignOut();
  Settle();
  const std::vector<std::string> next = Tour();
  ASSERT_EQ(next.size(), fresh.size());
  for (size_t i = 0; i < fresh.size(); ++i) EXPECT_EQ(next[i], fresh[i]);
}

TEST_F(ExercisePageTest, NobodyCutsWithTheMouseInPlaceOfABrokenDeviceByHabit) {
  PlugBroken();
  Open({});
  ToExercise();
  EXPECT_NE(ui_->words().find("Mouse and keyboard | The force is shown, not felt. | in use"),
            std::string::npos)
      << ui_->words();
  // Start has the focus.
  Press(render::kKeyEnter);
  ASSERT_EQ(flow_->dialog(), Dialog::kFallback) << flow_->problem();
  EXPECT_EQ(ui_->page(), "fallback");
  EXPECT_NE(ui_->words().find("Bench arm cannot be used"), std::string::npos) << ui_->words();
  EXPECT_NE(ui_->words().find("The device is not connected."), std::string::npos) << ui_->words();
  Press(render::kKeyEnter);
  EXPECT_EQ(flow_->dialog(), Dialog::kNone);
  EXPECT_EQ(flow_->place(), Place::kExercise) << "it looked for devices again";
  flow_->Start(false);
  Settle();
  ASSERT_EQ(flow_->dialog(), Dialog::kFallback);
  Press(render::kKeyEscape);
  EXPECT_EQ(flow_->place(), Place::kExercise);

  flow_->Start(false);
  flow_->StartWithFallback();
  EXPECT_EQ(flow_->dialog(), Dialog::kNone);
  EXPECT_EQ(flow_->place(), Place::kReady) << flow_->problem();
  flow_->Back();
  Settle();
  flow_->Start(false);
  EXPECT_EQ(flow_->dialog(), Dialog::kNone) << "it was agreed to";
  flow_->SignOut();
  ToExercise();
  flow_->Start(false);
  EXPECT_EQ(flow_->dialog(), Dialog::kFallback) << "not by the next person";
}

TEST_F(ExercisePageTest, AskedIsAlsoWhereTheDeviceThatWasCutWithIsUnplugged) {
  ASSERT_TRUE(KeepLastDevice(folder_ / "data", {"Bench arm", "phantom_desktop"}).ok());
  Open({});
  ToExercise();
  ASSERT_EQ(flow_->offers().size(), 1u) << "nothing is attached";
  flow_->Start(false);
  Settle();
  ASSERT_EQ(flow_->dialog(), Dialog::kFallback);
  EXPECT_NE(ui_->words().find("Bench arm cannot be used"), std::string::npos) << ui_->words();
  EXPECT_NE(ui_->words().find("The device is not connected."), std::string::npos) << ui_->words();
  Close();
  // A chair that is set to the mouse has no other device.
  Open({.profile = "pointer"});
  ToExercise();
  EXPECT_FALSE(flow_->missing_device());
}

TEST_F(ExercisePageTest, ADeviceThatIsRepairedIsUsedInPlaceOfTheMouseThatNobodyChose) {
  PlugBroken();
  Open({});
  ToExercise();
  ASSERT_EQ(flow_->offers()[flow_->offer_index()].profile, "pointer");
  HidBus::Get().Reset();
  PlayedBoard board(folder_ / "arm", "phantom_desktop");
  flow_->LookForDevices();
  Settle();
  EXPECT_EQ(flow_->offers()[flow_->offer_index()].title, "Bench arm");
  EXPECT_EQ(ui_->words().find("no real-time rights") != std::string::npos, flow_->lacks_realtime());
  EXPECT_TRUE(LayoutFaults().empty()) << LayoutFaults()[0];
  const auto mouse = FirstUsable(flow_->offers(), "pointer");
  flow_->ChooseOffer(mouse);
  Settle();
  flow_->LookForDevices();
  Settle();
  EXPECT_EQ(flow_->offer_index(), mouse) << "chosen on purpose";
  EXPECT_FALSE(flow_->lacks_realtime()) << "which a mouse does not need";
  EXPECT_FALSE(flow_->missing_device());
}

}  // namespace
}  // namespace enamel::station::desk
