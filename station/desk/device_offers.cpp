#include "station/desk/device_offers.h"

#include <algorithm>
#include <cstdio>

#include "station/desk/problem_words.h"
#include "station/devices/operators.h"
#include "station/devices/trouble.h"
#include "station/sdk/open_sdk_device.h"

namespace enamel::station::desk {
namespace {

using language::Words;

using hid::HidInfo;
using hid::HidKind;

struct Pedal {
  std::string choice;  // empty: none can be used
  std::string words;
};

Pedal FindPedal(const Words& words, const std::vector<HidInfo>& attached,
                const hid::DeviceChoice& choice) {
  if (!choice.pedal.empty()) {
    return {choice.pedal, words.Say("device.pedal_named", {{"pedal", choice.pedal}})};
  }
  for (const HidInfo& info : attached) {
    if (hid::Recognise(info) != HidKind::kFootPedal) continue;
    // The device is not at fault: it has a button of its own, so it is still offered.
    if (const Status refused = hid::WhyNotUsable(info); !refused.ok()) {
      return {"", words.Say("device.pedal_refused", {{"reason", ProblemText(words, refused)}})};
    }
    return {hid::DeviceNameOf(info), words.Say("device.pedal")};
  }
  return {"", words.Say("device.button")};
}

std::string BoardText(const Words& words, const hid::FeatureReport& board) {
  return words.Say("device.felt", {{"force", words.Decimal(board.peak_force_mn[0] * 1e-3, 1)},
                                   {"cells", words.Decimal(board.resolution_nm[0] * 1e-6, 3)}});
}

void AskBoard(const Words& words, const HidInfo& info, DeviceOffer& offer) {
  auto board = hid::AskBoard(info);
  if (!board.ok()) {
    offer.problem = ProblemText(words, board.status());
    return;
  }
  // The board's own name: a bus name means nothing to a person.
  if (!board->name.empty()) offer.title = board->name;
  offer.profile = board->profile;
  offer.detail = BoardText(words, *board);
  if (board->profile.empty()) {
    offer.problem = words.Say("device.no_profile");
  }
}

DeviceOffer AttachedOffer(const Words& words, const HidInfo& info, const Pedal& pedal) {
  bool board = hid::Recognise(info) == HidKind::kHapticBoard;
  DeviceOffer offer;
  offer.title = info.name.empty() ? hid::HidKindText(hid::Recognise(info)) : info.name;
  offer.device = hid::DeviceNameOf(info);
  offer.pedal = pedal.choice;
  offer.felt = board;
  if (const Status refused = hid::WhyNotUsable(info); !refused.ok()) {
    offer.problem = ProblemText(words, refused);
  }
  if (!board) {
    offer.profile = "pointer";
    offer.detail = words.Say("device.shown");
  } else if (offer.problem.empty()) {
    AskBoard(words, info, offer);
  }
  if (offer.problem.empty()) {
    offer.detail =
        words.Say("device.with_pedal", {{"device", offer.detail}, {"pedal", pedal.words}});
  }
  return offer;
}

DeviceOffer SdkOffer(const Words& words, const sdk::SdkDevice& found, const Pedal& pedal) {
  DeviceOffer offer;
  offer.title = found.name;
  offer.device = found.choice;
  offer.profile = found.profile;
  offer.felt = true;
  offer.pedal = pedal.choice;
  const bool is_borne = found.problem.field() == trouble::kNoGrip && !pedal.choice.empty();
  if (!found.problem.ok() && !is_borne) offer.problem = ProblemText(words, found.problem);
  offer.detail = words.Say("device.with_pedal",
                           {{"device", words.Say("device.by_library", {{"library", found.choice}})},
                            {"pedal", pedal.words}});
  return offer;
}

}  // namespace

std::vector<DeviceOffer> DeviceOffers(const language::Words& words, bool simulated,
                                      const hid::DeviceChoice& choice) {
  const std::vector<HidInfo> attached = hid::ListHid();
  const Pedal pedal = FindPedal(words, attached, choice);
  std::vector<DeviceOffer> offers;
  auto add = [&](HidKind kind) {
    for (const HidInfo& info : attached) {
      if (hid::Recognise(info) == kind) offers.push_back(AttachedOffer(words, info, pedal));
    }
  };
  // In order of preference: force that can be felt first, a mouse if there is nothing else.
  // FirstUsable takes the first that fits.
  add(HidKind::kHapticBoard);
  for (const sdk::SdkDevice& found : sdk::ListSdkDevices()) {
    offers.push_back(SdkOffer(words, found, pedal));
  }
  add(HidKind::kSpaceMouse);
  offers.push_back(
      // Always there, so that the list is never empty.
      {words.Say("device.mouse"), words.Say("device.mouse_detail"), "pointer", {}, {}, {}, {}});
  // Simulated hands are for tests and demonstrations: nobody should practise by watching.
  if (!simulated) return offers;
  for (const OperatorPreset& preset : OperatorPresets()) {
    if (!preset.offered) continue;
    std::string key = "simulated_hand." + std::string(preset.name);
    std::ranges::replace(key, '-', '_');
    offers.push_back({words.Say(key),
                      words.Say(key + "_detail"),
                      "phantom_desktop",
                      std::string(preset.name),
                      {},
                      {},
                      {}});
  }
  return offers;
}

size_t FirstUsable(const std::vector<DeviceOffer>& offers, const std::string& profile) {
  auto fits = [&](const DeviceOffer& o) {
    return o.problem.empty() && (profile.empty() || o.profile == profile);
  };
  return static_cast<size_t>(std::ranges::find_if(offers, fits) - offers.begin());
}

std::optional<MissingDevice> MissingFor(const language::Words& words,
                                        const std::vector<DeviceOffer>& offers, size_t chosen,
                                        const std::string& profile, const std::string& named) {
  const auto wanted = [&](const DeviceOffer& o) {
    return profile.empty() ? o.felt : o.profile == profile;
  };
  const auto usable = [&](const DeviceOffer& o) { return o.problem.empty() && wanted(o); };
  if (chosen >= offers.size() || std::ranges::any_of(offers, usable)) return std::nullopt;
  auto broken = std::ranges::find_if(offers, wanted);
  // A board that does not answer has no profile.
  const auto refused = [](const DeviceOffer& o) { return o.felt && !o.problem.empty(); };
  if (broken == offers.end()) broken = std::ranges::find_if(offers, refused);
  if (broken != offers.end()) return MissingDevice{broken->title, broken->problem};
  if (profile.empty()) return std::nullopt;
  return MissingDevice{named, words.Say("device_trouble." + std::string(trouble::kNotAttached))};
}

}  // namespace enamel::station::desk
