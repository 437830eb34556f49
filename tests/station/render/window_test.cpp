#include "station/render/window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "common/cutting/cutter.h"
#include "station/render/panel.h"
#include "tests/station/render/virtual_display.h"

namespace enamel::station::render {
namespace {

const language::Words kEnglish(language::Language::kEnglish);

using cutting::Bur;
using cutting::BurShape;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;

// At 0.1 mm: 0.8 mm of enamel over dentin, pulp at the bottom.
template <typename Distance_mm>
Volume Shaped(Distance_mm&& distance_mm) {
  cutting::GridSpec spec{100'000, {12, 12, 6}, {-4'800'000, -4'800'000, -4'000'000}};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 first = ivec3(b % 12, b / 12 % 12, b / 144) * 8;
    std::array<int16_t, kBrickVoxels> phi;
    std::vector<uint8_t> labels(kBrickVoxels);
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      auto n = static_cast<int>(i);
      dvec3 p = spec.origin_m() * 1e3 + 0.1 * dvec3(first + ivec3(n & 7, n >> 3 & 7, n >> 6));
      phi[i] = static_cast<int16_t>(
          std::clamp(distance_mm(p) / 0.1 * cutting::kPhiPerVoxel, -32767.0, 32767.0));
      labels[i] = static_cast<uint8_t>(p.z > -0.8   ? Tissue::kEnamel
                                       : p.z > -2.6 ? Tissue::kDentin
                                                    : Tissue::kPulp);
    }
    volume.SetBrick(b, phi, labels, Tissue::kEnamel);
  }
  volume.Reserve();
  return volume;
}

// 8 x 8 x 3.2 mm, its top at z = 0.
Volume Slab() {
  return Shaped([](const dvec3& p) {
    dvec3 q = glm::abs(p - dvec3(0, 0, -1.6)) - dvec3(4, 4, 1.6);
    return std::max({q.x, q.y, q.z});
  });
}

// Of the same tissues, 4.4 mm thick.
Volume Ball() {
  return Shaped([](const dvec3& p) { return glm::length(p - dvec3(0, 0, -1.6)) - 2.2; });
}

// First row at the top.
struct Shot : Image {
  // Pixels outside the panel's corner for which `is(r, g, b)`.
  template <typename Is>
  int Count(Is&& is) const {
    int count = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if ((x < 340 && y < 330) || y > height - 45) continue;
        const uint8_t* p = &rgb[(static_cast<size_t>(y) * width + x) * 3];
        count += is(int{p[0]}, int{p[1]}, int{p[2]});
      }
    }
    return count;
  }
};

Shot ReadShot(const std::string& path) {
  auto image = ReadPng(path);
  if (!image.ok()) return {};
  Shot out{std::move(*image)};
  const auto row = static_cast<std::ptrdiff_t>(out.width) * 3;
  for (int y = 0; y < out.height / 2; ++y) {
    const auto low = out.rgb.begin() + y * row, high = out.rgb.end() - (y + 1) * row;
    std::swap_ranges(low, low + row, high);
  }
  return out;
}

bool IsIvory(int r, int g, int b) { return r > 130 && r >= g && g > b && r - b > 8 && r - b < 62; }
bool IsDentin(int r, int g, int b) { return r > 60 && g > b && 100 * (r - b) > 42 * r; }
bool IsSteel(int r, int g, int b) { return b > r + 14 && b > 80 && g < b; }
bool IsArrow(int r, int g, int b) { return g > r + 50 && b > r + 40 && g > 90; }

class WindowTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { display_ = new VirtualDisplay; }
  static void TearDownTestSuite() {
    delete display_;
    display_ = nullptr;
  }
  void SetUp() override {
    if (!display_->ok()) GTEST_SKIP() << "skipped: Xvfb is not installed";
    std::string pattern = std::filesystem::temp_directory_path() / "enamel-render-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  std::string File(const char* name) const { return folder_ / name; }
  Shot Screenshot(Window& window) {
    Status status = window.WriteScreenshot(File("picture.png"));
    EXPECT_TRUE(status.ok()) << status.message();
    return ReadShot(File("picture.png"));
  }

  static VirtualDisplay* display_;
  std::filesystem::path folder_;
};
VirtualDisplay* WindowTest::display_ = nullptr;

