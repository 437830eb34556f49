#include "tests/support/s3_stand_in.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <optional>

#include "common/base/check.h"

namespace enamel::test {
namespace {

using std::chrono::system_clock;

std::string Decoded(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size()) {
      out += static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string Escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

std::string Iso(system_clock::time_point time) {
  const std::time_t seconds = system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S.000Z", &utc);
  return text;
}

system_clock::time_point OfAmzDate(const std::string& text) {
  std::tm utc{};
  return strptime(text.c_str(), "%Y%m%dT%H%M%SZ", &utc) == nullptr
             ? system_clock::time_point()
             : system_clock::from_time_t(timegm(&utc));
}

}  // namespace

struct S3StandIn::Asked {
  std::string method, path;
  s3::Pairs query;
  std::map<std::string, std::string> headers;
  Bytes body;
  std::string Param(const std::string& name) const {
    for (const auto& [key, value] : query) {
      if (key == name) return value;
    }
    return {};
  }
  bool Has(const std::string& name) const {
    return std::ranges::any_of(query, [&](const auto& pair) { return pair.first == name; });
  }
};

struct S3StandIn::Reply {
  int status = 200;
  Bytes body{};
  static Reply Refuse(int status, const std::string& code) {
    const std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Error><Code>" + code +
                            "</Code><Message>as it was told to</Message></Error>";
    return {status, Bytes(xml.begin(), xml.end())};
  }
  static Reply Xml(const std::string& text) { return {200, Bytes(text.begin(), text.end())}; }
};

// One connection: requests in, bytes out.
class S3StandIn::Connection {
 public:
  explicit Connection(int socket) : socket_(socket) {}

