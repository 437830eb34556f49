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

#include "station/desk/desk.h"
#include "station/render/png_file.h"
#include "station/spool/spool.h"
#include "tests/station/desk/played_board.h"
#include "tests/station/render/virtual_display.h"
#include "tests/station/session/kept_attempt.h"
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
  // Keeps an attempt, and makes it, with these lines of the script before it and while it runs. Its id.
  Uuid Play(const std::string& before, const std::string& during) {
    Uuid attempt;
    {
      auto spool = Spool::Open(data());
      ENAMEL_CHECK(spool.ok());
      attempt = KeepAttempt(data(), **spool, credentials_, keys_.secret_key, server_->person,
                            kProfile, kKeptPin);
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
        << "\nkey Enter\npage exercise\nsee " << words.Say("exercise.device") << "\n"
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
    Play("",
         Meet([&] { HidBus::Get().Unplug(Node().string()); }) + "picture " + lost.string() + "\n");
    board_.reset();
    board_.emplace(Node(), kProfile);
    // A disc of a fifth of the picture's height, less its symbol.
    const double disc = 0.785 * 0.2 * 0.2 * shown.height_px * shown.height_px;
    EXPECT_GT(static_cast<double>(RedIn(lost)), 0.4 * disc) << name;
  }
}

}  // namespace
}  // namespace enamel::station::desk