const Bur kBur{BurShape::kCylinder, 0.6e-3, 3e-3};

WindowOptions Options() {
  WindowOptions options;
  options.screen.width_px = 900;
  options.screen.height_px = 640;
  options.view.burs = {kBur};
  options.view.focus_m = {0, 0, -1e-3};
  return options;
}

// Cuts a slot 1.6 mm deep, publishing every step as the tick would.
FrameState CutSlot(Volume& volume, Window& window) {
  cutting::Cutter cutter(volume, kBur);
  cutting::RemovedUnits removed{};
  FrameState state;
  for (int i = 0; i <= 80; ++i) {
    state.tick = static_cast<uint64_t>(i);
    state.time_s = i * 0.5;
    state.anchor.tip_m = dvec3(-2e-3 + 0.05e-3 * i, 0, -1.6e-3);
    state.device = state.anchor;
    EXPECT_TRUE(cutter.Cut(state.anchor, removed));
    window.tooth().PublishBricks(volume, cutter.touched());
    for (size_t t = 0; t < removed.size(); ++t)
      state.removed_mm3[t] = cutting::RemovedUnitsToM3(removed[t], 1e-4) * 1e9;
    window.tooth().Publish(state);
  }
  return state;
}

TEST_F(WindowTest, ShowsToothThenCavityAndBur) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  Window& window = **created;

  Shot whole = Screenshot(window);
  ASSERT_EQ(whole.width, 900);
  ASSERT_EQ(whole.height, 640);
  int pixels = whole.width * whole.height;
  EXPECT_GT(whole.Count(IsIvory), pixels / 10);
  EXPECT_LT(whole.Count(IsSteel), pixels / 2000);

  FrameState state = CutSlot(volume, window);
  window.tooth().FlushBricks(volume);
  Shot cut = Screenshot(window);
  EXPECT_GT(cut.Count(IsSteel), pixels / 100);
  EXPECT_GT(cut.Count(IsDentin), whole.Count(IsDentin) + pixels / 500);
  EXPECT_LT(cut.Count(IsArrow), pixels / 5000);

  state.pressed_n = {0, 0, 2};
  window.tooth().Publish(state);
  EXPECT_GT(Screenshot(window).Count(IsArrow), pixels / 2000);
}

TEST_F(WindowTest, ShowsAGhostWhereTheHandIsWhenItLeavesTheBur) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  Window& window = **created;
  FrameState state;
  state.anchor.tip_m = state.device.tip_m = {0, 0, 0.5e-3};
  window.tooth().Publish(state);
  int together = Screenshot(window).Count(IsSteel);
  state.device.tip_m.x += 2.5e-3;
  window.tooth().Publish(state);
  EXPECT_GT(Screenshot(window).Count(IsSteel), together + together / 4);
}

TEST(PanelTest, AKeyAndWhatItDoesStayInOneLineOfTheHint) {
  EXPECT_EQ(Unbroken("M: mirror   Ctrl + mouse: move  "),
            "M:\u00a0mirror   Ctrl\u00a0+\u00a0mouse:\u00a0move  ");
}

TEST(PanelTest, WhileNothingIsStoredNoProgressIsShown) {
  PanelContent content;
  content.state.time_s = 12;
  content.state.removed_mm3[1] = 3;
  content.zones = ZoneShares{40, 10, 0, 0};
  content.reach.pulp_mm = 1.2;
  HideProgress(content);
  EXPECT_FALSE(content.recorded);
  EXPECT_FALSE(content.zones);
  EXPECT_FALSE(content.reach.pulp_mm);
  EXPECT_EQ(content.state.removed_mm3[1], 0);
  EXPECT_EQ(content.state.time_s, 12) << "time goes on";
}

