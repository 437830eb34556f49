#include "server/s3/s3_client.h"

#include <sodium.h>

#include <algorithm>
#include <cstring>
#include <thread>

#include "common/base/utf8.h"
#include "server/s3/endpoint.h"
#include "server/s3/libcurl.h"

namespace enamel::s3 {
namespace {

using std::chrono::milliseconds;

// Whether there may be room, or rights, later is the store's keeper's business.
bool IsFull(long status, const std::string& code) {
  return status == 507 || code == "QuotaExceeded" || code == "EntityTooLarge" ||
         code.find("StorageFull") != std::string::npos ||
         code.find("QuotaExceeded") != std::string::npos;
}

// S3 API Reference, "Error responses": RequestTimeout comes with 400, where what was sent came too
// slowly; OperationAborted with 409, while another request for the same key is under way. The answer
// to HEAD names no code.
bool MayPass(long status, const std::string& code) {
  return status == 408 || status == 429 || status == 500 || status == 502 || status == 503 ||
         status == 504 || code == "SlowDown" || code == "RequestTimeout" ||
         code == "OperationAborted" || (status == 409 && code.empty());
}

// The store does not know the setting of a bucket that was asked for.
bool IsUnknownSetting(long status, const std::string& code) {
  return status == 501 || status == 405 || code == "NotImplemented" || code == "MethodNotAllowed";
}

bool MayPass(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_CONNECT:
    case CURLE_WEIRD_SERVER_REPLY:
    case CURLE_PARTIAL_FILE:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_SSL_CONNECT_ERROR:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_FAIL_REWIND:  // a kept connection that was lost; libcurl leaves the rest to us
      return true;
    default:
      return false;
  }
}

// What to do about a 403.
const char* Remedy(const std::string& code) {
  if (code == "RequestTimeTooSkewed" || code == "RequestExpired")
    return "set this machine's clock, or the store's";
  if (code == "SignatureDoesNotMatch" || code == "InvalidAccessKeyId")
    return "check that access key and secret are those of the store, and that the region is";
  return "check that the access key may read, write, list and delete in this bucket";
}

}  // namespace

struct S3Client::Call {
  std::string method;
  std::string key{};  // empty: the bucket itself
  Pairs query{};
  ByteView body{};
  Sha256 body_hash = HashSha256({});
  size_t most = kMaxXmlBytes;  // of the answer's body
};

struct S3Client::Answer {
  long status = 0;
  Bytes body;
  size_t most = 0;
  bool too_large = false;
  const Libcurl* curl = nullptr;
  CURL* handle = nullptr;
  ByteView unsent;

  static size_t Receive(char* data, size_t one, size_t count, void* to) {
    auto& answer = *static_cast<Answer*>(to);
    const size_t size = one * count;
    answer.curl->easy_getinfo(answer.handle, CURLINFO_RESPONSE_CODE, &answer.status);
    // The beginning of a refusal is enough.
    const bool refusal = answer.status >= 300;
    const size_t most = refusal ? kMaxRefusalBytes : answer.most;
    const size_t taken = std::min(size, most - std::min(most, answer.body.size()));
    answer.body.insert(answer.body.end(), data, data + taken);
    if (taken == size || refusal) return size;
    answer.too_large = true;
    return 0;
  }
  static size_t Send(char* data, size_t one, size_t count, void* from) {
    auto& answer = *static_cast<Answer*>(from);
    const size_t size = std::min(one * count, answer.unsent.size());
    std::memcpy(data, answer.unsent.data(), size);
    answer.unsent = answer.unsent.subspan(size);
    return size;
  }
};

