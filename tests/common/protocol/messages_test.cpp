#include "common/protocol/messages.h"

#include <gtest/gtest.h>

#include "common/protocol/attempt_facts.h"

namespace enamel::protocol {
namespace {

TEST(MessagesTest, RequestComesBackAsSent) {
  wire::Request request;
  request.set_id(7);
  request.mutable_seal_attempt()->set_chunks(3);
  request.mutable_seal_attempt()->set_state_hash(0xfedcba9876543210ull);
  auto read = ParseRequest(Serialize(request));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->id(), 7u);
  EXPECT_EQ(read->seal_attempt().state_hash(), 0xfedcba9876543210ull);
}

TEST(MessagesTest, BytesThatAreNoMessageAreRefused) {
  Bytes bytes(20, 0xff);
  EXPECT_EQ(ParseRequest(bytes).status().code(), Code::kInvalidInput);
  EXPECT_EQ(ParseReply(bytes).status().code(), Code::kInvalidInput);
}

TEST(MessagesTest, KindOfALaterVersionParsesAsNoBody) {
  ByteWriter later;
  later.Varint(1 << 3);  // field 1, varint: id
  later.Varint(5);
  later.Varint(900 << 3 | 2);  // field 900, bytes
  later.Varint(3);
  later.Raw(AsBytes("new"));
  auto request = ParseRequest(later.bytes());
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(request->id(), 5u);
  EXPECT_EQ(request->body_case(), wire::Request::BODY_NOT_SET);
}

TEST(MessagesTest, EveryCodeSurvivesTheWire) {
  for (int c = static_cast<int>(Code::kInvalidInput); c <= static_cast<int>(Code::kInternal); ++c) {
    Status sent(static_cast<Code>(c), "expected a, found b", "where");
    Status got = ToStatus(ToError(sent));
    EXPECT_EQ(got.code(), sent.code());
    EXPECT_EQ(got.message(), sent.message());
    EXPECT_EQ(got.field(), sent.field());
  }
}

TEST(MessagesTest, CodesOfALaterServerStayErrors) {
  wire::Error error;
  error.set_code("ok");
  error.set_message("odd");
  EXPECT_EQ(ToStatus(error).code(), Code::kInternal);
  error.set_code("teapot");
  EXPECT_EQ(ToStatus(error).code(), Code::kInternal);
  EXPECT_NE(ToStatus(error).message().find("teapot"), std::string::npos);
  EXPECT_EQ(ToStatus(UnsupportedError()).code(), Code::kVersion);
}

// A server's text is printed on a terminal: it may not clear it, colour it or write over other
// lines.
TEST(MessagesTest, AnErrorsTextIsShownAndNotObeyed) {
  wire::Error error;
  error.set_code("conflict");
  error.set_message("\x1b[2Jall is well\r\n\u202e");
  error.set_field("\x07");
  const Status status = ToStatus(error);
  EXPECT_EQ(status.message(), "\\x1b[2Jall is well\\x0d\\x0a\\u202e");
  EXPECT_EQ(status.field(), "\\x07");
  error.set_code("\x1b]0;mine\x07");
  EXPECT_EQ(ToStatus(error).message().find('\x1b'), std::string::npos);
}

TEST(MessagesTest, FieldsOfAnotherSizeAreRefusedByName) {
  Uuid id = Uuid::New();
  EXPECT_EQ(*ReadUuid(ToField(id.view()), "attempt"), id);
  EXPECT_EQ(ReadUuid("short", "attempt").status().field(), "attempt");
  Sha256 hash = HashSha256(AsBytes("x"));
  EXPECT_EQ(*ReadSha256(ToField(hash.view()), "exercise"), hash);
  EXPECT_EQ(ReadSha256("", "exercise").status().code(), Code::kInvalidInput);
  EXPECT_EQ(ReadKey(std::string(33, 'k'), "public_key").status().field(), "public_key");
}

// Field 1000 represents a future one.
TEST(AttemptFactsTest, KeepsFactsThatItDoesNotKnowAndNamesThoseItKnows) {
  const Bytes later{0x08, 0x02, 0xc2, 0x3e, 0x05, 'l', 'a', 't', 'e', 'r'};
  auto facts = DecodeFacts(later);
  ASSERT_TRUE(facts.ok()) << facts.status().message();
  EXPECT_EQ(EncodeFacts(*facts), later);
  EXPECT_NE(FactsJson(*facts).find("\"resumed\":2"), std::string::npos) << FactsJson(*facts);
  EXPECT_EQ(FactsJson(*facts).find("later"), std::string::npos);
  EXPECT_NE(FactsJson(AttemptFacts()).find("\"resumed\":0"), std::string::npos);
  EXPECT_EQ(FactsText(*facts), "resumed: 2");
  EXPECT_EQ(FactsText(AttemptFacts()), "");
  EXPECT_TRUE(CheckFacts(*facts).ok());
}

TEST(AttemptFactsTest, RefusesBytesThatAreNoFactsAndMoreThanFits) {
  EXPECT_EQ(DecodeFacts(Bytes{0x08}).status().code(), Code::kInvalidInput);
  Bytes long_one{0xc2, 0x3e, 0x80, 0x20};  // field 1000 with 4096 bytes
  long_one.resize(long_one.size() + kMaxFactsBytes, 'x');
  EXPECT_EQ(DecodeFacts(long_one).status().code(), Code::kInvalidInput);
  AttemptFacts facts;
  ASSERT_TRUE(facts.ParseFromArray(long_one.data(), static_cast<int>(long_one.size())));
  EXPECT_EQ(CheckFacts(facts).code(), Code::kTooLarge);
  EXPECT_EQ(CheckFacts(facts).field(), "facts");
}

// Lists and the API show facts from the descriptor. A kind with another form in JSON (text for 64
// bits, base64 for bytes) would reach people in that form.
TEST(AttemptFactsTest, MembersAreOfKindsThatJsonShowsAsTheyAre) {
  using Field = google::protobuf::FieldDescriptor;
  const auto* description = AttemptFacts::descriptor();
  for (int i = 0; i < description->field_count(); ++i) {
    const Field& field = *description->field(i);
    const auto type = field.cpp_type();
    EXPECT_FALSE(field.is_repeated()) << field.name();
    EXPECT_TRUE(type == Field::CPPTYPE_UINT32 || type == Field::CPPTYPE_INT32 ||
                type == Field::CPPTYPE_DOUBLE || type == Field::CPPTYPE_BOOL ||
                field.type() == Field::TYPE_STRING)
        << field.name();
  }
}

}  // namespace
}  // namespace enamel::protocol
