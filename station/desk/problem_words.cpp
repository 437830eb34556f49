#include "station/desk/problem_words.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "common/base/pin.h"
#include "common/protocol/refusals.h"
#include "station/devices/trouble.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {
namespace {

struct Said {
  std::optional<Code> code;  // none: any
  std::string_view field, key;
};

constexpr Code kInvalid = Code::kInvalidInput, kConflict = Code::kConflict;

constexpr std::array kSaid = {
    Said{{}, kServerAway, "sign_in.away"},
    Said{kInvalid, kPinDigits, "pin.weak"},
    Said{kInvalid, kPinRepeats, "pin.repeats"},
    Said{kInvalid, kPinRun, "pin.run"},
    Said{kInvalid, kPinDate, "pin.date"},
    Said{Code::kUnauthenticated, "pin", "pin.wrong"},
    // Exercise and device profile (CompilePlan), with the delay of the device (UseDelayOf).
    Said{kInvalid, "bus_delay_ticks", "problem.slow_device"},
    Said{kInvalid, "rate_hz", "problem.slow_rate"},
    Said{kInvalid, "coupling_mn_per_mm", "problem.device_settings"},
    Said{kInvalid, "friction_mn", "problem.device_settings"},
    Said{kInvalid, "coupling_un_m_per_rad", "problem.device_settings"},
    Said{kInvalid, "friction_un_m", "problem.device_settings"},
    Said{kInvalid, "damping_un_m_s_per_rad", "problem.device_settings"},
    Said{kInvalid, "peak_un_m", "problem.device_settings"},
    Said{kConflict, "board_spring", "problem.device_settings"},
    // Exercise and scene (CompilePlan, CheckVolume).
    Said{kInvalid, "bur", "problem.exercise"},
    Said{kInvalid, "touch_cues", "problem.exercise"},
    Said{kInvalid, "landmark", "problem.exercise"},
    Said{{}, "tissues", "problem.exercise"},
    Said{kConflict, "scene_sha256", "problem.exercise"},
    Said{kConflict, "voxel_nm", "problem.exercise"},
    // A resumed attempt and another device.
    Said{kConflict, "bus_delay_ticks", "problem.other_device"},
    Said{kConflict, "coupling_mn_per_mm", "problem.other_device"},
    Said{kConflict, "coupling_un_m_per_rad", "problem.other_device"},
    Said{kConflict, "hand", "problem.other_device"},
    // This station.
    Said{Code::kStorage, kRecordingHere, "problem.disk"},
    Said{kConflict, kRecordingHere, "problem.recording_elsewhere"},
};

// Of a refusal that few people meet.
std::string_view KeyOf(Code code) {
  switch (code) {
    case Code::kOk:
    case Code::kInternal:
      break;
    case Code::kInvalidInput:
      return "problem.invalid_input";
    case Code::kUnauthenticated:
      return "problem.unauthenticated";
    case Code::kForbidden:
      return "problem.forbidden";
    case Code::kNotFound:
      return "problem.not_found";
    case Code::kConflict:
      return "problem.conflict";
    case Code::kTooLarge:
      return "problem.too_large";
    case Code::kUnavailable:
      return "problem.unavailable";
    case Code::kStorage:
      return "problem.storage";
    case Code::kVersion:
      return "problem.version";
  }
  return "problem.internal";
}

}  // namespace

std::string ProblemText(const language::Words& words, const Status& status) {
  const auto said = std::ranges::find_if(kSaid, [&](const Said& s) {
    return s.field == status.field() && s.code.value_or(status.code()) == status.code();
  });
  if (said != kSaid.end()) return words.Say(said->key);
  if (trouble::IsListed(status.field())) return words.Say("device_trouble." + status.field());
  if (!protocol::IsListed(status.code(), status.field())) return words.Say(KeyOf(status.code()));
  return words.Say("refusal." + status.field(), {{"said", status.message()}});
}

const char* FaultKey(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return "";
    case Fault::kStalled:
      return "fault.stalled";
    case Fault::kLateOnce:
      return "fault.late_once";
    case Fault::kLateOften:
      return "fault.late_often";
    case Fault::kTooSlow:
      return "fault.too_slow";
    case Fault::kUnplugged:
      return "fault.unplugged";
    case Fault::kSwitchedOff:
      return "fault.switched_off";
  }
  return "";
}

std::string FaultSentence(const language::Words& words, Fault fault, const Status& device,
                          bool lacks_realtime) {
  if (fault == Fault::kNone) return {};
  const std::string& cause = device.field();
  // The fault's own words are as precise and do not speak of looking for devices.
  const bool same = cause == trouble::kSilent || cause == trouble::kNotAttached;
  const bool away = fault == Fault::kUnplugged || fault == Fault::kStalled;
  if (away && !same && trouble::IsListed(cause)) {
    return words.Say("fault.device", {{"reason", words.Say("device_trouble." + cause)}});
  }
  const bool late = fault == Fault::kLateOnce || fault == Fault::kLateOften;
  const char* key = late && lacks_realtime ? "fault.no_realtime" : FaultKey(fault);
  return words.Say("fault.text", {{"reason", words.Say(key)}});
}

std::string NoScoreText(const language::Words& words, const Status& problem) {
  return protocol::IsListed(problem.code(), problem.field()) ? ProblemText(words, problem)
                                                             : words.Say("result.no_words");
}

std::string SofterText(const language::Words& words, scene::DelayUsed::From from,
                       const std::string& device) {
  switch (from) {
    case scene::DelayUsed::From::kAssumed:
      return words.Say("ready.not_calibrated", {{"device", device}});
    case scene::DelayUsed::From::kAnswers:
      return words.Say("ready.slow_answers", {{"device", device}});
    case scene::DelayUsed::From::kPoses:
      return words.Say("ready.slow_poses", {{"device", device}});
    case scene::DelayUsed::From::kProfile:
    case scene::DelayUsed::From::kCalibration:
      break;
  }
  return {};
}

}  // namespace enamel::station::desk