// A handle for one try. One that failed is not used again: what is left of its connection is
// unknown.
class S3Client::Lease {
 public:
  explicit Lease(S3Client& client) : client_(client) {
    {
      MutexLock lock(client.mutex_);
      if (!client.idle_.empty()) {
        handle_ = client.idle_.back();
        client.idle_.pop_back();
      }
    }
    if (handle_ == nullptr) handle_ = client.curl_.easy_init();
  }
  ~Lease() {
    if (handle_ == nullptr) return;
    if (keep_) {
      client_.curl_.easy_reset(handle_);
      MutexLock lock(client_.mutex_);
      if (client_.idle_.size() < kMaxIdle) {
        client_.idle_.push_back(handle_);
        return;
      }
    }
    client_.curl_.easy_cleanup(handle_);
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  CURL* get() const { return handle_; }
  void Keep() { keep_ = true; }

 private:
  S3Client& client_;
  CURL* handle_ = nullptr;
  bool keep_ = false;
};

Result<std::unique_ptr<S3Client>> S3Client::Make(S3Options options) {
  ENAMEL_ASSIGN_OR_RETURN(Place place, PlaceOf(options.endpoint));
  // S3 User Guide, "Bucket naming rules"; other stores admit more.
  if (!IsSimple(options.bucket, "-._", 255) || options.bucket.starts_with('.')) {
    return Status(
        Code::kInvalidInput,
        "expected the name of a bucket, of letters, digits, \"-\", \".\" and \"_\", found "
        "\"" +
            Printable(options.bucket) + "\"",
        "bucket");
  }
  if (!IsSimple(options.region, "-_", 100)) {
    return Status(Code::kInvalidInput,
                  "expected a region like us-east-1, found \"" + Printable(options.region) + "\"",
                  "region");
  }
  // Both go into headers. Swift's tempauth has "account:user".
  const Credentials& who = options.credentials;
  if (!IsSimple(who.access_key, "-._:+=@", 256) || who.secret_key.empty()) {
    return Status(
        Code::kInvalidInput,
        "expected an access key and its secret for the S3 store, found " +
            std::string(who.access_key.empty()   ? "no access key"
                        : who.secret_key.empty() ? "no secret"
                                                 : "signs that an access key does not have"),
        "credentials");
  }
  ENAMEL_ASSIGN_OR_RETURN(const Libcurl* curl, LoadLibcurl());
  if (!options.time.now) options.time.now = [] { return std::chrono::system_clock::now(); };
  if (!options.time.steady) options.time.steady = [] { return std::chrono::steady_clock::now(); };
  if (!options.time.pause) {
    options.time.pause = [](milliseconds time) { std::this_thread::sleep_for(time); };
  }
  options.endpoint = (place.secure ? "https://" : "http://") + place.host;
  auto client = std::unique_ptr<S3Client>(new S3Client(*curl, std::move(options)));
  client->host_ = place.host;
  return client;
}

S3Client::S3Client(const Libcurl& curl, S3Options options)
    : curl_(curl), options_(std::move(options)) {}

S3Client::~S3Client() {
  MutexLock lock(mutex_);
  for (void* handle : idle_) curl_.easy_cleanup(handle);
}

std::string S3Client::Where() const { return options_.endpoint + ", bucket " + options_.bucket; }

Request S3Client::Signed(const Call& call, std::string& authorization) const {
  Request out;
  out.method = call.method;
  out.path = "/" + options_.bucket + (call.key.empty() ? "" : "/" + call.key);
  out.query = call.query;
  out.body = call.body_hash;
  const std::string date = AmzDate(options_.time.now());
  out.headers = {{"Host", host_}, {"x-amz-content-sha256", out.body.Hex()}, {"x-amz-date", date}};
  if (const std::string& token = options_.credentials.session_token; !token.empty())
    out.headers.emplace_back("x-amz-security-token", token);
  authorization = Authorization(out, {options_.region}, options_.credentials, date);
  return out;
}

Status S3Client::Try(const Call& call, milliseconds left, Answer& answer, bool& again) {
  again = false;
  Lease lease(*this);
  CURL* const handle = lease.get();
  if (handle == nullptr) return Status(Code::kUnavailable, "libcurl has no memory; try again");
  std::string authorization;
  const Request request = Signed(call, authorization);
  const std::string question = CanonicalQuery(request.query);
  const std::string url =
      options_.endpoint + UriEncode(request.path, false) + (question.empty() ? "" : "?" + question);
  curl_slist* headers = nullptr;
  auto add = [&](const std::string& line) { headers = curl_.slist_append(headers, line.c_str()); };
  for (const auto& [name, value] : request.headers) add(name + ": " + value);
  add("Authorization: " + authorization);
  add("Expect:");  // else a second round trip before each large PUT
  char words[CURL_ERROR_SIZE] = "";
  answer = {};
  answer.most = call.most;
  // In one piece: growing, it would be in memory twice.
  if (call.method == "GET" && !call.key.empty()) answer.body.reserve(call.most);
  answer.curl = &curl_;
  answer.handle = handle;
  answer.unsent = call.body;
  auto set = [&](CURLoption option, auto value) { curl_.easy_setopt(handle, option, value); };
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PATH_AS_IS, 1L);  // a key may be "a/../b"
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_PROXY, "");
  set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  set(CURLOPT_HTTPHEADER, headers);
  set(CURLOPT_ERRORBUFFER, words);
  set(CURLOPT_NOSIGNAL, 1L);  // other threads
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(options_.limits.connect.count()));
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(std::max<int64_t>(left.count(), 1)));
  set(CURLOPT_LOW_SPEED_LIMIT, 1L);
  set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(options_.limits.stall.count()));
  set(CURLOPT_WRITEFUNCTION, &Answer::Receive);
  set(CURLOPT_WRITEDATA, &answer);
  if (!options_.ca_file.empty()) set(CURLOPT_CAINFO, options_.ca_file.c_str());
  if (call.method == "PUT") {
    set(CURLOPT_UPLOAD, 1L);
    set(CURLOPT_READFUNCTION, &Answer::Send);
    set(CURLOPT_READDATA, &answer);
    set(CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(call.body.size()));
  } else if (call.method == "HEAD") {
    set(CURLOPT_NOBODY, 1L);
  } else {
    set(CURLOPT_CUSTOMREQUEST, call.method.c_str());
  }
  ++requests_;
  const CURLcode code = curl_.easy_perform(handle);
  curl_.easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &answer.status);
  curl_.slist_free_all(headers);
  if (code == CURLE_OK) {
    lease.Keep();
    return Judge(call, answer, again);
  }
  const std::string what = call.method + " " + call.key + " at " + Where();
  if (answer.too_large) {
    return Status(Code::kTooLarge, "expected at most " + std::to_string(call.most) + " bytes of " +
                                       what + ", found more; find out what put it there");
  }
  again = MayPass(code);
  const std::string found = words[0] != '\0' ? words : curl_.easy_strerror(code);
  if (again) {
    return Status(Code::kUnavailable, "expected an answer to " + what + ", found: " + found +
                                          "; check that the store runs and can be reached");
  }
  const bool certificate =
      code == CURLE_PEER_FAILED_VERIFICATION || code == CURLE_SSL_CACERT_BADFILE;
  return Status(Code::kStorage, "expected an answer to " + what + ", found: " + found + "; " +
                                    (certificate ? "check that the CA file belongs to the "
                                                   "authority that signed the store's certificate"
                                                 : "check that the endpoint is an S3 store"));
}

