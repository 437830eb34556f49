#include "server/commands/report.h"

#include <unistd.h>

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <chrono>
#include <iostream>
#include <thread>

#include "common/base/counted.h"
#include "common/base/hex.h"
#include "common/base/utf8.h"
#include "common/language/score_text.h"
#include "common/program/output.h"
#include "common/scoring/score.h"
#include "server/app/data_folder.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/results/result_document.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/judging/result_rows.h"

namespace enamel::server::app {
namespace {

namespace json = boost::json;
using scoring::ScoreResult;

// The server is another process, with which this one shares the database alone: asking is the only
// way to hear of a score. Five times a second costs nothing and nobody sees the delay.
constexpr auto kPoll = std::chrono::milliseconds(200);
constexpr int kPollsALine = 20;  // 4 s
constexpr char kDeviationMetric[] = "deviation_rms_mm";

Result<bool> HasOpenJob(JobRows& jobs_rows, const Uuid& attempt) {
  // A scored attempt may be scored again; its old score is not what --wait was for.
  for (const char* state : {"queued", "running"}) {
    ENAMEL_ASSIGN_OR_RETURN(auto jobs, jobs_rows.Jobs(state));
    if (std::ranges::any_of(jobs, [&](const JobRow& job) { return job.attempt == attempt; }))
      return true;
  }
  return false;
}

// On a screen one line that is overwritten; elsewhere, where every line stays, now and then one.
void ShowProgress(const AttemptRow& row, int poll) {
  const bool screen = ::isatty(STDERR_FILENO) != 0;
  if (!screen && poll % kPollsALine != 0) return;
  std::cerr << fmt::format("{}{:<20} {:3.0f} %{}", screen ? "\r" : "", StateText(row.state),
                           row.progress * 100, screen ? "" : "\n")
            << std::flush;
}

// The attempt once nothing is going to happen to it any more.
Result<AttemptRow> WaitForVerdict(AttemptRows& attempts, JobRows& jobs, const Uuid& attempt,
                                  int wait_s) {
  auto until = std::chrono::steady_clock::now() + std::chrono::seconds(wait_s);
  for (int poll = 1;; ++poll) {
    auto row = attempts.AttemptById(attempt);
    ENAMEL_RETURN_IF_ERROR(row.status());
    ENAMEL_ASSIGN_OR_RETURN(auto open, HasOpenJob(jobs, attempt));
    bool settled = row->state == AttemptState::kScored || row->state == AttemptState::kFailed ||
                   row->state == AttemptState::kQuarantined;
    if (settled && !open) return row;
    if (std::chrono::steady_clock::now() >= until) {
      // Scored before, and being scored again.
      if (open && row->score) {
        return Status(Code::kUnavailable,
                      fmt::format("the score of attempt {} is being computed again; ask again with "
                                  "--wait SECONDS, or look at the earlier one on the page",
                                  attempt.Text()));
      }
      if (open && wait_s == 0) {
        return Status(Code::kUnavailable,
                      fmt::format("the score of attempt {} is being computed (it is {}); ask again "
                                  "with --wait SECONDS",
                                  attempt.Text(), StateText(row->state)));
      }
      return Status(
          Code::kUnavailable,
          fmt::format("attempt {} is {} after {} s, not scored; is enamel-server running on this "
                      "data folder? Ask again with a longer --wait",
                      attempt.Text(), StateText(row->state), wait_s));
    }
    ShowProgress(*row, poll);
    std::this_thread::sleep_for(kPoll);
  }
}

std::optional<double> Metric(const ScoreResult& score, std::string_view name) {
  for (const auto& metric : score.metrics) {
    if (metric.name == name) return metric.value;
  }
  return std::nullopt;
}

// What the signed result says of itself (schemas/result.md).
struct SignedBy {
  bool is_signed = false;
  std::string problem;    // why a document that is there proves nothing
  std::string key, hash;  // hexadecimal
};

SignedBy ReadSigned(const AttemptRow& row, const AttemptResult& result) {
  SignedBy out;
  auto document = DecodeResult(result.document);
  if (!document.ok()) {
    out.problem = document.status().message();
  } else if (!VerifyResult(*document)) {
    out.problem = "its signature does not fit it";
  } else if (document->attempt != row.id || document->points != result.score ||
             document->critical_fail != result.critical_fail ||
             document->score_document != result.score_json) {
    out.problem = "another score than this one was signed; run enamel-server verify";
  }
  out.is_signed = out.problem.empty();
  out.hash = HashSha256(result.document).Hex();
  if (document.ok()) out.key = ToHex(document->key);
  return out;
}

json::object Facts(const AttemptRow& row, const ScoreResult& score, const AttemptResult& result,
                   const std::string& page_url) {
  json::array criteria, mistakes, metrics;
  for (const auto& c : score.criteria) {
    criteria.push_back(json::object{{"name", c.name},
                                    {"group", scoring::NameOf(c.group)},
                                    {"title", c.title},
                                    {"value", c.value},
                                    {"unit", c.unit},
                                    {"lost", c.lost},
                                    {"most", c.most},
                                    {"state", scoring::NameOf(c.state)},
                                    {"reason", c.reason},
                                    {"judged", c.judged}});
  }
  for (const auto& m : score.mistakes) {
    mistakes.push_back(json::object{{"kind", scoring::NameOf(m.kind)},
                                    {"place", m.place},
                                    {"size", m.size},
                                    {"unit", scoring::UnitOf(m.kind)},
                                    {"points", m.points}});
  }
  for (const auto& m : score.metrics) {
    metrics.push_back(json::object{{"name", m.name}, {"value", m.value}, {"unit", m.unit}});
  }
  json::object out{{"attempt_id", row.id.Text()},
                   {"reference_id", score.reference_attempt},
                   {"score", score.score},
                   {"critical_fail", score.critical_fail},
                   {"criteria", std::move(criteria)},
                   {"mistakes", std::move(mistakes)},
                   {"metrics", std::move(metrics)}};
  auto deviation = Metric(score, kDeviationMetric);
  out["deviation_rms_mm"] = deviation ? json::value(*deviation) : json::value();
  out["hand"] = {{"kind", HandKindName(row.hand.kind)}, {"text", HandText(row.hand)}};
  out["ticks"] = score.ticks;
  out["chunks"] = row.chunks;
  out["gaps"] = score.gap_ticks;
  out["outages"] = score.outages;
  out["witness_ok"] = score.witness_ok;
  out["trace_bytes"] = row.trace_bytes;
  out["realtime_factor"] = result.replay_realtime_factor;
  const SignedBy by = ReadSigned(row, result);
  out["result"] = json::object{
      {"signed", by.is_signed}, {"problem", by.problem}, {"key", by.key}, {"sha256", by.hash}};
  json::array flags;
  for (const char* flag : AttemptFlagNames(row.flags)) flags.emplace_back(flag);
  out["flags"] = std::move(flags);
  out["override"] = row.overridden ? json::value{{"score", row.overridden->score},
                                                 {"reason", row.overridden->reason}}
                                   : json::value();
  out["page_url"] = page_url;
  return out;
}

void Line(const std::string& name, const std::string& value) { Say("  {:<34} {}\n", name, value); }

// The dearest are worth a line each: a hand heeds three things at most the next time.
constexpr size_t kDearest = 3;
// A loss that one decimal shows, points.
constexpr double kSeen = 0.05;

struct Loss {
  double points;
  std::string what, next;  // both without a full stop, or sentences with it
};

// What cost a tenth of a point, the dearest first. A figure of the hand tells its remedy in its reason.
std::vector<Loss> LossesOf(const language::Words& words, const ScoreResult& score) {
  std::vector<Loss> out;
  for (const auto& m : score.mistakes)
    out.push_back({m.points, language::MistakeText(words, m), language::RemedyText(words, m)});
  for (const auto& c : score.criteria) {
    if (c.group == scoring::Group::kHand && c.lost > 0) out.push_back({c.lost, c.reason, ""});
  }
  std::erase_if(out, [](const Loss& loss) { return loss.points < kSeen; });
  std::ranges::stable_sort(out, std::greater{}, &Loss::points);
  return out;
}

void PrintSummary(const AttemptRow& row, const ScoreResult& score, const ReportOptions& options) {
  Say("\n{}, {}: {:.1f} of 100 points{}\n", row.exercise_title, row.person_name, score.score,
      score.acceptance == scoring::Acceptance::kNotAcceptable ? " (not acceptable)" : "");
  for (const auto& error : score.critical) Say("  {}\n", error.reason);
  for (const auto& limit : score.borderline) Say("  Borderline: {}\n", limit.reason);
  if (row.overridden) {
    Say("What counts instead is a person's score, {:.1f}: {}\n", row.overridden->score,
        Printable(row.overridden->reason));
  }
  const language::Words words(language::Language::kEnglish);
  const std::vector<Loss> losses = LossesOf(words, score);
  if (losses.empty()) Say("  No points were lost.\n");
  const size_t told = options.all ? losses.size() : std::min(losses.size(), kDearest);
  double smaller = 0;
  for (size_t i = 0; i < losses.size(); ++i) {
    if (i < told)
      Say("  -{:<5.1f} {}\n", losses[i].points, losses[i].what);
    else
      smaller += losses[i].points;
  }
  if (losses.size() > told)
    Say("  -{:<5.1f} {}\n", smaller, Counted(losses.size() - told, "smaller mistake"));
  if (!losses.empty() && !losses.front().next.empty()) Say("Next time: {}\n", losses.front().next);
  if (!options.page_url.empty()) Say("The tooth in 3-D: {}\n", options.page_url);
  if (!options.all) Say("Every figure: add --all\n");
}

void PrintAll(const AttemptRow& row, const ScoreResult& score, const AttemptResult& result) {
  Say("Points lost\n");
  for (const auto& c : score.criteria) {
    const bool has_value = c.judged && !c.unit.empty();
    Say("  {:<34} {:>9} {:<5} {:>5.1f}, {}\n", c.title,
        has_value ? fmt::format("{:.3f}", c.value) : "", has_value ? c.unit : "", c.lost,
        scoring::NameOf(c.state));
  }
  Say("Measured\n");
  for (const auto& m : score.metrics) {
    const auto* info = scoring::FindMetric(m.name);
    Line(info != nullptr ? std::string(info->title) : m.name,
         fmt::format("{:>9.3f} {}", m.value, m.unit));
  }
  Say("Trace\n");
  Line("held by", HandText(row.hand));
  std::string flags;
  for (const char* flag : AttemptFlagNames(row.flags))
    flags += (flags.empty() ? "" : ", ") + std::string(flag);
  if (!flags.empty()) Line("flags", flags);
  Line("ticks, chunks", fmt::format("{}, {}", score.ticks, row.chunks));
  Line("size",
       fmt::format("{:.1f} kB ({:.1f} bytes a tick)", static_cast<double>(row.trace_bytes) / 1e3,
                   static_cast<double>(row.trace_bytes) /
                       static_cast<double>(std::max<uint64_t>(score.ticks, 1))));
  Line("lost",
       score.gap_ticks == 0 ? "nothing" : Counted(score.gap_ticks, "tick") + ", declared as gaps");
  Line("late ticks, force bounded", fmt::format("{}, {}", score.late_ticks, score.bounded_ticks));
  Line("force interrupted", Counted(score.outages, "time"));
  const scoring::Disturbance& d = score.disturbance;
  if (d.disturbed()) {
    Line("disturbed by the station",
         fmt::format("{:.1f} % late, {:.1f} % missing, {:.1f} % at the device's limit",
                     d.late_percent, d.gap_percent, d.limited_percent));
  }
  Line("replay agrees tick by tick", score.witness_ok ? "yes" : "no: " + score.witness_note);
  Line("replayed at", fmt::format("{:.1f} x real time", result.replay_realtime_factor));
  const SignedBy by = ReadSigned(row, result);
  if (by.is_signed) {
    Line("result", by.hash);
    Line("signed by", by.key);
  } else {
    Line("result", by.problem);
  }
  Line("attempt", row.id.Text());
  Line("reference", !score.reference_attempt.empty() ? score.reference_attempt
                    : row.as_reference               ? "none: compared with itself"
                                                     : "none: judged by the exercise's own target");
  if (score.envelope) {
    const auto& nearest = score.envelope->members.front();
    Line("among " + Counted(score.envelope->members.size(), "reference"),
         fmt::format("nearest {}, {:.1f} % overlap", nearest.attempt, 100 * nearest.dice));
  }
}

}  // namespace

Status Report(const ReportOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto id, Uuid::Parse(options.attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(options.data));
  ENAMEL_ASSIGN_OR_RETURN(auto row,
                          WaitForVerdict(store->attempts, store->jobs, id, options.wait_s));
  if (row.state != AttemptState::kScored) {
    return Status(Code::kConflict, fmt::format("attempt {} is {}: {}", id.Text(),
                                               StateText(row.state), row.problem));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto result, store->results.ResultOf(id));
  ENAMEL_ASSIGN_OR_RETURN(auto text, store->blobs.GetBlob(result.score_json));
  ENAMEL_ASSIGN_OR_RETURN(auto score, scoring::ScoreFromJson(AsText(text)));
  PrintSummary(row, score, options);
  if (options.all) PrintAll(row, score, result);
  return program::WriteJsonFile(options.json, Facts(row, score, result, options.page_url));
}

void DeclareReport(CommandGroup root) {
  auto [cmd, o] = Declare<ReportOptions>(
      root, "report", "Show an attempt's score with its reasons, and facts of its recording",
      Report);
  AddData(cmd, o.data);
  cmd->add_option("--attempt", o.attempt, "Id of the attempt (admin list-attempts)")->required();
  cmd->add_flag("--all", o.all, "Show every figure of the score and of its recording");
  cmd->add_option("--json", o.json, "Write the same facts to this file");
  cmd->add_option("--wait", o.wait_s, "Seconds to wait for the score")->check(CLI::Range(0, 86400));
  cmd->add_option("--page-url", o.page_url, "Address of the attempt's page, to be printed");
  AddExample(cmd, std::string("--wait 60 --attempt ") + kSomeId);
}

}  // namespace enamel::server::app
