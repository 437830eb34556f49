#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "server/ops/metrics.h"

// What one party (a station, a person, an address) may take of a server at most, so that it harms
// itself alone. README.md of the server, "Budgets".
namespace enamel::server::ops {

// The section [budgets] of the settings. Of each server by itself, for all its schools.
struct Budgets {
  int station_links = 8;
  int station_time_percent = 50;
  int station_frames_mib = 32;
  int station_recordings_mib = 4096;
  int person_requests = 6;
  int person_views = 64;
  int views = 512;
  int answers_mib = 192;
  int bodies_mib = 48;
};

enum class BudgetUnit : uint8_t { kCount, kPercent, kMib };

struct BudgetKind {
  std::string_view name;  // in the settings with - for _
  int Budgets::*limit;
  BudgetUnit unit;
  int least, most;
  const char* what;
};

inline constexpr BudgetKind kStationLinks{
    "station_links",
    &Budgets::station_links,
    BudgetUnit::kCount,
    1,
    1024,
    "Connections of a station; for one more, its oldest ends"};
inline constexpr BudgetKind kStationTime{
    "station_time_percent",
    &Budgets::station_time_percent,
    BudgetUnit::kPercent,
    1,
    1600,
    "Share of one thread's time that a station's requests get; then it waits"};
inline constexpr BudgetKind kStationFrames{
    "station_frames_mib",
    &Budgets::station_frames_mib,
    BudgetUnit::kMib,
    4,
    65536,
    "Frames that stations have begun to send, MiB in all; beyond it, the oldest of the station\n"
    "that has most are refused"};
inline constexpr BudgetKind kStationRecordings{
    "station_recordings_mib",
    &Budgets::station_recordings_mib,
    BudgetUnit::kMib,
    16,
    1 << 20,
    "Recordings of a station within 24 h, MiB; the rest waits at the station"};
inline constexpr BudgetKind kPersonRequests{"person_requests",
                                            &Budgets::person_requests,
                                            BudgetUnit::kCount,
                                            1,
                                            64,
                                            "Requests of a person under way"};
inline constexpr BudgetKind kPersonViews{
    "person_views", &Budgets::person_views, BudgetUnit::kCount, 1, 16384, "Live views of a person"};
inline constexpr BudgetKind kViews{
    "views", &Budgets::views, BudgetUnit::kCount, 1, 16384, "Live views of all people of a school"};
inline constexpr BudgetKind kAnswers{
    "answers_mib",
    &Budgets::answers_mib,
    BudgetUnit::kMib,
    64,
    65536,
    "Large answers being sent, MiB for a school; beyond it, the oldest of the person that has\n"
    "most are cut off"};
inline constexpr BudgetKind kBodies{
    "bodies_mib",
    &Budgets::bodies_mib,
    BudgetUnit::kMib,
    8,
    65536,
    "Request bodies that have begun to come, MiB in all; beyond it, the oldest of the address\n"
    "that has most are refused"};
inline constexpr const BudgetKind* kBudgets[] = {
    &kStationLinks,   &kStationTime, &kStationFrames, &kStationRecordings,
    &kPersonRequests, &kPersonViews, &kViews,         &kAnswers,
    &kBodies};

// The limit as a number to compare: bytes where the setting is in MiB.
uint64_t LimitOf(const BudgetKind& kind, const Budgets& budgets);

// Refuses for a budget, which the message and the field name. Code kUnavailable.
Status OverBudget(const BudgetKind& kind, const Budgets& budgets, const std::string& why);
bool IsOverBudget(const Status& status);

enum class PartyKind : uint8_t { kNone, kStation, kPerson, kAddress };

struct BudgetUse {
  const BudgetKind* kind = nullptr;
  uint64_t limit = 0, most = 0;  // `most`: of the party that uses most now
  PartyKind party = PartyKind::kNone;
  std::string of;        // its id; of an address, the address
  uint64_t refused = 0;  // since the server started, of all its schools
};

// Addresses too: metrics are for whoever runs the server.
void AddBudgets(MetricsText& text, std::span<const BudgetUse> uses);

const char* NameOf(PartyKind kind);

}  // namespace enamel::server::ops