Status S3Client::Judge(const Call& call, const Answer& answer, bool& again) const {
  again = false;
  if (answer.status >= 200 && answer.status < 300) return Status::Ok();
  const auto refusal = ReadRefusal(AsText(answer.body));
  const std::string code = refusal.ok() ? refusal->code : std::string();
  const std::string what = call.method + " " + call.key + " at " + Where();
  const std::string found =
      std::to_string(answer.status) +
      (refusal.ok() ? " " + Printable(ShortenedText(code + ": " + refusal->message, 300)) : "");
  // Head looks into a 404 by itself.
  if (answer.status == 404 && (code == "NoSuchKey" || call.method == "HEAD"))
    return Status(Code::kNotFound, "there is no object " + call.key + " at " + Where());
  if (IsFull(answer.status, code)) {
    return Status(Code::kStorage,
                  "the store has no room for " + what + " (" + found + "); make room there");
  }
  if (MayPass(answer.status, code)) {
    again = true;
    return Status(Code::kUnavailable, "the store cannot do " + what + " now (" + found +
                                          "); check the store, and try again");
  }
  if (answer.status == 403) {
    return Status(Code::kStorage,
                  "the store refuses " + what + " (" + found + "); " + Remedy(code));
  }
  if (code == "NoSuchBucket") {
    return Status(Code::kStorage, "the store has no bucket for " + what + " (" + found +
                                      "); create the bucket, or name another one");
  }
  // A store names what is missing. A page that does not is a proxy's, and does not prove that it is
  // gone.
  if (answer.status == 404) {
    again = true;
    return Status(Code::kUnavailable, "something other than an S3 store answered " + what + " (" +
                                          found + "); check the endpoint and any proxy before it");
  }
  return Status(Code::kStorage, "the store does not do " + what + " (" + found +
                                    "); see that endpoint, region and bucket are right");
}

