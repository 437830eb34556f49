#include <algorithm>
#include <string>

#include "common/base/check.h"
#include "server/http/wire/request_reader.h"

namespace {

using namespace enamel;
using namespace enamel::server::http;
using Step = RequestReader::Step;

struct Outcome {
  bool refused = false;
  size_t used = 0;
  std::string text;  // the request, or the status of the refusal

  bool operator==(const Outcome&) const = default;
};

std::string TextOf(const Request& request) {
  std::string out = std::string(MethodName(request.method)) + " " + request.path + "\n";
  for (const auto& [name, value] : request.query) out += name + "=" + value + "\n";
  for (const auto& [name, value] : request.headers) out += name + ": " + value + "\n";
  return out + "\n" + request.body;
}

// One request out of `stream`, which arrives `piece` bytes at a time; none if it is cut off.
bool ReadIn(std::string_view stream, size_t piece, Outcome& out) {
  RequestReader reader;
  size_t arrived = 0;
  out = {};
  while (arrived < stream.size()) {
    arrived = std::min(stream.size(), arrived + piece);
    size_t used = 0;
    Step step = reader.Feed(stream.substr(out.used, arrived - out.used), used);
    ENAMEL_CHECK(used <= arrived - out.used);
    out.used += used;
    out.refused = step == Step::kRefused;
    if (out.refused) out.text = std::to_string(reader.refusal().status);
    if (step == Step::kRequest) out.text = TextOf(reader.request());
    if (out.refused || step == Step::kRequest) return true;
    ENAMEL_CHECK(arrived - out.used < kMaxHeadBytes);  // what the connection's buffer must hold
  }
  return false;
}

// The guarantees that the layers behind the reader rely on.
void CheckRequest(std::string_view stream, const Outcome& whole) {
  std::string head(stream.substr(0, stream.find("\r\n\r\n")));
  ENAMEL_CHECK(head.find('\0') == std::string::npos);
  std::transform(head.begin(), head.end(), head.begin(),
                 [](unsigned char c) { return static_cast<char>(c < 0x80 ? std::tolower(c) : c); });
  bool length = head.find("\r\ncontent-length:") != std::string::npos;
  bool coding = head.find("\r\ntransfer-encoding:") != std::string::npos;
  ENAMEL_CHECK(!(length && coding));
  ENAMEL_CHECK(head.find("\r\nhost:") != std::string::npos);
  size_t head_bytes = head.size() + 4;
  ENAMEL_CHECK(length || coding || whole.used == head_bytes);
  size_t body = whole.text.size() - whole.text.find("\n\n") - 2;
  ENAMEL_CHECK(coding || body == whole.used - head_bytes || whole.text.find("\n\n") == 0);
}

}  // namespace

// Any bytes from a browser: one request or a refusal, the same however they are split, and every
// request separated as in RFC 9112.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string_view stream(reinterpret_cast<const char*>(data), size);
  Outcome whole, pieces;
  bool done = ReadIn(stream, std::max<size_t>(size, 1), whole);
  size_t piece = size > 0 ? data[size - 1] % 61 + 1u : 1u;
  bool done_in_pieces = ReadIn(stream, piece, pieces);
  // A stream that ends early may be refused earlier in one piece than in many; both refuse or wait.
  if (done && !whole.refused) {
    ENAMEL_CHECK(done_in_pieces && pieces == whole);
    CheckRequest(stream, whole);
  } else {
    ENAMEL_CHECK(!done_in_pieces || pieces.refused);
  }
  return 0;
}
