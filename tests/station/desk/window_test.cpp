#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "common/trace/replay.h"
#include "station/desk/desk.h"
#include "station/render/png_file.h"
#include "station/spool/spool.h"
#include "tests/station/desk/played_board.h"
#include "tests/station/render/second_client.h"
#include "tests/station/render/virtual_display.h"
#include "tests/station/session/kept_attempt.h"
#include "tests/station/session/log_lines.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

// The window as a person starts it, with a device in their hand.
namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;
using testing_support::HidBus;

constexpr char kProfile[] = "phantom_desktop";
constexpr int32_t kAside_counts = 60, kFar_counts = 100'000;  // of 0.5 um; far: further than
                                                              // kWayToTheRight_m

// The window, played by a script, for an attempt kept at a station whose device is a board that a test
// moves and unplugs.
class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!display_.ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    HidBus::Get().Reset();
    board_.emplace(Node(), kProfile);
    server_.emplace(temp_.path());
    keys_ = trace::NewKeyPair();
    credentials_ = server_->NewStation();
    credentials_.ticket_key = keys_.public_key;
    ASSERT_TRUE(SaveCredentials(data(), credentials_).ok());
    options_.workplace.data = data();
    options_.full_screen = false;
    options_.width_px = 900;
    options_.height_px = 600;
    options_.quality = "low";
    options_.sound = false;
    options_.mouth = false;
    options_.script = temp_.path() / "script";
  }
  void TearDown() override {
    board_.reset();
    HidBus::Get().Reset();
  }

  fs::path data() const { return temp_.path() / "data"; }
  fs::path Node() const { return temp_.path() / "board"; }
  // Lines of a script at which the window waits until `change` was made.
  std::string Meet(std::function<void()> change) {
    const std::string at = (temp_.path() / ("meeting-" + std::to_string(++meetings_))).string();
    changes_.push_back({at + ".png", at, std::move(change)});
    return "picture " + at + ".png\nuntil " + at + "\nframes 30\n";
  }
  // As Meet, but the script continues at once.
  std::string MeetBriefly(std::function<void()> change) {
    std::string lines = Meet(std::move(change));
    return lines.substr(0, lines.rfind("frames"));
  }
  // Keeps an attempt, and makes it, with these lines of the script before it and while it runs. Its id.
  Uuid Play(const std::string& before, const std::string& during) {
    Uuid attempt;
    {
      auto spool = Spool::Open(data());
      ENAMEL_CHECK(spool.ok());
      attempt = KeepAttempt(data(), **spool, credentials_, keys_.secret_key, server_->person,
                            profile_, kKeptPin);
    }
    std::thread meanwhile([&] {
      for (const Change& each : changes_) {
        for (int i = 0; i < 3000 && !fs::exists(each.reached); ++i) {
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        each.make();
        std::ofstream(each.made) << "";
      }
    });
    const language::Words words(options_.language);
    std::ofstream(options_.script)
        << "page sign-in\nclick " << words.Say("sign_in.offline")
        << "\npage reserved\nkey Enter\npage pin\ntype " << kKeptPin
        << "\nkey Enter\npage exercise\nsee " << words.Say("exercise.in_use") << "\n"
        << before << "click " << words.Say("exercise.start") << "\npage running\nframes 20\n"
        << during << "key F\npage finish\nclick " << words.Say("finish.hand_in")
        << "\npage sign-in\nquit\n";
    const Status played = RunDesk(options_);
    meanwhile.join();
    changes_.clear();
    EXPECT_TRUE(played.ok()) << played.message();
    return attempt;
  }
  // Where the attempt's last tick has the hand, sideways, in counts.
  std::array<int32_t, 2> RecordedLast(const Uuid& attempt) {
    auto spool = Spool::Open(data());
    ENAMEL_CHECK(spool.ok());
    const auto file = (*spool)->Export(attempt);
    ENAMEL_CHECK(file.ok() && !file->chunks.empty());
    const auto chunk = trace::DecodeChunk(file->chunks.back());
    ENAMEL_CHECK(chunk.ok());
    const auto& counts = chunk->ticks.back().input.counts;
    return {counts[0], counts[1]};
  }

  const render::VirtualDisplay display_;
  test::TempFolder temp_;
  std::optional<PlayedBoard> board_;
  std::optional<FakeServer> server_;
  trace::KeyPair keys_;
  Credentials credentials_;
  DeskOptions options_;
  std::string profile_ = kProfile;

 private:
  struct Change {
    fs::path reached, made;
    std::function<void()> make;
  };
  std::vector<Change> changes_;
  int meetings_ = 0;
};

TEST_F(WindowTest, ADeviceThatStandsTurnedMovesTheBurAsTheHandSeesIt) {
  options_.hand_turn_deg = 90;
  // The board counts from the place where the window opened it.
  const auto to = [&](int32_t counts) { return [=, this] { board_->right_counts = counts; }; };
  const Uuid set = Play("", Meet(to(kAside_counts)));
  EXPECT_EQ(RecordedLast(set), (std::array{0, kAside_counts}));

  // It stands the other way round: the hand goes to the right, and the device counts to its left.
  board_->right_counts = 0;
  const language::Words words(options_.language);
  std::string align = "click " + words.Say("warm_up.try") + "\npage warm-up\nclick " +
                      words.Say("warm_up.align") + "\nsee " + words.Say("warm_up.align_move") +
                      "\n";
  align += Meet(to(-kFar_counts));
  align += "see " + words.Say("warm_up.aligned") + "\npicture " +
           (temp_.path() / "aligned.png").string() + "\nclick " + words.Say("exercise.back") +
           "\npage exercise\n";
  align += Meet(to(0));
  const Uuid measured = Play(align, Meet(to(-kAside_counts)));
  EXPECT_EQ(RecordedLast(measured), (std::array{kAside_counts, 0}));
}