Status S3Client::Run(const Call& call, std::chrono::steady_clock::time_point begun,
                     Answer& answer) {
  const auto now = options_.time.steady();
  {
    MutexLock lock(mutex_);
    in_progress_.insert(now);
  }
  Status status = RunTries(call, begun, answer);
  calls_.Add(options_.time.steady() - now);
  // The store has answered where there is no such object, or a larger one than the caller takes.
  if (!status.ok() && status.code() != Code::kNotFound && status.code() != Code::kTooLarge)
    ++failed_;
  MutexLock lock(mutex_);
  in_progress_.erase(in_progress_.find(now));
  return status;
}

S3Figures S3Client::figures() const {
  S3Figures out{requests_, failed_, calls_.counts(), 0};
  MutexLock lock(mutex_);
  if (!in_progress_.empty()) {
    out.oldest_wait_s =
        std::chrono::duration<double>(options_.time.steady() - *in_progress_.begin()).count();
  }
  return out;
}

Status S3Client::RunTries(const Call& call, std::chrono::steady_clock::time_point begun,
                          Answer& answer) {
  const S3Limits& limits = options_.limits;
  auto left = [&] {
    return std::chrono::duration_cast<milliseconds>(limits.call - (options_.time.steady() - begun));
  };
  Status status(Code::kUnavailable, "no time was left to ask " + Where() + "; try again");
  milliseconds pause = limits.first_pause;
  for (int n = 1; left() > milliseconds(0); ++n) {
    bool again = false;
    status = Try(call, left(), answer, again);
    if (!again || n >= limits.tries) break;
    const auto half = static_cast<uint32_t>(pause.count() / 2);
    const milliseconds random(half + randombytes_uniform(half + 1));
    if (random >= left()) break;
    options_.time.pause(random);
    pause = std::min(pause * 2, limits.longest_pause);
  }
  return status;
}

Status S3Client::Run(const Call& call) {
  Answer answer;
  return Run(call, options_.time.steady(), answer);
}

Status S3Client::Put(const std::string& key, ByteView body) {
  if (body.size() > options_.limits.object_bytes) {
    return Status(Code::kTooLarge, "expected an object of at most " +
                                       std::to_string(options_.limits.object_bytes) +
                                       " bytes, found " + std::to_string(body.size()));
  }
  Call call{"PUT", key};
  call.body = body;
  call.body_hash = HashSha256(body);
  return Run(call);
}

Result<Bytes> S3Client::Get(const std::string& key, const Sha256& hash, size_t bytes) {
  Call call{"GET", key};
  call.most = bytes;
  const auto begun = options_.time.steady();
  // Once more: what came may have been changed on the way, or by one of several copies.
  for (int n = 1; n <= 2; ++n) {
    Answer answer;
    const Status came = Run(call, begun, answer);
    if (came.code() == Code::kTooLarge) return Status(Code::kStorage, came.message());
    ENAMEL_RETURN_IF_ERROR(came);
    if (HashSha256(answer.body) == hash) return std::move(answer.body);
  }
  return Status(Code::kStorage, "expected the object " + key + " with the content " + hash.Hex() +
                                    ", found other bytes, twice, at " + Where() +
                                    "; restore it from a backup");
}

