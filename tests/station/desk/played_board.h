#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "common/scene/cell.h"
#include "station/hid/haptic_report.h"
#include "tests/station/hid/hid_double.h"

namespace enamel::station::desk {

// A haptic board of this profile that reports its pose about a thousand times a second.
class PlayedBoard {
 public:
  PlayedBoard(const std::filesystem::path& node, const std::string& profile_name)
      : path_(node.string()) {
    std::ofstream(node) << "";  // who may read and write the file may use the device
    testing_support::ScriptedHid d;
    d.path = path_;
    d.vendor = 0x1209;
    d.product = 0x0001;
    d.usage_page = hid::kBoardUsagePage;
    d.usage = hid::kBoardUsage;
    hid::FeatureReport f;
    for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
      if (p.name != profile_name) continue;
      f.resolution_nm.fill(static_cast<uint32_t>(scene::CountNm(p)));
      f.peak_force_mn.fill(static_cast<uint32_t>(p.peak_force_mn.value));
    }
    f.rate_hz = 1000;
    f.max_watchdog_ms = 100;
    f.name = "Bench arm";
    f.profile = profile_name;
    auto bytes = hid::EncodeFeature(f);
    d.feature.assign(bytes.begin(), bytes.end());
    testing_support::HidBus::Get().Plug(d);
    player_ = std::thread([this] { Play(); });
  }
  ~PlayedBoard() {
    stop_ = true;
    player_.join();
  }

  std::atomic<uint8_t> buttons{0};       // bit 0 the pedal, bit 1 in its holder
  std::atomic<int32_t> right_counts{0};  // how far to the right of its middle the hand rests

 private:
  void Play() {
    hid::InputReport report;
    while (!stop_) {
      ++report.sequence;
      report.time_us += 1000;
      report.buttons = buttons;
      report.counts[0] = right_counts;
      testing_support::HidBus::Get().Send(path_, hid::EncodeInput(report));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  const std::string path_;
  std::atomic<bool> stop_{false};
  std::thread player_;
};

}  // namespace enamel::station::desk
