#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

namespace enamel::station {

struct FirstHourCommand {
  std::string device;   // as 'calibrate' takes it
  std::string profile;  // for comparison; empty: the device's own
  double max_force_n = 2;
  std::filesystem::path out;      // the document
  std::filesystem::path answers;  // a script of answers (first_hour/person.h); empty: the terminal
};

// Leads a person through the first hour with a unit, on the terminal, and writes what was found to
// `out` after each step (schemas/first_hour.schema.json). Ctrl-C ends the hour and keeps what was found.
// A script never says yes to a push of a real unit: the terminal does. Errors: kInvalidInput; kStorage;
// kUnavailable when the hour did not reach its end.
Status RunFirstHour(const FirstHourCommand& options);

}  // namespace enamel::station
