#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "common/base/bytes.h"
#include "common/math/vec.h"
#include "station/lab/devices/emulated_arm.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::testing_support {

// Angles of a Falcon's thighs with its tip there, rad and m in its own frame, by the formula of libnifalcon
// (FalconKinematicStamper.cpp), which the driver does not use.
dvec3 FalconAnglesAt(const dvec3& tip_m);

// Novint's Falcon behind libusb's double: loader, firmware, frames. At first its firmware runs, and the grip has been
// homed. Thread safety: all of it.
class EmulatedFalcon final : public lab::EmulatedArm {
 public:
  EmulatedFalcon();
  ~EmulatedFalcon() override;
  std::string choice() const override { return "falcon:" + firmware_file(); }
  const char* profile() const override { return "falcon"; }
  void Lower(int steps) override;
  size_t answer_bytes() const override { return 16; }
  void Unplug() override;
  void Plug() override { PlugAt("1-2"); }
  // No firmware runs, and it is not homed. A person homes it once it has power.
  void SwitchOff() override;
  void SwitchOn() override;
  bool PlugOther() override;

  std::string firmware_file() const { return (folder_.path() / "falcon.bin").string(); }
  // Echoes of so many uploads from now on have a wrong byte.
  void SpoilUploads(int uploads) { spoiled_ = uploads; }
  // Those that began.
  int uploads() const { return uploads_; }
  // The grip is in a person's hand, who pulls it out and pushes it in while the light is red.
  void SetHomed(bool homed) { homed_ = homed; }
  void HomeWhenRed(bool homes) { homes_ = homes; }
  int lights() const { return lights_; }
  // Tip, m, the device's own frame; as near as the counters can tell.
  void Set(const dvec3& tip_m);
  void SetCounts(const std::array<int, 3>& counts);
  std::array<int, 3> counts() const;
  void Press(int buttons) { buttons_ = buttons; }
  // Each answer comes in two packets.
  void InPieces(bool pieces) { pieces_ = pieces; }
  // From each answer the byte at this place is missing; below 0: none.
  void LoseByte(int at) { lose_ = at; }

 private:
  void PlugAt(const char* place);
  struct Said {
    enum Kind : uint8_t { kRequest, kBytes, kPower } kind;
    uint8_t request = 0;
    uint16_t value = 0;
    Bytes bytes;
  };
  void Say(Said said);
  void Run();
  void OnRequest(uint8_t request, uint16_t value);
  void OnBytes(ByteView bytes);
  void Load(uint8_t byte);
  void TakeFrame();
  void Send(ByteView bytes);

  const test::TempFolder folder_;
  Bytes firmware_;
  std::array<int, 3> counts_{};              // under mutex_
  std::atomic<const char*> place_{nullptr};  // a literal
  std::atomic<bool> is_powered_{true}, runs_{true}, homed_{true}, homes_{false}, pieces_{false};
  std::atomic<int> spoiled_{0}, uploads_{0}, lights_{0}, buttons_{0}, lose_{-1};
  // What the chip has not passed on yet.
  std::mutex inbox_mutex_;
  std::condition_variable came_;
  std::deque<Said> inbox_;
  bool stop_ = false;
  // Owned by the thread.
  int divisor_ = 0, latency_ms_ = 16;
  bool is_reset_ = false;  // by DTR, low and then high
  bool dtr_ = false, spoils_ = false;
  Bytes loaded_, frame_;
  enum class Loader { kAwaitsHail, kAwaitsBegin, kTakes } loader_ = Loader::kAwaitsHail;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace enamel::station::testing_support
