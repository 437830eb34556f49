#include "station/app/first_hour/hour.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

namespace enamel::station::first_hour {
namespace {

namespace json = boost::json;

// For a question: whoever is called away for longer begins again.
constexpr double kAnswer_s = 1800;
constexpr double kPlace_s = 0.25;
constexpr const char* kSkip = "skip";
constexpr const char* kEnd = "end";
constexpr std::string_view kSkipWord = "skip";

struct Entry {
  const char* name;
  Status (*run)(Hour&, Step&);
};
constexpr std::array<Entry, 11> kSteps = {{{"start", Start},
                                           {"homing", Homing},
                                           {"workspace", Workspace},
                                           {"directions", Directions},
                                           {"force", Force},
                                           {"weight", Weight},
                                           {"delay", Delay},
                                           {"noise", Noise},
                                           {"buttons", Buttons},
                                           {"unplug", Unplug},
                                           {"end", End}}};

Status Over(const char* why) { return Status(Code::kUnavailable, why, kEnd); }

const char* StateOf(const Status& status) {
  if (status.ok()) return "done";
  return IsSkip(status) ? "skipped" : "failed";
}

}  // namespace

Status Skipped(const std::string& reason) { return Status(Code::kConflict, reason, kSkip); }
bool IsSkip(const Status& status) { return status.field() == kSkip; }
bool IsEnd(const Status& status) { return status.field() == kEnd; }

double Rounded(double v, int digits) {
  const double unit = std::pow(10, digits);
  const double out = std::round(v * unit) / unit;
  return std::isfinite(out) ? out + 0.0 : 0;  // no -0
}

json::array Rounded(const dvec3& v, int digits) {
  return {Rounded(v.x, digits), Rounded(v.y, digits), Rounded(v.z, digits)};
}

std::string AxisOf(const dvec3& way, double least) {
  const double length = std::sqrt(Dot(way, way));
  for (int i = 0; i < 3; ++i) {
    if (length > 0 && std::fabs(way[i]) >= least * length)
      return std::string(way[i] < 0 ? "-" : "+") + static_cast<char>('x' + i);
  }
  return {};
}

json::object CountersOf(const Device& device) {
  const DeviceCounters c = device.counters();
  return {{"samples", c.samples},  {"lost", c.lost},     {"duplicated", c.duplicated},
          {"refused", c.refused},  {"writes", c.writes}, {"write_errors", c.write_errors},
          {"detached", c.detached}};
}

void Step::Problem(const char* code, const std::string& text) {
  problems.push_back(json::object{{"step", name_}, {"code", code}, {"text", text}});
}

Hour::Hour(const HourSetup& setup)
    : setup_(setup), rig_(setup.tick_s, setup.by_clock, *setup.stop) {}

double Hour::MostForce_n() const {
  return std::min(setup_.max_force_n,
                  static_cast<double>(rig_.unit().profile.peak_force_mn.value) * 1e-3);
}

Status Hour::UnitIsThere() const {
  if (!rig_.has_unit()) return Status(Code::kUnavailable, "no unit is open");
  if (!rig_.sample().attached) return Status(Code::kUnavailable, "the unit is unplugged");
  if (rig_.silent_s() > 1) return Status(Code::kUnavailable, "the unit sends no pose");
  return Status::Ok();
}

Status Hour::Wait(double seconds, const std::function<void()>& each) {
  const double until_s = rig_.now_s() + seconds;
  while (rig_.now_s() < until_s) {
    if (rig_.is_stopped()) return Over("the program was asked to stop");
    rig_.Tick();
    if (each) each();
  }
  return Status::Ok();
}

Result<dvec3> Hour::Place() {
  dvec3 sum(0);
  int count = 0;
  ENAMEL_RETURN_IF_ERROR(Wait(kPlace_s, [&] {
    sum += rig_.tip_m();
    ++count;
  }));
  ENAMEL_RETURN_IF_ERROR(UnitIsThere());
  return sum / static_cast<double>(std::max(count, 1));
}

Result<std::string> Hour::Listen(Step& step, const std::string& id,
                                 const std::function<void()>& each) {
  const double from_s = rig_.now_s();
  while (rig_.now_s() - from_s < kAnswer_s) {
    if (rig_.is_stopped()) return Over("the program was asked to stop");
    const Heard heard = setup_.person->Listen(rig_.now_s());
    if (heard.kind == Heard::Kind::kClosed) return Over("the input ended");
    if (heard.kind == Heard::Kind::kAnswer) {
      step.asked.push_back(json::object{
          {"id", id}, {"answer", heard.text}, {"seconds", Rounded(rig_.now_s() - from_s, 1)}});
      return heard.text;
    }
    rig_.Tick();
    if (each) each();
  }
  return Over("nobody answered within half an hour");
}

Result<std::string> Hour::Ask(Step& step, const std::string& id, const std::string& text,
                              const std::function<void()>& each) {
  setup_.person->Ask(id, text);
  ENAMEL_ASSIGN_OR_RETURN(std::string answer, Listen(step, id, each));
  if (answer != kSkipWord && !answer.starts_with(std::string(kSkipWord) + " ")) return answer;
  std::string reason = answer.substr(std::min(answer.size(), kSkipWord.size() + 1));
  if (reason.empty()) {
    const std::string why = step.name() + ".why";
    setup_.person->Ask(why, "Why is this step left out? One line:");
    ENAMEL_ASSIGN_OR_RETURN(reason, Listen(step, why, {}));
  }
  return Skipped(reason.empty() ? "no reason given" : reason);
}

Status Hour::AskToPush(Step& step, const std::string& id, const std::string& text, double most_n) {
  char limit[120];
  std::snprintf(
      limit, sizeof limit,
      "\nThe motors push with at most %.2f N. Type yes to let them, or skip and a reason.", most_n);
  std::string question = text + limit;
  while (true) {
    ENAMEL_ASSIGN_OR_RETURN(const std::string answer, Ask(step, id, question));
    ENAMEL_RETURN_IF_ERROR(UnitIsThere());
    if (answer == "yes") return Status::Ok();
    question = "Only yes lets the motors push, found '" + answer + "'. yes, or skip and a reason?";
  }
}

Status Hour::OpenUnit(json::object& attempt) {
  const double from_s = rig_.now_s();
  // Maker's calls and threads take real time, simulated or not.
  const int64_t from_ns = Now_ns();
  rig_.Close();
  auto opened = setup_.open();
  attempt["at_s"] = Rounded(from_s, 1);
  attempt["took_ms"] = Rounded(static_cast<double>(Now_ns() - from_ns) * 1e-6, 1);
  attempt["ok"] = opened.ok();
  attempt["cause"] = opened.ok() ? "" : opened.status().field();
  attempt["message"] = opened.ok() ? "" : opened.status().message();
  ENAMEL_RETURN_IF_ERROR(opened.status());
  rig_.Hold(std::move(*opened));
  NoteUnit();
  return Status::Ok();
}

void Hour::NoteUnit() {
  const MeasuredDevice& unit = rig_.unit();
  const enamel::Hand hand = unit.device->hand();
  document_["device"] = json::object{{"name", unit.device->Name()}, {"driver", hand.driver},
                                     {"unit", unit.device->Unit()}, {"address", unit.address},
                                     {"real", unit.real},           {"profile", unit.profile.name}};
}

json::object Hour::Run() {
  json::object steps;
  json::array problems;
  document_ = {{"device", nullptr}, {"complete", false}, {"ended_by", "end"}};
  Status over;
  int number = 0;
  for (const Entry& entry : kSteps) {
    Step step(entry.name);
    const double from_s = rig_.now_s();
    Status status = over;
    if (over.ok()) {
      Tell("\nStep " + std::to_string(++number) + " of " + std::to_string(kSteps.size()) + ": " +
           entry.name);
      status = entry.run(*this, step);
      rig_.EndPush();
      if (!status.ok()) Tell("Left at this: " + status.message() + ".");
    }
    const bool reached = over.ok();
    if (over.ok() && IsEnd(status)) {
      over = status;
      document_["ended_by"] = status.message();
    }
    // Nothing can be found of a unit that was never open.
    if (over.ok() && !status.ok() && std::string_view(entry.name) == "start") {
      over = Status(Code::kUnavailable, "no unit was opened", kEnd);
      document_["ended_by"] = over.message();
    }
    steps[entry.name] = json::object{{"state", reached ? StateOf(status) : "not_reached"},
                                     {"reason", status.message()},
                                     {"seconds", Rounded(rig_.now_s() - from_s, 1)},
                                     {"asked", std::move(step.asked)},
                                     {"found", std::move(step.found)}};
    for (json::value& problem : step.problems) {
      Tell(std::string("Not as expected: ") + problem.at("text").as_string().c_str() + ".");
      problems.push_back(std::move(problem));
    }
    document_["steps"] = steps;
    document_["problems"] = problems;
    if (reached) setup_.keep(document_);
  }
  rig_.Close();
  document_["complete"] = over.ok();
  return document_;
}

}  // namespace enamel::station::first_hour
