#include "common/board/report.h"

uint16_t EnCrc16(const uint8_t* bytes, size_t size) {
  // Bit by bit: two reports of some 60 bytes a millisecond need no table.
  uint32_t crc = 0xFFFF;
  for (size_t i = 0; i < size; ++i) {
    crc ^= (uint32_t)bytes[i] << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1;
    crc &= 0xFFFF;
  }
  return (uint16_t)crc;
}

// Little-endian, at a place that moves on.
static uint32_t Take(const uint8_t** at, int size) {
  uint32_t value = 0;
  for (int i = 0; i < size; ++i) value |= (uint32_t)(*at)[i] << (8 * i);
  *at += size;
  return value;
}
static int32_t TakeI32(const uint8_t** at) { return (int32_t)Take(at, 4); }
static int16_t TakeI16(const uint8_t** at) { return (int16_t)Take(at, 2); }

static void Put(uint8_t** at, uint32_t value, int size) {
  for (int i = 0; i < size; ++i) (*at)[i] = (uint8_t)(value >> (8 * i));
  *at += size;
}

EnReportError EnCheckReport(const uint8_t* bytes, size_t available, uint8_t id, size_t size) {
  if (available == 0) return kEnShort;
  if (bytes[0] != id) return kEnWrongId;
  if (available < 2) return kEnShort;
  // Before the length: another version may have another one, and must not be called short.
  if (bytes[1] != kEnReportVersion) return kEnVersion;
  if (available < size) return kEnShort;
  // At the layout's end, not the report's: the rest is padding of the bus.
  const uint16_t crc = (uint16_t)(bytes[size - 2] | bytes[size - 1] << 8);
  return EnCrc16(bytes, size - 2) == crc ? kEnWhole : kEnChecksum;
}

EnReportError EnReadForce(const uint8_t* bytes, size_t size, EnForceReport* out) {
  const EnReportError error = EnCheckReport(bytes, size, kEnForceId, kEnForceBytes);
  if (error != kEnWhole) return error;
  out->motors_on = (bytes[2] & 1) != 0;
  const uint8_t* at = bytes + 4;
  out->sequence = Take(&at, 4);
  for (int i = 0; i < 3; ++i) out->force_100un[i] = TakeI32(&at);
  for (int i = 0; i < 3; ++i) out->torque_un_m[i] = TakeI32(&at);
  out->watchdog_ms = (uint16_t)Take(&at, 2);
  return kEnWhole;
}

EnReportError EnReadSpring(const uint8_t* bytes, size_t size, EnSpringReport* out) {
  const EnReportError error = EnCheckReport(bytes, size, kEnSpringId, kEnSpringBytes);
  if (error != kEnWhole) return error;
  out->motors_on = (bytes[2] & 1) != 0;
  out->spring_on = (bytes[2] & 2) != 0;
  out->follow = (bytes[2] & 4) != 0;
  const uint8_t* at = bytes + 4;
  out->sequence = Take(&at, 4);
  for (int i = 0; i < 3; ++i) out->rest_nm[i] = TakeI32(&at);
  for (int i = 0; i < 3; ++i) out->force_100un[i] = TakeI16(&at);
  for (int i = 0; i < 3; ++i) out->torque_20un_m[i] = TakeI16(&at);
  out->share = (uint16_t)Take(&at, 2);
  out->bound_mn = (uint16_t)Take(&at, 2);
  for (int i = 0; i < 9; ++i) out->cell_nm[i] = TakeI16(&at);
  return kEnWhole;
}

void EnWritePose(const EnPoseReport* report, uint8_t out[kEnPoseBytes]) {
  uint8_t* at = out;
  Put(&at, kEnPoseId, 1);
  Put(&at, kEnReportVersion, 1);
  Put(&at, report->status, 1);
  Put(&at, report->buttons, 1);
  Put(&at, report->sequence, 4);
  Put(&at, report->time_us, 4);
  for (int i = 0; i < 3; ++i) Put(&at, (uint32_t)report->counts[i], 4);
  for (int i = 0; i < 4; ++i) Put(&at, (uint16_t)report->orientation[i], 2);
  Put(&at, report->bur_speed_krpm, 2);
  for (int i = 0; i < 3; ++i) Put(&at, (uint32_t)report->rest_nm[i], 4);
  Put(&at, report->share, 2);
  Put(&at, report->energy_nj, 4);
  Put(&at, report->work_nj, 4);
  Put(&at, EnCrc16(out, kEnPoseBytes - 2), 2);
}
