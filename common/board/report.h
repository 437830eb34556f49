#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The board's half of the HID reports of schemas/hid_haptic_report.md: what it reads and what it
// sends. Pure functions, any thread, real-time safe.
#ifdef __cplusplus
extern "C" {
#endif

enum {
  kEnReportVersion = 1,
  kEnPoseId = 0x48,
  kEnForceId = 0x46,
  kEnSpringId = 0x47,
  kEnPoseBytes = 58,
  kEnForceBytes = 36,
  kEnSpringBytes = 56,
};

typedef enum EnReportError {
  kEnWhole = 0,
  kEnShort,
  kEnWrongId,
  kEnVersion,
  kEnChecksum,
} EnReportError;

// Input report 0x48.
typedef struct EnPoseReport {
  uint8_t status, buttons;
  uint32_t sequence, time_us;
  int32_t counts[3];
  int16_t orientation[4];
  uint16_t bur_speed_krpm;
  int32_t rest_nm[3];
  uint16_t share;
  uint32_t energy_nj, work_nj;
} EnPoseReport;

// Output report 0x46.
typedef struct EnForceReport {
  bool motors_on;
  uint32_t sequence;
  int32_t force_100un[3], torque_un_m[3];
  uint16_t watchdog_ms;
} EnForceReport;

// Output report 0x47.
typedef struct EnSpringReport {
  bool motors_on, spring_on, follow;
  uint32_t sequence;
  int32_t rest_nm[3];
  int16_t force_100un[3], torque_20un_m[3];
  uint16_t share, bound_mn;
  int16_t cell_nm[9];
} EnSpringReport;

// CRC-16/CCITT-FALSE.
uint16_t EnCrc16(const uint8_t* bytes, size_t size);

// kEnWhole if `bytes` begin with a report of this id, `size` bytes long in this version.
EnReportError EnCheckReport(const uint8_t* bytes, size_t available, uint8_t id, size_t size);

// `out` is unchanged unless kEnWhole is returned.
EnReportError EnReadForce(const uint8_t* bytes, size_t size, EnForceReport* out);
EnReportError EnReadSpring(const uint8_t* bytes, size_t size, EnSpringReport* out);

void EnWritePose(const EnPoseReport* report, uint8_t out[kEnPoseBytes]);

#ifdef __cplusplus
}
#endif
