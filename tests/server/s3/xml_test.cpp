#include "server/s3/xml.h"

#include <gtest/gtest.h>

namespace enamel::s3 {
namespace {

constexpr char kPage[] = R"(<?xml version="1.0" encoding="UTF-8"?>
<ListBucketResult xmlns="http://s3.amazonaws.com/doc/2006-03-01/">
  <Name>bucket</Name><Prefix/><KeyCount>2</KeyCount><MaxKeys>2</MaxKeys>
  <IsTruncated>true</IsTruncated><NextContinuationToken>1ueGcxLPRx1Tr/XYExHnhbYLgveDs2J/wm36Hy4vbOwM=</NextContinuationToken>
  <Contents><Key>a &amp; b&#x2f;&#252;</Key><LastModified>2009-10-12T17:50:30.000Z</LastModified>
    <ETag>&quot;fba9dede5f27731c9771645a39863328&quot;</ETag><Size>434234</Size><StorageClass>STANDARD</StorageClass></Contents>
  <Contents><Key>c</Key><LastModified>2024-02-29T23:59:59Z</LastModified><Size>0</Size>
    <Owner xsi:type="CanonicalUser"><ID>me</ID></Owner></Contents>
</ListBucketResult>)";

TEST(S3XmlTest, PageOfAListIsReadWithTheMembersThatAreNeeded) {
  const auto page = ReadListPage(kPage);
  ASSERT_TRUE(page.ok()) << page.status().message();
  ASSERT_EQ(page->objects.size(), 2u);
  EXPECT_EQ(page->objects[0], (ListedObject{"a & b/\u00fc", 1255369830000, 434234}));
  EXPECT_EQ(page->objects[1], (ListedObject{"c", 1709251199000, 0}));
  EXPECT_EQ(page->next, "1ueGcxLPRx1Tr/XYExHnhbYLgveDs2J/wm36Hy4vbOwM=");
}

TEST(S3XmlTest, LastPageHasNoNext) {
  const auto page = ReadListPage(
      "<ListBucketResult><IsTruncated>false</IsTruncated><NextContinuationToken>x"
      "</NextContinuationToken></ListBucketResult>");
  ASSERT_TRUE(page.ok()) << page.status().message();
  EXPECT_TRUE(page->objects.empty() && page->next.empty());
}

TEST(S3XmlTest, ListThatEndsInTheMiddleIsNoShorterList) {
  const std::string page = kPage;
  for (size_t end = 0; end < page.size(); ++end) {
    EXPECT_EQ(ReadListPage(page.substr(0, end)).status().code(), Code::kStorage) << end;
  }
}

TEST(S3XmlTest, WhatIsNoAnswerOfAStoreIsRefused) {
  for (const std::string& inside :
       {std::string("<Contents>"), std::string("<Contents></Key>"), std::string("<Contents b=c/>"),
        std::string("<!-- "), std::string("<Contents><Key>\xff</Key></Contents>"),
        std::string("<Contents><Key>\x1f</Key></Contents>"),
        std::string("<Contents><Key>&#xd800;</Key></Contents>"),
        std::string("<Contents><Key>a\0</Key></Contents>", 32),
        "<Contents><Key>" + std::string(kMaxXmlText + 1, 'b') + "</Key></Contents>",
        std::string(kMaxXmlBytes, ' ')}) {
    EXPECT_EQ(ReadListPage("<ListBucketResult>" + inside + "</ListBucketResult>").status().code(),
              Code::kStorage)
        << inside.substr(0, 60);
  }
  for (const char* document : {"", "<html>", "{\"Key\":1}", "<ListBucketResult/><b/>"}) {
    EXPECT_EQ(ReadListPage(document).status().code(), Code::kStorage) << document;
  }
}

TEST(S3XmlTest, DocumentTypeDefinesNoEntities) {
  const auto page = ReadListPage(
      "<!DOCTYPE a [<!ENTITY b \"c\">]><ListBucketResult><Contents><Key>&b;</Key></Contents>"
      "</ListBucketResult>");
  EXPECT_TRUE(!page.ok() || page->objects[0].key == "&b;");
}

TEST(S3XmlTest, ListWithAMemberThatCannotBeIsRefused) {
  auto of = [](const std::string& contents) {
    return ReadListPage("<ListBucketResult>" + contents + "</ListBucketResult>").status();
  };
  EXPECT_FALSE(of("<Contents><Key>a</Key><Size>-1</Size></Contents>").ok());
  EXPECT_FALSE(of("<Contents><Key>a</Key><LastModified>yesterday</LastModified></Contents>").ok());
  EXPECT_FALSE(of("<Contents><Size>1</Size></Contents>").ok());
  EXPECT_FALSE(of("<IsTruncated>true</IsTruncated>").ok()) << "the rest would be missing unnoticed";
  for (const char* unknown : {"yes", "", " "})
    EXPECT_FALSE(of("<IsTruncated>" + std::string(unknown) + "</IsTruncated>").ok()) << unknown;
  EXPECT_FALSE(ReadListPage("<Other/>").ok());
}

TEST(S3XmlTest, ListIsReadToItsEndHoweverAStoreWritesThatItContinues) {
  auto next = [](const std::string& truncated) {
    return ReadListPage("<ListBucketResult><IsTruncated>" + truncated +
                        "</IsTruncated><NextContinuationToken>x</NextContinuationToken>"
                        "</ListBucketResult>")
        ->next;
  };
  for (const char* yes : {"true", "1", "True"}) EXPECT_EQ(next(yes), "x") << yes;
  for (const char* no : {"false", "0", "False"}) EXPECT_EQ(next(no), "") << no;
}

TEST(S3XmlTest, RefusalSaysItsCode) {
  const auto refusal = ReadRefusal(
      "<?xml version='1.0' encoding='UTF-8'?>\n<Error><Code>SlowDown</Code><Message>Please reduce "
      "your request rate.</Message><RequestId>tx1</RequestId></Error>");
  ASSERT_TRUE(refusal.ok()) << refusal.status().message();
  EXPECT_EQ(refusal->code, "SlowDown");
  EXPECT_EQ(refusal->message, "Please reduce your request rate.");
  EXPECT_FALSE(ReadRefusal("<html><body>502</body></html>").ok());
}

TEST(S3XmlTest, VersioningThatWasNeverSwitchedOnIsToldFromWhatKeepsVersions) {
  auto of = [](const std::string& members) {
    return ReadVersioning(
        "<VersioningConfiguration xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\">" + members +
        "</VersioningConfiguration>");
  };
  EXPECT_EQ(*of(""), Versioning::kNever);
  EXPECT_EQ(*of("<Status>Enabled</Status>"), Versioning::kEnabled);
  EXPECT_EQ(*of("<Status>Suspended</Status>"), Versioning::kSuspended);
  EXPECT_FALSE(of("<Status>Maybe</Status>").ok());
  EXPECT_FALSE(ReadVersioning("<ListBucketResult/>").ok()) << "no answer is not no";
}

TEST(S3XmlTest, LocksAreFoundAndAStoreWithoutThemIsTold) {
  EXPECT_TRUE(
      *ReadObjectLock("<ObjectLockConfiguration><ObjectLockEnabled>Enabled</ObjectLockEnabled>"
                      "<Rule><DefaultRetention><Mode>COMPLIANCE</Mode><Days>1</Days>"
                      "</DefaultRetention></Rule></ObjectLockConfiguration>"));
  EXPECT_FALSE(*ReadObjectLock("<ObjectLockConfiguration/>"));
  EXPECT_FALSE(*ReadObjectLock("<ListBucketResult><Name>b</Name></ListBucketResult>"));
  EXPECT_FALSE(ReadObjectLock("<Other/>").ok());
}

TEST(S3XmlTest, TimesThatDoNotExistAreRefused) {
  EXPECT_EQ(*ReadTimeMs("1970-01-01T00:00:00Z"), 0);
  EXPECT_EQ(*ReadTimeMs("1970-01-01T00:00:01.5Z"), 1500);
  EXPECT_EQ(*ReadTimeMs("1970-01-01T00:00:01.123456789Z"), 1123);
  for (const char* time : {"", "Z", "1970-01-01", "1970-02-30T00:00:00Z", "1970-01-01T24:00:00Z",
                           "1970-01-01T00:00:00", "1970-01-01 00:00:00Z", "1970-01-01T00:00:00.Z",
                           "1970-01-01T00:00:00.xZ", "+970-01-01T00:00:00Z"}) {
    EXPECT_FALSE(ReadTimeMs(time).ok()) << time;
  }
}

}  // namespace
}  // namespace enamel::s3
