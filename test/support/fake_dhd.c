// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A fake of the calls of libdhd that are used, one device with an id of its own; a test sets and
// reads the variables.
enum { ID = 5 };

double fake_position[3] = {0.01, 0.02, 0.03}, fake_velocity[3] = {0.1, 0.2, 0.4};
double fake_force[3] = {9.0, 9.0, 9.0}, fake_torque[3] = {9.0, 9.0, 9.0};
double fake_frame[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // of the handle, by rows
double fake_force_when_enabled = -1.0;
int fake_type = 33, fake_serial = 77, fake_reported_serial = 77, fake_busy = 0, fake_power = 1, fake_calibrated = 1;
int fake_result = 0;         // of reads
int fake_force_result = 0;   // of forces
int fake_buttons = 0;
int fake_enabled = 0, fake_open = 0, fake_window_ms = 20;

static int checked(char id, int result) { return id == ID && fake_open ? result : -1; }

int dhdOpen(void) {
  if (fake_busy) return -1;
  fake_open = 1;
  return ID;
}
int dhdOpenSerial(int serial) { return serial == fake_serial ? dhdOpen() : -1; }
int dhdClose(char id) {
  int result = checked(id, 0);
  fake_open = 0;
  return result;
}
int dhdGetSerialNumber(unsigned short *serial, char id) {
  *serial = fake_reported_serial;
  return checked(id, 0);
}
int dhdGetSystemType(char id) { return checked(id, fake_type); }
const char *dhdGetSystemName(char id) { return id == ID ? "fake" : 0; }
const char *dhdErrorGetLastStr(void) { return "device in use"; }
int dhdGetStatus(int *status, char id) {
  status[0] = fake_power;
  status[3] = fake_calibrated;
  return checked(id, 0);
}
int dhdEnableForce(unsigned char on, char id) {
  fake_enabled = on;
  if (on) fake_force_when_enabled = fake_force[0];
  return checked(id, 0);
}
unsigned dhdGetButtonMask(char id) { return checked(id, 0) ? 0 : fake_buttons; }
int dhdConfigLinearVelocity(int ms, int mode, char id) {
  fake_window_ms = ms;
  return checked(id, mode);
}
static int vector(const double *from, double *x, double *y, double *z, char id) {
  *x = from[0], *y = from[1], *z = from[2];
  return checked(id, fake_result);
}
int dhdGetPosition(double *x, double *y, double *z, char id) {
  return vector(fake_position, x, y, z, id);
}
int dhdGetLinearVelocity(double *x, double *y, double *z, char id) {
  return vector(fake_velocity, x, y, z, id);
}
int dhdGetOrientationFrame(double *frame, char id) {
  for (int i = 0; i < 9; i++) frame[i] = fake_frame[i];
  return checked(id, fake_result);
}
int dhdSetForceAndTorque(double x, double y, double z, double a, double b, double c, char id) {
  fake_force[0] = x, fake_force[1] = y, fake_force[2] = z;
  fake_torque[0] = a, fake_torque[1] = b, fake_torque[2] = c;
  return checked(id, fake_force_result);
}
int dhdSetForce(double x, double y, double z, char id) {
  fake_torque[0] = fake_torque[1] = fake_torque[2] = 0;
  fake_force[0] = x, fake_force[1] = y, fake_force[2] = z;
  return checked(id, fake_force_result);
}
