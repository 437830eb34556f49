#include "common/program/settings.h"

#include <toml++/toml.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <numeric>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/file.h"

namespace enamel::program {
namespace {

constexpr size_t kMaxFileBytes = 1 << 20;
constexpr size_t kMaxKeyBytes = 64;  // of a key that is compared with the known ones
// Where to read settings from, and what is only for the command line.
constexpr std::string_view kNotInFile[] = {"help", "help-all", "config", "print-settings"};

bool IsSetting(const std::string& name) {
  return !name.empty() && std::ranges::find(kNotInFile, name) == std::end(kNotInFile);
}

// Long name without dashes; empty: none.
std::string NameOf(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

// The option's name of a file's key.
std::string SettingOf(std::string_view key) {
  std::string out(key);
  std::ranges::replace(out, '_', '-');
  return out;
}

// The section of a settings file that an option belongs to; empty: none.
std::string SectionOf(const CLI::Option& option) {
  const std::string& group = option.get_group();
  return NameOf(option).starts_with(group + "-") ? group : std::string();
}

std::string Where(const std::string& file, const toml::source_region& region) {
  return file + ":" + std::to_string(region.begin.line) + ":" +
         std::to_string(region.begin.column) + ": ";
}

// Letters to put in, take out or change that make one of the other (Levenshtein).
size_t Edits(std::string_view from, std::string_view to) {
  std::vector<size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < from.size(); ++i) {
    size_t before = std::exchange(row[0], i + 1);
    for (size_t j = 0; j < to.size(); ++j) {
      size_t change = before + (from[i] == to[j] ? 0 : 1);
      before = row[j + 1];
      row[j + 1] = std::min({change, before + 1, row[j] + 1});
    }
  }
  return row.back();
}

// The settings there are; of many, those that `found` may have meant.
std::string Names(const CLI::App& command, std::set<std::string> of_others,
                  std::string_view found) {
  constexpr size_t kMany = 12, kNearest = 5;
  of_others.merge(SettingNames(command));
  std::vector<std::string> names(of_others.begin(), of_others.end());
  const size_t all = names.size();
  if (all > kMany) {
    // Edits takes time by the product of the two lengths, and a file's key may be as long as the
    // file.
    found = found.substr(0, kMaxKeyBytes);
    std::ranges::stable_sort(names, {}, [&](const auto& name) { return Edits(found, name); });
    names.resize(kNearest);
  }
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return all > kMany ? out + " (the nearest of " + std::to_string(all) + " settings)" : out;
}

Result<std::vector<std::string>> TextsOf(const toml::node& node) {
  // Exact: value() would also take what can be converted, such as 1.0 for an integer.
  if (auto text = node.value_exact<std::string>()) return std::vector{*text};
  if (auto number = node.value_exact<int64_t>()) return std::vector{std::to_string(*number)};
  if (auto yes = node.value_exact<bool>()) return std::vector<std::string>{*yes ? "true" : "false"};
  const toml::array* list = node.as_array();
  std::vector<std::string> out;
  bool texts = list != nullptr;
  for (size_t i = 0; texts && i < list->size(); ++i) {
    auto text = list->get(i)->value_exact<std::string>();
    texts = text.has_value();
    if (texts) out.push_back(*text);
  }
  if (texts) return out;
  return Status(Code::kInvalidInput, "expected a text, an integer, true, false or a list of texts");
}

// Where the quotes that begin at `at` end: one past the last. Nowhere: the end of the text.
size_t EndOfQuotes(std::string_view text, size_t at) {
  const char quote = text[at];
  const std::string three(3, quote);
  const std::string closing = text.substr(at).starts_with(three) ? three : std::string(1, quote);
  for (at += closing.size(); at < text.size(); ++at) {
    // TOML's single quotes know no escapes.
    if (text[at] == '\\' && quote == '"')
      ++at;
    else if (text.substr(at).starts_with(closing))
      return at + closing.size();
    else if (text[at] == '\n' && closing.size() == 1)
      break;
  }
  return std::min(at, text.size());
}

// The first character beyond ASCII outside of quotes and comments, where TOML has none; npos: there
// is none. Called before the parser, whose behaviour with some of them is undefined (toml++ 3.1).
size_t StrayCharacter(std::string_view text) {
  for (size_t at = text.starts_with("\xef\xbb\xbf") ? 3 : 0; at < text.size();) {
    const char c = text[at];
    if (static_cast<unsigned char>(c) >= 0x80) return at;
    if (c == '"' || c == '\'') {
      at = EndOfQuotes(text, at);
    } else if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else {
      ++at;
    }
  }
  return std::string_view::npos;
}

// Unless something nearer gave the option already.
Status Apply(CLI::Option& option, const std::vector<std::string>& texts) {
  // Nearer places are read first, so what is there already is to stay.
  if (option.count() > 0 || texts.empty()) return Status::Ok();
  try {
    for (const std::string& text : texts) option.add_result(text);
    option.run_callback();
  } catch (const CLI::Error& error) {
    return Status(Code::kInvalidInput, error.what());
  }
  return Status::Ok();
}

bool HasSection(const CLI::App& command, const std::string& section) {
  return !section.empty() &&
         std::ranges::any_of(command.get_options(), [&](const CLI::Option* option) {
           return SectionOf(*option) == section;
         });
}

// The settings of a section, whose name with "-" begins theirs, or of the file.
Status ApplyTable(const toml::table& table, const std::string& section, const std::string& file,
                  CLI::App& command, const std::set<std::string>& of_others) {
  for (auto&& [key, node] : table) {
    const std::string name = section + SettingOf(key.str());
    if (const toml::table* inner = node.as_table(); inner != nullptr && HasSection(command, name)) {
      ENAMEL_RETURN_IF_ERROR(ApplyTable(*inner, name + "-", file, command, of_others));
      continue;
    }
    CLI::Option* option = IsSetting(name) ? command.get_option_no_throw("--" + name) : nullptr;
    if (option != nullptr && section.empty() && !SectionOf(*option).empty()) option = nullptr;
    if (option == nullptr && (of_others.contains(name) || of_others.contains(kAnyKey))) continue;
    if (option == nullptr) {
      return Status(Code::kInvalidInput, Where(file, key.source()) + "expected one of " +
                                             Names(command, of_others, name) + "; found \"" +
                                             std::string(key.str()) + "\"");
    }
    auto texts = TextsOf(node);
    Status applied = texts.ok() ? Apply(*option, *texts) : texts.status();
    if (!applied.ok()) {
      return Status(Code::kInvalidInput,
                    Where(file, node.source()) + name + ": " + applied.message());
    }
  }
  return Status::Ok();
}

std::string Quoted(const std::string& text) {
  std::ostringstream out;
  // The library's own escapes: what is printed reads back.
  out << toml::value<std::string>(text);
  return out.str();
}

std::string ValueText(const CLI::Option& option) {
  std::vector<std::string> values = option.results();
  if (values.empty() && !option.get_default_str().empty()) values = {option.get_default_str()};
  if (values.empty()) return "";
  bool list = option.get_expected_max() > 1;
  std::string out;
  for (const std::string& value : values) out += (out.empty() ? "" : ", ") + Quoted(value);
  return list ? "[" + out + "]" : out;
}

}  // namespace

std::string EnvironmentName(const std::string& option, const std::string& prefix) {
  std::string out = prefix + option;
  std::ranges::transform(out, out.begin(), [](unsigned char c) {
    return c == '-' ? '_' : static_cast<char>(std::toupper(c));
  });
  return out;
}

Status ReadEnvironment(CLI::App& command, const std::string& prefix) {
  for (CLI::Option* option : command.get_options()) {
    std::string name = NameOf(*option);
    // The environment may say where the file is; a file cannot name another.
    if (!IsSetting(name) && name != "config") continue;
    const char* value = std::getenv(EnvironmentName(name, prefix).c_str());
    if (value == nullptr) continue;
    if (Status applied = Apply(*option, {value}); !applied.ok()) {
      return Status(Code::kInvalidInput, EnvironmentName(name, prefix) + ": " + applied.message());
    }
  }
  return Status::Ok();
}

Status ReadSettingsFile(const std::filesystem::path& file, CLI::App& command,
                        const std::set<std::string>& of_others) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(file, kMaxFileBytes));
  return ReadSettings(AsText(bytes), file.string(), command, of_others);
}

