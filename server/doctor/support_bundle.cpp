#include "server/doctor/support_bundle.h"

#include <sys/sysinfo.h>
#include <sys/utsname.h>

#include <boost/json.hpp>
#include <deque>
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/net/frame_client.h"
#include "common/net/web_question.h"
#include "common/program/findings.h"
#include "common/program/output.h"
#include "common/program/version.h"
#include "server/app/data_folder.h"
#include "server/doctor/doctor.h"
#include "server/doctor/scrub.h"

namespace enamel::server::app {
namespace {

namespace json = boost::json;

constexpr size_t kMaxLines = 5000, kMaxLineBytes = 4000;

json::object System() {
  utsname name{};
  ::uname(&name);
  struct sysinfo info {};
  ::sysinfo(&info);
  return {{"system", std::string(name.sysname) + " " + name.release},
          {"machine", name.machine},
          {"processors", std::thread::hardware_concurrency()},
          {"memory_mib", (uint64_t{info.totalram} * info.mem_unit) >> 20},
          {"up_s", info.uptime}};
}

// Who must not be named. Errors: the store's.
Result<std::set<std::string>> Names(const ServeOptions& serve) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenForCommand(serve.data));
  std::set<std::string> out;
  PeopleFilter everybody;
  everybody.limit = 200;
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(const auto people, store->people.FindPeople(everybody));
    for (const Person& person : people) {
      out.insert(person.login);
      out.insert(person.display_name);
      // Each part as well: a message may have one of them.
      for (size_t at = 0; at < person.display_name.size();) {
        const size_t end = std::min(person.display_name.find(' ', at), person.display_name.size());
        if (end - at > 2) out.insert(person.display_name.substr(at, end - at));
        at = end + 1;
      }
    }
    if (people.size() < everybody.limit) break;
    everybody.after_login = people.back().login;
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto stations, store->stations.Stations());
  for (const StationRow& station : stations) out.insert(station.name);
  ENAMEL_ASSIGN_OR_RETURN(const auto cohorts, store->cohorts.Cohorts());
  for (const Cohort& cohort : cohorts) out.insert(cohort.name);
  return out;
}

// What names the computer and, with it, the school.
std::set<std::string> Hosts(const ServeOptions& serve) {
  std::set<std::string> out(serve.host_names.begin(), serve.host_names.end());
  utsname name{};
  ::uname(&name);
  out.insert(name.nodename);
  // Of https://HOST:PORT/PATH.
  const size_t scheme = serve.page_url.find("://");
  if (scheme != std::string::npos) {
    const std::string rest = serve.page_url.substr(scheme + 3);
    out.insert(rest.substr(0, rest.find_first_of(":/")));
  }
  return out;
}

// A line of the log: text, or one JSON object of which the message is scrubbed.
json::value Line(const Scrubber& scrubber, const std::string& line) {
  boost::system::error_code error;
  const json::value parsed = json::parse(line, error);
  const json::object* object = error ? nullptr : parsed.if_object();
  if (object == nullptr) return json::string(scrubber.Scrubbed(line));
  json::object out;
  for (const auto& [name, value] : *object) {
    const bool is_said = name == "message" || !value.is_string();
    const bool is_known = name == "time" || name == "level" || name == "request";
    if (is_known) {
      out[name] = value;
    } else if (value.is_string()) {
      out[name] = scrubber.Scrubbed(std::string(value.as_string()));
    } else if (is_said) {
      out[name] = value;
    }
  }
  return out;
}

// The last lines.
json::array Lines(const Scrubber& scrubber, std::istream& in) {
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    line.resize(std::min(line.size(), kMaxLineBytes));
    lines.push_back(std::move(line));
    if (lines.size() > kMaxLines) lines.pop_front();
  }
  json::array out;
  for (const std::string& line : lines) out.push_back(Line(scrubber, line));
  return out;
}

// What the running server answers; null: nothing.
json::value Answer(const ServeOptions& serve, const char* path) {
  const auto at = net::ParseEndpoint(serve.http);
  if (!at.ok()) return nullptr;
  net::WebQuestion question{at->host, at->port};
  if (question.host == "0.0.0.0") question.host = "127.0.0.1";
  if (question.host == "::") question.host = "::1";
  question.tls = serve.http_self_signed || !serve.http_certificate.empty();
  if (!serve.host_names.empty()) question.host_name = serve.host_names.front();
  question.path = path;
  const auto answer = net::Ask(question);
  return answer.ok() && answer->status != 404 ? json::value(answer->body) : json::value();
}

json::array Scrubbed(const Scrubber& scrubber, json::value findings) {
  json::array out;
  for (json::value& finding : findings.as_object().at("findings").as_array()) {
    json::object one = std::move(finding.as_object());
    for (const char* text : {"what", "found", "advice"}) {
      one[text] = scrubber.Scrubbed(std::string(one[text].as_string()));
    }
    out.push_back(std::move(one));
  }
  return out;
}

// Those that are set.
json::array Settings(const Scrubber& scrubber, const std::string& text) {
  json::array out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('#')) out.emplace_back(scrubber.Scrubbed(line, /*quoted=*/false));
  }
  return out;
}

Status Write(const std::filesystem::path& target, const std::string& text) {
  if (target == "-") {
    std::cout << text << std::flush;
    return std::cout.good() ? Status::Ok()
                            : Status(Code::kStorage, "standard output cannot be written");
  }
  Status written = WriteFileDurably(target, AsBytes(text), 0600);
  if (written.ok()) return written;
  return Status(written.code(), written.message() +
                                    "; name a file on another disk, or - and pass standard output "
                                    "on");
}

}  // namespace

Status SupportBundle(const SupportBundleCommand& command) {
  const auto names = Names(command.serve);
  const Scrubber scrubber(names.ok() ? *names : std::set<std::string>(), Hosts(command.serve));
  json::object out{{"format", 1},
                   {"made_ms", enamel::UnixMs()},
                   {"version", program::VersionText("enamel-server")},
                   {"machine", System()}};
  out["settings"] = Settings(scrubber, command.settings);
  out["doctor"] = Scrubbed(scrubber, program::FindingsJson(Examine(command.serve)));
  out["readyz"] = Answer(command.serve, "/readyz");
  out["metrics"] = Answer(command.serve, "/metrics");
  out["log"] = nullptr;
  if (!names.ok()) {
    out["log_problem"] =
        "left out: the database, which knows whose names to take out, cannot be read: " +
        scrubber.Scrubbed(names.status().message());
  } else if (command.log == "-") {
    out["log"] = Lines(scrubber, std::cin);
  } else if (!command.log.empty()) {
    std::ifstream in(command.log);
    if (!in) {
      return Status(Code::kNotFound, "expected the server's log in " + command.log.string() +
                                         ", found no file that can be read");
    }
    out["log"] = Lines(scrubber, in);
  }
  return Write(command.target, program::JsonText(out) + "\n");
}

}  // namespace enamel::server::app
