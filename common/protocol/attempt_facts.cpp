#include "common/protocol/attempt_facts.h"

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include "common/base/check.h"

namespace enamel::protocol {

Bytes EncodeFacts(const AttemptFacts& facts) {
  Bytes out(facts.ByteSizeLong());
  ENAMEL_CHECK(facts.SerializeToArray(out.data(), static_cast<int>(out.size())));
  return out;
}

Result<AttemptFacts> DecodeFacts(ByteView bytes) {
  AttemptFacts facts;
  if (bytes.size() <= kMaxFactsBytes &&
      facts.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return facts;
  }
  return Status(Code::kInvalidInput, "expected an attempt's facts, found " +
                                         std::to_string(bytes.size()) + " bytes that are none");
}

Status CheckFacts(const AttemptFacts& facts) {
  const size_t size = facts.ByteSizeLong();
  if (size <= kMaxFactsBytes) return Status::Ok();
  return Status(Code::kTooLarge,
                "expected at most " + std::to_string(kMaxFactsBytes) +
                    " bytes of facts about an attempt, found " + std::to_string(size),
                "facts");
}

std::string FactsJson(const AttemptFacts& facts) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  ENAMEL_CHECK(google::protobuf::util::MessageToJsonString(facts, &json, options).ok());
  return json;
}

std::string FactsText(const AttemptFacts& facts) {
  google::protobuf::TextFormat::Printer printer;
  printer.SetSingleLineMode(true);
  printer.SetHideUnknownFields(true);
  std::string text;
  ENAMEL_CHECK(printer.PrintToString(facts, &text));
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

}  // namespace enamel::protocol