Status ReadSettings(std::string_view text, const std::string& file, CLI::App& command,
                    const std::set<std::string>& of_others) {
  if (size_t stray = StrayCharacter(text); stray != std::string_view::npos) {
    auto line = 1 + std::ranges::count(text.substr(0, stray), '\n');
    return Status(Code::kInvalidInput, file + ":" + std::to_string(line) +
                                           ": expected letters beyond ASCII in quotes only");
  }
  toml::table table;
  try {
    table = toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    return Status(Code::kInvalidInput,
                  Where(file, error.source()) + std::string(error.description()));
  }
  return ApplyTable(table, "", file, command, of_others);
}

std::vector<std::string> ApplyPolicy(const std::vector<PolicySetting>& policy, CLI::App& command,
                                     const std::set<std::string>& nearer) {
  std::vector<std::string> wrong;
  for (const PolicySetting& setting : policy) {
    CLI::Option* option =
        IsSetting(setting.name) ? command.get_option_no_throw("--" + setting.name) : nullptr;
    if (option == nullptr || nearer.contains(setting.name)) continue;
    const std::vector<std::string> before = option->results();
    if (setting.fixed) option->clear();
    if (Status applied = Apply(*option, {setting.value}); !applied.ok()) {
      wrong.push_back(setting.name + ": " + applied.message());
      option->clear();
      (void)Apply(*option, before);
    }
  }
  return wrong;
}

