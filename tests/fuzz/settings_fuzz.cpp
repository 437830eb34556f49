#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/program/settings.h"

// Any bytes as a settings file: refused with file and line, or settings that read back the same
// from the file they make.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  struct Settings {
    std::string http = "127.0.0.1:8080";
    int threads = 1;
    bool flag = false;
    std::vector<std::string> names;
    CLI::App app{"settings"};
    Settings() {
      app.add_option("--http", http)->capture_default_str();
      app.add_option("--job-threads", threads)->check(CLI::Range(0, 64))->capture_default_str();
      app.add_flag("--http-self-signed", flag);
      app.add_option("--host-name", names);
    }
  };
  Settings given;
  std::string_view text(reinterpret_cast<const char*>(data), size);
  Status read = program::ReadSettings(text, "fuzz.toml", given.app);
  if (!read.ok()) {
    ENAMEL_CHECK(read.message().starts_with("fuzz.toml:"));
    return 0;
  }
  ENAMEL_CHECK(given.threads >= 0 && given.threads <= 64);
  Settings again;
  Status reread = program::ReadSettings(program::SettingsText(given.app), "again.toml", again.app);
  ENAMEL_CHECK(reread.ok());
  ENAMEL_CHECK(again.http == given.http && again.threads == given.threads);
  ENAMEL_CHECK(again.names == given.names && again.flag == given.flag);
  return 0;
}
