#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/language/words.h"
#include "station/hid/open_device.h"

namespace enamel::station::desk {

// A device offered to a person: mouse and keyboard unless another is named.
struct DeviceOffer {
  std::string title, detail;
  std::string profile;        // of the catalogue
  std::string operator_name;  // of a simulated hand
  std::string device, pedal;  // of an attached one, as hid::DeviceChoice and sdk name them
  std::string problem;        // why it cannot be used now, and what to do; empty if it can
  bool felt = false;          // it has motors, whether it can be used or not
};

// Devices available now, the most like a handpiece first: haptic boards (with the profile they
// name), devices of makers' libraries (with the profile of the model's name), 6-DoF mice, mouse and
// keyboard, and with `simulated` simulated hands for demonstrations. An attached pedal goes with
// every attached device; `choice.pedal` names one that is not recognised. Opens boards and makers'
// devices briefly to identify them, which may take some 10 ms each. Not during an attempt. Texts
// are in the language of `words`. Thread safety: any thread, one at a time.
std::vector<DeviceOffer> DeviceOffers(const language::Words& words, bool simulated,
                                      const hid::DeviceChoice& choice);

// Index of the first offer usable with this profile (empty: any), or offers.size().
size_t FirstUsable(const std::vector<DeviceOffer>& offers, const std::string& profile);

// The device that people should cut with here, and why it cannot be used, as a sentence.
struct MissingDevice {
  std::string title, reason;
};
// What a start with the offer `chosen` would fall back from: the station's own device, of this
// profile, or, where `profile` is empty, an attached one with motors. None: `chosen` is one, or one
// can be used and somebody chose another. `named`: the profile as people call it.
std::optional<MissingDevice> MissingFor(const language::Words& words,
                                        const std::vector<DeviceOffer>& offers, size_t chosen,
                                        const std::string& profile, const std::string& named);

}  // namespace enamel::station::desk