  // None: it ended.
  std::optional<Asked> Head(size_t& length) {
    size_t end;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
      if (buffer_.size() > 64 << 10 || !Fill()) return std::nullopt;
    }
    Asked out;
    const std::string head = buffer_.substr(0, end + 2);
    buffer_.erase(0, end + 4);
    size_t at = head.find("\r\n");
    const std::string line = head.substr(0, at);
    out.method = line.substr(0, line.find(' '));
    const std::string target =
        line.substr(out.method.size() + 1, line.rfind(' ') - out.method.size() - 1);
    const size_t question = target.find('?');
    out.path = Decoded(target.substr(0, question));
    for (std::string rest = question == std::string::npos ? "" : target.substr(question + 1);
         !rest.empty();) {
      const size_t cut = std::min(rest.find('&'), rest.size());
      const std::string pair = rest.substr(0, cut);
      const size_t equal = std::min(pair.find('='), pair.size());
      out.query.emplace_back(Decoded(pair.substr(0, equal)),
                             Decoded(pair.substr(std::min(equal + 1, pair.size()))));
      rest.erase(0, cut + 1);
    }
    for (at += 2; at < head.size();) {
      const size_t stop = head.find("\r\n", at);
      const std::string header = head.substr(at, stop - at);
      const size_t colon = header.find(':');
      out.headers[Lower(header.substr(0, colon))] = header.substr(colon + 2);
      at = stop + 2;
    }
    const auto said = out.headers.find("content-length");
    length = said == out.headers.end() ? 0 : std::stoul(said->second);
    return out;
  }
  bool Body(Asked& asked, size_t length) {
    while (buffer_.size() < length) {
      if (!Fill()) return false;
    }
    asked.body.assign(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(length));
    buffer_.erase(0, length);
    return true;
  }
  bool Send(ByteView data) {
    while (!data.empty()) {
      const ssize_t sent = ::send(socket_, data.data(), data.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      data = data.subspan(static_cast<size_t>(sent));
    }
    return true;
  }
  // The peer's next read or write fails with ECONNRESET.
  void Reset() {
    const linger now{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
  }
  bool Fill() {
    char piece[16 << 10];
    const ssize_t got = ::recv(socket_, piece, sizeof piece, 0);
    if (got <= 0) return false;
    buffer_.append(piece, static_cast<size_t>(got));
    return true;
  }

 private:
  const int socket_;
  std::string buffer_;
};

s3::S3Options S3StandIn::options() const {
  s3::S3Options out;
  out.endpoint = endpoint();
  out.region = kRegion;
  out.bucket = kBucket;
  out.credentials = credentials_;
  return out;
}

S3StandIn::S3StandIn() : now_([] { return system_clock::now(); }) { Start(); }

S3StandIn::~S3StandIn() { Stop(); }

void S3StandIn::Start() {
  ENAMEL_CHECK(!running_);
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port_);
  ENAMEL_CHECK(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  ENAMEL_CHECK(::listen(listener_, 64) == 0);
  socklen_t size = sizeof address;
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  port_ = ntohs(address.sin_port);
  running_ = true;
  accepting_ = std::thread([this] { Accept(); });
}

void S3StandIn::Stop() {
  if (!running_.exchange(false)) return;
  ::shutdown(listener_, SHUT_RDWR);  // wakes accept
  accepting_.join();
  ::close(listener_);
  std::vector<std::thread> serving;
  {
    std::lock_guard lock(mutex_);
    for (int socket : sockets_) ::shutdown(socket, SHUT_RDWR);
    serving.swap(serving_);
  }
  for (std::thread& thread : serving) thread.join();
}

void S3StandIn::Accept() {
  while (running_) {
    const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket < 0) continue;
    ++connections_;
    std::lock_guard lock(mutex_);
    if (!running_) {
      ::close(socket);
      return;
    }
    sockets_.push_back(socket);
    serving_.emplace_back([this, socket] { Serve(socket); });
  }
}

void S3StandIn::Serve(int socket) {
  Connection connection(socket);
  for (;;) {
    size_t length = 0;
    auto asked = connection.Head(length);
    if (!asked) break;
    const Fault fault = FaultOf(asked->method);
    if (fault == Fault::kResetInBody && asked->method == "PUT") {
      connection.Body(*asked, length / 2);
      connection.Reset();
      break;
    }
    if (!connection.Body(*asked, length) || !Answer(connection, *asked, fault)) break;
  }
  std::lock_guard lock(mutex_);
  sockets_.remove(socket);
  ::close(socket);
}

S3StandIn::Fault S3StandIn::FaultOf(const std::string& method) {
  std::lock_guard lock(mutex_);
  ++requests_;
  ++asked_[method];
  if (faults_left_ == 0 || (!fault_method_.empty() && fault_method_ != method)) return Fault::kNone;
  if (faults_left_ > 0) --faults_left_;
  return fault_;
}

bool S3StandIn::Answer(Connection& connection, const Asked& asked, Fault fault) {
  Reply reply;
  switch (fault) {
    case Fault::kForbidden:
      reply = Reply::Refuse(403, "AccessDenied");
      break;
    case Fault::kInternal:
      reply = Reply::Refuse(500, "InternalError");
      break;
    case Fault::kSlowRequest:
      reply = Reply::Refuse(400, "RequestTimeout");
      break;
    case Fault::kAborted:
      reply = Reply::Refuse(409, "OperationAborted");
      break;
    case Fault::kNotImplemented:
      reply = Reply::Refuse(501, "NotImplemented");
      break;
    case Fault::kNotAllowed:
      reply = Reply::Refuse(405, "MethodNotAllowed");
      break;
    case Fault::kSlowDown:
      reply = Reply::Refuse(503, "SlowDown");
      break;
    case Fault::kFull:
      reply = Reply::Refuse(507, "XMinioStorageFull");
      break;
    case Fault::kQuota:
      reply = Reply::Refuse(403, "QuotaExceeded");
      break;
    case Fault::kGateway:
      reply = Reply::Xml("<html><br>Bad Gateway</html>");
      reply.status = 502;
      break;
    case Fault::kProxyNotFound:
      reply = Reply::Xml("<html><br>Not Found</html>");
      reply.status = 404;
      break;
    case Fault::kSamePage: {
      Asked first = asked;
      std::erase_if(first.query,
                    [](const auto& each) { return each.first == "continuation-token"; });
      std::lock_guard lock(mutex_);
      reply = DoBucket(first);
      break;
    }
    case Fault::kEmptyPage:
      reply =
          Reply::Xml("<ListBucketResult><IsTruncated>true</IsTruncated><NextContinuationToken>" +
                     std::to_string(requests_) + "</NextContinuationToken></ListBucketResult>");
      break;
    case Fault::kSilence:
      while (connection.Fill()) {
      }
      return false;
    default:
      reply = Do(asked);
  }
  const bool empty = asked.method == "HEAD" || reply.status == 204;
  if (fault == Fault::kResetAfterwards || (fault == Fault::kResetInBody && empty)) {
    connection.Reset();
    return false;
  }
  if (fault == Fault::kWrongBytes && !reply.body.empty()) reply.body.back() ^= 1;
  const std::string head = "HTTP/1.1 " + std::to_string(reply.status) +
                           " Said\r\nContent-Length: " + std::to_string(reply.body.size()) +
                           "\r\n\r\n";
  Bytes all(head.begin(), head.end());
  if (!empty) all.insert(all.end(), reply.body.begin(), reply.body.end());
  if (fault == Fault::kResetInBody) {
    connection.Send(ByteView(all).first(all.size() - reply.body.size() / 2));
    connection.Reset();
    return false;
  }
  return connection.Send(all);
}

std::string S3StandIn::Complaint(const Asked& asked) const {
  auto header = [&](const std::string& name) {
    const auto found = asked.headers.find(name);
    return found == asked.headers.end() ? std::string() : found->second;
  };
  if (HashSha256(asked.body).Hex() != header("x-amz-content-sha256"))
    return "XAmzContentSHA256Mismatch";
  const auto off = OfAmzDate(header("x-amz-date")) - now_();
  if (off > std::chrono::minutes(15) || off < -std::chrono::minutes(15))
    return "RequestTimeTooSkewed";
  const std::string said = header("authorization");
  constexpr std::string_view kNames = "SignedHeaders=";
  const size_t at = said.find(kNames);
  if (at == std::string::npos) return "AccessDenied";
  s3::Request request{asked.method, asked.path, asked.query, {}, HashSha256(asked.body)};
  std::string names = said.substr(at + kNames.size());
  names = names.substr(0, names.find(','));
  for (const char* needed : {"host", "x-amz-date", "x-amz-content-sha256"}) {
    if ((";" + names + ";").find(std::string(";") + needed + ";") == std::string::npos)
      return "AccessDenied";
  }
  while (!names.empty()) {
    const size_t cut = std::min(names.find(';'), names.size());
    request.headers.emplace_back(names.substr(0, cut), header(names.substr(0, cut)));
    names.erase(0, cut + 1);
  }
  const std::string expected =
      s3::Authorization(request, {kRegion}, credentials_, header("x-amz-date"));
  return said == expected ? "" : "SignatureDoesNotMatch";
}

S3StandIn::Reply S3StandIn::Do(const Asked& asked) {
  std::lock_guard lock(mutex_);
  if (std::string complaint = Complaint(asked); !complaint.empty()) {
    complaints_.push_back(complaint);
    return Reply::Refuse(complaint == "XAmzContentSHA256Mismatch" ? 400 : 403, complaint);
  }
  const std::string bucket = std::string("/") + kBucket;
  if (asked.path == bucket) return DoBucket(asked);
  if (!asked.path.starts_with(bucket + "/")) return Reply::Refuse(404, "NoSuchBucket");
  return DoObject(asked, asked.path.substr(bucket.size() + 1));
}

S3StandIn::Reply S3StandIn::DoObject(const Asked& asked, const std::string& key) {
  if (asked.method == "PUT") {
    objects_[key] = {asked.body, now_()};
    return {};
  }
  if (asked.method == "DELETE") {
    objects_.erase(key);
    return {204};
  }
  const auto found = objects_.find(key);
  if (found == objects_.end()) return Reply::Refuse(404, "NoSuchKey");
  return {200, found->second.body};
}

S3StandIn::Reply S3StandIn::DoBucket(const Asked& asked) {
  if (asked.Has("versioning")) {
    return Reply::Xml("<VersioningConfiguration>" +
                      (versioning_.empty() ? "" : "<Status>" + versioning_ + "</Status>") +
                      "</VersioningConfiguration>");
  }
  if (asked.Has("object-lock")) {
    if (!locked_) return Reply::Refuse(404, "ObjectLockConfigurationNotFoundError");
    return Reply::Xml(
        "<ObjectLockConfiguration><ObjectLockEnabled>Enabled</ObjectLockEnabled>"
        "</ObjectLockConfiguration>");
  }
  if (asked.method != "GET" || asked.Param("list-type") != "2")
    return Reply::Refuse(501, "NotImplemented");
  const std::string prefix = asked.Param("prefix"), after = asked.Param("continuation-token");
  std::string contents, last;
  size_t count = 0;
  bool more = false;
  for (const auto& [key, object] : objects_) {
    if (!key.starts_with(prefix) || (!after.empty() && key <= after)) continue;
    if (count == page_size_) {
      more = true;
      break;
    }
    contents += "<Contents><Key>" + Escaped(key) + "</Key><LastModified>" + Iso(object.modified) +
                "</LastModified><Size>" + std::to_string(object.body.size()) + "</Size></Contents>";
    last = key;
    ++count;
  }
  return Reply::Xml("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<ListBucketResult>" +
                    std::string(more ? "<IsTruncated>true</IsTruncated><NextContinuationToken>" +
                                           Escaped(last) + "</NextContinuationToken>"
                                     : "<IsTruncated>false</IsTruncated>") +
                    contents + "</ListBucketResult>");
}

void S3StandIn::FailNext(Fault fault, int count, const std::string& method) {
  std::lock_guard lock(mutex_);
  fault_ = fault;
  faults_left_ = count;
  fault_method_ = method;
}

void S3StandIn::SetVersioning(const std::string& state) {
  std::lock_guard lock(mutex_);
  versioning_ = state;
}

void S3StandIn::SetLocked(bool locked) {
  std::lock_guard lock(mutex_);
  locked_ = locked;
}

void S3StandIn::SetNow(std::function<system_clock::time_point()> now) {
  std::lock_guard lock(mutex_);
  now_ = std::move(now);
}

std::map<std::string, Bytes> S3StandIn::objects() const {
  std::lock_guard lock(mutex_);
  std::map<std::string, Bytes> out;
  for (const auto& [key, object] : objects_) out[key] = object.body;
  return out;
}

void S3StandIn::SetObject(const std::string& key, Bytes body) {
  std::lock_guard lock(mutex_);
  objects_[key] = {std::move(body), now_()};
}

void S3StandIn::RemoveObject(const std::string& key) {
  std::lock_guard lock(mutex_);
  objects_.erase(key);
}

void S3StandIn::SetModified(const std::string& key, system_clock::time_point time) {
  std::lock_guard lock(mutex_);
  objects_.at(key).modified = time;
}

int S3StandIn::requests(const std::string& method) const {
  std::lock_guard lock(mutex_);
  const auto found = asked_.find(method);
  return found == asked_.end() ? 0 : found->second;
}

std::vector<std::string> S3StandIn::complaints() const {
  std::lock_guard lock(mutex_);
  return complaints_;
}

}  // namespace enamel::test
