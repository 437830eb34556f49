#pragma once

#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/protocol/station.pb.h"

namespace enamel::protocol {

// What a station reports of an attempt beside its recording: not signed, not an input of the core,
// and true whether the server believes it or not. The spool keeps it with the attempt, every
// OpenAttempt sends it, and the server never changes it. schemas/wire/station.proto alone defines
// its members; code that lists, stores or shows facts uses FactsJson. CONTRIBUTING.md, "Where a
// fact of an attempt belongs", says which facts belong here and which places a new one touches.
using AttemptFacts = wire::AttemptFacts;

// Of encoded facts, unknown ones included: the data kept with each attempt must not grow on a
// station's word.
inline constexpr size_t kMaxFactsBytes = 4096;

// As the spool keeps them. Facts that are unknown here are kept as they came.
Bytes EncodeFacts(const AttemptFacts& facts);
// Errors: kInvalidInput.
Result<AttemptFacts> DecodeFacts(ByteView bytes);

// Facts from a peer may not be longer than kMaxFactsBytes: kTooLarge, field "facts".
Status CheckFacts(const AttemptFacts& facts);

// A JSON object, {"resumed":0}: every known member by its name in station.proto, also one that was
// not said.
std::string FactsJson(const AttemptFacts& facts);
// One line for a person, "resumed: 1": the known members that are set; empty: none is. Characters
// that are not ASCII are escaped.
std::string FactsText(const AttemptFacts& facts);

}  // namespace enamel::protocol
