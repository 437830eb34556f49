#include "server/commands/verify_result.h"

#include <vector>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/base/hex.h"
#include "server/commands/say.h"
#include "server/results/result_files.h"

namespace enamel::server::app {
namespace {

namespace fs = std::filesystem;

struct Asked {
  fs::path file;
  std::string key;
};

// Those beside the result that it binds.
Result<std::vector<ResultFile>> FilesBeside(const fs::path& result) {
  std::vector<ResultFile> out;
  for (std::string_view name : BoundFileNames()) {
    std::error_code error;
    const fs::path path = result.parent_path() / name;
    if (!fs::exists(path, error)) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto content, ReadFile(path));
    out.push_back({std::string(name), std::move(content)});
  }
  return out;
}

Result<ResultDocument> ReadSigned(const Asked& asked) {
  ENAMEL_ASSIGN_OR_RETURN(const auto bytes, ReadFile(asked.file));
  ENAMEL_ASSIGN_OR_RETURN(auto document, DecodeResult(bytes));
  if (!VerifyResult(document)) {
    return Status(
        Code::kInvalidInput,
        asked.file.string() + ": changed since it was signed; ask the school for it again");
  }
  if (!asked.key.empty() && ToHex(document.key) != asked.key) {
    return Status(Code::kInvalidInput, asked.file.string() + ": expected the signature of key " +
                                           asked.key + ", found that of " + ToHex(document.key));
  }
  return document;
}

void List(const char* what, const std::vector<std::string>& names) {
  if (names.empty()) return;
  Say("{}\n", what);
  for (const std::string& name : names) Say("  {}\n", name);
}

Status VerifyResultFile(const Asked& asked) {
  ENAMEL_ASSIGN_OR_RETURN(const auto document, ReadSigned(asked));
  ENAMEL_ASSIGN_OR_RETURN(const auto files, FilesBeside(asked.file));
  const ResultCheck check = CheckResultFiles(document, files);
  Say("{:.1f} of 100 points{} for attempt {}, scored {} UTC\nsigned by key {}{}\n"
      "fingerprint {}, as the printed report has it\n",
      document.points, document.critical_fail ? " (critical fault)" : "", document.attempt.Text(),
      UtcText(document.scored_ms), ToHex(document.key),
      asked.key.empty() ? ": compare it with the one that the school names" : "",
      HashSha256(EncodeResult(document)).Hex());
  List("as signed:", check.as_signed);
  List("not there:", check.not_there);
  List("CHANGED:", check.changed);
  if (check.changed.empty()) return Status::Ok();
  return Status(Code::kConflict, Counted(check.changed.size(), "file is", "files are") +
                                     " not what was signed; ask the school for the result again");
}

}  // namespace

void DeclareVerifyResult(CommandGroup root) {
  auto [verify, o] = Declare<Asked>(
      root, "verify-result", "Check a signed result and the files beside it", VerifyResultFile);
  verify->add_option("FILE", o.file, "result.bin, of a person's export or of the API")->required();
  verify->add_option("--key", o.key, "The school's public key: 64 hexadecimal digits, lower case")
      ->check([](const std::string& text) {
        const bool ok =
            text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
        return ok ? std::string() : "expected 64 hexadecimal digits, lower case";
      });
  verify->footer(
      "Needs no server and no data folder. `enamel-server admin list-stations` shows the school's\n"
      "key. verify_result.py checks the same with Python, in the package enamel-doc as\n"
      "/usr/share/doc/enamel/schemas/verify_result.py.\n\n"
      "  tar -xf result.tar && enamel-server verify-result result.bin\n\n"
      "Exit codes: 0 as signed, 1 something was changed or cannot be read.");
}

}  // namespace enamel::server::app
