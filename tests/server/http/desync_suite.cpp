#include "tests/server/http/desync_suite.h"

#include <algorithm>
#include <filesystem>

#include "common/base/file.h"

namespace enamel::server::http {
namespace {

void AppendEscape(std::string_view text, size_t& i, std::string& out) {
  char c = text[++i];
  if (c == 'x') {
    int byte = std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16);
    // YAML's \xNN is the character U+00NN; the suite means the byte.
    out += static_cast<char>(byte);
    i += 2;
  } else {
    out += c == 't' ? '\t' : c == 'r' ? '\r' : c == 'n' ? '\n' : c == '0' ? '\0' : c;
  }
}

std::string DoubleQuoted(std::string_view text) {
  std::string out;
  for (size_t i = 1; i < text.size() && text[i] != '"'; ++i) {
    if (text[i] == '\\' && i + 1 < text.size()) {
      AppendEscape(text, i, out);
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string SingleQuoted(std::string_view text) {
  std::string out;
  for (size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '\'') {
      if (i + 1 >= text.size() || text[i + 1] != '\'') break;
      ++i;
    }
    out += text[i];
  }
  return out;
}

std::string Scalar(std::string_view text) {
  if (text.starts_with('"')) return DoubleQuoted(text);
  if (text.starts_with('\'')) return SingleQuoted(text);
  if (size_t comment = text.find(" #"); comment != std::string_view::npos)
    text = text.substr(0, comment);
  size_t last = text.find_last_not_of(' ');
  return std::string(text.substr(0, last == std::string_view::npos ? 0 : last + 1));
}

struct Line {
  size_t indent = 0;
  bool item = false;  // begins with "- "
  std::string key, value;
};

Line Split(std::string_view text) {
  Line out;
  out.indent = text.find_first_not_of(' ');
  text.remove_prefix(out.indent);
  if (text.starts_with("- ")) {
    out.item = true;
    text.remove_prefix(2);
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  }
  size_t colon = text.find(':');
  if (colon == std::string_view::npos) return out;
  out.key = std::string(text.substr(0, colon));
  text.remove_prefix(colon + 1);
  size_t value = text.find_first_not_of(' ');
  if (value != std::string_view::npos) out.value = Scalar(text.substr(value));
  return out;
}

void Take(const Line& line, DesyncCase& into) {
  if (line.indent <= 2) {
    if (line.key == "name") into.name = line.value;
    if (line.key == "uri") into.uri = line.value;
    if (line.key == "method") into.method = line.value;
    if (line.key == "version") into.version = line.value;
    return;
  }
  if (line.key == "name" && line.item) into.headers.emplace_back(line.value, "");
  if (line.key == "value" && !into.headers.empty()) into.headers.back().second = line.value;
  if (line.key == "tier" && line.indent == 4) into.tier = line.value;
  if (line.key == "reason" && line.indent == 4) into.reason = line.value;
}

}  // namespace

std::string DesyncCase::Head() const {
  std::string out = method + " " + uri + (version.empty() ? "" : " " + version) + "\r\n";
  bool has_host = std::any_of(headers.begin(), headers.end(),
                              [](const auto& header) { return header.first == "Host"; });
  if (!has_host) out += "Host: localhost\r\n";
  for (const auto& [header, value] : headers) out += header + ": " + value + "\r\n";
  return out + "\r\n";
}

std::vector<DesyncCase> ReadDesyncCases(std::string_view yaml) {
  std::vector<DesyncCase> out;
  while (!yaml.empty()) {
    size_t end = std::min(yaml.find('\n'), yaml.size());
    std::string_view text = yaml.substr(0, end);
    yaml.remove_prefix(std::min(end + 1, yaml.size()));
    size_t first = text.find_first_not_of(" \r");
    if (first == std::string_view::npos || text[first] == '#') continue;
    Line line = Split(text);
    if (line.item && line.indent == 0) out.emplace_back();
    // `tier` of a header is next to its name, `tier` of the verdict is under "expected".
    if (!out.empty()) Take(line, out.back());
  }
  return out;
}

std::vector<DesyncCase> SharedDesyncCases() {
  namespace fs = std::filesystem;
  std::vector<DesyncCase> out;
  const fs::path folder = fs::path(ENAMEL_SHARED_DATA) / "suites/http_desync_guardian/tests";
  if (!fs::exists(folder)) return out;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    Result<Bytes> text = ReadFile(file, 1 << 20);
    if (!text.ok()) continue;
    for (DesyncCase& found : ReadDesyncCases(AsText(*text))) out.push_back(std::move(found));
  }
  return out;
}

}  // namespace enamel::server::http
