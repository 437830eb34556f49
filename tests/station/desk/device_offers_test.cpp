#include "station/desk/device_offers.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "station/hid/haptic_report.h"
#include "tests/station/desk/english.h"
#include "tests/station/hid/hid_double.h"
#include "tests/support/opens_with.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::desk {
namespace {

using testing_support::HidBus;
using testing_support::ScriptedHid;

// Devices are files here: a person who may read and write the file may use the device.
class DeviceOffersTest : public testing::Test {
 protected:
  void SetUp() override { HidBus::Get().Reset(); }
  void TearDown() override { HidBus::Get().Reset(); }
  ScriptedHid Device(const char* node, uint16_t vendor, uint16_t product) {
    ScriptedHid d;
    d.path = folder_ / node;
    d.vendor = vendor;
    d.product = product;
    std::ofstream(d.path) << "";
    return d;
  }
  ScriptedHid Board(const std::string& profile) {
    ScriptedHid d = Device("board", 0x1209, 0x0001);
    d.usage_page = hid::kBoardUsagePage;
    d.usage = hid::kBoardUsage;
    hid::FeatureReport f;
    f.resolution_nm.fill(10'000);
    f.peak_force_mn.fill(7'900);
    f.rate_hz = 1000;
    f.max_watchdog_ms = 100;
    f.name = "Bench arm";
    f.profile = profile;
    auto bytes = hid::EncodeFeature(f);
    d.feature.assign(bytes.begin(), bytes.end());
    return d;
  }
  test::TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
};

TEST_F(DeviceOffersTest, WithNothingAttachedThereIsMouseAndKeyboard) {
  auto offers = DeviceOffers(kEnglish, false, {});
  ASSERT_EQ(offers.size(), 1u);
  EXPECT_EQ(offers[0].profile, "pointer");
  EXPECT_EQ(offers[0].device, "");
  for (const language::Language each : language::kLanguages) {
    const auto simulated = DeviceOffers(language::Words(each), true, {});
    ASSERT_GT(simulated.size(), 1u);
    for (const DeviceOffer& offer : simulated) {
      EXPECT_EQ(offer.title.find("simulated_hand."), std::string::npos) << offer.title;
      EXPECT_EQ(offer.detail.find("simulated_hand."), std::string::npos) << offer.detail;
    }
  }
}

TEST_F(DeviceOffersTest, ABoardIsOfferedFirstWithItsProfileAndThePedalThatIsThere) {
  HidBus::Get().Plug(Device("pedal", 0x05f3, 0x00ff));
  HidBus::Get().Plug(Board("phantom_desktop"));
  auto offers = DeviceOffers(kEnglish, false, {});
  ASSERT_EQ(offers.size(), 2u);
  EXPECT_EQ(offers[0].title, "Bench arm");
  EXPECT_EQ(offers[0].device, "hid:1209:0001");
  EXPECT_EQ(offers[0].pedal, "05f3:00ff");
  EXPECT_EQ(offers[0].profile, "phantom_desktop");
  EXPECT_EQ(offers[0].problem, "");
  EXPECT_NE(offers[0].detail.find("7.9 N"), std::string::npos) << offers[0].detail;
  EXPECT_EQ(FirstUsable(offers, ""), 0u);
  EXPECT_EQ(FirstUsable(offers, "pointer"), 1u);
  EXPECT_EQ(FirstUsable(offers, "omega3"), offers.size());
}

TEST_F(DeviceOffersTest, WhatMayNotBeOpenedIsShownWithWhatToDoAndNotChosen) {
  HidBus::Get().Plug(Board("phantom_desktop"));
  const test::OpensWith call([](const char*, int) {
    errno = EACCES;
    return -1;
  });
  auto offers = DeviceOffers(kEnglish, false, {});
  ASSERT_EQ(offers.size(), 2u);
  EXPECT_EQ(offers[0].problem.find("This station may not use the device."), 0u)
      << offers[0].problem;
  const language::Words german(language::Language::kGerman);
  EXPECT_EQ(DeviceOffers(german, false, {})[0].problem.find("Diese Station darf das Gerät nicht"),
            0u);
  EXPECT_EQ(FirstUsable(offers, ""), 1u);
}

TEST_F(DeviceOffersTest, APedalThatMayNotBeOpenedIsSaidAndLeftOut) {
  const test::OpensWith call([](const char* path, int flags) {
    errno = EACCES;
    return std::string_view(path).ends_with("pedal") ? -1 : ::open(path, flags);
  });
  HidBus::Get().Plug(Device("pedal", 0x05f3, 0x00ff));
  HidBus::Get().Plug(Board("phantom_desktop"));
  auto offers = DeviceOffers(kEnglish, false, {});
  EXPECT_EQ(offers[0].pedal, "");
  EXPECT_EQ(offers[0].problem, "");
  EXPECT_NE(offers[0].detail.find("without the foot pedal"), std::string::npos) << offers[0].detail;
}

TEST_F(DeviceOffersTest, ABoardWithoutAProfileSaysHowToGetOne) {
  HidBus::Get().Plug(Board(""));
  auto offers = DeviceOffers(kEnglish, false, {});
  EXPECT_NE(offers[0].problem.find("calibrate"), std::string::npos) << offers[0].problem;
}

TEST_F(DeviceOffersTest, ASpaceMouseIsOfferedWithoutForceAndTheNamedPedal) {
  ScriptedHid mouse = Device("mouse", 0x256f, 0xc62e);
  mouse.usage_page = 1;
  mouse.usage = 8;
  mouse.name = L"SpaceMouse";
  HidBus::Get().Plug(mouse);
  hid::DeviceChoice choice;
  choice.pedal = "1a86:e026,id=1,byte=3,mask=ff";
  auto offers = DeviceOffers(kEnglish, false, choice);
  ASSERT_EQ(offers.size(), 2u);
  EXPECT_EQ(offers[0].title, "SpaceMouse");
  EXPECT_EQ(offers[0].device, "spacemouse:256f:c62e");
  EXPECT_EQ(offers[0].pedal, choice.pedal);
  EXPECT_EQ(offers[0].profile, "pointer");
}

TEST(MissingForTest, IsTheStationsDeviceOrOneWithMotorsThatCannotBeUsed) {
  const DeviceOffer mouse{"Mouse", "", "pointer", "", "", "", "", false};
  const DeviceOffer falcon{"Falcon", "", "falcon", "", "falcon", "", "", true};
  DeviceOffer broken{"Inverse3", "", "inverse3", "", "inverse3", "", "It is off.", true};
  const auto missing = [&](const std::vector<DeviceOffer>& offers, size_t chosen,
                           const std::string& profile) {
    const auto found = MissingFor(kEnglish, offers, chosen, profile, "Haply Inverse3");
    return found ? found->title + ": " + found->reason : std::string();
  };
  EXPECT_EQ(missing({mouse}, 0, ""), "") << "a chair with a mouse";
  EXPECT_EQ(missing({mouse}, 0, "pointer"), "");
  EXPECT_EQ(missing({broken, mouse}, 1, ""), "Inverse3: It is off.");
  EXPECT_EQ(missing({broken, mouse}, 1, "pointer"), "") << "the chair's own device is the mouse";
  EXPECT_EQ(missing({broken, falcon, mouse}, 1, ""), "") << "any with motors will do";
  EXPECT_EQ(missing({broken, falcon, mouse}, 1, "inverse3"), "Inverse3: It is off.");
  EXPECT_EQ(missing({falcon, mouse}, 1, ""), "") << "chosen on purpose";
  EXPECT_EQ(missing({falcon, mouse}, 1, "falcon"), "") << "chosen on purpose";
  EXPECT_EQ(missing({mouse}, 0, "inverse3").find("Haply Inverse3: The device is not connected."),
            0u);
  broken.profile = "";  // it does not say who it is
  EXPECT_EQ(missing({broken, mouse}, 1, "inverse3"), "Inverse3: It is off.");
  EXPECT_EQ(missing({}, 0, "inverse3"), "");
}

}  // namespace
}  // namespace enamel::station::desk
