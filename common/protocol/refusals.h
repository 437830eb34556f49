#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "common/base/password.h"
#include "common/base/pin.h"
#include "common/base/result.h"

// Refusals that a person at a chair meets, and why an attempt has no score: schemas/wire/README.md,
// "Refusals". Code and field identify each; the station has a sentence for it in every language.
namespace enamel::protocol {

// Field of `unavailable` to OpenAttempt: this recording waits for something that a restore has
// taken from the server, however long; others do not wait for it.
inline constexpr const char* kAwaited = "awaited";
// Field of `conflict` to MarkReference: the attempt does not do what its exercise asks for. Sent
// again with a reason in this field it is taken.
inline constexpr const char* kAnyway = "anyway";

// Fields of a problem: why an attempt has failed (`kConflict`) or is quarantined.
inline constexpr const char* kReplay = "replay";
inline constexpr const char* kBrokenLaw = "broken_law";
inline constexpr const char* kUnreadable = "unreadable";
inline constexpr const char* kOtherHand = "other_hand";
inline constexpr const char* kFasterThanTime = "faster_than_time";
inline constexpr const char* kContradicted = "contradicted";

// Fields of `kConflict` to SignOff.
inline constexpr const char* kSignedAlready = "signed_already";
inline constexpr const char* kNotToSign = "not_to_sign";
inline constexpr const char* kStartAgain = "start_again";
inline constexpr const char* kNotArrived = "not_arrived";

struct Refusal {
  Code code = Code::kInternal;
  std::string_view field;
};

inline constexpr std::array kRefusals = {
    // SignIn, ChoosePassword
    Refusal{Code::kUnavailable, "throttled"},
    Refusal{Code::kUnauthenticated, "one_time_password"},
    Refusal{Code::kForbidden, "one_time_password"},
    Refusal{Code::kForbidden, "password"},
    Refusal{Code::kForbidden, "session"},
    Refusal{Code::kInvalidInput, kNewPassword},
    // RequestTicket, and ExerciseRef.refusal
    Refusal{Code::kForbidden, "exercise"},
    Refusal{Code::kForbidden, "opens"},
    Refusal{Code::kForbidden, "due"},
    Refusal{Code::kForbidden, "attempt_limit"},
    Refusal{Code::kForbidden, "stations"},
    Refusal{Code::kForbidden, "station"},
    Refusal{Code::kForbidden, "exam"},
    Refusal{Code::kForbidden, "clock"},
    Refusal{Code::kForbidden, "hand"},
    Refusal{Code::kForbidden, "for_later"},
    Refusal{Code::kForbidden, "as_reference"},
    Refusal{Code::kNotFound, "profile"},
    // OpenAttempt, PutChunk, SealAttempt
    Refusal{Code::kForbidden, "ticket"},
    Refusal{Code::kConflict, "ticket"},
    Refusal{Code::kForbidden, "sign_off"},
    Refusal{Code::kConflict, "person"},
    Refusal{Code::kUnavailable, kAwaited},
    // SignOff
    Refusal{Code::kForbidden, "signer"},
    Refusal{Code::kForbidden, kPinLocked},
    Refusal{Code::kConflict, kSignedAlready},
    Refusal{Code::kConflict, kNotToSign},
    Refusal{Code::kConflict, kStartAgain},
    Refusal{Code::kConflict, kNotArrived},
    // MarkReference, and "as_reference" of a ticket
    Refusal{Code::kConflict, "attempt"},
    Refusal{Code::kConflict, "consent"},
    Refusal{Code::kInvalidInput, "dentist"},
    Refusal{Code::kConflict, kAnyway},
    // AttemptState.problem
    Refusal{Code::kConflict, kReplay},
    Refusal{Code::kConflict, kBrokenLaw},
    Refusal{Code::kConflict, kUnreadable},
    Refusal{Code::kConflict, kOtherHand},
    Refusal{Code::kConflict, kFasterThanTime},
    Refusal{Code::kConflict, kContradicted},
};

// False: the station has only a sentence for its code.
constexpr bool IsListed(Code code, std::string_view field) {
  return std::ranges::any_of(kRefusals,
                             [&](const Refusal& r) { return r.code == code && r.field == field; });
}

}  // namespace enamel::protocol
