#pragma once

#include "common/board/guard.h"

// Vectors of the C sources in this folder. Real-time safe, any thread.
static inline double EnDot(EnVec a, EnVec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline EnVec EnPlus(EnVec a, EnVec b) {
  EnVec out = {a.x + b.x, a.y + b.y, a.z + b.z};
  return out;
}
static inline EnVec EnMinus(EnVec a, EnVec b) {
  EnVec out = {a.x - b.x, a.y - b.y, a.z - b.z};
  return out;
}
static inline EnVec EnTimes(EnVec a, double s) {
  EnVec out = {a.x * s, a.y * s, a.z * s};
  return out;
}
