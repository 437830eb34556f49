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

// What a server says is printed on a terminal: it may not clear it, colour it or write over other lines.
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

// As a peer reads it that was made before the fact was known, and the other way round.
TEST(AttemptFactsTest, ComeBackAndAreDefaultsWhereAPeerDoesNotSayThem) {
  AttemptFacts facts;
  facts.resumed = 3;
  wire::OpenAttempt message;
  SetFacts(facts, message);
  EXPECT_EQ(FactsOf(message), facts);
  EXPECT_EQ(message.resumed(), 3u);
  EXPECT_EQ(FactsOf(wire::OpenAttempt()), AttemptFacts());
}

}  // namespace
}  // namespace enamel::protocol
