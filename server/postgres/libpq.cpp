#include "server/postgres/libpq.h"

#include <dlfcn.h>

#include <string>

namespace enamel::sql {
namespace {

// The name of every 5.x since PostgreSQL 8.2; all since 14 have the functions used here.
constexpr char kLibrary[] = "libpq.so.5";

Result<Libpq> Load() {
  // Never closed: statements and connections may live until the program's end.
  void* library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return Status(Code::kUnavailable, std::string("PostgreSQL's library ") + kLibrary +
                                          " cannot be opened (" + dlerror() +
                                          "); install Debian's package libpq5");
  }
  Libpq out{};
  const char* missing = nullptr;
  auto find = [&](auto& function, const char* name) {
    void* const found = dlsym(library, name);
    if (found == nullptr) missing = name;
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
  };
  find(out.connect_start_params, "PQconnectStartParams");
  find(out.connect_poll, "PQconnectPoll");
  find(out.conninfo_parse, "PQconninfoParse");
  find(out.conninfo_free, "PQconninfoFree");
  find(out.freemem, "PQfreemem");
  find(out.finish, "PQfinish");
  find(out.status, "PQstatus");
  find(out.transaction_status, "PQtransactionStatus");
  find(out.error_message, "PQerrorMessage");
  find(out.set_error_verbosity, "PQsetErrorVerbosity");
  find(out.set_notice_receiver, "PQsetNoticeReceiver");
  find(out.set_nonblocking, "PQsetnonblocking");
  find(out.send_query, "PQsendQuery");
  find(out.send_prepare, "PQsendPrepare");
  find(out.flush, "PQflush");
  find(out.socket, "PQsocket");
  find(out.consume_input, "PQconsumeInput");
  find(out.is_busy, "PQisBusy");
  find(out.ping_params, "PQpingParams");
  find(out.host, "PQhost");
  find(out.hostaddr, "PQhostaddr");
  find(out.port, "PQport");
  find(out.server_version, "PQserverVersion");
  find(out.ssl_in_use, "PQsslInUse");
  find(out.ssl_struct, "PQsslStruct");
  find(out.result_status, "PQresultStatus");
  find(out.result_error_field, "PQresultErrorField");
  find(out.clear, "PQclear");
  find(out.ntuples, "PQntuples");
  find(out.nfields, "PQnfields");
  find(out.fname, "PQfname");
  find(out.ftype, "PQftype");
  find(out.getisnull, "PQgetisnull");
  find(out.getvalue, "PQgetvalue");
  find(out.getlength, "PQgetlength");
  find(out.cmd_tuples, "PQcmdTuples");
  find(out.enter_pipeline_mode, "PQenterPipelineMode");
  find(out.exit_pipeline_mode, "PQexitPipelineMode");
  find(out.pipeline_sync, "PQpipelineSync");
  find(out.send_query_params, "PQsendQueryParams");
  find(out.send_query_prepared, "PQsendQueryPrepared");
  find(out.get_result, "PQgetResult");
  if (missing != nullptr) {
    return Status(Code::kUnavailable, std::string("PostgreSQL's library ") + kLibrary + " has no " +
                                          missing +
                                          "; install Debian's package libpq5 of version 15");
  }
  return out;
}

}  // namespace

Result<const Libpq*> LoadLibpq() {
  static const Result<Libpq> kLoaded = Load();
  ENAMEL_RETURN_IF_ERROR(kLoaded.status());
  return &*kLoaded;
}

}  // namespace enamel::sql
