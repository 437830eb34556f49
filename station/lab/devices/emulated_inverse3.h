#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/bytes.h"
#include "common/math/vec.h"
#include "station/lab/devices/emulated_arm.h"

namespace enamel::station::lab {

// The maker's service with one Inverse3 and a grip, on a TCP port of this computer, any number of
// sessions at a time. Thread safety: all of it.
class EmulatedInverse3 final : public EmulatedArm {
 public:
  EmulatedInverse3();
  ~EmulatedInverse3() override;
  std::string choice() const override { return "inverse3:" + address(); }
  const char* profile() const override { return "inverse3"; }
  void Lower(int steps) override;
  // About: the coordinates' digits differ.
  size_t answer_bytes() const override { return 400; }
  // The service ends: its sessions and its port are closed. It begins again with the same port.
  void Unplug() override;
  void Plug() override;
  void SwitchOff() override { Status("power_supply", false); }
  void SwitchOn() override { Status("power_supply", true); }
  bool PlugOther() override;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // Tip, m.
  void Set(const dvec3& tip_m);
  // The grip's quaternion x, y, z, w and its button; wireless: as the wireless grip writes them.
  void Grip(const std::array<double, 4>& xyzw, bool button, bool wireless);
  // Connects a grip to the service, or disconnects it.
  void HasGrip(bool has);
  // The grip is one that somebody built: the service lists it as custom_verse_grip.
  void HasBuiltGrip();
  // Sets its config.type: "inverse3", "minverse".
  void IsOf(const std::string& type);
  // Sessions from now on get these bytes again and again in place of messages.
  void Babble(const Bytes& bytes);
  // The one form of a force that this version of the service takes: "vector" or "values".
  void Take(const std::string& form);
  // What the status says of `member` ("calibrated", "power_supply", "ready") from now on.
  void Status(const std::string& member, bool value);
  // The service's filters.damping.scalar.
  void Damp(double scalar);
  // From now on messages are of another session, as after a restart.
  void Restart();
  // Answers from now on are text that is no JSON.
  void Truncate(bool truncate);
  // The service lists another Inverse3, which nobody commands, before this one.
  void ListOtherFirst();
  // No device is connected to the service.
  void Disconnect();

 private:
  struct Service;
  std::unique_ptr<Service> service_;
  uint16_t port_ = 0;
};

}  // namespace enamel::station::lab