// Between its neighbours a tooth was a sixth of the picture's width.
TEST_F(WindowTest, ThePictureIsAsWideAsTheToothWithoutItsNeighbours) {
  const cutting::GridSpec spec{100'000, {12, 12, 6}, {-4'800'000, -4'800'000, -4'000'000}};
  Volume volume(spec);
  std::array<int16_t, kBrickVoxels> phi;
  phi.fill(-1);
  for (int x = 0; x < 12; ++x) {
    const bool own = x >= 4 && x < 8;
    volume.SetBrick(spec.BrickIndex({x, 5, 3}), phi, {},
                    own ? Tissue::kEnamel : Tissue::kNeighbour);
  }
  volume.Reserve();
  WindowOptions options = Options();
  options.view.view_radius_m = 0;
  auto created = Window::Create(options, volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  EXPECT_NEAR((*created)->tooth().camera().radius_mm(), 0.62 * 4 * 8 * 0.1, 1e-4);
}

// The tooth is redrawn only where it has changed: the picture must be identical.
TEST_F(WindowTest, DrawnPieceByPieceIsDrawnAsAWhole) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  Window& window = **created;
  Screenshot(window);
  CutSlot(volume, window);
  window.tooth().FlushBricks(volume);
  Shot pieces = Screenshot(window);
  ASSERT_FALSE(window.tooth().work().whole);
  EXPECT_LT(window.tooth().work().triangles_drawn, window.tooth().work().triangles);
  window.tooth().camera().SetView(View::kBuccal);
  Screenshot(window);
  window.tooth().camera().SetView(View::kOblique);
  Shot whole = Screenshot(window);
  ASSERT_EQ(pieces.rgb.size(), whole.rgb.size());
  int differ = 0;
  for (size_t i = 0; i < whole.rgb.size(); ++i)
    differ += std::abs(pieces.rgb[i] - whole.rgb[i]) > 2;
  EXPECT_EQ(differ, 0);
}

// Drawn as in an attempt without a graphics card, without the panel.
class TurningTest : public WindowTest {
 protected:
  Shot Draw(Screen& screen, ToothView& view, const Quality& quality, int pictures = 1) {
    for (int i = 0; i < pictures; ++i) {
      screen.Begin();
      view.Draw(screen.width(), screen.height(), quality);
      screen.Show(view.result());
      screen.End();
    }
    EXPECT_TRUE(screen.WriteScreenshot(File("turning.png")).ok());
    return ReadShot(File("turning.png"));
  }
  // Pixels that are tooth in `shown`, among those inside the tooth's outline in `outline`.
  static int InsideTooth(const Shot& outline, const Shot& shown) {
    auto is_tooth = [](const Shot& image, int x, int y) {
      const uint8_t* p = &image.rgb[(static_cast<size_t>(y) * image.width + x) * 3];
      return p[0] > p[2];  // it is warm, and what is behind it is not
    };
    int count = 0;
    for (int y = 2; y < outline.height - 2; ++y) {
      for (int x = 2; x < outline.width - 2; ++x) {
        bool inside = true;
        for (int i = 0; i < 25 && inside; ++i) {
          inside = is_tooth(outline, x + i % 5 - 2, y + i / 5 - 2);
        }
        count += inside && is_tooth(shown, x, y);
      }
    }
    return count;
  }
  static ScreenOptions Plain() {
    ScreenOptions options;
    options.width_px = 900;
    options.height_px = 640;
    options.paced = false;
    return options;
  }
};

TEST_F(TurningTest, WhileTheCameraTurnsFewerTrianglesShowTheSameToothAndAtRestAllOfThem) {
  const Quality& quality = *FindQuality("good");
  Screen screen(Plain());
  ToothView view(Options().view, Ball());
  ASSERT_TRUE(view.WaitIdle(std::chrono::seconds(30)));
  Draw(screen, view, quality);
  EXPECT_FALSE(view.work().coarse);
  size_t all = view.work().triangles_drawn;

  view.camera().Orbit(0.02f, 0);
  Shot turning = Draw(screen, view, quality);
  EXPECT_TRUE(view.work().coarse);
  EXPECT_LT(view.work().triangles_drawn, all * 3 / 4);
  Shot rest = Draw(screen, view, quality, Picture::kStillPictures);
  EXPECT_FALSE(view.work().coarse);
  ASSERT_EQ(turning.rgb.size(), rest.rgb.size());
  int differ = 0;
  for (size_t i = 0; i < rest.rgb.size(); i += 3) {
    differ += std::abs(turning.rgb[i] - rest.rgb[i]) > 24;
  }
  EXPECT_LT(differ, rest.width * rest.height / 200);
  EXPECT_GT(InsideTooth(rest, rest), rest.width * rest.height / 20);
  EXPECT_EQ(InsideTooth(rest, turning), InsideTooth(rest, rest));

  // No trace of the turn is left in the picture.
  view.camera().Orbit(-0.02f, 0);
  Draw(screen, view, quality);
  view.camera().Orbit(0.02f, 0);
  EXPECT_EQ(Draw(screen, view, quality, 1 + Picture::kStillPictures).rgb, rest.rgb);
}

TEST_F(TurningTest, WhatIsCutWhileTheCameraTurnsIsWholeOnceItRests) {
  const Quality& quality = *FindQuality("good");
  Screen screen(Plain());
  Volume volume = Slab();
  ToothView view(Options().view, volume);
  ASSERT_TRUE(view.WaitIdle(std::chrono::seconds(30)));
  Draw(screen, view, quality);
  cutting::Cutter cutter(volume, kBur);
  cutting::RemovedUnits removed{};
  cutting::Pose pose;
  for (int i = 0; i <= 40; ++i) {
    pose.tip_m = {-1e-3 + 0.05e-3 * i, 0, -1e-3};
    cutter.Cut(pose, removed);
    view.PublishBricks(volume, cutter.touched());
    view.camera().Orbit(0.002f, 0);
    if (i % 8 == 0) Draw(screen, view, quality);
  }
  view.FlushBricks(volume);
  Shot after = Draw(screen, view, quality, 1 + Picture::kStillPictures);
  // The same tooth, not seen before.
  ToothView anew(Options().view, volume);
  anew.camera() = view.camera();
  ASSERT_TRUE(anew.WaitIdle(std::chrono::seconds(30)));
  Shot fresh = Draw(screen, anew, quality);
  int differ = 0;
  for (size_t i = 0; i < fresh.rgb.size(); ++i) {
    differ += std::abs(after.rgb[i] - fresh.rgb[i]) > 24;
  }
  // To the new view nothing was cut, so it has fewer triangles there.
  EXPECT_LT(differ, fresh.width * fresh.height / 200);
}

TEST_F(TurningTest, ChipsFlyWhileSomethingIsRemovedAndLeaveNoTrace) {
  const Quality& quality = *FindQuality("good");
  Screen screen(Plain());
  ToothView view(Options().view, Slab());
  ASSERT_TRUE(view.WaitIdle(std::chrono::seconds(30)));
  FrameState state;
  state.removed_mm3.fill(3);  // before this window opened
  auto drawn = [&](double dentin_mm3) {
    state.time_s += 0.05;
    state.removed_mm3[static_cast<size_t>(Tissue::kDentin)] += dentin_mm3;
    view.Publish(state);
    return Draw(screen, view, quality);
  };
  const Shot before = drawn(0);
  EXPECT_EQ(drawn(0).rgb, before.rgb);
  const Shot cutting = drawn(0.2);
  EXPECT_GT(cutting.Count(IsDentin), before.Count(IsDentin) + 100);
  for (double age_s = 0; age_s < static_cast<double>(Chips::kLongest_s); age_s += 0.05) drawn(0);
  EXPECT_EQ(drawn(0).rgb, before.rgb);
}

TEST_F(WindowTest, TheBurThrowsAShadowOnTheToothBelow) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  Window& window = **created;
  Shot alone = Screenshot(window);
  FrameState state;
  state.anchor.tip_m = state.device.tip_m = {0, 0, 0.4e-3};
  window.tooth().Publish(state);
  Shot with = Screenshot(window);
  // Ivory that is darker than it was: shadow, not bur.
  int darker = 0;
  for (size_t i = 0; i < alone.rgb.size(); i += 3) {
    bool ivory = with.rgb[i] > with.rgb[i + 2] + 10;
    darker += ivory && with.rgb[i] + 25 < alone.rgb[i];
  }
  EXPECT_GT(darker, alone.width * alone.height / 1000);
}

