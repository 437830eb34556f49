#include "station/render/window.h"

#include <gtest/gtest.h>
#include <png.h>

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

using cutting::Bur;
using cutting::BurShape;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;

// A slab of 8 x 8 x 3.2 mm at 0.1 mm: 0.8 mm of enamel over dentin, pulp at the bottom. Its top is
// at z = 0.
Volume Slab() {
  cutting::GridSpec spec{100'000, {12, 12, 6}, {-4'800'000, -4'800'000, -4'000'000}};
  Volume volume(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    ivec3 first = ivec3(b % 12, b / 12 % 12, b / 144) * 8;
    std::array<int16_t, kBrickVoxels> phi;
    std::vector<uint8_t> labels(kBrickVoxels);
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      auto n = static_cast<int>(i);
      dvec3 p = spec.origin_m() * 1e3 + 0.1 * dvec3(first + ivec3(n & 7, n >> 3 & 7, n >> 6));
      dvec3 q = glm::abs(p - dvec3(0, 0, -1.6)) - dvec3(4, 4, 1.6);
      double d_mm = std::max({q.x, q.y, q.z});
      phi[i] =
          static_cast<int16_t>(std::clamp(d_mm / 0.1 * cutting::kPhiPerVoxel, -32767.0, 32767.0));
      labels[i] = static_cast<uint8_t>(p.z > -0.8   ? Tissue::kEnamel
                                       : p.z > -2.6 ? Tissue::kDentin
                                                    : Tissue::kPulp);
    }
    volume.SetBrick(b, phi, labels, Tissue::kEnamel);
  }
  volume.Reserve();
  return volume;
}

struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;

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

Image ReadPng(const std::string& path) {
  Image out;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&image, path.c_str())) return out;
  image.format = PNG_FORMAT_RGB;
  out.width = static_cast<int>(image.width);
  out.height = static_cast<int>(image.height);
  out.rgb.resize(PNG_IMAGE_SIZE(image));
  png_image_finish_read(&image, nullptr, out.rgb.data(), 0, nullptr);
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
  Image Screenshot(Window& window) {
    Status status = window.WriteScreenshot(File("picture.png"));
    EXPECT_TRUE(status.ok()) << status.message();
    return ReadPng(File("picture.png"));
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
  options.view.bur = kBur;
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

  Image whole = Screenshot(window);
  ASSERT_EQ(whole.width, 900);
  ASSERT_EQ(whole.height, 640);
  int pixels = whole.width * whole.height;
  EXPECT_GT(whole.Count(IsIvory), pixels / 10);
  EXPECT_LT(whole.Count(IsSteel), pixels / 2000);

  FrameState state = CutSlot(volume, window);
  window.tooth().FlushBricks(volume);
  Image cut = Screenshot(window);
  EXPECT_GT(cut.Count(IsSteel), pixels / 100);
  EXPECT_GT(cut.Count(IsDentin), whole.Count(IsDentin) + pixels / 500);
  EXPECT_LT(cut.Count(IsArrow), pixels / 5000);

  state.force_sent_n = {0, 0, 2};
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

// The tooth is drawn anew only where it has changed: the picture must not tell.
TEST_F(WindowTest, DrawnPieceByPieceIsDrawnAsAWhole) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  Window& window = **created;
  Screenshot(window);
  CutSlot(volume, window);
  window.tooth().FlushBricks(volume);
  Image pieces = Screenshot(window);
  ASSERT_FALSE(window.tooth().work().whole);
  EXPECT_LT(window.tooth().work().triangles_drawn, window.tooth().work().triangles);
  window.tooth().camera().SetView(View::kBuccal);
  Screenshot(window);
  window.tooth().camera().SetView(View::kOblique);
  Image whole = Screenshot(window);
  ASSERT_EQ(pieces.rgb.size(), whole.rgb.size());
  int differ = 0;
  for (size_t i = 0; i < whole.rgb.size(); ++i)
    differ += std::abs(pieces.rgb[i] - whole.rgb[i]) > 2;
  EXPECT_EQ(differ, 0);
}

TEST_F(WindowTest, TheBurThrowsAShadowOnTheToothBelow) {
  Volume volume = Slab();
  auto created = Window::Create(Options(), volume);
  ASSERT_TRUE(created.ok()) << created.status().message();
  Window& window = **created;
  Image alone = Screenshot(window);
  FrameState state;
  state.anchor.tip_m = state.device.tip_m = {0, 0, 0.4e-3};
  window.tooth().Publish(state);
  Image with = Screenshot(window);
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
  Image image = Screenshot(**created);
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
    Image image = Screenshot(**created);
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

TEST(PanelTextTest, TimerReadsAsMinutesAndSeconds) {
  EXPECT_EQ(TimerText(0), "0:00");
  EXPECT_EQ(TimerText(187.9), "3:07");
  EXPECT_EQ(TimerText(3723), "1:02:03");
  EXPECT_EQ(TimerText(-5), "0:00");
}

TEST(PanelTextTest, EveryWarningHasASentence) {
  EXPECT_EQ(WarningText(0), "");
  for (uint32_t bit = kWarnForceBounded; bit < 1u << kWarningCount; bit <<= 1)
    EXPECT_NE(WarningText(bit), "");
  EXPECT_EQ(WarningText(kWarnLate | kWarnPulpExposed),
            "Force is uneven: computer too busy\nPulp exposed");
}

TEST(PanelTextTest, AFaultInWordsStandsInPlaceOfTheWarningsThatSayLess) {
  PanelContent content;
  content.state.warnings = kWarnFault | kWarnDevice | kWarnPulpExposed;
  EXPECT_EQ(WarningText(content), WarningText(kWarnFault | kWarnDevice | kWarnPulpExposed));
  content.fault = "Force is off: plug the device in";
  EXPECT_EQ(WarningText(content), "Force is off: plug the device in\nPulp exposed");
  content.state.warnings = kWarnFault;
  EXPECT_EQ(WarningText(content), "Force is off: plug the device in");
}

}  // namespace
}  // namespace enamel::station::render
