#include <cstdio>
#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "tests/common/trace/describe.h"
#include "tests/common/trace/sample.h"

// Writes schemas/golden/trace anew (schemas/golden/README.md).
namespace enamel::trace {
namespace {

namespace json = boost::json;

bool IsFlat(const json::array& array) {
  for (const json::value& v : array) {
    if (v.is_object() || v.is_array()) return false;
  }
  return true;
}

void Pretty(const json::value& value, const std::string& indent, std::string& out) {
  const std::string inner = indent + "  ";
  std::string separator = "\n";
  if (value.is_object() && !value.get_object().empty()) {
    out += "{";
    for (const auto& [key, item] : value.get_object()) {
      out += separator + inner + json::serialize(json::value(key)) + ": ";
      Pretty(item, inner, out);
      separator = ",\n";
    }
    out += "\n" + indent + "}";
  } else if (value.is_array() && !IsFlat(value.get_array())) {
    out += "[";
    for (const json::value& item : value.get_array()) {
      out += separator + inner;
      Pretty(item, inner, out);
      separator = ",\n";
    }
    out += "\n" + indent + "]";
  } else {
    out += json::serialize(value);
  }
}

void Write(const std::filesystem::path& folder, const std::string& name, ByteView bytes,
           const json::object& content) {
  std::string text;
  Pretty(content, "", text);
  text += "\n";
  ENAMEL_CHECK(WriteFileDurably(folder / (name + ".bin"), bytes).ok());
  ENAMEL_CHECK(WriteFileDurably(folder / (name + ".json"), AsBytes(text)).ok());
  std::printf("%s: %zu bytes\n", name.c_str(), bytes.size());
}

void WriteAll(const std::filesystem::path& folder) {
  Header header = sample::MakeHeader();
  Write(folder, "ticket", EncodeTicket(header.ticket), Describe(header.ticket));
  Write(folder, "header", EncodeHeader(header), Describe(header));

  ChunkHead head;
  head.attempt = header.ticket.attempt;
  head.state_hash = 0x0123456789abcdefull;
  head.previous = HashSha256(EncodeHeader(header));
  Bytes chunk = EncodeChunk(head, sample::OddTicks(), sample::StationKeys().secret_key);
  Write(folder, "chunk", chunk, Describe(*DecodeChunk(chunk)));

  auto recording = sample::Record(sample::CutInputs(1500), 500);
  Write(folder, "seal", EncodeSeal(recording.seal), Describe(recording.seal));
  TraceFile file{EncodeHeader(recording.header), recording.chunks, recording.seal, false};
  Write(folder, "recording", EncodeTraceFile(file), Describe(file));
}

}  // namespace
}  // namespace enamel::trace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: enamel_write_golden FOLDER\n");
    return 2;
  }
  enamel::trace::WriteAll(argv[1]);
  return 0;
}
