#include "server/s3/sigv4.h"

#include <gtest/gtest.h>

#include <chrono>

// Compared with what AWS publishes: the examples of the S3 API Reference ("Signature Calculations
// for the Authorization Header: Transferring Payload in a Single Chunk") and the suite of test
// vectors that AWS's own signers are tested with (aws-c-auth, tests/aws-signing-test-suite/v4,
// headers).
namespace enamel::s3 {
namespace {

std::string SignatureOf(const std::string& authorization) {
  return authorization.substr(authorization.rfind('=') + 1);
}

struct Vector {
  const char* name;
  Request request;
  std::string hash;  // of the canonical request
  std::string signature;
};

class PublishedVectors : public ::testing::TestWithParam<Vector> {};

std::string NameOf(const ::testing::TestParamInfo<Vector>& info) { return info.param.name; }

// S3's: the hash of the body is a header too.
Request OfS3(const std::string& method, const std::string& path, Pairs query, Pairs headers,
             const std::string& body = {}) {
  Request out{method, path, std::move(query), std::move(headers), HashSha256(AsBytes(body))};
  out.headers.emplace_back("Host", "examplebucket.s3.amazonaws.com");
  out.headers.emplace_back("x-amz-date", "20130524T000000Z");
  out.headers.emplace_back("x-amz-content-sha256", out.body.Hex());
  return out;
}

class S3Examples : public PublishedVectors {};

TEST_P(S3Examples, AreSignedAsPublished) {
  const Scope scope{"us-east-1"};
  const Credentials credentials{"AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY"};
  const Vector& vector = GetParam();
  EXPECT_EQ(
      StringToSign(vector.request, scope, "20130524T000000Z"),
      "AWS4-HMAC-SHA256\n20130524T000000Z\n20130524/us-east-1/s3/aws4_request\n" + vector.hash)
      << CanonicalRequest(vector.request);
  const std::string authorization =
      Authorization(vector.request, scope, credentials, "20130524T000000Z");
  EXPECT_EQ(SignatureOf(authorization), vector.signature);
  EXPECT_EQ(authorization.find(credentials.secret_key), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Published, S3Examples,
    ::testing::Values(Vector{"GetObject", OfS3("GET", "/test.txt", {}, {{"Range", "bytes=0-9"}}),
                             "7344ae5b7ee6c3e7e6b0fe0640412a37625d1fbfff95c48bbb2dc43964946972",
                             "f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41"},
                      Vector{"PutObject",
                             OfS3("PUT", "/test$file.text", {},
                                  {{"Date", "Fri, 24 May 2013 00:00:00 GMT"},
                                   {"x-amz-storage-class", "REDUCED_REDUNDANCY"}},
                                  "Welcome to Amazon S3."),
                             "9e0e90d9c76de8fa5b200d8c849cd5b8dc7a3be3951ddb7f6a76b4158342019d",
                             "98ad721746da40c64f1a55b78f14c238d841ea1380cd77a1b5971af0ece108bd"},
                      Vector{"GetBucketLifecycle", OfS3("GET", "/", {{"lifecycle", ""}}, {}),
                             "9766c798316ff2757b517bc739a67f6213b4ab36dd5da2f94eaebf79c77395ca",
                             "fea454ca298b7da1c68078a5d1bdbfbbe0d65c699e0f91ac7a200a0136783543"},
                      Vector{"ListObjects",
                             OfS3("GET", "/", {{"prefix", "J"}, {"max-keys", "2"}}, {}),
                             "df57d21db20da04d7fa30298dd4488ba3a2b47ca3a489c74750e0f1e7df1b9b7",
                             "34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7"}),
    NameOf);

Request OfSuite(const std::string& method, const std::string& path, Pairs query,
                Pairs headers = {}) {
  Request out{method, path, std::move(query), std::move(headers), HashSha256({})};
  out.headers.emplace_back("X-Amz-Date", "20150830T123600Z");
  out.headers.emplace_back("Host", "example.amazonaws.com");
  return out;
}

constexpr char kUnreserved[] = "-._~0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

class Suite : public PublishedVectors {};

TEST_P(Suite, IsSignedAsPublished) {
  const Scope scope{"us-east-1", "service"};
  const Credentials credentials{"AKIDEXAMPLE", "wJalrXUtnFEMI/K7MDENG+bPxRfiCYEXAMPLEKEY"};
  const Vector& vector = GetParam();
  EXPECT_EQ(
      StringToSign(vector.request, scope, "20150830T123600Z"),
      "AWS4-HMAC-SHA256\n20150830T123600Z\n20150830/us-east-1/service/aws4_request\n" + vector.hash)
      << CanonicalRequest(vector.request);
  EXPECT_EQ(SignatureOf(Authorization(vector.request, scope, credentials, "20150830T123600Z")),
            vector.signature);
}

INSTANTIATE_TEST_SUITE_P(
    Published, Suite,
    ::testing::Values(
        Vector{"Vanilla", OfSuite("GET", "/", {}),
               "bb579772317eb040ac9ed261061d46c1f17a8133879d6129b6e1c25292927e63",
               "5fa00fa31553b73ebf1942676e86291e8372ff2a2260956d9b8aae1d763fbf31"},
        Vector{"VanillaQueryOrderKeyCase",
               OfSuite("GET", "/", {{"Param2", "value2"}, {"Param1", "value1"}}),
               "816cd5b414d056048ba4f7c5386d6e0533120fb1fcfa93762cf0fc39e2cf19e0",
               "b97d918cfa904a5beff61c982a1b6f458b799221646efd99d3219ec94cdf2500"},
        Vector{"VanillaEmptyQueryKey", OfSuite("GET", "/", {{"Param1", "value1"}}),
               "1e24db194ed7d0eec2de28d7369675a243488e08526e8c1c73571282f7c517ab",
               "a67d582fa61cc504c4bae71f336f98b97f1ea3c7a6bfe1b6e45aec72011b9aeb"},
        Vector{"VanillaQueryUnreserved", OfSuite("GET", "/", {{kUnreserved, kUnreserved}}),
               "c30d4703d9f799439be92736156d47ccfb2d879ddf56f5befa6d1d6aab979177",
               "9c3e54bfcdf0b19771a7f523ee5669cdf59bc7cc0884027167c21bb143a40197"},
        Vector{"VanillaUtf8Query", OfSuite("GET", "/", {{"\u1234", "bar"}}),
               "eb30c5bed55734080471a834cc727ae56beb50e5f39d1bff6d0d38cb192a7073",
               "2cdec8eed098649ff3a119c94853b13c643bcf08f8b0a1d91e12c9027818dd04"},
        Vector{"Utf8", OfSuite("GET", "/\u1234", {}),
               "2a0a97d02205e45ce2e994789806b19270cfbbb0921b278ccf58f5249ac42102",
               "8318018e0b0f223aa2bbf98705b62bb787dc9c0e678f255a891fd03141be5d85"},
        Vector{"Space", OfSuite("GET", "/example space/", {}),
               "63ee75631ed7234ae61b5f736dfc7754cdccfedbff4b5128a915706ee9390d86",
               "652487583200325589f1fba4c7e578f72c47cb61beeca81406b39ddec1366741"},
        Vector{"Unreserved", OfSuite("GET", std::string("/") + kUnreserved, {}),
               "6a968768eefaa713e2a6b16b589a8ea192661f098f37349f4e2c0082757446f9",
               "07ef7494c76fa4850883e2b006601f940f8a34d404d0cfa977f52a65bbf5f24f"},
        Vector{
            "HeaderValueTrim",
            OfSuite("GET", "/", {}, {{"My-Header1", " value1"}, {"My-Header2", " \"a   b   c\""}}),
            "a726db9b0df21c14f559d0a978e563112acb1b9e05476f0a6a1c7d68f28605c7",
            "acc3ed3afb60bb290fc8d2dd0098b9911fcaa05412b367055dee359757a9c736"},
        Vector{"HeaderValueOrder",
               OfSuite("GET", "/", {},
                       {{"My-Header1", "value4"},
                        {"My-Header1", "value1"},
                        {"My-Header1", "value3"},
                        {"My-Header1", "value2"}}),
               "31ce73cd3f3d9f66977ad3dd957dc47af14df92fcd8509f59b349e9137c58b86",
               "08c7e5a9acfcfeb3ab6b2185e75ce8b1deb5e634ec47601a50643f830c755c01"},
        Vector{
            "HeaderKeyDuplicate",
            OfSuite("GET", "/", {},
                    {{"My-Header1", "value2"}, {"My-Header1", "value2"}, {"My-Header1", "value1"}}),
            "dc7f04a3abfde8d472b0ab1a418b741b7c67174dad1551b4117b15527fbe966c",
            "c9d5ea9f3f72853aea855b47ea873832890dbdd183b4468f858259531a5138ea"},
        Vector{"PostHeaderKeySort", OfSuite("POST", "/", {}, {{"My-Header1", "value1"}}),
               "9368318c2967cf6de74404b30c65a91e8f6253e0a8659d6d5319f1a812f87d65",
               "c5410059b04c1ee005303aed430f6e6645f61f4dc9e1461ec8f8916fdf18852c"},
        Vector{"PostVanillaQuery", OfSuite("POST", "/", {{"Param1", "value1"}}),
               "9d659678c1756bb3113e2ce898845a0a79dbbc57b740555917687f1b3340fbbd",
               "28038455d6de14eafc1f9222cf5aa6f1a96197d7deb8263271d420d138af7f11"}),
    NameOf);

TEST(SigV4Test, WholeCanonicalRequestAndHeaderAreThoseOfTheExample) {
  const Request request = OfS3("GET", "/test.txt", {}, {{"Range", "bytes=0-9"}});
  const std::string nothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
  EXPECT_EQ(CanonicalRequest(request),
            "GET\n/test.txt\n\nhost:examplebucket.s3.amazonaws.com\nrange:bytes=0-9\n"
            "x-amz-content-sha256:" +
                nothing +
                "\nx-amz-date:20130524T000000Z\n\nhost;range;x-amz-content-sha256;x-amz-date\n" +
                nothing);
  EXPECT_EQ(Authorization(request, {"us-east-1"},
                          {"AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY"},
                          "20130524T000000Z"),
            "AWS4-HMAC-SHA256 Credential=AKIAIOSFODNN7EXAMPLE/20130524/us-east-1/s3/aws4_request,"
            "SignedHeaders=host;range;x-amz-content-sha256;x-amz-date,"
            "Signature=f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41");
}

TEST(SigV4Test, PathIsNeitherNormalisedNorEncodedTwice) {
  Request request;
  request.path = "/bucket/a//../b%20 c";
  EXPECT_TRUE(CanonicalRequest(request).starts_with("GET\n/bucket/a//../b%2520%20c\n"));
}

TEST(SigV4Test, QueryIsSortedByEncodedNameThenValue) {
  EXPECT_EQ(CanonicalQuery({{"b", "2"}, {"a b", "/"}, {"a", "z"}, {"a", "A"}, {"A", ""}}),
            "A=&a=A&a=z&a%20b=%2F&b=2");
}

TEST(SigV4Test, TimeIsUtcToTheSecond) {
  EXPECT_EQ(AmzDate(std::chrono::system_clock::from_time_t(1369353600)), "20130524T000000Z");
  EXPECT_EQ(AmzDate(std::chrono::system_clock::from_time_t(1369353600) +
                    std::chrono::milliseconds(86'399'999)),
            "20130524T235959Z");
}

}  // namespace
}  // namespace enamel::s3
