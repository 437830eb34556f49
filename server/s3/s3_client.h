#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/s3/s3_figures.h"
#include "server/s3/sigv4.h"
#include "server/s3/xml.h"

// Reads and writes the objects of one bucket of an S3 store (S3 API Reference; also OpenStack Swift
// with s3api, Ceph, MinIO). Only this folder includes libcurl's header, and the first client opens
// the library.
namespace enamel::s3 {

struct Libcurl;

struct S3Limits {
  std::chrono::milliseconds connect{3'000};
  // A try ends after this time without a byte in either direction. Whole seconds.
  std::chrono::seconds stall{10};
  // A call with all its tries and pauses ends after it: a station's request waits 60 s.
  std::chrono::milliseconds call{40'000};
  // The pause before the n-th try is a random half to whole of min(first_pause · 2^(n-2),
  // longest_pause): clients that were refused together do not return together.
  int tries = 5;
  std::chrono::milliseconds first_pause{100};
  std::chrono::milliseconds longest_pause{2'000};
  // Of a Put, as a file of the folder may have (common/base/file.h); S3 itself takes 5 GB.
  size_t object_bytes = size_t{1} << 31;
};

// Where time comes from. For tests; those that are empty are the machine's.
struct S3Time {
  std::function<std::chrono::system_clock::time_point()> now{};     // what is signed
  std::function<std::chrono::steady_clock::time_point()> steady{};  // what limits count
  std::function<void(std::chrono::milliseconds)> pause{};
};

struct S3Options {
  // "https://HOST[:PORT]". "http://…" on this machine only: who reads on the way would read the
  // blobs.
  std::string endpoint;
  std::string region = "us-east-1";
  std::string bucket;
  std::string ca_file{};  // PEM, of who signed the store's certificate; empty: the system's
  Credentials credentials{};
  S3Limits limits{};
  S3Time time{};
};

// Buckets are addressed by path (ENDPOINT/BUCKET/KEY), which every store knows. Proxies of the
// environment are not used, redirects not followed. HTTP/1.1; connections are kept and used again,
// at most kMaxIdle.
//
// The client retries failures that may pass: no connection, a connection that was lost or is
// silent, 408, 429, 500, 502, 503 (SlowDown), 504, RequestTimeout (400), OperationAborted (409), and
// a 404 that is not the store's own. It reports at
// once those that will not pass: 400, 403, a missing object or bucket, a full store. A call that
// failed may still have been carried out.
//
// Errors: kNotFound (no such object); kUnavailable (not reachable, or overloaded, after all tries:
// it may be later); kTooLarge (more than object_bytes); kStorage (it refuses, is full, or gives an
// answer that an S3 store does not give). Messages name host, bucket and key, never the
// credentials.
//
// Thread safety: any thread; each call in progress has a connection of its own.
class S3Client {
 public:
  // Asks nothing yet. Errors: kInvalidInput (endpoint, region, bucket or credentials cannot be
  // used), kUnavailable (no libcurl).
  static Result<std::unique_ptr<S3Client>> Make(S3Options options);
  ~S3Client();
  S3Client(const S3Client&) = delete;
  S3Client& operator=(const S3Client&) = delete;

  // The store compares what it got with the hash that is signed. An object of that key is replaced.
  Status Put(const std::string& key, ByteView body);
  // `bytes`: the object's size; what is larger is kStorage, and not taken into memory. Bytes that do
  // not match the hash are requested once more, then kStorage.
  Result<Bytes> Get(const std::string& key, const Sha256& hash, size_t bytes);
  Status Head(const std::string& key);
  // Whether the store answers for the bucket within this time; the object need not exist.
  Status Look(const std::string& key, std::chrono::milliseconds within);
  // Absent: nothing to do.
  Status Delete(const std::string& key);

  // Keys that begin with the prefix, in order, at most a thousand; `next` of the page before, empty
  // for the first.
  Result<ListPage> List(const std::string& prefix, const std::string& next = {});
  // All of them, a page at a time. Errors: also kStorage where a page does not continue the one
  // before; `each` may then have seen some objects.
  Status ListEach(const std::string& prefix, const std::function<void(ListedObject&)>& each);
  // The bucket keeps what is overwritten and deleted. Never: neither does nor did, or the store
  // knows no versions.
  Result<Versioning> GetBucketVersioning();
  // The bucket may refuse to delete. A store that knows no locks: false.
  Result<bool> GetObjectLockConfiguration();

  // Does not wait for the store.
  S3Figures figures() const;

  // For messages: "https://HOST, bucket NAME".
  std::string Where() const;

 private:
  static constexpr size_t kMaxIdle = 16;
  static constexpr size_t kMaxRefusalBytes = 64 << 10;
  // A store may filter a page down to nothing and continue.
  static constexpr int kMaxEmptyPages = 100;
  struct Call;
  struct Answer;
  class Lease;
  S3Client(const Libcurl& curl, S3Options options);

  // With all its tries. `begun`: since when the call is counted. `answer`: the last one, also when
  // it is a refusal.
  Status Run(const Call& call, std::chrono::steady_clock::time_point begun, Answer& answer);
  Status Run(const Call& call);
  // The same, not counted.
  Status RunTries(const Call& call, std::chrono::steady_clock::time_point begun, Answer& answer);
  // One try; `again`: another may succeed.
  Status Try(const Call& call, std::chrono::milliseconds left, Answer& answer, bool& again);
  Status Judge(const Call& call, const Answer& answer, bool& again) const;
  Request Signed(const Call& call, std::string& authorization) const;

  const Libcurl& curl_;
  const S3Options options_;
  std::string host_;  // as the header Host says it
  std::atomic<uint64_t> requests_{0}, failed_{0};
  Histogram calls_;
  mutable Mutex mutex_;
  std::vector<void*> idle_ ENAMEL_GUARDED_BY(mutex_);  // handles of libcurl with their connections
  // When the calls in progress began.
  std::multiset<std::chrono::steady_clock::time_point> in_progress_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::s3
