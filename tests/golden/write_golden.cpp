#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/protocol/frame.h"
#include "common/protocol/messages.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "tests/common/trace/describe.h"
#include "tests/common/trace/sample.h"

// Writes the files of schemas/golden that a program can write (schemas/golden/README.md):
// recordings and their parts, the frames of the wire's messages, the built-in device profiles.
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

void WriteTraces(const std::filesystem::path& folder) {
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

// Each message's description is written by hand; its frame follows from it.
void WriteFrames(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> descriptions;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") descriptions.push_back(entry.path());
  }
  std::ranges::sort(descriptions);
  for (std::filesystem::path path : descriptions) {
    std::unique_ptr<google::protobuf::Message> message;
    if (path.filename().string().starts_with("request"))
      message = std::make_unique<wire::Request>();
    else
      message = std::make_unique<wire::Reply>();
    auto text = ReadFile(path);
    ENAMEL_CHECK(text.ok());
    auto parsed =
        google::protobuf::util::JsonStringToMessage(std::string(AsText(*text)), message.get());
    if (!parsed.ok()) std::fprintf(stderr, "%s: %s\n", path.c_str(), parsed.ToString().c_str());
    ENAMEL_CHECK(parsed.ok());
    const Bytes frame = *protocol::EncodeFrame(protocol::Serialize(*message));
    ENAMEL_CHECK(WriteFileDurably(path.replace_extension(".bin"), frame).ok());
    std::printf("%s: %zu bytes\n", path.stem().c_str(), frame.size());
  }
}

void WriteProfiles(const std::filesystem::path& folder) {
  for (const scene::DeviceProfile& profile : scene::BuiltinProfiles()) {
    const std::string name = "scene_profile_" + profile.name + ".json";
    const std::string text = scene::ToJson(profile);
    ENAMEL_CHECK(WriteFileDurably(folder / name, AsBytes(text)).ok());
    std::printf("%s: %zu bytes\n", name.c_str(), text.size());
  }
}

}  // namespace
}  // namespace enamel::trace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: enamel_write_golden FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  enamel::trace::WriteTraces(folder / "trace");
  enamel::trace::WriteFrames(folder / "wire");
  enamel::trace::WriteProfiles(folder);
  return 0;
}
