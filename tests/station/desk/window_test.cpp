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

constexpr char kPin[] = "804217";
constexpr char kProfile[] = "phantom_desktop";
constexpr int32_t kRight_counts = 60;

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
  // Keeps an attempt, and makes it. While it runs, the window is kept waiting for `change`; then
  // come these lines of the script. Its id.
  Uuid Play(const std::function<void()>& change, const std::string& lines) {
    Uuid attempt;
    {
      auto spool = Spool::Open(data());
      ENAMEL_CHECK(spool.ok());
      attempt = KeepAttempt(data(), **spool, credentials_, keys_.secret_key, server_->person,
                            kProfile, kPin);
    }
    const fs::path runs = temp_.path() / (attempt.Text() + ".png"),
                   changed = temp_.path() / attempt.Text();
    std::thread meanwhile([&] {
      for (int i = 0; i < 3000 && !fs::exists(runs); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
      change();
      std::ofstream(changed) << "";
    });
    const language::Words words(options_.language);
    std::ofstream(options_.script)
        << "page sign-in\nclick " << words.Say("sign_in.offline")
        << "\npage reserved\nkey Enter\npage pin\ntype " << kPin
        << "\nkey Enter\npage exercise\nsee " << words.Say("exercise.device") << "\nclick "
        << words.Say("exercise.start") << "\npage running\nframes 20\n"
        << "picture " << runs.string() << "\nuntil " << changed.string() << "\nframes 30\n"
        << lines << "key F\npage finish\nclick " << words.Say("finish.hand_in")
        << "\npage sign-in\nquit\n";
    const Status played = RunDesk(options_);
    meanwhile.join();
    EXPECT_TRUE(played.ok()) << played.message();
    return attempt;
  }

  const render::VirtualDisplay display_;
  test::TempFolder temp_;
  std::optional<PlayedBoard> board_;
  std::optional<FakeServer> server_;
  trace::KeyPair keys_;
  Credentials credentials_;
  DeskOptions options_;
};

// A hand that rests to the right of its middle.
TEST_F(WindowTest, ADeviceThatStandsTurnedMovesTheBurAsTheHandSeesIt) {
  for (const auto& [turn_deg, expected] :
       {std::pair{0, std::array{kRight_counts, 0}}, {90, std::array{0, kRight_counts}}}) {
    options_.hand_turn_deg = turn_deg;
    // Where the board is as it is opened is the middle.
    board_->right_counts = 0;
    const Uuid attempt = Play([&] { board_->right_counts = kRight_counts; }, "");
    auto spool = Spool::Open(data());
    ASSERT_TRUE(spool.ok());
    const auto file = (*spool)->Export(attempt);
    ASSERT_TRUE(file.ok()) << file.status().message();
    ASSERT_FALSE(file->chunks.empty());
    const auto chunk = trace::DecodeChunk(file->chunks.back());
    ASSERT_TRUE(chunk.ok());
    const auto& counts = chunk->ticks.back().input.counts;
    EXPECT_EQ((std::array{counts[0], counts[1]}), expected) << turn_deg;
  }
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
      for (const auto& [w, h] : {std::pair{900, 600}, {1366, 768}, {1920, 1080}}) {
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
    Play([&] { HidBus::Get().Unplug(Node().string()); }, "picture " + lost.string() + "\n");
    board_.reset();
    board_.emplace(Node(), kProfile);
    // A disc of a fifth of the picture's height, less its symbol.
    const double disc = 0.785 * 0.2 * 0.2 * shown.height_px * shown.height_px;
    EXPECT_GT(static_cast<double>(RedIn(lost)), 0.4 * disc) << name;
  }
}

}  // namespace
}  // namespace enamel::station::desk
