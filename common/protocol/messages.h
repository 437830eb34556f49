#pragma once

#include <string>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/hands/hand.h"
#include "common/protocol/station.pb.h"

// Between the generated Protobuf classes (namespace enamel::wire) and our own types. Pure
// functions.
namespace enamel::protocol {

inline constexpr uint32_t kProtocolVersion = 1;

// Message -> bytes for one frame.
Bytes Serialize(const google::protobuf::MessageLite& message);
// Bytes of one frame -> message. Unknown fields are kept, not refused. A body of a kind this
// program does not know parses as BODY_NOT_SET. Errors: kInvalidInput.
Result<wire::Request> ParseRequest(ByteView frame);
Result<wire::Reply> ParseReply(ByteView frame);

// A refusal on the wire, and back. Unknown code names (a newer peer's) become kInternal with the
// name in front of the message; "unsupported" becomes kVersion.
wire::Error ToError(const Status& status);
// As text that a terminal shows and does not obey (Printable).
Status ToStatus(const wire::Error& error);
// Answer to a request whose body this program does not know.
wire::Error UnsupportedError();

// An address of the page that a station may show to people: `https://` or `http://` and the rest,
// at most 200 printable ASCII characters without spaces.
bool IsPageUrl(std::string_view text);

// Fixed-size byte fields. Errors: kInvalidInput naming `field`, expected and found size.
Result<Uuid> ReadUuid(const std::string& bytes, const char* field);
Result<Sha256> ReadSha256(const std::string& bytes, const char* field);
Result<std::array<uint8_t, 32>> ReadKey(const std::string& bytes, const char* field);
// The hand that holds the tool. A kind that this program does not know reads as not reported.
Hand ReadHand(const wire::Hand& message);
void SetHand(const Hand& hand, wire::Hand& message);
// Any of our byte types as a Protobuf bytes field: message.set_attempt(ToField(id.view())).
inline std::string ToField(ByteView bytes) { return std::string(AsText(bytes)); }

}  // namespace enamel::protocol
