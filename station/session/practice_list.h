#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "station/uplink/server_link.h"

// What this station can practise with the server away: DATA/practice.json, of the lists that people
// saw here. It has names and hashes of documents, and nothing of any person
// (schemas/station_settings.md, "Practice without the server"). Thread safety: functions, any thread.
namespace enamel::station {

struct PracticeList {
  // A document's name and its hash, those listed last first.
  using Document = std::pair<std::string, Sha256>;
  std::vector<Document> exercises, profiles;

  bool operator==(const PracticeList&) const = default;
};

// Empty where there is none. A file that cannot be read counts as none, and is logged as a warning.
PracticeList LoadPracticeList(const std::filesystem::path& data);
// Adds the practice exercises of a described list (Workplace::Describe) and its profiles; a newer
// version replaces the one of the same name. Exercises that the list has as graded, as an exam or as
// not open yet are taken out. Failures are logged.
void KeepPracticeList(const std::filesystem::path& data, const Catalogue& described,
                      int64_t now_unix_ms);

}  // namespace enamel::station