TEST_F(WindowTest, CapitalsThatMustBeReadFromTwoMetresAreTwelveMillimetres) {
  WindowOptions options = Options();
  options.screen.width_px = 1520;
  options.screen.height_px = 900;
  auto created = Window::Create(options, Slab());
  ASSERT_TRUE(created.ok()) << created.status().message();
  const Fonts& fonts = (*created)->screen().fonts();
  double pixel_mm = kReferencePixel_mm * kReferenceHeight_px / 900;  // the same 24-inch screen
  EXPECT_GE(CapitalHeight_px(*fonts.far) * pixel_mm, kFarCapital_mm);
  EXPECT_LE(CapitalHeight_px(*fonts.far) * pixel_mm, kFarCapital_mm + 1);
  EXPECT_GT(CapitalHeight_px(*fonts.score), 2 * CapitalHeight_px(*fonts.far));

  // And as drawn: the timer's white digits are as high as capitals in DejaVu.
  FrameState state;
  state.time_s = 11;
  (*created)->tooth().Publish(state);
  Shot image = Screenshot(**created);
  int first = image.height, last = 0;
  for (int y = 60; y < 160; ++y) {
    for (int x = 30; x < 330; ++x) {
      const uint8_t* p = &image.rgb[(static_cast<size_t>(y) * image.width + x) * 3];
      if (p[0] < 200 || p[1] < 200 || p[2] < 200) continue;
      first = std::min(first, y);
      last = std::max(last, y);
    }
  }
  EXPECT_GE((last - first + 1) * pixel_mm, kFarCapital_mm - pixel_mm);
}

