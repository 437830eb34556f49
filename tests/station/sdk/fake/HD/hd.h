#pragma once

// The part of the maker's interface that station/sdk/open_haptics.cpp calls, with a device that a
// test moves (fake_sdk.h).
using HHD = unsigned int;
using HDdouble = double;
using HDint = int;
struct HDErrorInfo {
  unsigned int errorCode;
};

#define HD_DEFAULT_DEVICE nullptr
#define HD_INVALID_HANDLE 0xFFFFFFFFu
#define HD_DEVICE_BUTTON_1 1
#define HD_DEVICE_ERROR(info) ((info).errorCode != 0)
enum { HD_DEVICE_MODEL_TYPE, HD_CURRENT_POSITION, HD_CURRENT_BUTTONS, HD_CURRENT_FORCE };
enum { HD_FORCE_OUTPUT };

extern "C" {
HHD hdInitDevice(const char* name);
void hdDisableDevice(HHD device);
void hdMakeCurrentDevice(HHD device);
void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
const char* hdGetString(int what);
void hdGetDoublev(int what, HDdouble* out);
void hdGetIntegerv(int what, HDint* out);
void hdSetDoublev(int what, const HDdouble* in);
void hdEnable(int what);
void hdStartScheduler();
HDErrorInfo hdGetError();
}