std::set<std::string> GivenSettings(const CLI::App& command) {
  std::set<std::string> out;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() > 0) out.insert(NameOf(*option));
  }
  return out;
}

std::set<std::string> SettingsIn(const std::filesystem::path& file) {
  std::set<std::string> out;
  auto bytes = ReadFile(file, kMaxFileBytes);
  if (!bytes.ok() || StrayCharacter(AsText(*bytes)) != std::string_view::npos) return out;
  try {
    for (auto&& [key, node] : toml::parse(AsText(*bytes))) {
      const std::string name = SettingOf(key.str());
      out.insert(name);
      if (const toml::table* section = node.as_table(); section != nullptr)
        for (auto&& [inner, value] : *section) out.insert(name + "-" + SettingOf(inner.str()));
    }
  } catch (const toml::parse_error&) {
    return {};
  }
  return out;
}

std::set<std::string> SettingNames(const CLI::App& app) {
  std::set<std::string> out;
  for (const CLI::Option* option : app.get_options()) {
    if (std::string name = NameOf(*option); IsSetting(name)) out.insert(name);
  }
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    out.merge(SettingNames(*command));
  }
  return out;
}

std::string SettingsText(const CLI::App& command) {
  std::string out;
  std::map<std::string, std::string> sections;  // behind all that is in none
  for (const CLI::Option* option : command.get_options()) {
    std::string name = NameOf(*option);
    if (!IsSetting(name)) continue;
    const std::string section = SectionOf(*option);
    if (!section.empty()) name = name.substr(section.size() + 1);
    std::string& to = section.empty() ? out : sections[section];
    std::string value = ValueText(*option);
    std::istringstream help(option->get_description());
    for (std::string line; std::getline(help, line);) to += "# " + line + "\n";
    to += value.empty() ? "# " + name + " =\n" : name + " = " + value + "\n";
  }
  for (const auto& [section, text] : sections) out += "\n[" + section + "]\n" + text;
  return out;
}

}  // namespace enamel::program