TEST_F(WindowTest, EveryViewShowsTheToothAndViewsDiffer) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  std::vector<std::vector<uint8_t>> pictures;
  for (View view : {View::kOcclusal, View::kBuccal, View::kMesial, View::kOblique}) {
    (*created)->tooth().camera().SetView(view);
    Shot image = Screenshot(**created);
    EXPECT_GT(image.Count([](int r, int g, int b) { return r > b + 8 && g > b; }),
              image.width * image.height / 20);
    for (const auto& other : pictures) EXPECT_NE(image.rgb, other);
    pictures.push_back(image.rgb);
  }
}

TEST_F(WindowTest, ProducerNeverWaitsWhileTheWindowIsNotPumped) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  std::thread producer([&] { CutSlot(volume, **created); });
  producer.join();  // Without a single frame drawn.
  (*created)->tooth().FlushBricks(volume);
  int frames = 0;
  (*created)->Run([&] { return ++frames > 3; });
  EXPECT_EQ(frames, 4);
}

TEST_F(WindowTest, SaysWhereAScreenshotCannotBeWritten) {
  auto created = Window::Create(Options(), Slab());
  ASSERT_TRUE(created.ok()) << created.status().message();
  Status status = (*created)->WriteScreenshot(File("missing/picture.png"));
  EXPECT_EQ(status.code(), Code::kStorage);
  EXPECT_NE(status.message().find("missing/picture.png"), std::string::npos);
}

TEST_F(WindowTest, SaysWhatToDoWithoutADisplay) {
  std::string display = std::getenv("DISPLAY");
  setenv("DISPLAY", ":4095", 1);
  auto created = Window::Create(Options(), Slab());
  setenv("DISPLAY", display.c_str(), 1);
  ASSERT_FALSE(created.ok());
  EXPECT_EQ(created.status().code(), Code::kUnavailable);
  EXPECT_NE(created.status().message().find("--window"), std::string::npos);
}

