#include "station/uplink/credentials.h"

#include <sys/stat.h>

#include <algorithm>
#include <boost/json.hpp>

#include "common/base/csv.h"
#include "common/base/file.h"
#include "common/base/hex.h"
#include "station/uplink/private_folder.h"

namespace enamel::station {
namespace {

namespace json = boost::json;

constexpr int kFormat = 1;
constexpr char kKind[] = "enamel_station";
// The file has eight short members; a longer one is another file.
constexpr size_t kMaxFile = 64 << 10;

std::filesystem::path FileIn(const std::filesystem::path& folder) {
  return folder / "station.json";
}

Status Damaged(const std::filesystem::path& file, const std::string& what) {
  return Status(Code::kInvalidInput,
                file.string() + ": " + what + ": restore the file or enrol this station again",
                kEnrolment);
}

template <size_t N>
bool ReadHex(const json::object& object, const char* member, std::array<uint8_t, N>& out) {
  const json::value* v = object.if_contains(member);
  if (v == nullptr || !v->is_string()) return false;
  auto bytes = FromHex(std::string_view(v->get_string()));
  if (!bytes.ok() || bytes->size() != N) return false;
  std::copy(bytes->begin(), bytes->end(), out.begin());
  return true;
}

}  // namespace

trace::PublicKey Credentials::public_key() const {
  trace::PublicKey out;
  // libsodium's secret key is the seed and then the public key.
  std::copy(secret_key.end() - static_cast<ptrdiff_t>(out.size()), secret_key.end(), out.begin());
  return out;
}

Status SaveCredentials(const std::filesystem::path& folder, const Credentials& c) {
  ENAMEL_RETURN_IF_ERROR(MakePrivateFolder(folder));
  json::object object{{kKind, kFormat},
                      {"server", c.server.Text()},
                      {"fingerprint", c.fingerprint.Hex()},
                      {"station", c.station.Text()},
                      {"name", c.name},
                      {"credential", ToHex(c.credential)},
                      {"ticket_key", ToHex(c.ticket_key)},
                      {"secret_key", ToHex(c.secret_key)}};
  return WriteFileDurably(FileIn(folder), AsBytes(json::serialize(object) + "\n"), 0600);
}

Result<Credentials> LoadCredentials(const std::filesystem::path& folder) {
  std::filesystem::path file = FileIn(folder);
  auto bytes = ReadFile(file, kMaxFile);
  if (!bytes.ok() && bytes.status().code() == Code::kNotFound) {
    return Status(Code::kNotFound,
                  "this station is not enrolled (no " + file.string() +
                      "): ask an admin for a code ('enamel-server admin enrol-code') and run "
                      "'enamel-station enrol --server HOST:PORT --code CODE', or name the right "
                      "folder with --data");
  }
  if (!bytes.ok()) return Status(bytes.status().code(), bytes.status().message(), kEnrolment);
  struct stat info {};
  // Anybody who has read the key can sign recordings as this station. Changing the mode afterwards
  // does not tell whether somebody has, so the file is refused, not repaired here.
  if (::stat(file.c_str(), &info) == 0 && (info.st_mode & 077) != 0) {
    return Status(Code::kForbidden,
                  file.string() +
                      " can be read by others, and it holds this "
                      "station's key: 'chmod 600' it",
                  kEnrolment);
  }
  json::error_code error;
  json::value root = json::parse(AsText(*bytes), error);
  if (error || !root.is_object()) return Damaged(file, "expected a JSON object");
  const json::object& object = root.get_object();
  auto text = [&](const char* member) {
    const json::value* v = object.if_contains(member);
    return v != nullptr && v->is_string() ? std::string(v->get_string()) : std::string();
  };
  if (const json::value* v = object.if_contains(kKind);
      v == nullptr || !v->is_int64() || v->get_int64() != kFormat) {
    const std::string whose = object.contains("format") ? "an earlier Enamel" : "another version";
    return Status(Code::kVersion,
                  file.string() + " is of " + whose +
                      ", which this program cannot read: upload what was recorded here with the "
                      "program that wrote it, then enrol in another folder (--data)",
                  kEnrolment);
  }
  Credentials c;
  auto server = net::ParseEndpoint(text("server"));
  auto fingerprint = Sha256::FromHex(text("fingerprint"));
  auto station = Uuid::Parse(text("station"));
  if (!server.ok() || !fingerprint.ok() || !station.ok()) {
    return Damaged(file, "server, fingerprint or station is not readable");
  }
  c.server = *server;
  c.fingerprint = *fingerprint;
  c.station = *station;
  c.name = text("name");
  if (!ReadHex(object, "credential", c.credential) ||
      !ReadHex(object, "ticket_key", c.ticket_key) ||
      !ReadHex(object, "secret_key", c.secret_key)) {
    return Damaged(file, "a key is not readable");
  }
  return c;
}

Result<Credentials> LoadCredentialsFor(const std::filesystem::path& folder,
                                       std::string_view server) {
  auto credentials = LoadCredentials(folder);
  if (!credentials.ok() || server.empty()) return credentials;
  auto endpoint = net::ParseEndpoint(server);
  if (!endpoint.ok()) {
    return Status(endpoint.status().code(), endpoint.status().message(), kServerOption);
  }
  credentials->server = *endpoint;
  return credentials;
}

Result<EnrolCode> ParseEnrolCode(std::string_view text) {
  Status bad(Code::kInvalidInput,
             "expected CODE@FINGERPRINT as 'enamel-server admin enrol-code' prints it, found '" +
                 std::string(text.substr(0, 100)) + "'",
             "code");
  size_t at = text.find('@');
  if (at == std::string_view::npos || at == 0) return bad;
  std::string hex(text.substr(at + 1));
  // As openssl prints fingerprints, with colons, or without.
  hex.erase(std::remove(hex.begin(), hex.end(), ':'), hex.end());
  auto fingerprint = Sha256::FromHex(hex);
  if (!fingerprint.ok()) return bad;
  return EnrolCode{std::string(text.substr(0, at)), *fingerprint};
}

Result<EnrolCode> FindEnrolCode(std::string_view table, std::string_view name) {
  const CsvTable csv = ReadCsv(table);
  ENAMEL_RETURN_IF_ERROR(csv.status());
  if (csv.rows.empty() || csv.rows[0].cells != std::vector<std::string>{"name", "code"}) {
    return Status(Code::kInvalidInput,
                  "expected a table with the columns name,code, as 'enamel-server admin enrol-code "
                  "--names' prints it");
  }
  for (const CsvRow& row : csv.rows) {
    if (row.cells.size() == 2 && row.cells[0] == name) return ParseEnrolCode(row.cells[1]);
  }
  return Status(Code::kNotFound, "the table of codes has no station named '" + std::string(name) +
                                     "'; give this station's name with --name");
}

}  // namespace enamel::station
