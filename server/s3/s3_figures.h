#pragma once

#include <cstdint>

#include "common/base/histogram.h"

namespace enamel::s3 {

// What an S3Client has done since it was made.
struct S3Figures {
  uint64_t requests = 0;     // sent to the store, every try
  uint64_t failed = 0;       // calls, after all their tries; a missing object is no failure
  Histogram::Counts calls;   // how long calls took, with all tries and pauses
  double oldest_wait_s = 0;  // of the oldest call in progress
};

}  // namespace enamel::s3
