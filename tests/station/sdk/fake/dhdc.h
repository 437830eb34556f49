#pragma once

// The part of the maker's interface that station/sdk/force_dimension.cpp calls, with a device that
// a test moves (fake_sdk.h).
#define DHD_ON 1
#define DHD_OFF 0

extern "C" {
int dhdOpen();
int dhdClose(char id);
const char* dhdGetSystemName(char id);
const char* dhdErrorGetLastStr();
int dhdEnableForce(unsigned char on, char id);
int dhdGetPosition(double* x, double* y, double* z, char id);
int dhdGetButton(int button, char id);
int dhdSetForce(double x, double y, double z, char id);
bool dhdHasWrist(char id);
bool dhdHasActiveWrist(char id);
int dhdGetOrientationFrame(double matrix[3][3], char id);
int dhdSetForceAndTorque(double fx, double fy, double fz, double tx, double ty, double tz, char id);
}
