#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

// The XML answers of an S3 store that the client uses (S3 API Reference: ListObjectsV2, Error
// Responses, GetBucketVersioning, GetObjectLockConfiguration). A store is not trusted: its answers
// are bounded and read strictly, and members that are not named here are ignored. Pure functions,
// any thread. Errors: kStorage, with what was expected and found.
namespace enamel::s3 {

// A page of a thousand keys of a thousand bytes is 1.5 MB.
inline constexpr size_t kMaxXmlBytes = 4 << 20;
inline constexpr size_t kMaxXmlText = 8192;  // of one element

struct ListedObject {
  std::string key;
  int64_t modified_ms = 0;  // since 1970-01-01 UTC, by the store's clock
  uint64_t bytes = 0;
  bool operator==(const ListedObject&) const = default;
};
struct ListPage {
  std::vector<ListedObject> objects;
  std::string next;  // goes along with the question for the next page; empty: this is the last
  bool operator==(const ListPage&) const = default;
};
Result<ListPage> ReadListPage(std::string_view document);

// Why a store refused: {"NoSuchKey", "The specified key does not exist."}.
struct Refusal {
  std::string code;
  std::string message;
};
Result<Refusal> ReadRefusal(std::string_view document);

enum class Versioning { kNever, kEnabled, kSuspended };
Result<Versioning> ReadVersioning(std::string_view document);

// Whether objects may be locked against deleting. A store that has no locks and passes the question
// over (OpenStack Swift) answers with a list of objects: false.
Result<bool> ReadObjectLock(std::string_view document);

// "2009-10-12T17:50:30.000Z". Errors: kStorage.
Result<int64_t> ReadTimeMs(std::string_view text);

}  // namespace enamel::s3
