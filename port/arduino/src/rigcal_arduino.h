/* rigcal_arduino.h - the choices of rigcal_config.h for sketches, which cannot
 * pass options to the compiler: this file is the place for them. */
#ifndef RIGCAL_ARDUINO_H
#define RIGCAL_ARDUINO_H

/* Few boards have a double-precision FPU. 0 for those that do. */
#ifndef RIGCAL_USE_FLOAT
#define RIGCAL_USE_FLOAT 1
#endif

#endif /* RIGCAL_ARDUINO_H */
