#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/bytes.h"
#include "server/s3/s3_client.h"

namespace enamel::test {

// A store of one bucket on loopback that fails on command. It implements the part of S3 that we
// use, and checks signatures, hashes and times as S3 does. Objects outlive Stop. Thread safety: any
// thread.
class S3StandIn {
 public:
  S3StandIn();
  ~S3StandIn();
  S3StandIn(const S3StandIn&) = delete;
  S3StandIn& operator=(const S3StandIn&) = delete;

  static constexpr char kBucket[] = "blobs";
  static constexpr char kRegion[] = "eu-test-1";
  const s3::Credentials& credentials() const { return credentials_; }
  std::string endpoint() const { return "http://127.0.0.1:" + std::to_string(port_); }
  // For a client of its bucket.
  s3::S3Options options() const;

  enum class Fault {
    kNone,
    kForbidden,        // 403 AccessDenied
    kInternal,         // 500 InternalError
    kSlowDown,         // 503 SlowDown
    kSlowRequest,      // 400 RequestTimeout
    kAborted,          // 409 OperationAborted
    kNotImplemented,   // 501 NotImplemented
    kNotAllowed,       // 405 MethodNotAllowed
    kGateway,          // 502 with a page of HTML
    kProxyNotFound,    // 404 with a page of HTML
    kSamePage,         // the first page of a list, whatever page is asked for
    kEmptyPage,        // a page of a list without objects, and a token that was never seen before
    kFull,             // 507 XMinioStorageFull
    kQuota,            // 403 QuotaExceeded
    kResetInBody,      // of what is sent or received
    kResetAfterwards,  // what is asked for is done, and the answer lost
    kWrongBytes,       // 200, one byte of the body another
    kSilence,          // no answer, until the other ends the connection
  };
  // The next `count` requests of that method (empty: any) fail in this way; -1: all, until
  // FailNext(kNone, 0).
  void FailNext(Fault fault, int count, const std::string& method = {});
  // An outage: connections end and none is accepted, until Start.
  void Stop();
  void Start();

  // The bucket's own settings; empty: never versioned, or no lock.
  void SetVersioning(const std::string& state);
  void SetLocked(bool locked);
  void SetPageSize(size_t keys) { page_size_ = keys; }
  void SetNow(std::function<std::chrono::system_clock::time_point()> now);

  std::map<std::string, Bytes> objects() const;
  void SetObject(const std::string& key, Bytes body);
  void RemoveObject(const std::string& key);
  void SetModified(const std::string& key, std::chrono::system_clock::time_point time);
  int requests() const { return requests_; }
  int requests(const std::string& method) const;
  int connections() const { return connections_; }
  // Wrong requests: a signature that does not fit, a different body. Empty: none.
  std::vector<std::string> complaints() const;

 private:
  struct Object {
    Bytes body;
    std::chrono::system_clock::time_point modified;
  };
  struct Asked;
  struct Reply;
  class Connection;
  void Accept();
  void Serve(int socket);
  bool Answer(Connection& connection, const Asked& asked, Fault fault);
  Reply Do(const Asked& asked);
  Reply DoObject(const Asked& asked, const std::string& key);
  Reply DoBucket(const Asked& asked);
  std::string Complaint(const Asked& asked) const;
  Fault FaultOf(const std::string& method);

  const s3::Credentials credentials_{"AKIDTEST", "secret/of+the=test"};
  uint16_t port_ = 0;
  std::atomic<size_t> page_size_{1000};
  std::atomic<int> requests_{0}, connections_{0};
  std::atomic<bool> running_{false};
  int listener_ = -1;
  std::thread accepting_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<std::string, Object> objects_;
  std::map<std::string, int> asked_;  // by method
  Fault fault_ = Fault::kNone;
  int faults_left_ = 0;
  std::string fault_method_;
  std::string versioning_;
  bool locked_ = false;
  std::function<std::chrono::system_clock::time_point()> now_;
  std::vector<std::string> complaints_;
  std::list<int> sockets_;
  std::vector<std::thread> serving_;
};

}  // namespace enamel::test
