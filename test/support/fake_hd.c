// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A fake of the calls of libHD that are used: one device, whose thread calls back every millisecond
// while nobody stalls it; a test sets and reads the variables. -DLACKS leaves one call out.
#include <pthread.h>
#include <string.h>
#include <unistd.h>

typedef struct { unsigned code; int internal; unsigned device; } Error;
typedef unsigned (*Callback)(void *);
enum { ID = 3, HANDLE = 9, NONE = 0xFFFFFFFF };

double fake_position[3] = {10, 20, 30}, fake_velocity[3] = {100, 200, 400};  // mm, mm/s
double fake_force[3] = {9, 9, 9};
double fake_transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1};  // by columns
double fake_max_force = 3.3, fake_lasting_force = 0.88;
char fake_model[32] = "Touch", fake_serial[32] = "S-1", fake_name[32] = "";
int fake_busy = 0, fake_code = 0, fake_copies = 1, fake_calibration = 0x5000, fake_updated = 0;
int fake_buttons = 0;
int fake_enabled = 0, fake_open = 0, fake_stalled = 0, fake_frames = 0, fake_in_frame = 0;

static pthread_t thread;
static Callback callback;
static volatile int running = 0;

unsigned hdInitDevice(const char *name) {
  if (fake_busy || fake_open || (name && strcmp(name, fake_name))) {
    fake_code = 0x0302;
    return NONE;
  }
  fake_open = 1;
  return ID;
}
void hdDisableDevice(unsigned id) { fake_open = 0; }
void hdMakeCurrentDevice(unsigned id) {}
const char *hdGetString(unsigned name) { return name == 0x2501 ? fake_model : fake_serial; }
Error hdGetError(void) {
  Error error = {fake_code, 0, ID};
  if (fake_copies > 1) fake_copies--;  // of an error on the stack
  else fake_code = 0;
  return error;
}
const char *hdGetErrorString(unsigned code) { return code == 0x0302 ? "communication error" : "?"; }
void hdEnable(unsigned what) { fake_enabled = 1; }
void hdDisable(unsigned what) { fake_enabled = 0; }
unsigned hdCheckCalibration(void) { return fake_calibration; }
void hdUpdateCalibration(unsigned style) {
  if (style == 2) fake_updated++, fake_calibration = 0x5000;
}
void hdBeginFrame(unsigned id) { fake_in_frame = id == ID; }
void hdEndFrame(unsigned id) { fake_in_frame = 0; }
void hdGetIntegerv(unsigned what, int *value) { *value = what == 0x2555 ? 2 : what == 0x2000 ? fake_buttons : 0; }
void hdGetDoublev(unsigned what, double *value) {
  if (what == 0x2603) *value = fake_max_force;
  if (what == 0x2604) *value = fake_lasting_force;
  if (!fake_in_frame) return;
  if (what == 0x2050) memcpy(value, fake_position, sizeof fake_position);
  if (what == 0x2051) memcpy(value, fake_velocity, sizeof fake_velocity);
  if (what == 0x2052) memcpy(value, fake_transform, sizeof fake_transform);
}
void hdSetDoublev(unsigned what, const double *value) {
  if (what == 0x2700 && fake_in_frame) memcpy(fake_force, value, sizeof fake_force);
}
static void *serve(void *_) {
  while (running) {
    usleep(1000);
    if (!fake_stalled && callback(0) == 1) fake_frames++;
  }
  return 0;
}
unsigned long hdScheduleAsynchronous(Callback called, void *data, unsigned short priority) {
  callback = called;
  return HANDLE;
}
void hdUnschedule(unsigned long handle) { callback = 0; }
void hdStartScheduler(void) {
  running = 1;
  pthread_create(&thread, 0, serve, 0);
}
#ifndef LACKS
void hdStopScheduler(void) {
  running = 0;
  pthread_join(thread, 0);
}
#endif
