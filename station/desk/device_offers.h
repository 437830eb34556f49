#pragma once

#include <string>
#include <vector>

#include "common/language/words.h"
#include "station/hid/open_device.h"

namespace enamel::station::desk {

// A device as it is offered to a person: mouse and keyboard unless one of the others is named.
struct DeviceOffer {
  std::string title, detail;
  std::string profile;        // of the catalogue
  std::string operator_name;  // of a simulated hand
  std::string device, pedal;  // of an attached one, as hid::DeviceChoice and sdk name them
  std::string problem;        // why it cannot be used now, and what to do; empty: it can
};

// What this station has now, what is most like a handpiece first: haptic boards (with the profile
// they name), what makers' libraries find (with the profile of its model's name), 6-DoF mice, mouse
// and keyboard, and with `simulated` simulated hands, for demonstrations. An attached pedal goes
// with every attached device; `choice.pedal` names one that is not recognised. Opens boards and
// makers' devices for a moment to ask what they are: may take some 10 ms each. Not while an attempt
// is made. Thread safety: any thread, one at a time. What is said of them is in the words' language.
std::vector<DeviceOffer> DeviceOffers(const language::Words& words, bool simulated,
                                      const hid::DeviceChoice& choice);

// The first that can be used with this profile (empty: with any), or offers.size().
size_t FirstUsable(const std::vector<DeviceOffer>& offers, const std::string& profile);

}  // namespace enamel::station::desk
