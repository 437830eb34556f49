#pragma once

#include "common/sql/query.h"
#include "station/spool/spool.h"

namespace enamel::station {

// What a row of the table `attempts` says, by the names of its columns: one that the row does not
// have (a spool of an earlier version, a shorter SELECT) reads as empty or 0.
SpooledAttempt ReadAttemptRow(const sql::Query& row);

// kNotFound, and how to see those that are there.
Status NoAttempt(const Uuid& attempt);

}  // namespace enamel::station
