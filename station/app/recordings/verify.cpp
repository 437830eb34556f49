#include "station/app/recordings/verify.h"

#include <boost/json.hpp>
#include <cstdio>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "common/program/example.h"
#include "common/program/output.h"
#include "common/trace/replay.h"
#include "station/app/command_line.h"
#include "station/app/recordings/recording_file.h"
#include "station/uplink/credentials.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

std::string Trimmed(std::string text) {
  const char* const kBlank = " \t\r\n";
  text.erase(0, text.find_first_not_of(kBlank));
  return text.erase(text.find_last_not_of(kBlank) + 1);
}

// `text`: 64 hexadecimal digits, or the name of a file that holds them.
Result<trace::PublicKey> ReadKey(const std::string& text, const std::string& option) {
  constexpr size_t kMaxBytes = 4096;
  std::string digits = text;
  std::error_code none;
  // A file first: nobody gives a file a name of 64 hexadecimal digits.
  if (fs::exists(text, none)) {
    ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(text, kMaxBytes));
    digits = Trimmed(std::string(AsText(bytes)));
  }
  // A key is 32 bytes, like a hash.
  auto key = Sha256::FromHex(digits);
  if (!key.ok()) {
    return Status(Code::kInvalidInput,
                  option + ": expected 64 hexadecimal digits or a file that holds them, found \"" +
                      text.substr(0, 80) + "\"",
                  option);
  }
  trace::PublicKey out{};
  ByteView view = key->view();
  std::copy(view.begin(), view.end(), out.begin());
  return out;
}

struct Keys {
  trace::PublicKey station{}, server{};
};
Result<Keys> KeysFor(const VerifyOptions& options) {
  Keys out;
  // A key that is not given is this station's own, which requires enrolment.
  if (options.station_key.empty() || options.server_key.empty()) {
    auto own = LoadCredentials(options.data);
    if (!own.ok()) {
      return Status(own.status().code(),
                    "whose recording is it? Name both keys with --station-key and --server-key; " +
                        own.status().message());
    }
    out = {own->public_key(), own->ticket_key};
  }
  if (!options.station_key.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(out.station, ReadKey(options.station_key, "--station-key"));
  }
  if (!options.server_key.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(out.server, ReadKey(options.server_key, "--server-key"));
  }
  return out;
}

// The checks of one recording; prints each result at once. The first failure is the outcome.
class Checks {
 public:
  void Add(const char* name, const Status& status, const std::string& good) {
    std::printf("%-8s %-6s %s\n", name, status.ok() ? "ok" : "FAILED",
                status.ok() ? good.c_str() : status.message().c_str());
    json_[name] = status.ok();
    // Makes every check: two failures together say more than the first.
    if (first_.ok() && !status.ok()) first_ = status;
  }
  const Status& first_failure() const { return first_; }
  boost::json::object& json() { return json_; }

 private:
  Status first_;
  boost::json::object json_;
};

Status CheckTicket(const RecordingFile& recording, const trace::PublicKey& key) {
  if (trace::VerifyTicket(recording.header.ticket, key)) return Status::Ok();
  return Status(Code::kConflict, "the ticket was not issued by the server with this key");
}

Status CheckSignatures(const RecordingFile& recording, const trace::PublicKey& key) {
  for (size_t i = 0; i < recording.file.chunks.size(); ++i) {
    if (trace::VerifyChunk(recording.file.chunks[i], key)) continue;
    return Status(Code::kConflict, "chunk " + std::to_string(i) + " of " +
                                       std::to_string(recording.file.chunks.size()) +
                                       " was not signed by the station with this key");
  }
  return Status::Ok();
}

Status CheckSeal(const RecordingFile& recording) {
  // Before the seal: a file that ends early has none either, and that would be the wrong reason.
  if (recording.file.truncated) {
    return Status(Code::kConflict,
                  "the file is cut short: everything after its whole chunks is lost");
  }
  if (!recording.file.seal) {
    return Status(Code::kConflict,
                  "there is none: the recording was interrupted, or still running when it was "
                  "exported");
  }
  return Status::Ok();
}

Status CheckReplay(const RecordingFile& recording, const VerifyOptions& options) {
  ENAMEL_RETURN_IF_ERROR(core::ValidateParams(recording.header.params));
  ENAMEL_ASSIGN_OR_RETURN(auto volume,
                          ReadVolumeOf(recording.header, options.volume, options.data));
  core::Core core(recording.header.params, std::move(volume));
  ENAMEL_ASSIGN_OR_RETURN(
      const trace::ReplayReport report,
      trace::Replay(
          core, recording.header, recording.file.chunks,
          [](const trace::Tick&, const core::TickOutput&) {}, [](double) { return true; }));
  if (report.witness_ok) return Status::Ok();
  return Status(Code::kConflict,
                "the core differs at tick " + std::to_string(report.first_bad_tick) + " of chunk " +
                    std::to_string(report.first_bad_chunk) + " (" + report.what + ")");
}

}  // namespace

Status VerifyRecording(const VerifyOptions& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_ASSIGN_OR_RETURN(const RecordingFile recording, ReadRecordingFile(options.trace));
  ENAMEL_ASSIGN_OR_RETURN(const Keys keys, KeysFor(options));
  const std::string chunks = std::to_string(recording.file.chunks.size());
  Checks checks;
  // The cheapest first.
  checks.Add("ticket", CheckTicket(recording, keys.server), "issued by the server");
  checks.Add("chunks", CheckSignatures(recording, keys.station),
             "all " + chunks + " signed by the station");
  checks.Add("chain", CheckChain(recording), "each chunk follows the one before");
  checks.Add(
      "seal", CheckSeal(recording),
      "fits the last chunk; it has no signature, so that only the server can say that nothing came "
      "after");
  checks.Add("replay", CheckReplay(recording, options), "the core does every tick again");
  boost::json::object json{{"format", 1},
                           {"attempt_id", recording.header.ticket.attempt.Text()},
                           {"verified", checks.first_failure().ok()},
                           {"checks", checks.json()}};
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(options.json, json));
  return checks.first_failure();
}

void DeclareVerify(CommandGroup group) {
  auto [cmd, o] = Declare<VerifyOptions>(
      group, "verify",
      "Check an exported recording: ticket, signatures, chain, seal, and every tick again",
      [&place = group.place](VerifyOptions& options) {
        options.data = place.data;
        return VerifyRecording(options);
      });
  AddDataOption(*cmd, group.place);
  cmd->add_option("trace", o.trace, "File from 'spool export'")->required();
  cmd->add_option("--station-key", o.station_key,
                  "Public key of the station, 64 hexadecimal digits or a file; this station's own "
                  "if left out");
  cmd->add_option("--server-key", o.server_key,
                  "Public key of the server's tickets, 64 hexadecimal digits or a file");
  cmd->add_option("--volume", o.volume, "The tooth it began with, when it is not in the cache");
  cmd->add_option("--json", o.json, "Write what was found to this file");
  program::AddExamples(*cmd, {"last.entrace --server-key server.pub"});
}

}  // namespace enamel::station
