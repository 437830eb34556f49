#pragma once

#include "common/sql/query.h"
#include "station/spool/spool.h"

namespace enamel::station {

// Reads a row of the table `attempts` by column name. A column that the row does not have (a spool
// of an earlier version, a shorter SELECT) reads as empty or 0.
SpooledAttempt ReadAttemptRow(const sql::Query& row);

// kNotFound, with how to list the attempts.
Status NoAttempt(const Uuid& attempt);

}  // namespace enamel::station
