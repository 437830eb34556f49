#include "server/storage/people/school_list.h"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"

// The schools of an installation.
namespace enamel::server {
bool IsSchoolName(std::string_view name) {
  constexpr size_t kMost = 32;
  const auto letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !name.empty() && name.size() <= kMost && letter(name[0]) &&
         std::ranges::all_of(
             name, [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; });
}

bool IsHostName(std::string_view host) {
  constexpr size_t kMost = 253, kMaxLabel = 63;
  if (host.size() > kMost) return false;
  for (;;) {
    const size_t end = std::min(host.find('.'), host.size());
    const std::string_view label = host.substr(0, end);
    const bool good = !label.empty() && label.size() <= kMaxLabel && label.front() != '-' &&
                      label.back() != '-' && std::ranges::all_of(label, [](char c) {
                        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
                      });
    if (!good || end == host.size()) return good;
    host.remove_prefix(end + 1);
  }
}

namespace {

constexpr const char* kStates[] = {"being_made", "served", "suspended", "being_deleted"};

}  // namespace

const char* SchoolStateName(SchoolState state) { return kStates[static_cast<size_t>(state)]; }

namespace {

std::string HostsText(const std::vector<std::string>& hosts) {
  std::string out;
  for (const std::string& host : hosts) out += (out.empty() ? "" : " ") + host;
  return out;
}

std::vector<std::string> HostsOf(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream words(text);
  for (std::string host; words >> host;) out.push_back(host);
  return out;
}

SchoolState StateNamed(const std::string& name) {
  const auto at = std::ranges::find(kStates, name);
  // The table has no others.
  ENAMEL_CHECK(at != std::end(kStates));
  return static_cast<SchoolState>(at - std::begin(kStates));
}

bool MayBecome(SchoolState before, SchoolState after) {
  using enum SchoolState;
  if (before == after) return true;
  switch (before) {
    case kBeingMade:
      return after == kServed || after == kBeingDeleted;
    case kServed:
      return after == kSuspended;
    case kSuspended:
      return after == kServed || after == kBeingDeleted;
    case kBeingDeleted:
      return false;
  }
  return false;
}

Result<std::vector<SchoolRow>> AllSchools(Db& db) {
  Query q(db,
          "SELECT name, id, hosts, state, created_ms FROM schools WHERE tenant = ?1 ORDER BY "
          "name");
  std::vector<SchoolRow> out;
  while (q.Next()) {
    out.push_back({q.Text(0), q.Id(1), HostsOf(q.Text(2)), StateNamed(q.Text(3)), q.Int(4)});
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return out;
}

Status CheckSchool(const SchoolRow& row, const std::vector<SchoolRow>& all) {
  constexpr size_t kMaxHosts = 16;
  if (!IsSchoolName(row.name)) {
    return {Code::kInvalidInput,
            "expected a school's name of 1 to 32 of a-z 0-9 -, a letter first, found \"" +
                row.name + "\"",
            "name"};
  }
  if (row.hosts.empty() || row.hosts.size() > kMaxHosts) {
    return {Code::kInvalidInput,
            "expected 1 to 16 names that the page is opened under, found " +
                std::to_string(row.hosts.size()),
            "hosts"};
  }
  for (const std::string& host : row.hosts) {
    if (!IsHostName(host)) {
      return {Code::kInvalidInput,
              "expected a host name such as dental.example.edu, in lower case and without port, "
              "found \"" +
                  host + "\"",
              "hosts"};
    }
    for (const SchoolRow& other : all) {
      if (other.name == row.name || !std::ranges::count(other.hosts, host)) continue;
      return {Code::kConflict,
              "expected a host name of its own, found " + host + ", which is " + other.name + "'s",
              "hosts"};
    }
  }
  return Status::Ok();
}

std::string SchoolJson(const SchoolRow& row) {
  return JsonOf({{"hosts", HostsText(row.hosts)}, {"state", SchoolStateName(row.state)}});
}

}  // namespace

Result<std::vector<SchoolRow>> SchoolRows::Schools() {
  return rows_.Read([&](Db& db) { return AllSchools(db); });
}

Status SchoolRows::AddSchool(const SchoolRow& row, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto all, AllSchools(db));
    ENAMEL_RETURN_IF_ERROR(CheckSchool(row, all));
    if (std::ranges::count(all, row.name, &SchoolRow::name) > 0) {
      return {Code::kConflict, "there is a school \"" + row.name + "\" already", "name"};
    }
    ENAMEL_RETURN_IF_ERROR(Insert(db, "schools", "name", row.name, "id", row.id, "hosts",
                                  HostsText(row.hosts), "state", SchoolStateName(row.state),
                                  "created_ms", NowMs()));
    return WriteAudit(db, by, "school.add", row.name, "{}", SchoolJson(row));
  });
}

Status SchoolRows::ChangeSchool(const SchoolRow& row, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto all, AllSchools(db));
    ENAMEL_RETURN_IF_ERROR(CheckSchool(row, all));
    const auto before = std::ranges::find(all, row.name, &SchoolRow::name);
    if (before == all.end()) {
      return {Code::kNotFound, "there is no school \"" + row.name + "\"", "name"};
    }
    if (!MayBecome(before->state, row.state)) {
      return {Code::kConflict,
              "the school \"" + row.name + "\" is " + SchoolStateName(before->state) +
                  ", and cannot become " + SchoolStateName(row.state),
              "state"};
    }
    Query q(db, "UPDATE schools SET hosts = ?3, state = ?4 WHERE tenant = ?1 AND name = ?2");
    ENAMEL_RETURN_IF_ERROR(
        q.Bind(row.name, HostsText(row.hosts), SchoolStateName(row.state)).Run());
    return WriteAudit(db, by, "school.change", row.name, SchoolJson(*before), SchoolJson(row));
  });
}

Status SchoolRows::RemoveSchool(const std::string& name, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto all, AllSchools(db));
    const auto found = std::ranges::find(all, name, &SchoolRow::name);
    if (found == all.end()) {
      return {Code::kNotFound, "there is no school \"" + name + "\"", "name"};
    }
    if (found->state != SchoolState::kBeingDeleted) {
      return {Code::kConflict, "the school \"" + name + "\" is " + SchoolStateName(found->state),
              "state"};
    }
    Query q(db, "DELETE FROM schools WHERE tenant = ?1 AND name = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(name).Run());
    return WriteAudit(db, by, "school.remove", name, SchoolJson(*found), "{}");
  });
}

}  // namespace enamel::server