// A program on the same display takes keyboard and pointer from the window while the bur cuts, and gives
// them back. The recording, replayed, says what the hand did. With ENAMEL_FULL=1 50 times.
TEST_F(WindowTest, AnotherProgramThatTakesTheKeyboardStopsTheBurAndMovesNothing) {
  const int times = ::getenv("ENAMEL_FULL") != nullptr ? 50 : 6;
  profile_ = "pointer";
  options_.width_px = 320;
  options_.height_px = 200;
  std::optional<render::SecondClient> other;
  // Into the block, and back by a notch: a hand that rests there cuts nothing more.
  std::string during = "wheel 5\nframes 3\nhold Left\nwheel 5\nframes 20\nwheel -1\nframes 12\n";
  for (int i = 0; i < times; ++i) {
    during += MeetBriefly([&, i] {
      if (!other) other.emplace();
      other->TakeKeyboard();
      // Anywhere on the display. Sometimes the window draws a frame meanwhile.
      other->PutPointer(7 * i % 320, 311 * i % 1000);
      if (i % 3 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(40));
      other->MovePointer(90 - 31 * i % 180, 40);
      EXPECT_TRUE(other->GiveKeyboard("Enamel"));
      other->PutPointer(1500 - 23 * i, 13 * i);
    });
    during += "page paused\nframes 2\nkey Enter\npage running\nframes 4\nhold Left\nframes 4\n";
  }
  const Uuid attempt = Play("", during + "let Left\n");

  auto spool = Spool::Open(data());
  ASSERT_TRUE(spool.ok());
  const auto file = (*spool)->Export(attempt);
  ASSERT_TRUE(file.ok());
  const auto header = trace::DecodeHeader(file->header);
  ASSERT_TRUE(header.ok());
  core::Core core(header->params, scene::BuildBuiltinScene("block", 200'000)->volume);
  int starts = 0, stops = 0;
  int64_t cut = 0, cut_afterwards = 0;
  int32_t moved = 0;
  std::optional<std::array<int32_t, 3>> rested;  // where the bur first stopped
  const auto replayed =
      trace::Replay(core, *header, file->chunks, [&](const trace::Tick& t, const auto& out) {
        const bool on = (t.input.flags & core::kBurOn) != 0;
        starts += on && starts == stops;
        stops += !on && starts > stops;
        if (stops > 0 && !rested) rested = t.input.counts;
        for (const int64_t units : out.removed) (rested ? cut_afterwards : cut) += units;
        for (size_t i = 0; rested && i < 3; ++i) {
          moved = std::max(moved, std::abs(t.input.counts[i] - (*rested)[i]));
        }
      });
  ASSERT_TRUE(replayed.ok() && replayed->witness_ok);
  EXPECT_EQ(stops, times + 1) << "and once at the end";
  EXPECT_GT(cut, 50 * 65'536) << "voxels";
  EXPECT_EQ(cut_afterwards, 0);
  EXPECT_EQ(moved, 0) << "counts";
}

// Pixels of the picture in the red of a sign.
size_t RedIn(const fs::path& png) {
  const auto image = render::ReadPng(png.string());
  if (!image.ok()) return 0;
  const auto near = [](int value, int wanted) { return std::abs(value - wanted) < 8; };
  size_t red = 0;
  for (size_t i = 0; i + 2 < image->rgb.size(); i += 3) {
    const uint8_t* p = image->rgb.data() + i;
    red += near(p[0], 176) && near(p[1], 38) && near(p[2], 28);
  }
  return red;
}

// ENAMEL_PICTURES keeps the pictures, at each size and in each language with ENAMEL_FULL=1.
TEST_F(WindowTest, ALostDeviceIsSeenAtAGlance) {
  const char* kept = ::getenv("ENAMEL_PICTURES");
  const fs::path pictures = kept != nullptr ? fs::path(kept) : temp_.path();
  struct Shown {
    int width_px, height_px;
    language::Language language;
  };
  std::vector<Shown> all = {{900, 600, language::Language::kEnglish}};
  if (::getenv("ENAMEL_FULL") != nullptr) {
    all.clear();
    for (language::Language each : language::kLanguages) {
      for (const auto& [w, h] : {std::pair{900, 600}, {1366, 768}, {1920, 1080}, {3840, 2160}}) {
        all.push_back({w, h, each});
      }
    }
  }
  for (const Shown& shown : all) {
    options_.width_px = shown.width_px;
    options_.height_px = shown.height_px;
    options_.language = shown.language;
    const std::string name =
        std::to_string(shown.width_px) + "-" + std::string(language::CodeOf(shown.language));
    const fs::path lost = pictures / ("lost-device-" + name + ".png");
    const LogLines log;
    const auto unplug = [&] {
      HidBus::Get().Unplug(Node().string());
      // A busy computer finds it out after many frames.
      for (int i = 0; i < 3000 && !log.Has("the force is off"); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    };
    Play("", Meet(unplug) + "picture " + lost.string() + "\n");
    board_.reset();
    board_.emplace(Node(), kProfile);
    // A disc of a fifth of the picture's height, less its symbol.
    const double disc = 0.785 * 0.2 * 0.2 * shown.height_px * shown.height_px;
    EXPECT_GT(static_cast<double>(RedIn(lost)), 0.4 * disc) << name;
  }
}

}  // namespace
}  // namespace enamel::station::desk
