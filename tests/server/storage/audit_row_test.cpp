#include "server/storage/audit/audit_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <filesystem>

#include "common/base/file.h"
#include "common/base/hex.h"

// Rows of the audit trail are signed as schemas/audit.md says.
namespace enamel::server {
namespace {

namespace json = boost::json;

class AuditRowTest : public ::testing::Test {
 protected:
  AuditRowTest() {
    const auto text =
        ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/audit_row.json");
    EXPECT_TRUE(text.ok()) << text.status().message();
    says_ = json::parse(AsText(*text)).as_object();
    EXPECT_EQ(says_.size(), 21u) << "every member is compared";
    const Bytes salt = *FromHex(Text("salt")), key = *FromHex(Text("secret_key"));
    std::ranges::copy(salt, salt_.begin());
    std::ranges::copy(key, key_.begin());
    std::copy(key.begin() + 32, key.end(), public_key_.begin());
    seal_ = {*Uuid::Parse(Text("id")),
             says_.at("at_ms").as_int64(),
             *Uuid::Parse(Text("actor")),
             Text("via"),
             Text("action"),
             Text("object"),
             Text("subject"),
             AuditContentHash(salt_, Text("before"), Text("after"), Text("state")),
             {*Uuid::Parse(Text("chain")), static_cast<uint64_t>(says_.at("number").as_int64()),
              *Sha256::FromHex(Text("previous"))}};
  }
  std::string Text(const char* name) const { return std::string(says_.at(name).as_string()); }

  json::object says_;
  AuditSalt salt_{};
  trace::SecretKey key_{};
  trace::PublicKey public_key_{};
  AuditSeal seal_;
};

TEST_F(AuditRowTest, GoldenRowAndItsChainsEndAreSignedAsTheirDescriptionSays) {
  EXPECT_EQ(seal_.content.Hex(), Text("content_hash"));
  EXPECT_EQ(ToHex(EncodeAuditSeal(seal_)), Text("signed"));
  EXPECT_EQ(AuditSealHash(seal_).Hex(), Text("hash"));
  const trace::Signature signature = SignAuditSeal(seal_, key_);
  EXPECT_EQ(ToHex(signature), Text("signature")) << "signed apart from our code";
  EXPECT_TRUE(VerifyAuditSeal(seal_, signature, public_key_));
  AuditHead head{seal_.link.chain, seal_.link.number, seal_.id, AuditSealHash(seal_)};
  EXPECT_EQ(ToHex(EncodeAuditHead(head)), Text("end_signed"));
  head.signature = SignAuditHead(head, key_);
  EXPECT_EQ(ToHex(head.signature), Text("end_signature")) << "signed apart from our code";
  EXPECT_TRUE(VerifyAuditHead(head, public_key_));
  ++head.number;
  EXPECT_FALSE(VerifyAuditHead(head, public_key_));
}

TEST_F(AuditRowTest, TextsThatMoveFromOneFieldToTheNextAreAnotherRow) {
  const trace::Signature signature = SignAuditSeal(seal_, key_);
  AuditSeal moved = seal_;
  moved.via = seal_.via + seal_.action.substr(0, 1);
  moved.action = seal_.action.substr(1);
  EXPECT_FALSE(VerifyAuditSeal(moved, signature, public_key_));
  EXPECT_NE(AuditContentHash(salt_, "ab", "c", ""), AuditContentHash(salt_, "a", "bc", ""));
  EXPECT_NE(AuditContentHash(salt_, "", "", "a"), AuditContentHash(salt_, "", "a", ""));
}

TEST_F(AuditRowTest, RowAtAnotherPlaceOfItsChainIsAnotherRow) {
  const trace::Signature signature = SignAuditSeal(seal_, key_);
  AuditSeal moved = seal_;
  ++moved.link.number;
  EXPECT_FALSE(VerifyAuditSeal(moved, signature, public_key_));
  moved = seal_;
  moved.link.previous = {};
  EXPECT_FALSE(VerifyAuditSeal(moved, signature, public_key_));
  moved = seal_;
  moved.link.chain = moved.id;
  EXPECT_FALSE(VerifyAuditSeal(moved, signature, public_key_));
}

TEST_F(AuditRowTest, SaltIsAnotherEachTime) { EXPECT_NE(NewAuditSalt(), NewAuditSalt()); }

}  // namespace
}  // namespace enamel::server
