#pragma once

#include <libpq-fe.h>

#include "common/base/result.h"

// libpq (https://www.postgresql.org/docs/15/libpq.html), opened when the first connection is: who
// uses SQLite needs no PostgreSQL on the machine. Private to server/postgres.
namespace enamel::sql {

struct Libpq {
  decltype(&PQconnectStartParams) connect_start_params;
  decltype(&PQconnectPoll) connect_poll;
  decltype(&PQconninfoParse) conninfo_parse;
  decltype(&PQconninfoFree) conninfo_free;
  decltype(&PQfreemem) freemem;
  decltype(&PQfinish) finish;
  decltype(&PQstatus) status;
  decltype(&PQtransactionStatus) transaction_status;
  decltype(&PQerrorMessage) error_message;
  decltype(&PQsetErrorVerbosity) set_error_verbosity;
  decltype(&PQsetNoticeReceiver) set_notice_receiver;
  // None of these waits for the server: PgDb::Await does, with a deadline
  // (https://www.postgresql.org/docs/15/libpq-async.html).
  decltype(&PQsetnonblocking) set_nonblocking;
  decltype(&PQsendQuery) send_query;
  decltype(&PQsendPrepare) send_prepare;
  decltype(&PQflush) flush;
  decltype(&PQsocket) socket;
  decltype(&PQconsumeInput) consume_input;
  decltype(&PQisBusy) is_busy;
  decltype(&PQpingParams) ping_params;
  decltype(&PQhost) host;
  decltype(&PQhostaddr) hostaddr;
  decltype(&PQport) port;
  decltype(&PQserverVersion) server_version;
  decltype(&PQsslInUse) ssl_in_use;
  decltype(&PQsslStruct) ssl_struct;
  decltype(&PQresultStatus) result_status;
  decltype(&PQresultErrorField) result_error_field;
  decltype(&PQclear) clear;
  decltype(&PQntuples) ntuples;
  decltype(&PQnfields) nfields;
  decltype(&PQfname) fname;
  decltype(&PQftype) ftype;
  decltype(&PQgetisnull) getisnull;
  decltype(&PQgetvalue) getvalue;
  decltype(&PQgetlength) getlength;
  decltype(&PQcmdTuples) cmd_tuples;
  // Several statements before the first answer
  // (https://www.postgresql.org/docs/15/libpq-pipeline-mode.html).
  decltype(&PQenterPipelineMode) enter_pipeline_mode;
  decltype(&PQexitPipelineMode) exit_pipeline_mode;
  decltype(&PQpipelineSync) pipeline_sync;
  decltype(&PQsendQueryParams) send_query_params;
  decltype(&PQsendQueryPrepared) send_query_prepared;
  decltype(&PQgetResult) get_result;
};

// Once; the same for everybody. Errors: kUnavailable (not installed, or too old). Thread safety:
// any.
Result<const Libpq*> LoadLibpq();

}  // namespace enamel::sql
