# The route table and the declarations of the handlers, from the contract:
#   cmake -D CONTRACT=schemas/api/openapi.yaml -D WAITING="SignIn;…" -D OUT=DIR -P operations.cmake
# The operation `listPeople` is answered by the handler ListPeople. Who may call it at all follows from `x-may`: the least
# role that is named there. WAITING: handlers that wait without a thread of the store.
cmake_minimum_required(VERSION 3.25)
file(STRINGS ${CONTRACT} lines ENCODING UTF-8
     REGEX "^(  /[^ ]*:|    (get|post|put|patch|delete):|      (operationId|x-may|security): .*)$")
set(routes "")
set(declared "")
set(open "")  # the operation that has no need yet
foreach(line IN LISTS lines)
  if(line MATCHES "^  (/.*):$")
    set(path ${CMAKE_MATCH_1})
  elseif(line MATCHES "^    ([a-z]+):$")
    set(method ${CMAKE_MATCH_1})
  elseif(line MATCHES "operationId: (.)(.*)$")
    if(open)
      message(FATAL_ERROR "${CONTRACT}: ${open} has neither x-may nor security")
    endif()
    string(TOUPPER ${CMAKE_MATCH_1} first)
    set(open ${first}${CMAKE_MATCH_2})
  else()
    if(line MATCHES "x-may: .*student")
      set(need kPerson)
    elseif(line MATCHES "x-may: .*instructor")
      set(need kInstructor)
    elseif(line MATCHES "x-may: .*admin")
      set(need kAdmin)
    elseif(line MATCHES "security: ..$")
      set(need kNobody)
    else()
      message(FATAL_ERROR "${CONTRACT}: ${open}: expected x-may with a role, or security: [], found ${line}")
    endif()
    string(SUBSTRING ${method} 0 1 first)
    string(TOUPPER ${first} first)
    string(SUBSTRING ${method} 1 -1 rest)
    string(APPEND routes "Route{Method::k${first}${rest}, \"${path}\", Need::${need}, &${open}},\n")
    if(open IN_LIST WAITING)
      string(APPEND declared "boost::asio::awaitable<Result<Response>> ${open}(Call call, Store& store);\n")
    else()
      string(APPEND declared "Result<Response> ${open}(const Call& call, Store& store);\n")
    endif()
    set(open "")
  endif()
endforeach()
file(CONFIGURE OUTPUT ${OUT}/routes.inc CONTENT "${routes}")
file(CONFIGURE OUTPUT ${OUT}/operations.h CONTENT "#pragma once

#include \"server/http/routes.h\"

// The handlers of the route table, by subject: server/http/handlers/*_handlers.cpp. They trust the table for session,
// role and CSRF, and decide themselves whose data the caller may see. Made of schemas/api/openapi.yaml by
// server/http/operations.cmake.
namespace enamel::server::http {

${declared}
}  // namespace enamel::server::http
")