Status S3Client::Head(const std::string& key) {
  const auto begun = options_.time.steady();
  Answer answer;
  Status status = Run(Call{"HEAD", key}, begun, answer);
  if (answer.status != 404) return status;
  // The answer to HEAD has no body, so a proxy's 404 looks like the store's. The answer to GET has
  // one.
  Call get{"GET", key};
  get.most = 0;
  status = Run(get, begun, answer);
  return status.code() == Code::kTooLarge ? Status::Ok() : status;
}

Status S3Client::Look(const std::string& key, milliseconds within) {
  Call get{"GET", key};
  get.most = 0;
  Answer answer;
  const milliseconds call = options_.limits.call;
  const Status status = Run(get, options_.time.steady() - (call - std::min(within, call)), answer);
  const bool answered = status.code() == Code::kTooLarge || status.code() == Code::kNotFound;
  return answered ? Status::Ok() : status;
}

Status S3Client::Delete(const std::string& key) {
  const Status status = Run(Call{"DELETE", key});
  return status.code() == Code::kNotFound ? Status::Ok() : status;
}

Result<ListPage> S3Client::List(const std::string& prefix, const std::string& next) {
  Call call{"GET"};
  call.query = {{"list-type", "2"}, {"max-keys", "1000"}, {"prefix", prefix}};
  if (!next.empty()) call.query.emplace_back("continuation-token", next);
  Answer answer;
  ENAMEL_RETURN_IF_ERROR(Run(call, options_.time.steady(), answer));
  return ReadListPage(AsText(answer.body));
}

Status S3Client::ListEach(const std::string& prefix,
                          const std::function<void(ListedObject&)>& each) {
  std::string next, last;
  int empty_pages = 0;
  do {
    ENAMEL_ASSIGN_OR_RETURN(ListPage page, List(prefix, next));
    // Keys come in the order of their UTF-8 bytes (S3 API Reference, ListObjectsV2). A page that
    // does not continue the one before would be listed forever.
    bool advances = page.next.empty() || !page.objects.empty() || ++empty_pages <= kMaxEmptyPages;
    for (ListedObject& object : page.objects) {
      advances = advances && object.key > last;
      last = object.key;
      if (advances) each(object);
    }
    if (!advances || (!page.next.empty() && page.next == next)) {
      return Status(Code::kStorage, "the list of objects at " + Where() +
                                        " repeats itself; check that the endpoint is an S3 store");
    }
    next = page.next;
  } while (!next.empty());
  return Status::Ok();
}

Result<Versioning> S3Client::GetBucketVersioning() {
  Call call{"GET"};
  call.query = {{"versioning", ""}};
  Answer answer;
  const Status status = Run(call, options_.time.steady(), answer);
  if (status.ok()) return ReadVersioning(AsText(answer.body));
  const auto refusal = ReadRefusal(AsText(answer.body));
  if (IsUnknownSetting(answer.status, refusal.ok() ? refusal->code : "")) return Versioning::kNever;
  return status;
}

Result<bool> S3Client::GetObjectLockConfiguration() {
  Call call{"GET"};
  call.query = {{"object-lock", ""}};
  Answer answer;
  const Status status = Run(call, options_.time.steady(), answer);
  if (status.ok()) return ReadObjectLock(AsText(answer.body));
  // AWS, Ceph and MinIO say of a bucket without a lock that it has no configuration.
  const auto refusal = ReadRefusal(AsText(answer.body));
  const std::string code = refusal.ok() ? refusal->code : std::string();
  if (answer.status == 404 && code == "ObjectLockConfigurationNotFoundError") return false;
  if (IsUnknownSetting(answer.status, code)) return false;
  return status;
}

}  // namespace enamel::s3
