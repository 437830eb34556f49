#pragma once

#include <curl/curl.h>

#include "common/base/result.h"

// libcurl (https://curl.se/libcurl/c), opened when the first S3 store is asked: who keeps blobs in
// a folder needs no libcurl on the machine. Private to server/s3.
namespace enamel::s3 {

struct Libcurl {
  decltype(&curl_global_init) global_init;
  decltype(&curl_easy_init) easy_init;
  decltype(&curl_easy_cleanup) easy_cleanup;
  decltype(&curl_easy_reset) easy_reset;
  // The value after the option is a long, a curl_off_t or a pointer, as the option's page says:
  // nothing converts it.
  decltype(&curl_easy_setopt) easy_setopt;
  decltype(&curl_easy_getinfo) easy_getinfo;
  decltype(&curl_easy_perform) easy_perform;
  decltype(&curl_easy_strerror) easy_strerror;
  decltype(&curl_slist_append) slist_append;
  decltype(&curl_slist_free_all) slist_free_all;
};

// Once; the same for everybody. Errors: kUnavailable (not installed, or too old). Thread safety:
// any.
Result<const Libcurl*> LoadLibcurl();

}  // namespace enamel::s3
