#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "server/storage/people/station_rows.h"

// The `admin` commands about stations and device profiles. Each opens the data folder beside a
// running server, or without one, prints its outcome to standard output and returns.
namespace enamel::server::app {

// The admitted station of this id or name. Errors: kNotFound (none, or several of that name, with
// what to do).
Result<StationRow> StationNamed(StationRows& stations_rows, const std::string& text);

Status ListStations(const std::filesystem::path& data);
// Recordings that stations still hold for a person, an exercise or a profile that is newer than the
// backup this folder was restored from, and what to do about each.
Status ListAwaited(const std::filesystem::path& data);
// `station`: its id, or its name when only one admitted station has it. For good.
Status RevokeStation(const std::filesystem::path& data, const std::string& station);

// Haptic devices that graded work is done with: `name` is its unit as `enamel-station devices`
// shows it, or its model where that shows none; `title` is for people.
Status ListDevice(const std::filesystem::path& data, const std::string& name,
                  const std::string& title);
Status UnlistDevice(const std::filesystem::path& data, const std::string& name);
Status ListListedDevices(const std::filesystem::path& data);

// Settings of stations (schemas/station_settings.md, "Policy").
Status SetStations(const std::filesystem::path& data, const StationSetting& setting);
Status UnsetStations(const std::filesystem::path& data, const std::string& name,
                     const std::string& scope);
Status ListStationSettings(const std::filesystem::path& data);

// Prints every criterion with its figures (common/scene/profile_criteria.h); stores the profile as
// the newest version of its name when all are met, unless it is only to be checked.
Status PutProfile(const std::filesystem::path& data, const std::string& name_or_path,
                  bool check_only);
// What `enamel-lab qualify --report` wrote: JSON or HTML by the file's name, at most 1 MiB.
Status AddProfileReport(const std::filesystem::path& data, const std::string& profile,
                        const std::filesystem::path& file);
// What `enamel-station calibrate` wrote (schemas/calibration.schema.json).
Status AddCalibration(const std::filesystem::path& data, const std::filesystem::path& file);
Status ListCalibrations(const std::filesystem::path& data, const std::string& profile);

struct CommandGroup;
// On the command line (command_line.h), by subject.
void DeclareStations(CommandGroup admin);
void DeclareStationSettings(CommandGroup admin);
void DeclareProfiles(CommandGroup admin);

}  // namespace enamel::server::app
