#include "common/hands/hand.h"

#include <array>
#include <utility>

#include "common/base/utf8.h"

namespace enamel {
namespace {

template <typename E, size_t N>
using Names = std::array<std::pair<E, const char*>, N>;

constexpr Names<HandKind, 4> kKinds = {{{HandKind::kNotTold, "not_told"},
                                        {HandKind::kHaptic, "haptic"},
                                        {HandKind::kPointer, "pointer"},
                                        {HandKind::kProgram, "program"}}};
constexpr Names<HandsAllowed, 4> kAllowed = {{{HandsAllowed::kListed, "listed"},
                                              {HandsAllowed::kHaptic, "haptic"},
                                              {HandsAllowed::kPointer, "pointer"},
                                              {HandsAllowed::kAny, "any"}}};

template <typename E, size_t N>
const char* NameIn(const Names<E, N>& names, E value) {
  for (const auto& [each, name] : names) {
    if (each == value) return name;
  }
  return names.front().second;
}

template <typename E, size_t N>
std::optional<E> FromName(const Names<E, N>& names, std::string_view name) {
  for (const auto& [value, each] : names) {
    if (name == each) return value;
  }
  return std::nullopt;
}

std::string Shortened(std::string_view text) {
  return ShortenedText(Printable(text), kMaxHandTextBytes);
}

bool Admits(HandsAllowed allowed, HandKind kind) {
  switch (kind) {
    case HandKind::kHaptic:
      return true;
    case HandKind::kPointer:
      return allowed >= HandsAllowed::kPointer;
    case HandKind::kProgram:
    case HandKind::kNotTold:
      break;
  }
  return allowed == HandsAllowed::kAny;
}

}  // namespace

const char* HandKindName(HandKind kind) { return NameIn(kKinds, kind); }
std::optional<HandKind> HandKindFromName(std::string_view name) { return FromName(kKinds, name); }

Hand MakeHand(HandKind kind, std::string_view device, std::string_view driver,
              std::string_view unit) {
  return {kind, Shortened(device), Shortened(driver), Shortened(unit)};
}

std::string HandText(const Hand& hand) {
  switch (hand.kind) {
    case HandKind::kNotTold:
      return "no device named";
    case HandKind::kProgram:
      return "a simulated hand (" + hand.driver + ")";
    case HandKind::kHaptic:
    case HandKind::kPointer:
      break;
  }
  return hand.unit.empty() ? hand.device : hand.device + " (" + hand.unit + ")";
}

const std::string& ListedAs(const Hand& hand) {
  return hand.unit.empty() ? hand.device : hand.unit;
}

const char* HandsAllowedName(HandsAllowed allowed) { return NameIn(kAllowed, allowed); }
std::optional<HandsAllowed> HandsAllowedFromName(std::string_view name) {
  return FromName(kAllowed, name);
}

const char* HandsAllowedText(HandsAllowed allowed) {
  switch (allowed) {
    case HandsAllowed::kListed:
      return "a haptic device on the school's list";
    case HandsAllowed::kHaptic:
      return "a haptic device";
    case HandsAllowed::kPointer:
      return "a haptic device or a mouse";
    case HandsAllowed::kAny:
      break;
  }
  return "any hand, also a simulated one";
}

Status MayHold(HandsAllowed allowed, const Hand& hand, bool listed) {
  const bool admitted = Admits(allowed, hand.kind);
  if (admitted && (allowed != HandsAllowed::kListed || listed)) return Status::Ok();
  std::string what_to_do =
      "use such a device, or ask an instructor to allow this one in the "
      "assignment";
  if (admitted) what_to_do = "an admin puts it on the list as \"" + ListedAs(hand) + "\"";
  if (hand.kind == HandKind::kNotTold) what_to_do = "name the device that will hold the tool";
  return Status(Code::kForbidden,
                std::string("graded work here is done with ") + HandsAllowedText(allowed) +
                    ", found " + HandText(hand) + "; " + what_to_do,
                "hand");
}

}  // namespace enamel
