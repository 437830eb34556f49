#include "common/protocol/messages.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>

#include "common/base/utf8.h"

namespace enamel::protocol {
namespace {

constexpr const char* kUnsupported = "unsupported";

// Protobuf reports malformed input on stderr as well as in its result: a peer could fill the log.
// Errors are returned here, and handled once by the caller.
void SilenceProtobuf() {
  // The handler is the process's: set once, before anything is parsed.
  static const bool done = [] {
    google::protobuf::SetLogHandler(nullptr);
    return true;
  }();
  (void)done;
}

template <typename Message>
Result<Message> Parse(ByteView frame, const char* kind) {
  SilenceProtobuf();
  Message message;
  if (!message.ParseFromArray(frame.data(), static_cast<int>(frame.size()))) {
    return Status(Code::kInvalidInput, std::string("frame of ") + std::to_string(frame.size()) +
                                           " bytes: expected a Protobuf message of kind " + kind +
                                           " (schemas/wire/station.proto), found something else");
  }
  return message;
}

Status CheckSize(const std::string& bytes, size_t expected, const char* field) {
  if (bytes.size() == expected) return Status::Ok();
  return Status(Code::kInvalidInput,
                std::string("field ") + field + ": expected " + std::to_string(expected) +
                    " bytes, found " + std::to_string(bytes.size()),
                field);
}

}  // namespace

Bytes Serialize(const google::protobuf::MessageLite& message) {
  Bytes out(message.ByteSizeLong());
  ENAMEL_CHECK(message.SerializeToArray(out.data(), static_cast<int>(out.size())));
  return out;
}

Result<wire::Request> ParseRequest(ByteView frame) {
  return Parse<wire::Request>(frame, "Request");
}
Result<wire::Reply> ParseReply(ByteView frame) { return Parse<wire::Reply>(frame, "Reply"); }

wire::Error ToError(const Status& status) {
  wire::Error error;
  error.set_code(CodeName(status.code()));
  error.set_message(status.message());
  error.set_field(status.field());
  return error;
}

Status ToStatus(const wire::Error& error) {
  // The other side wrote it, and it is shown on a terminal.
  const std::string message = Printable(error.message()), field = Printable(error.field());
  for (int c = static_cast<int>(Code::kInvalidInput); c <= static_cast<int>(Code::kInternal); ++c) {
    auto code = static_cast<Code>(c);
    if (error.code() == CodeName(code)) return Status(code, message, field);
  }
  // No code of ours: a server says it of a kind of request that it does not know (wire/README.md,
  // "Frames").
  if (error.code() == kUnsupported) return Status(Code::kVersion, message, field);
  // A newer peer's code still says something to a person.
  return Status(Code::kInternal, Printable(error.code()) + ": " + message, field);
}

wire::Error UnsupportedError() {
  wire::Error error;
  error.set_code(kUnsupported);
  error.set_message(
      "this server does not know this kind of request; update it, or use a station of its version");
  return error;
}

bool IsPageUrl(std::string_view text) {
  constexpr size_t kMaxBytes = 200;
  for (std::string_view scheme : {"https://", "http://"}) {
    if (text.starts_with(scheme) && text.size() > scheme.size()) {
      return text.size() <= kMaxBytes &&
             std::ranges::all_of(text, [](char c) { return c > ' ' && c < '\x7f'; });
    }
  }
  return false;
}

Result<Uuid> ReadUuid(const std::string& bytes, const char* field) {
  ENAMEL_RETURN_IF_ERROR(CheckSize(bytes, 16, field));
  return Uuid::FromBytes(AsBytes(bytes));
}

Result<Sha256> ReadSha256(const std::string& bytes, const char* field) {
  ENAMEL_RETURN_IF_ERROR(CheckSize(bytes, 32, field));
  return Sha256::FromBytes(AsBytes(bytes));
}

Result<std::array<uint8_t, 32>> ReadKey(const std::string& bytes, const char* field) {
  ENAMEL_RETURN_IF_ERROR(CheckSize(bytes, 32, field));
  std::array<uint8_t, 32> out;
  std::copy(bytes.begin(), bytes.end(), out.begin());
  return out;
}

Hand ReadHand(const wire::Hand& message) {
  return MakeHand(HandKindFromName(message.kind()).value_or(HandKind::kNotTold), message.device(),
                  message.driver(), message.unit());
}

void SetHand(const Hand& hand, wire::Hand& message) {
  if (hand.kind != HandKind::kNotTold) message.set_kind(HandKindName(hand.kind));
  message.set_device(hand.device);
  message.set_driver(hand.driver);
  message.set_unit(hand.unit);
}

}  // namespace enamel::protocol