// For any direction and distance: this far right of the middle, in picture heights.
TEST(CameraTest, WhatIsTurnedStaysAsideOfThePanel) {
  glm::vec3 focus(1, -2, 3);
  constexpr float kAspect = 16.0f / 9;
  Camera camera(focus, 7, 0.16f);
  for (int i = 0; i < 20; ++i) {
    glm::vec4 at = camera.ClipFromView(kAspect) * camera.ViewFromScene() * glm::vec4(focus, 1);
    EXPECT_NEAR(0.5f * kAspect * at.x / at.w, 0.16f, 1e-4f);
    EXPECT_NEAR(at.y / at.w, 0, 1e-4f);
    camera.Orbit(0.07f, 0.01f);
    camera.Zoom(i % 3 == 0 ? 2.0f : -1.0f);
  }
}

TEST(PanelTextTest, TimerReadsAsMinutesAndSeconds) {
  EXPECT_EQ(TimerText(0), "0:00");
  EXPECT_EQ(TimerText(187.9), "3:07");
  EXPECT_EQ(TimerText(3723), "1:02:03");
  EXPECT_EQ(TimerText(-5), "0:00");
}

TEST(PanelTextTest, EveryWarningHasASentence) {
  EXPECT_EQ(WarningText(kEnglish, 0), "");
  for (uint32_t bit = kWarnForceBounded; bit < 1u << kWarningCount; bit <<= 1)
    EXPECT_NE(WarningText(kEnglish, bit), "");
  EXPECT_EQ(WarningText(kEnglish, kWarnLate | kWarnPulpExposed),
            "Force is uneven: computer too busy\nPulp exposed");
}

TEST(PanelTextTest, NobodyIsToldThatRecordingContinuesWhileNothingIsStored) {
  EXPECT_EQ(WarningText(kEnglish, kWarnOffline | kWarnDisk), WarningText(kEnglish, kWarnDisk));
}

// Relative luminance (WCAG 2.1) of an sRGB colour.
double Luminance(const std::array<float, 3>& srgb) {
  auto linear = [](double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(srgb[0]) + 0.7152 * linear(srgb[1]) + 0.0722 * linear(srgb[2]);
}
double Contrast(double a, double b) { return (std::max(a, b) + 0.05) / (std::min(a, b) + 0.05); }

TEST(PanelTextTest, BarsCanBeToldApartByBrightnessAlone) {
  constexpr Bearing kAll[] = {Bearing::kGood, Bearing::kCareful, Bearing::kBad};
  double ground = Luminance({15 / 255.0f, 17 / 255.0f, 20 / 255.0f});
  for (Bearing a : kAll) {
    EXPECT_GE(Contrast(Luminance(ColourOf(a)), ground), 3);
    for (Bearing b : kAll) {
      if (a == b) continue;
      EXPECT_GE(Contrast(Luminance(ColourOf(a)), Luminance(ColourOf(b))), 1.5);
    }
  }
}

TEST(PanelTextTest, BarsTurnBeforeItIsTooLate) {
  EXPECT_EQ(BearingOf({0.25, 0.25, ""}), Bearing::kGood);
  EXPECT_EQ(BearingOf({0.1, 0.25, "floor"}), Bearing::kCareful);
  EXPECT_EQ(BearingOf({-0.01, 0.25, "floor"}), Bearing::kBad);
  EXPECT_EQ(BearingOfPulp(1.5), Bearing::kGood);
  EXPECT_EQ(BearingOfPulp(0.8), Bearing::kCareful);
  EXPECT_EQ(BearingOfPulp(0.4), Bearing::kBad);
}

TEST(PanelTextTest, AFaultInWordsStandsInPlaceOfTheWarningsThatSayLess) {
  PanelContent content;
  content.state.warnings = kWarnFault | kWarnDevice | kWarnPulpExposed;
  EXPECT_EQ(WarningText(kEnglish, content),
            WarningText(kEnglish, kWarnFault | kWarnDevice | kWarnPulpExposed));
  content.fault = "Force is off: plug the device in";
  EXPECT_EQ(WarningText(kEnglish, content), "Force is off: plug the device in\nPulp exposed");
  content.state.warnings = kWarnFault;
  EXPECT_EQ(WarningText(kEnglish, content), "Force is off: plug the device in");
}

}  // namespace
}  // namespace enamel::station::render
