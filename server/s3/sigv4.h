#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/sha256.h"

// AWS Signature Version 4, by which a request to an S3 store proves who sent it. Source: AWS,
// "Create a signed AWS API request" (IAM User Guide, reference_sigv-create-signed-request) and, for
// what S3 does in its own way, "Signature Calculations for the Authorization Header" (S3 API
// Reference, sig-v4-header-based-auth). With HMAC for HMAC-SHA-256, hex for lower-case hexadecimal:
//
//   canonical = METHOD \n path \n query \n header:value \n … \n \n names;… \n hex(SHA256(body))
//   scope     = YYYYMMDD/region/service/aws4_request
//   to sign   = "AWS4-HMAC-SHA256" \n YYYYMMDDTHHMMSSZ \n scope \n hex(SHA256(canonical))
//   key       = HMAC(HMAC(HMAC(HMAC("AWS4" + secret, YYYYMMDD), region), service), "aws4_request")
//   signature = hex(HMAC(key, to sign))
//
// As S3 does it, the path is encoded once and not normalised: "a//../b" is a key like any other.
// Pure functions. Thread safety: any thread. Real-time: not safe (allocates).
namespace enamel::s3 {

// The account that signs requests. The secret stays with the signer; it is in no request and in no
// message.
struct Credentials {
  std::string access_key;
  std::string secret_key;
  std::string session_token{};  // of credentials that are lent for a time; empty: they are not
};

using Pairs = std::vector<std::pair<std::string, std::string>>;

struct Request {
  std::string method = "GET";
  std::string path = "/";  // as it is meant, not encoded; begins with '/'
  Pairs query{};  // as it is meant, in any order; no value: "lifecycle" is {"lifecycle", ""}
  // All that are signed, "host" and "x-amz-date" among them, and for S3 "x-amz-content-sha256".
  // Names in any case and order; several of one name keep theirs.
  Pairs headers{};
  Sha256 body{};  // the hash of what is sent; of nothing it is HashSha256({})
};

// For whom and where a signature counts.
struct Scope {
  std::string region;
  std::string service = "s3";
};

// All but A-Z a-z 0-9 - . _ ~ become %XX, upper-case; '/' only with `slash`. Bytes of UTF-8 are
// encoded one by one.
std::string UriEncode(std::string_view text, bool slash);
// "name=value&…", encoded and sorted by the encoded names, then values: also what is sent after
// '?'.
std::string CanonicalQuery(const Pairs& query);
std::string CanonicalRequest(const Request& request);
// "20130524T000000Z", UTC.
std::string AmzDate(std::chrono::system_clock::time_point time);
std::string StringToSign(const Request& request, const Scope& scope, const std::string& amz_date);
// The value of the header Authorization. `amz_date`: that of "x-amz-date".
std::string Authorization(const Request& request, const Scope& scope,
                          const Credentials& credentials, const std::string& amz_date);

}  // namespace enamel::s3
